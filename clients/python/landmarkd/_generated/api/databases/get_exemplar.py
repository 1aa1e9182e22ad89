from http import HTTPStatus
from typing import Any
from urllib.parse import quote
from uuid import UUID

import httpx

from ...client import AuthenticatedClient, Client
from ...models.exemplar_body import ExemplarBody
from ...models.problem import Problem
from ...types import Response


def _get_kwargs(
    database: str,
    id: UUID,
) -> dict[str, Any]:

    _kwargs: dict[str, Any] = {
        "method": "get",
        "url": "/v1/databases/{database}/exemplars/{id}".format(
            database=quote(str(database), safe=""),
            id=quote(str(id), safe=""),
        ),
    }

    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> ExemplarBody | Problem:
    if response.status_code == 200:
        response_200 = ExemplarBody.from_dict(response.json())

        return response_200

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
    id: UUID,
    *,
    client: AuthenticatedClient,
) -> Response[ExemplarBody | Problem]:
    """One training image.

    Args:
        database (str):
        id (UUID):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[ExemplarBody | Problem]
    """

    kwargs = _get_kwargs(
        database=database,
        id=id,
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
) -> ExemplarBody | Problem | None:
    """One training image.

    Args:
        database (str):
        id (UUID):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        ExemplarBody | Problem
    """

    return sync_detailed(
        database=database,
        id=id,
        client=client,
    ).parsed


async def asyncio_detailed(
    database: str,
    id: UUID,
    *,
    client: AuthenticatedClient,
) -> Response[ExemplarBody | Problem]:
    """One training image.

    Args:
        database (str):
        id (UUID):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[ExemplarBody | Problem]
    """

    kwargs = _get_kwargs(
        database=database,
        id=id,
    )

    response = await client.get_async_httpx_client().request(**kwargs)

    return _build_response(client=client, response=response)


async def asyncio(
    database: str,
    id: UUID,
    *,
    client: AuthenticatedClient,
) -> ExemplarBody | Problem | None:
    """One training image.

    Args:
        database (str):
        id (UUID):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        ExemplarBody | Problem
    """

    return (
        await asyncio_detailed(
            database=database,
            id=id,
            client=client,
        )
    ).parsed
