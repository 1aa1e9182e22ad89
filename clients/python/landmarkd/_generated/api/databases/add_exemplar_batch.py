from http import HTTPStatus
from typing import Any
from urllib.parse import quote

import httpx

from ...client import AuthenticatedClient, Client
from ...models.batch_body import BatchBody
from ...models.problem import Problem
from ...types import UNSET, File, Response, Unset


def _get_kwargs(
    database: str,
    *,
    body: File,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> dict[str, Any]:
    headers: dict[str, Any] = {}
    if not isinstance(x_robot_id, Unset):
        headers["X-Robot-Id"] = x_robot_id

    if not isinstance(x_frame_id, Unset):
        headers["X-Frame-Id"] = x_frame_id

    if not isinstance(x_stamp, Unset):
        headers["X-Stamp"] = x_stamp

    _kwargs: dict[str, Any] = {
        "method": "post",
        "url": "/v1/databases/{database}/exemplars:batch".format(
            database=quote(str(database), safe=""),
        ),
    }

    _kwargs["content"] = body.payload

    headers["Content-Type"] = "application/x-tar"

    _kwargs["headers"] = headers
    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> BatchBody | Problem:
    if response.status_code == 200:
        response_200 = BatchBody.from_dict(response.json())

        return response_200

    response_default = Problem.from_dict(response.json())

    return response_default


def _build_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> Response[BatchBody | Problem]:
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
    body: File,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Response[BatchBody | Problem]:
    """Add many training images: a form with a part `manifest` and then one part named as each file, or a
    tar archive of
    `<label>/<anything>.png|jpg` (a leaf name `…__<degrees>.<ext>` gives the pose).

    Args:
        database (str):
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[BatchBody | Problem]
    """

    kwargs = _get_kwargs(
        database=database,
        body=body,
        x_robot_id=x_robot_id,
        x_frame_id=x_frame_id,
        x_stamp=x_stamp,
    )

    response = client.get_httpx_client().request(
        **kwargs,
    )

    return _build_response(client=client, response=response)


def sync(
    database: str,
    *,
    client: AuthenticatedClient,
    body: File,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> BatchBody | Problem | None:
    """Add many training images: a form with a part `manifest` and then one part named as each file, or a
    tar archive of
    `<label>/<anything>.png|jpg` (a leaf name `…__<degrees>.<ext>` gives the pose).

    Args:
        database (str):
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        BatchBody | Problem
    """

    return sync_detailed(
        database=database,
        client=client,
        body=body,
        x_robot_id=x_robot_id,
        x_frame_id=x_frame_id,
        x_stamp=x_stamp,
    ).parsed


async def asyncio_detailed(
    database: str,
    *,
    client: AuthenticatedClient,
    body: File,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Response[BatchBody | Problem]:
    """Add many training images: a form with a part `manifest` and then one part named as each file, or a
    tar archive of
    `<label>/<anything>.png|jpg` (a leaf name `…__<degrees>.<ext>` gives the pose).

    Args:
        database (str):
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[BatchBody | Problem]
    """

    kwargs = _get_kwargs(
        database=database,
        body=body,
        x_robot_id=x_robot_id,
        x_frame_id=x_frame_id,
        x_stamp=x_stamp,
    )

    response = await client.get_async_httpx_client().request(**kwargs)

    return _build_response(client=client, response=response)


async def asyncio(
    database: str,
    *,
    client: AuthenticatedClient,
    body: File,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> BatchBody | Problem | None:
    """Add many training images: a form with a part `manifest` and then one part named as each file, or a
    tar archive of
    `<label>/<anything>.png|jpg` (a leaf name `…__<degrees>.<ext>` gives the pose).

    Args:
        database (str):
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        BatchBody | Problem
    """

    return (
        await asyncio_detailed(
            database=database,
            client=client,
            body=body,
            x_robot_id=x_robot_id,
            x_frame_id=x_frame_id,
            x_stamp=x_stamp,
        )
    ).parsed
