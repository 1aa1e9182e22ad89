from http import HTTPStatus
from typing import Any
from urllib.parse import quote

import httpx

from ...client import AuthenticatedClient, Client
from ...models.landmark_recognition_body import LandmarkRecognitionBody
from ...models.object_recognition_body import ObjectRecognitionBody
from ...models.problem import Problem
from ...types import UNSET, File, Response, Unset


def _get_kwargs(
    database: str,
    *,
    body: File,
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
        "url": "/v1/databases/{database}/recognitions".format(
            database=quote(str(database), safe=""),
        ),
        "params": params,
    }

    _kwargs["content"] = body.payload

    headers["Content-Type"] = "application/octet-stream"

    _kwargs["headers"] = headers
    return _kwargs


def _parse_response(
    *, client: AuthenticatedClient | Client, response: httpx.Response
) -> LandmarkRecognitionBody | ObjectRecognitionBody | Problem:
    if response.status_code == 200:

        def _parse_response_200(data: object) -> LandmarkRecognitionBody | ObjectRecognitionBody:
            try:
                if not isinstance(data, dict):
                    raise TypeError()
                componentsschemas_recognition_body_type_0 = LandmarkRecognitionBody.from_dict(data)

                return componentsschemas_recognition_body_type_0
            except (TypeError, ValueError, AttributeError, KeyError):
                pass
            if not isinstance(data, dict):
                raise TypeError()
            componentsschemas_recognition_body_type_1 = ObjectRecognitionBody.from_dict(data)

            return componentsschemas_recognition_body_type_1

        response_200 = _parse_response_200(response.json())

        return response_200

    response_default = Problem.from_dict(response.json())

    return response_default


def _build_response(
    *, client: AuthenticatedClient | Client, response: httpx.Response
) -> Response[LandmarkRecognitionBody | ObjectRecognitionBody | Problem]:
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
    alias: str | Unset = UNSET,
    version: int | Unset = UNSET,
    top: int | Unset = 5,
    explain: bool | Unset = False,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Response[LandmarkRecognitionBody | ObjectRecognitionBody | Problem]:
    """Recognise one frame. With `Accept: image/png` the answer is the frame with the evidence drawn on it
    (points and votes,
    or candidates and pose); the headers `X-Version` and `X-Digest` say what answered. With
    `Accept: image/png; view=reconstruction` (kind `objects`) it is what the version's eigenspace makes
    of the frame, three
    pictures beside each other: the appearance that is looked at, the same rebuilt from eigenimages, and
    the residual about
    mid-gray, whose length is `X-Distance-From-Space`.

    Args:
        database (str):
        alias (str | Unset):
        version (int | Unset):
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
        Response[LandmarkRecognitionBody | ObjectRecognitionBody | Problem]
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
    body: File,
    alias: str | Unset = UNSET,
    version: int | Unset = UNSET,
    top: int | Unset = 5,
    explain: bool | Unset = False,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> LandmarkRecognitionBody | ObjectRecognitionBody | Problem | None:
    """Recognise one frame. With `Accept: image/png` the answer is the frame with the evidence drawn on it
    (points and votes,
    or candidates and pose); the headers `X-Version` and `X-Digest` say what answered. With
    `Accept: image/png; view=reconstruction` (kind `objects`) it is what the version's eigenspace makes
    of the frame, three
    pictures beside each other: the appearance that is looked at, the same rebuilt from eigenimages, and
    the residual about
    mid-gray, whose length is `X-Distance-From-Space`.

    Args:
        database (str):
        alias (str | Unset):
        version (int | Unset):
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
        LandmarkRecognitionBody | ObjectRecognitionBody | Problem
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
    body: File,
    alias: str | Unset = UNSET,
    version: int | Unset = UNSET,
    top: int | Unset = 5,
    explain: bool | Unset = False,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Response[LandmarkRecognitionBody | ObjectRecognitionBody | Problem]:
    """Recognise one frame. With `Accept: image/png` the answer is the frame with the evidence drawn on it
    (points and votes,
    or candidates and pose); the headers `X-Version` and `X-Digest` say what answered. With
    `Accept: image/png; view=reconstruction` (kind `objects`) it is what the version's eigenspace makes
    of the frame, three
    pictures beside each other: the appearance that is looked at, the same rebuilt from eigenimages, and
    the residual about
    mid-gray, whose length is `X-Distance-From-Space`.

    Args:
        database (str):
        alias (str | Unset):
        version (int | Unset):
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
        Response[LandmarkRecognitionBody | ObjectRecognitionBody | Problem]
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
    body: File,
    alias: str | Unset = UNSET,
    version: int | Unset = UNSET,
    top: int | Unset = 5,
    explain: bool | Unset = False,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> LandmarkRecognitionBody | ObjectRecognitionBody | Problem | None:
    """Recognise one frame. With `Accept: image/png` the answer is the frame with the evidence drawn on it
    (points and votes,
    or candidates and pose); the headers `X-Version` and `X-Digest` say what answered. With
    `Accept: image/png; view=reconstruction` (kind `objects`) it is what the version's eigenspace makes
    of the frame, three
    pictures beside each other: the appearance that is looked at, the same rebuilt from eigenimages, and
    the residual about
    mid-gray, whose length is `X-Distance-From-Space`.

    Args:
        database (str):
        alias (str | Unset):
        version (int | Unset):
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
        LandmarkRecognitionBody | ObjectRecognitionBody | Problem
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
