import datetime
from http import HTTPStatus
from typing import Any, cast
from urllib.parse import quote

import httpx

from ...client import AuthenticatedClient, Client
from ...models.problem import Problem
from ...types import UNSET, Response, Unset


def _get_kwargs(
    database: str,
    *,
    label: str | Unset = UNSET,
    robot_id: str | Unset = UNSET,
    since: datetime.datetime | Unset = UNSET,
    before: datetime.datetime | Unset = UNSET,
) -> dict[str, Any]:

    params: dict[str, Any] = {}

    params["label"] = label

    params["robot_id"] = robot_id

    json_since: str | Unset = UNSET
    if not isinstance(since, Unset):
        json_since = since.isoformat()
    params["since"] = json_since

    json_before: str | Unset = UNSET
    if not isinstance(before, Unset):
        json_before = before.isoformat()
    params["before"] = json_before

    params = {k: v for k, v in params.items() if v is not UNSET and v is not None}

    _kwargs: dict[str, Any] = {
        "method": "delete",
        "url": "/v1/databases/{database}/exemplars".format(
            database=quote(str(database), safe=""),
        ),
        "params": params,
    }

    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> Any | Problem:
    if response.status_code == 204:
        response_204 = cast(Any, None)
        return response_204

    response_default = Problem.from_dict(response.json())

    return response_default


def _build_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> Response[Any | Problem]:
    return Response(
        status_code=HTTPStatus(response.status_code),
        content=response.content,
        headers=response.headers,
        parsed=_parse_response(client=client, response=response),
    )


def sync_detailed(
    database: str,
    *,
    client: AuthenticatedClient,
    label: str | Unset = UNSET,
    robot_id: str | Unset = UNSET,
    since: datetime.datetime | Unset = UNSET,
    before: datetime.datetime | Unset = UNSET,
) -> Response[Any | Problem]:
    """Delete the training images that match all that is given: a label, a robot, a span of time; with
    nothing given, none
    and 400. Versions trained with them stay as they are: train anew, then delete the older versions.

    Args:
        database (str):
        label (str | Unset):
        robot_id (str | Unset):
        since (datetime.datetime | Unset):
        before (datetime.datetime | Unset):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[Any | Problem]
    """

    kwargs = _get_kwargs(
        database=database,
        label=label,
        robot_id=robot_id,
        since=since,
        before=before,
    )

    response = client.get_httpx_client().request(
        **kwargs,
    )

    return _build_response(client=client, response=response)


def sync(
    database: str,
    *,
    client: AuthenticatedClient,
    label: str | Unset = UNSET,
    robot_id: str | Unset = UNSET,
    since: datetime.datetime | Unset = UNSET,
    before: datetime.datetime | Unset = UNSET,
) -> Any | Problem | None:
    """Delete the training images that match all that is given: a label, a robot, a span of time; with
    nothing given, none
    and 400. Versions trained with them stay as they are: train anew, then delete the older versions.

    Args:
        database (str):
        label (str | Unset):
        robot_id (str | Unset):
        since (datetime.datetime | Unset):
        before (datetime.datetime | Unset):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Any | Problem
    """

    return sync_detailed(
        database=database,
        client=client,
        label=label,
        robot_id=robot_id,
        since=since,
        before=before,
    ).parsed


async def asyncio_detailed(
    database: str,
    *,
    client: AuthenticatedClient,
    label: str | Unset = UNSET,
    robot_id: str | Unset = UNSET,
    since: datetime.datetime | Unset = UNSET,
    before: datetime.datetime | Unset = UNSET,
) -> Response[Any | Problem]:
    """Delete the training images that match all that is given: a label, a robot, a span of time; with
    nothing given, none
    and 400. Versions trained with them stay as they are: train anew, then delete the older versions.

    Args:
        database (str):
        label (str | Unset):
        robot_id (str | Unset):
        since (datetime.datetime | Unset):
        before (datetime.datetime | Unset):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[Any | Problem]
    """

    kwargs = _get_kwargs(
        database=database,
        label=label,
        robot_id=robot_id,
        since=since,
        before=before,
    )

    response = await client.get_async_httpx_client().request(**kwargs)

    return _build_response(client=client, response=response)


async def asyncio(
    database: str,
    *,
    client: AuthenticatedClient,
    label: str | Unset = UNSET,
    robot_id: str | Unset = UNSET,
    since: datetime.datetime | Unset = UNSET,
    before: datetime.datetime | Unset = UNSET,
) -> Any | Problem | None:
    """Delete the training images that match all that is given: a label, a robot, a span of time; with
    nothing given, none
    and 400. Versions trained with them stay as they are: train anew, then delete the older versions.

    Args:
        database (str):
        label (str | Unset):
        robot_id (str | Unset):
        since (datetime.datetime | Unset):
        before (datetime.datetime | Unset):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Any | Problem
    """

    return (
        await asyncio_detailed(
            database=database,
            client=client,
            label=label,
            robot_id=robot_id,
            since=since,
            before=before,
        )
    ).parsed
