from http import HTTPStatus
from typing import Any

import httpx

from ...client import AuthenticatedClient, Client
from ...models.polarity_word import PolarityWord
from ...models.problem import Problem
from ...models.segmentation_body import SegmentationBody
from ...models.threshold_word import ThresholdWord
from ...types import UNSET, File, Response, Unset


def _get_kwargs(
    *,
    body: File,
    threshold: float | ThresholdWord | Unset = UNSET,
    window_px: int | Unset = UNSET,
    offset: float | Unset = UNSET,
    polarity: PolarityWord | Unset = UNSET,
    min_area_px: int | Unset = UNSET,
    max_objects: int | Unset = 100,
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

    json_threshold: float | str | Unset
    if isinstance(threshold, Unset):
        json_threshold = UNSET
    elif isinstance(threshold, str):
        json_threshold = threshold
    else:
        json_threshold = threshold
    params["threshold"] = json_threshold

    params["window_px"] = window_px

    params["offset"] = offset

    json_polarity: str | Unset = UNSET
    if not isinstance(polarity, Unset):
        json_polarity = polarity

    params["polarity"] = json_polarity

    params["min_area_px"] = min_area_px

    params["max_objects"] = max_objects

    params = {k: v for k, v in params.items() if v is not UNSET and v is not None}

    _kwargs: dict[str, Any] = {
        "method": "post",
        "url": "/v1/segmentations",
        "params": params,
    }

    _kwargs["content"] = body.payload

    headers["Content-Type"] = "application/octet-stream"

    _kwargs["headers"] = headers
    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> Problem | SegmentationBody:
    if response.status_code == 200:
        response_200 = SegmentationBody.from_dict(response.json())

        return response_200

    response_default = Problem.from_dict(response.json())

    return response_default


def _build_response(
    *, client: AuthenticatedClient | Client, response: httpx.Response
) -> Response[Problem | SegmentationBody]:
    return Response(
        status_code=HTTPStatus(response.status_code),
        content=response.content,
        headers=response.headers,
        parsed=_parse_response(client=client, response=response),
    )


def sync_detailed(
    *,
    client: AuthenticatedClient,
    body: File,
    threshold: float | ThresholdWord | Unset = UNSET,
    window_px: int | Unset = UNSET,
    offset: float | Unset = UNSET,
    polarity: PolarityWord | Unset = UNSET,
    min_area_px: int | Unset = UNSET,
    max_objects: int | Unset = 100,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Response[Problem | SegmentationBody]:
    """Take a picture apart into regions and background. `Accept` chooses the form: the regions; a 16-bit
    label image
    (the region's id for each pixel, 0 is background); or, for people, the picture with outlines, boxes,
    axes and ids.
    A picture in which nothing stands out is an answer without regions.

    Args:
        threshold (float | ThresholdWord | Unset): A grey level, 0 to 255, or by itself.
        window_px (int | Unset):
        offset (float | Unset):
        polarity (PolarityWord | Unset): What objects look like.
        min_area_px (int | Unset):
        max_objects (int | Unset):  Default: 100.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[Problem | SegmentationBody]
    """

    kwargs = _get_kwargs(
        body=body,
        threshold=threshold,
        window_px=window_px,
        offset=offset,
        polarity=polarity,
        min_area_px=min_area_px,
        max_objects=max_objects,
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
    body: File,
    threshold: float | ThresholdWord | Unset = UNSET,
    window_px: int | Unset = UNSET,
    offset: float | Unset = UNSET,
    polarity: PolarityWord | Unset = UNSET,
    min_area_px: int | Unset = UNSET,
    max_objects: int | Unset = 100,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Problem | SegmentationBody | None:
    """Take a picture apart into regions and background. `Accept` chooses the form: the regions; a 16-bit
    label image
    (the region's id for each pixel, 0 is background); or, for people, the picture with outlines, boxes,
    axes and ids.
    A picture in which nothing stands out is an answer without regions.

    Args:
        threshold (float | ThresholdWord | Unset): A grey level, 0 to 255, or by itself.
        window_px (int | Unset):
        offset (float | Unset):
        polarity (PolarityWord | Unset): What objects look like.
        min_area_px (int | Unset):
        max_objects (int | Unset):  Default: 100.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Problem | SegmentationBody
    """

    return sync_detailed(
        client=client,
        body=body,
        threshold=threshold,
        window_px=window_px,
        offset=offset,
        polarity=polarity,
        min_area_px=min_area_px,
        max_objects=max_objects,
        x_robot_id=x_robot_id,
        x_frame_id=x_frame_id,
        x_stamp=x_stamp,
    ).parsed


async def asyncio_detailed(
    *,
    client: AuthenticatedClient,
    body: File,
    threshold: float | ThresholdWord | Unset = UNSET,
    window_px: int | Unset = UNSET,
    offset: float | Unset = UNSET,
    polarity: PolarityWord | Unset = UNSET,
    min_area_px: int | Unset = UNSET,
    max_objects: int | Unset = 100,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Response[Problem | SegmentationBody]:
    """Take a picture apart into regions and background. `Accept` chooses the form: the regions; a 16-bit
    label image
    (the region's id for each pixel, 0 is background); or, for people, the picture with outlines, boxes,
    axes and ids.
    A picture in which nothing stands out is an answer without regions.

    Args:
        threshold (float | ThresholdWord | Unset): A grey level, 0 to 255, or by itself.
        window_px (int | Unset):
        offset (float | Unset):
        polarity (PolarityWord | Unset): What objects look like.
        min_area_px (int | Unset):
        max_objects (int | Unset):  Default: 100.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[Problem | SegmentationBody]
    """

    kwargs = _get_kwargs(
        body=body,
        threshold=threshold,
        window_px=window_px,
        offset=offset,
        polarity=polarity,
        min_area_px=min_area_px,
        max_objects=max_objects,
        x_robot_id=x_robot_id,
        x_frame_id=x_frame_id,
        x_stamp=x_stamp,
    )

    response = await client.get_async_httpx_client().request(**kwargs)

    return _build_response(client=client, response=response)


async def asyncio(
    *,
    client: AuthenticatedClient,
    body: File,
    threshold: float | ThresholdWord | Unset = UNSET,
    window_px: int | Unset = UNSET,
    offset: float | Unset = UNSET,
    polarity: PolarityWord | Unset = UNSET,
    min_area_px: int | Unset = UNSET,
    max_objects: int | Unset = 100,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Problem | SegmentationBody | None:
    """Take a picture apart into regions and background. `Accept` chooses the form: the regions; a 16-bit
    label image
    (the region's id for each pixel, 0 is background); or, for people, the picture with outlines, boxes,
    axes and ids.
    A picture in which nothing stands out is an answer without regions.

    Args:
        threshold (float | ThresholdWord | Unset): A grey level, 0 to 255, or by itself.
        window_px (int | Unset):
        offset (float | Unset):
        polarity (PolarityWord | Unset): What objects look like.
        min_area_px (int | Unset):
        max_objects (int | Unset):  Default: 100.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Problem | SegmentationBody
    """

    return (
        await asyncio_detailed(
            client=client,
            body=body,
            threshold=threshold,
            window_px=window_px,
            offset=offset,
            polarity=polarity,
            min_area_px=min_area_px,
            max_objects=max_objects,
            x_robot_id=x_robot_id,
            x_frame_id=x_frame_id,
            x_stamp=x_stamp,
        )
    ).parsed
