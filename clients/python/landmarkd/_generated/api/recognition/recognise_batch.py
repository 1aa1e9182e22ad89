from http import HTTPStatus
from typing import Any
from urllib.parse import quote

import httpx

from ...client import AuthenticatedClient, Client
from ...models.images_form import ImagesForm
from ...models.problem import Problem
from ...models.recognition_batch import RecognitionBatch
from ...types import UNSET, Response, Unset


def _get_kwargs(
    database: str,
    *,
    body: ImagesForm,
    alias: str | Unset = UNSET,
    version: int | Unset = UNSET,
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

    params["alias"] = alias

    params["version"] = version

    params["top"] = top

    params["explain"] = explain

    params = {k: v for k, v in params.items() if v is not UNSET and v is not None}

    _kwargs: dict[str, Any] = {
        "method": "post",
        "url": "/v1/databases/{database}/recognitions:batch".format(
            database=quote(str(database), safe=""),
        ),
        "params": params,
    }

    _kwargs["files"] = body.to_multipart()

    _kwargs["headers"] = headers
    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> Problem | RecognitionBatch:
    if response.status_code == 200:
        response_200 = RecognitionBatch.from_dict(response.json())

        return response_200

    response_default = Problem.from_dict(response.json())

    return response_default


def _build_response(
    *, client: AuthenticatedClient | Client, response: httpx.Response
) -> Response[Problem | RecognitionBatch]:
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
    body: ImagesForm,
    alias: str | Unset = UNSET,
    version: int | Unset = UNSET,
    top: int | Unset = 5,
    explain: bool | Unset = False,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Response[Problem | RecognitionBatch]:
    """Recognise several frames: parts that are all called `image`. One bad picture never loses the rest.

    Args:
        database (str):
        alias (str | Unset):
        version (int | Unset):
        top (int | Unset):  Default: 5.
        explain (bool | Unset):  Default: False.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (ImagesForm): A form with several pictures.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[Problem | RecognitionBatch]
    """

    kwargs = _get_kwargs(
        database=database,
        body=body,
        alias=alias,
        version=version,
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
    *,
    client: AuthenticatedClient,
    body: ImagesForm,
    alias: str | Unset = UNSET,
    version: int | Unset = UNSET,
    top: int | Unset = 5,
    explain: bool | Unset = False,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Problem | RecognitionBatch | None:
    """Recognise several frames: parts that are all called `image`. One bad picture never loses the rest.

    Args:
        database (str):
        alias (str | Unset):
        version (int | Unset):
        top (int | Unset):  Default: 5.
        explain (bool | Unset):  Default: False.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (ImagesForm): A form with several pictures.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Problem | RecognitionBatch
    """

    return sync_detailed(
        database=database,
        client=client,
        body=body,
        alias=alias,
        version=version,
        top=top,
        explain=explain,
        x_robot_id=x_robot_id,
        x_frame_id=x_frame_id,
        x_stamp=x_stamp,
    ).parsed


async def asyncio_detailed(
    database: str,
    *,
    client: AuthenticatedClient,
    body: ImagesForm,
    alias: str | Unset = UNSET,
    version: int | Unset = UNSET,
    top: int | Unset = 5,
    explain: bool | Unset = False,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Response[Problem | RecognitionBatch]:
    """Recognise several frames: parts that are all called `image`. One bad picture never loses the rest.

    Args:
        database (str):
        alias (str | Unset):
        version (int | Unset):
        top (int | Unset):  Default: 5.
        explain (bool | Unset):  Default: False.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (ImagesForm): A form with several pictures.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[Problem | RecognitionBatch]
    """

    kwargs = _get_kwargs(
        database=database,
        body=body,
        alias=alias,
        version=version,
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
    *,
    client: AuthenticatedClient,
    body: ImagesForm,
    alias: str | Unset = UNSET,
    version: int | Unset = UNSET,
    top: int | Unset = 5,
    explain: bool | Unset = False,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Problem | RecognitionBatch | None:
    """Recognise several frames: parts that are all called `image`. One bad picture never loses the rest.

    Args:
        database (str):
        alias (str | Unset):
        version (int | Unset):
        top (int | Unset):  Default: 5.
        explain (bool | Unset):  Default: False.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (ImagesForm): A form with several pictures.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Problem | RecognitionBatch
    """

    return (
        await asyncio_detailed(
            database=database,
            client=client,
            body=body,
            alias=alias,
            version=version,
            top=top,
            explain=explain,
            x_robot_id=x_robot_id,
            x_frame_id=x_frame_id,
            x_stamp=x_stamp,
        )
    ).parsed
