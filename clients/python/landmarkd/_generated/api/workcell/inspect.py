from http import HTTPStatus
from typing import Any
from urllib.parse import quote

import httpx

from ...client import AuthenticatedClient, Client
from ...models.inspect_pair_view import InspectPairView
from ...models.inspection_body import InspectionBody
from ...models.inspection_form import InspectionForm
from ...models.problem import Problem
from ...types import UNSET, Response, Unset


def _get_kwargs(
    name: str,
    *,
    body: InspectionForm,
    alias: str | Unset = UNSET,
    version: int | Unset = UNSET,
    region: int | Unset = UNSET,
    pair_view: InspectPairView | Unset = UNSET,
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

    params["region"] = region

    json_pair_view: str | Unset = UNSET
    if not isinstance(pair_view, Unset):
        json_pair_view = pair_view

    params["pair_view"] = json_pair_view

    params = {k: v for k, v in params.items() if v is not UNSET and v is not None}

    _kwargs: dict[str, Any] = {
        "method": "post",
        "url": "/v1/workcells/{name}/inspections".format(
            name=quote(str(name), safe=""),
        ),
        "params": params,
    }

    _kwargs["files"] = body.to_multipart()

    _kwargs["headers"] = headers
    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> InspectionBody | Problem:
    if response.status_code == 200:
        response_200 = InspectionBody.from_dict(response.json())

        return response_200

    response_default = Problem.from_dict(response.json())

    return response_default


def _build_response(
    *, client: AuthenticatedClient | Client, response: httpx.Response
) -> Response[InspectionBody | Problem]:
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
    body: InspectionForm,
    alias: str | Unset = UNSET,
    version: int | Unset = UNSET,
    region: int | Unset = UNSET,
    pair_view: InspectPairView | Unset = UNSET,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Response[InspectionBody | Problem]:
    """Find every part on the table, say what it is, how it is turned and where to reach; with a focal
    pair, how far away
    it is. Parts that are nothing known have no decision, and are answered too. With `Accept: image/png`
    the answer is
    the picture with the parts drawn on it; the headers `X-Version` and `X-Digest` say what answered.

    Args:
        name (str):
        alias (str | Unset):
        version (int | Unset):
        region (int | Unset):
        pair_view (InspectPairView | Unset): What the pair shows.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (InspectionForm): The table, and with `near` and `far` a focal pair of a part or of
            the table.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[InspectionBody | Problem]
    """

    kwargs = _get_kwargs(
        name=name,
        body=body,
        alias=alias,
        version=version,
        region=region,
        pair_view=pair_view,
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
    body: InspectionForm,
    alias: str | Unset = UNSET,
    version: int | Unset = UNSET,
    region: int | Unset = UNSET,
    pair_view: InspectPairView | Unset = UNSET,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> InspectionBody | Problem | None:
    """Find every part on the table, say what it is, how it is turned and where to reach; with a focal
    pair, how far away
    it is. Parts that are nothing known have no decision, and are answered too. With `Accept: image/png`
    the answer is
    the picture with the parts drawn on it; the headers `X-Version` and `X-Digest` say what answered.

    Args:
        name (str):
        alias (str | Unset):
        version (int | Unset):
        region (int | Unset):
        pair_view (InspectPairView | Unset): What the pair shows.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (InspectionForm): The table, and with `near` and `far` a focal pair of a part or of
            the table.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        InspectionBody | Problem
    """

    return sync_detailed(
        name=name,
        client=client,
        body=body,
        alias=alias,
        version=version,
        region=region,
        pair_view=pair_view,
        x_robot_id=x_robot_id,
        x_frame_id=x_frame_id,
        x_stamp=x_stamp,
    ).parsed


async def asyncio_detailed(
    name: str,
    *,
    client: AuthenticatedClient,
    body: InspectionForm,
    alias: str | Unset = UNSET,
    version: int | Unset = UNSET,
    region: int | Unset = UNSET,
    pair_view: InspectPairView | Unset = UNSET,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> Response[InspectionBody | Problem]:
    """Find every part on the table, say what it is, how it is turned and where to reach; with a focal
    pair, how far away
    it is. Parts that are nothing known have no decision, and are answered too. With `Accept: image/png`
    the answer is
    the picture with the parts drawn on it; the headers `X-Version` and `X-Digest` say what answered.

    Args:
        name (str):
        alias (str | Unset):
        version (int | Unset):
        region (int | Unset):
        pair_view (InspectPairView | Unset): What the pair shows.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (InspectionForm): The table, and with `near` and `far` a focal pair of a part or of
            the table.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[InspectionBody | Problem]
    """

    kwargs = _get_kwargs(
        name=name,
        body=body,
        alias=alias,
        version=version,
        region=region,
        pair_view=pair_view,
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
    body: InspectionForm,
    alias: str | Unset = UNSET,
    version: int | Unset = UNSET,
    region: int | Unset = UNSET,
    pair_view: InspectPairView | Unset = UNSET,
    x_robot_id: str | Unset = UNSET,
    x_frame_id: str | Unset = UNSET,
    x_stamp: str | Unset = UNSET,
) -> InspectionBody | Problem | None:
    """Find every part on the table, say what it is, how it is turned and where to reach; with a focal
    pair, how far away
    it is. Parts that are nothing known have no decision, and are answered too. With `Accept: image/png`
    the answer is
    the picture with the parts drawn on it; the headers `X-Version` and `X-Digest` say what answered.

    Args:
        name (str):
        alias (str | Unset):
        version (int | Unset):
        region (int | Unset):
        pair_view (InspectPairView | Unset): What the pair shows.
        x_robot_id (str | Unset):
        x_frame_id (str | Unset):
        x_stamp (str | Unset):
        body (InspectionForm): The table, and with `near` and `far` a focal pair of a part or of
            the table.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        InspectionBody | Problem
    """

    return (
        await asyncio_detailed(
            name=name,
            client=client,
            body=body,
            alias=alias,
            version=version,
            region=region,
            pair_view=pair_view,
            x_robot_id=x_robot_id,
            x_frame_id=x_frame_id,
            x_stamp=x_stamp,
        )
    ).parsed
