from http import HTTPStatus
from typing import Any
from urllib.parse import quote

import httpx

from ...client import AuthenticatedClient, Client
from ...models.centring_body import CentringBody
from ...models.problem import Problem
from ...types import UNSET, File, Response, Unset


def _get_kwargs(
    name: str,
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
        "url": "/v1/workcells/{name}/centrings".format(
            name=quote(str(name), safe=""),
        ),
    }

    _kwargs["content"] = body.payload

    headers["Content-Type"] = "application/octet-stream"

    _kwargs["headers"] = headers
    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> CentringBody | Problem:
    if response.status_code == 200:
        response_200 = CentringBody.from_dict(response.json())

        return response_200

    response_default = Problem.from_dict(response.json())

    return response_default


def _build_response(
    *, client: AuthenticatedClient | Client, response: httpx.Response
) -> Response[CentringBody | Problem]:
    return Response(
        status_code=HTTPStatus(response.status_code),
        content=response.content,
        headers=response.headers,
        parsed=_parse_response(client=client, response=response),
    )


def sync_detailed(
    name: str,
    *,
    client: AuthenticatedClient,
    body: File,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Response[CentringBody | Problem]:
    """Look with the camera at the gripper: by how much it is off the part nearest the picture's middle.
    Move by it, and
    ask again until `centred`.

    Args:
        name (str):
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[CentringBody | Problem]
    """

    kwargs = _get_kwargs(
        name=name,
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
    name: str,
    *,
    client: AuthenticatedClient,
    body: File,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> CentringBody | Problem | None:
    """Look with the camera at the gripper: by how much it is off the part nearest the picture's middle.
    Move by it, and
    ask again until `centred`.

    Args:
        name (str):
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        CentringBody | Problem
    """

    return sync_detailed(
        name=name,
        client=client,
        body=body,
        x_robot_id=x_robot_id,
        x_frame_id=x_frame_id,
        x_stamp=x_stamp,
    ).parsed


async def asyncio_detailed(
    name: str,
    *,
    client: AuthenticatedClient,
    body: File,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Response[CentringBody | Problem]:
    """Look with the camera at the gripper: by how much it is off the part nearest the picture's middle.
    Move by it, and
    ask again until `centred`.

    Args:
        name (str):
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[CentringBody | Problem]
    """

    kwargs = _get_kwargs(
        name=name,
        body=body,
        x_robot_id=x_robot_id,
        x_frame_id=x_frame_id,
        x_stamp=x_stamp,
    )

    response = await client.get_async_httpx_client().request(**kwargs)

    return _build_response(client=client, response=response)


async def asyncio(
    name: str,
    *,
    client: AuthenticatedClient,
    body: File,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> CentringBody | Problem | None:
    """Look with the camera at the gripper: by how much it is off the part nearest the picture's middle.
    Move by it, and
    ask again until `centred`.

    Args:
        name (str):
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        CentringBody | Problem
    """

    return (
        await asyncio_detailed(
            name=name,
            client=client,
            body=body,
            x_robot_id=x_robot_id,
            x_frame_id=x_frame_id,
            x_stamp=x_stamp,
        )
    ).parsed
