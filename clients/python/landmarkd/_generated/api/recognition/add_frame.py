from http import HTTPStatus
from typing import Any
from urllib.parse import quote
from uuid import UUID

import httpx

from ...client import AuthenticatedClient, Client
from ...models.landmark_tracked_frame_body import LandmarkTrackedFrameBody
from ...models.object_tracked_frame_body import ObjectTrackedFrameBody
from ...models.problem import Problem
from ...types import UNSET, File, Response, Unset


def _get_kwargs(
    database: str,
    id: UUID,
    *,
    body: File,
    top: int | Unset = 5,
    explain: bool | Unset = False,
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

    params: dict[str, Any] = {}

    params["top"] = top

    params["explain"] = explain

    params = {k: v for k, v in params.items() if v is not UNSET and v is not None}

    _kwargs: dict[str, Any] = {
        "method": "post",
        "url": "/v1/databases/{database}/tracks/{id}/frames".format(
            database=quote(str(database), safe=""),
            id=quote(str(id), safe=""),
        ),
        "params": params,
    }

    _kwargs["content"] = body.payload

    headers["Content-Type"] = "application/octet-stream"

    _kwargs["headers"] = headers
    return _kwargs


def _parse_response(
    *, client: AuthenticatedClient | Client, response: httpx.Response
) -> LandmarkTrackedFrameBody | ObjectTrackedFrameBody | Problem:
    if response.status_code == 200:

        def _parse_response_200(data: object) -> LandmarkTrackedFrameBody | ObjectTrackedFrameBody:
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                componentsschemas_tracked_frame_body_type_0 = LandmarkTrackedFrameBody.from_dict(data)

                return componentsschemas_tracked_frame_body_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            if not isinstance(data, dict):
                raise TypeError()
            componentsschemas_tracked_frame_body_type_1 = ObjectTrackedFrameBody.from_dict(data)

            return componentsschemas_tracked_frame_body_type_1

        response_200 = _parse_response_200(response.json())

        return response_200

    response_default = Problem.from_dict(response.json())

    return response_default


def _build_response(
    *, client: AuthenticatedClient | Client, response: httpx.Response
) -> Response[LandmarkTrackedFrameBody | ObjectTrackedFrameBody | Problem]:
    return Response(
        status_code=HTTPStatus(response.status_code),
        content=response.content,
        headers=response.headers,
        parsed=_parse_response(client=client, response=response),
    )


def sync_detailed(
    database: str,
    id: UUID,
    *,
    client: AuthenticatedClient,
    body: File,
    top: int | Unset = 5,
    explain: bool | Unset = False,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Response[LandmarkTrackedFrameBody | ObjectTrackedFrameBody | Problem]:
    """Add a robot's next frame to its track, and say where the robot is by all of them. Frames of a track
    are taken one by
    one, in the order in which they come. The last frame sent again, by a robot that got no answer,
    isn't counted twice.
    When the alias moves to another version, the track goes on with that one.

    Args:
        database (str):
        id (UUID):
        top (int | Unset):  Default: 5.
        explain (bool | Unset):  Default: False.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[LandmarkTrackedFrameBody | ObjectTrackedFrameBody | Problem]
    """

    kwargs = _get_kwargs(
        database=database,
        id=id,
        body=body,
        top=top,
        explain=explain,
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
    id: UUID,
    *,
    client: AuthenticatedClient,
    body: File,
    top: int | Unset = 5,
    explain: bool | Unset = False,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> LandmarkTrackedFrameBody | ObjectTrackedFrameBody | Problem | None:
    """Add a robot's next frame to its track, and say where the robot is by all of them. Frames of a track
    are taken one by
    one, in the order in which they come. The last frame sent again, by a robot that got no answer,
    isn't counted twice.
    When the alias moves to another version, the track goes on with that one.

    Args:
        database (str):
        id (UUID):
        top (int | Unset):  Default: 5.
        explain (bool | Unset):  Default: False.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        LandmarkTrackedFrameBody | ObjectTrackedFrameBody | Problem
    """

    return sync_detailed(
        database=database,
        id=id,
        client=client,
        body=body,
        top=top,
        explain=explain,
        x_robot_id=x_robot_id,
        x_frame_id=x_frame_id,
        x_stamp=x_stamp,
    ).parsed


async def asyncio_detailed(
    database: str,
    id: UUID,
    *,
    client: AuthenticatedClient,
    body: File,
    top: int | Unset = 5,
    explain: bool | Unset = False,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Response[LandmarkTrackedFrameBody | ObjectTrackedFrameBody | Problem]:
    """Add a robot's next frame to its track, and say where the robot is by all of them. Frames of a track
    are taken one by
    one, in the order in which they come. The last frame sent again, by a robot that got no answer,
    isn't counted twice.
    When the alias moves to another version, the track goes on with that one.

    Args:
        database (str):
        id (UUID):
        top (int | Unset):  Default: 5.
        explain (bool | Unset):  Default: False.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[LandmarkTrackedFrameBody | ObjectTrackedFrameBody | Problem]
    """

    kwargs = _get_kwargs(
        database=database,
        id=id,
        body=body,
        top=top,
        explain=explain,
        x_robot_id=x_robot_id,
        x_frame_id=x_frame_id,
        x_stamp=x_stamp,
    )

    response = await client.get_async_httpx_client().request(**kwargs)

    return _build_response(client=client, response=response)


async def asyncio(
    database: str,
    id: UUID,
    *,
    client: AuthenticatedClient,
    body: File,
    top: int | Unset = 5,
    explain: bool | Unset = False,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> LandmarkTrackedFrameBody | ObjectTrackedFrameBody | Problem | None:
    """Add a robot's next frame to its track, and say where the robot is by all of them. Frames of a track
    are taken one by
    one, in the order in which they come. The last frame sent again, by a robot that got no answer,
    isn't counted twice.
    When the alias moves to another version, the track goes on with that one.

    Args:
        database (str):
        id (UUID):
        top (int | Unset):  Default: 5.
        explain (bool | Unset):  Default: False.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        LandmarkTrackedFrameBody | ObjectTrackedFrameBody | Problem
    """

    return (
        await asyncio_detailed(
            database=database,
            id=id,
            client=client,
            body=body,
            top=top,
            explain=explain,
            x_robot_id=x_robot_id,
            x_frame_id=x_frame_id,
            x_stamp=x_stamp,
        )
    ).parsed
