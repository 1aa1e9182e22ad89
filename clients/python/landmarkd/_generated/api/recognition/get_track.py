from http import HTTPStatus
from typing import Any
from urllib.parse import quote
from uuid import UUID

import httpx

from ...client import AuthenticatedClient, Client
from ...models.problem import Problem
from ...models.track_detail import TrackDetail
from ...types import UNSET, Response, Unset


def _get_kwargs(
    database: str,
    id: UUID,
    *,
    top: int | Unset = 5,
) -> dict[str, Any]:

    params: dict[str, Any] = {}

    params["top"] = top

    params = {k: v for k, v in params.items() if v is not UNSET and v is not None}

    _kwargs: dict[str, Any] = {
        "method": "get",
        "url": "/v1/databases/{database}/tracks/{id}".format(
            database=quote(str(database), safe=""),
            id=quote(str(id), safe=""),
        ),
        "params": params,
    }

    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> Problem | TrackDetail:
    if response.status_code == 200:
        response_200 = TrackDetail.from_dict(response.json())

        return response_200

    response_default = Problem.from_dict(response.json())

    return response_default


def _build_response(
    *, client: AuthenticatedClient | Client, response: httpx.Response
) -> Response[Problem | TrackDetail]:
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
    top: int | Unset = 5,
) -> Response[Problem | TrackDetail]:
    """One track with what is believed. Looking at it doesn't keep it alive.

    Args:
        database (str):
        id (UUID):
        top (int | Unset):  Default: 5.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[Problem | TrackDetail]
    """

    kwargs = _get_kwargs(
        database=database,
        id=id,
        top=top,
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
    top: int | Unset = 5,
) -> Problem | TrackDetail | None:
    """One track with what is believed. Looking at it doesn't keep it alive.

    Args:
        database (str):
        id (UUID):
        top (int | Unset):  Default: 5.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Problem | TrackDetail
    """

    return sync_detailed(
        database=database,
        id=id,
        client=client,
        top=top,
    ).parsed


async def asyncio_detailed(
    database: str,
    id: UUID,
    *,
    client: AuthenticatedClient,
    top: int | Unset = 5,
) -> Response[Problem | TrackDetail]:
    """One track with what is believed. Looking at it doesn't keep it alive.

    Args:
        database (str):
        id (UUID):
        top (int | Unset):  Default: 5.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[Problem | TrackDetail]
    """

    kwargs = _get_kwargs(
        database=database,
        id=id,
        top=top,
    )

    response = await client.get_async_httpx_client().request(**kwargs)

    return _build_response(client=client, response=response)


async def asyncio(
    database: str,
    id: UUID,
    *,
    client: AuthenticatedClient,
    top: int | Unset = 5,
) -> Problem | TrackDetail | None:
    """One track with what is believed. Looking at it doesn't keep it alive.

    Args:
        database (str):
        id (UUID):
        top (int | Unset):  Default: 5.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Problem | TrackDetail
    """

    return (
        await asyncio_detailed(
            database=database,
            id=id,
            client=client,
            top=top,
        )
    ).parsed
