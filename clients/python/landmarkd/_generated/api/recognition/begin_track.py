from http import HTTPStatus
from typing import Any
from urllib.parse import quote

import httpx

from ...client import AuthenticatedClient, Client
from ...models.new_track import NewTrack
from ...models.problem import Problem
from ...models.track_body import TrackBody
from ...types import UNSET, Response, Unset


def _get_kwargs(
    database: str,
    *,
    body: NewTrack | None | Unset = UNSET,
) -> dict[str, Any]:
    headers: dict[str, Any] = {}

    _kwargs: dict[str, Any] = {
        "method": "post",
        "url": "/v1/databases/{database}/tracks".format(
            database=quote(str(database), safe=""),
        ),
    }

    if isinstance(body, NewTrack):
        _kwargs["json"] = body.to_dict()
    else:
        _kwargs["json"] = body

    headers["Content-Type"] = "application/json"

    _kwargs["headers"] = headers
    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> Problem | TrackBody:
    if response.status_code == 201:
        response_201 = TrackBody.from_dict(response.json())

        return response_201

    response_default = Problem.from_dict(response.json())

    return response_default


def _build_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> Response[Problem | TrackBody]:
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
    body: NewTrack | None | Unset = UNSET,
) -> Response[Problem | TrackBody]:
    """Begin a track: before its first frame the robot may be anywhere. Tracks live in the memory of the
    process that began
    them, until they are deleted or no frame comes for ten minutes.

    Args:
        database (str):
        body (NewTrack | None | Unset):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[Problem | TrackBody]
    """

    kwargs = _get_kwargs(
        database=database,
        body=body,
    )

    response = client.get_httpx_client().request(
        **kwargs,
    )

    return _build_response(client=client, response=response)


def sync(
    database: str,
    *,
    client: AuthenticatedClient,
    body: NewTrack | None | Unset = UNSET,
) -> Problem | TrackBody | None:
    """Begin a track: before its first frame the robot may be anywhere. Tracks live in the memory of the
    process that began
    them, until they are deleted or no frame comes for ten minutes.

    Args:
        database (str):
        body (NewTrack | None | Unset):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Problem | TrackBody
    """

    return sync_detailed(
        database=database,
        client=client,
        body=body,
    ).parsed


async def asyncio_detailed(
    database: str,
    *,
    client: AuthenticatedClient,
    body: NewTrack | None | Unset = UNSET,
) -> Response[Problem | TrackBody]:
    """Begin a track: before its first frame the robot may be anywhere. Tracks live in the memory of the
    process that began
    them, until they are deleted or no frame comes for ten minutes.

    Args:
        database (str):
        body (NewTrack | None | Unset):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[Problem | TrackBody]
    """

    kwargs = _get_kwargs(
        database=database,
        body=body,
    )

    response = await client.get_async_httpx_client().request(**kwargs)

    return _build_response(client=client, response=response)


async def asyncio(
    database: str,
    *,
    client: AuthenticatedClient,
    body: NewTrack | None | Unset = UNSET,
) -> Problem | TrackBody | None:
    """Begin a track: before its first frame the robot may be anywhere. Tracks live in the memory of the
    process that began
    them, until they are deleted or no frame comes for ten minutes.

    Args:
        database (str):
        body (NewTrack | None | Unset):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Problem | TrackBody
    """

    return (
        await asyncio_detailed(
            database=database,
            client=client,
            body=body,
        )
    ).parsed
