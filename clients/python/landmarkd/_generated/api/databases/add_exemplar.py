from http import HTTPStatus
from typing import Any
from urllib.parse import quote

import httpx

from ...client import AuthenticatedClient, Client
from ...models.exemplar_body import ExemplarBody
from ...models.problem import Problem
from ...types import UNSET, File, Response, Unset


def _get_kwargs(
    database: str,
    *,
    body: File,
    label: str,
    pose_deg: float | Unset = UNSET,
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

    params["label"] = label

    params["pose_deg"] = pose_deg

    params = {k: v for k, v in params.items() if v is not UNSET and v is not None}

    _kwargs: dict[str, Any] = {
        "method": "post",
        "url": "/v1/databases/{database}/exemplars".format(
            database=quote(str(database), safe=""),
        ),
        "params": params,
    }

    _kwargs["content"] = body.payload

    headers["Content-Type"] = "application/octet-stream"

    _kwargs["headers"] = headers
    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> ExemplarBody | Problem:
    if response.status_code == 200:
        response_200 = ExemplarBody.from_dict(response.json())

        return response_200

    if response.status_code == 201:
        response_201 = ExemplarBody.from_dict(response.json())

        return response_201

    response_default = Problem.from_dict(response.json())

    return response_default


def _build_response(
    *, client: AuthenticatedClient | Client, response: httpx.Response
) -> Response[ExemplarBody | Problem]:
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
    label: str,
    pose_deg: float | Unset = UNSET,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Response[ExemplarBody | Problem]:
    """Add a training image: the raw picture, or a form with a part `image`. The same again is the same
    exemplar.

    Args:
        database (str):
        label (str):
        pose_deg (float | Unset):
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[ExemplarBody | Problem]
    """

    kwargs = _get_kwargs(
        database=database,
        body=body,
        label=label,
        pose_deg=pose_deg,
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
    label: str,
    pose_deg: float | Unset = UNSET,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> ExemplarBody | Problem | None:
    """Add a training image: the raw picture, or a form with a part `image`. The same again is the same
    exemplar.

    Args:
        database (str):
        label (str):
        pose_deg (float | Unset):
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        ExemplarBody | Problem
    """

    return sync_detailed(
        database=database,
        client=client,
        body=body,
        label=label,
        pose_deg=pose_deg,
        x_robot_id=x_robot_id,
        x_frame_id=x_frame_id,
        x_stamp=x_stamp,
    ).parsed


async def asyncio_detailed(
    database: str,
    *,
    client: AuthenticatedClient,
    body: File,
    label: str,
    pose_deg: float | Unset = UNSET,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Response[ExemplarBody | Problem]:
    """Add a training image: the raw picture, or a form with a part `image`. The same again is the same
    exemplar.

    Args:
        database (str):
        label (str):
        pose_deg (float | Unset):
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[ExemplarBody | Problem]
    """

    kwargs = _get_kwargs(
        database=database,
        body=body,
        label=label,
        pose_deg=pose_deg,
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
    label: str,
    pose_deg: float | Unset = UNSET,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> ExemplarBody | Problem | None:
    """Add a training image: the raw picture, or a form with a part `image`. The same again is the same
    exemplar.

    Args:
        database (str):
        label (str):
        pose_deg (float | Unset):
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        ExemplarBody | Problem
    """

    return (
        await asyncio_detailed(
            database=database,
            client=client,
            body=body,
            label=label,
            pose_deg=pose_deg,
            x_robot_id=x_robot_id,
            x_frame_id=x_frame_id,
            x_stamp=x_stamp,
        )
    ).parsed
