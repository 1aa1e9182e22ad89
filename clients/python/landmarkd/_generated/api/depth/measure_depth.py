from http import HTTPStatus
from typing import Any

import httpx

from ...client import AuthenticatedClient, Client
from ...models.depth_form import DepthForm
from ...models.depth_map_body import DepthMapBody
from ...models.problem import Problem
from ...types import UNSET, Response, Unset


def _get_kwargs(
    *,
    body: DepthForm,
    planes: str | Unset = "depth",
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

    params["planes"] = planes

    params = {k: v for k, v in params.items() if v is not UNSET and v is not None}

    _kwargs: dict[str, Any] = {
        "method": "post",
        "url": "/v1/depth-maps",
        "params": params,
    }

    _kwargs["files"] = body.to_multipart()

    _kwargs["headers"] = headers
    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> DepthMapBody | Problem:
    if response.status_code == 200:
        response_200 = DepthMapBody.from_dict(response.json())

        return response_200

    response_default = Problem.from_dict(response.json())

    return response_default


def _build_response(
    *, client: AuthenticatedClient | Client, response: httpx.Response
) -> Response[DepthMapBody | Problem]:
    return Response(
        status_code=HTTPStatus(response.status_code),
        content=response.content,
        headers=response.headers,
        parsed=_parse_response(client=client, response=response),
    )


def sync_detailed(
    *,
    client: AuthenticatedClient,
    body: DepthForm,
    planes: str | Unset = "depth",
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Response[DepthMapBody | Problem]:
    """The distance of everything from a near- and a far-focused picture. `Accept` chooses the form: a
    summary; a 16-bit
    PNG (distance = grey level × `X-Depth-Scale-Mm`, 0 = unknown); an array for NumPy; a point cloud in
    metres; or, for
    people, a picture in false colours (near is red). Pictures must be linear in light.

    Args:
        planes (str | Unset):  Default: 'depth'.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (DepthForm): A near- and a far-focused picture, and what the lens is. Either `optics`
            or `calibration`.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[DepthMapBody | Problem]
    """

    kwargs = _get_kwargs(
        body=body,
        planes=planes,
        x_robot_id=x_robot_id,
        x_frame_id=x_frame_id,
        x_stamp=x_stamp,
    )

    response = client.get_httpx_client().request(
        **kwargs,
    )

    return _build_response(client=client, response=response)


def sync(
    *,
    client: AuthenticatedClient,
    body: DepthForm,
    planes: str | Unset = "depth",
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> DepthMapBody | Problem | None:
    """The distance of everything from a near- and a far-focused picture. `Accept` chooses the form: a
    summary; a 16-bit
    PNG (distance = grey level × `X-Depth-Scale-Mm`, 0 = unknown); an array for NumPy; a point cloud in
    metres; or, for
    people, a picture in false colours (near is red). Pictures must be linear in light.

    Args:
        planes (str | Unset):  Default: 'depth'.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (DepthForm): A near- and a far-focused picture, and what the lens is. Either `optics`
            or `calibration`.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        DepthMapBody | Problem
    """

    return sync_detailed(
        client=client,
        body=body,
        planes=planes,
        x_robot_id=x_robot_id,
        x_frame_id=x_frame_id,
        x_stamp=x_stamp,
    ).parsed


async def asyncio_detailed(
    *,
    client: AuthenticatedClient,
    body: DepthForm,
    planes: str | Unset = "depth",
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Response[DepthMapBody | Problem]:
    """The distance of everything from a near- and a far-focused picture. `Accept` chooses the form: a
    summary; a 16-bit
    PNG (distance = grey level × `X-Depth-Scale-Mm`, 0 = unknown); an array for NumPy; a point cloud in
    metres; or, for
    people, a picture in false colours (near is red). Pictures must be linear in light.

    Args:
        planes (str | Unset):  Default: 'depth'.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (DepthForm): A near- and a far-focused picture, and what the lens is. Either `optics`
            or `calibration`.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[DepthMapBody | Problem]
    """

    kwargs = _get_kwargs(
        body=body,
        planes=planes,
        x_robot_id=x_robot_id,
        x_frame_id=x_frame_id,
        x_stamp=x_stamp,
    )

    response = await client.get_async_httpx_client().request(**kwargs)

    return _build_response(client=client, response=response)


async def asyncio(
    *,
    client: AuthenticatedClient,
    body: DepthForm,
    planes: str | Unset = "depth",
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> DepthMapBody | Problem | None:
    """The distance of everything from a near- and a far-focused picture. `Accept` chooses the form: a
    summary; a 16-bit
    PNG (distance = grey level × `X-Depth-Scale-Mm`, 0 = unknown); an array for NumPy; a point cloud in
    metres; or, for
    people, a picture in false colours (near is red). Pictures must be linear in light.

    Args:
        planes (str | Unset):  Default: 'depth'.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (DepthForm): A near- and a far-focused picture, and what the lens is. Either `optics`
            or `calibration`.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        DepthMapBody | Problem
    """

    return (
        await asyncio_detailed(
            client=client,
            body=body,
            planes=planes,
            x_robot_id=x_robot_id,
            x_frame_id=x_frame_id,
            x_stamp=x_stamp,
        )
    ).parsed
