from http import HTTPStatus
from typing import Any
from urllib.parse import quote

import httpx

from ...client import AuthenticatedClient, Client
from ...models.alias_body import AliasBody
from ...models.problem import Problem
from ...types import Response


def _get_kwargs(
    database: str,
    alias: str,
) -> dict[str, Any]:

    _kwargs: dict[str, Any] = {
        "method": "get",
        "url": "/v1/databases/{database}/aliases/{alias}".format(
            database=quote(str(database), safe=""),
            alias=quote(str(alias), safe=""),
        ),
    }

    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> AliasBody | Problem:
    if response.status_code == 200:
        response_200 = AliasBody.from_dict(response.json())

        return response_200

    response_default = Problem.from_dict(response.json())

    return response_default


def _build_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> Response[AliasBody | Problem]:
    return Response(
        status_code=HTTPStatus(response.status_code),
        content=response.content,
        headers=response.headers,
        parsed=_parse_response(client=client, response=response),
    )


def sync_detailed(
    database: str,
    alias: str,
    *,
    client: AuthenticatedClient,
) -> Response[AliasBody | Problem]:
    """One alias.

    Args:
        database (str):
        alias (str):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[AliasBody | Problem]
    """

    kwargs = _get_kwargs(
        database=database,
        alias=alias,
    )

    response = client.get_httpx_client().request(
        **kwargs,
    )

    return _build_response(client=client, response=response)


def sync(
    database: str,
    alias: str,
    *,
    client: AuthenticatedClient,
) -> AliasBody | Problem | None:
    """One alias.

    Args:
        database (str):
        alias (str):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        AliasBody | Problem
    """

    return sync_detailed(
        database=database,
        alias=alias,
        client=client,
    ).parsed


async def asyncio_detailed(
    database: str,
    alias: str,
    *,
    client: AuthenticatedClient,
) -> Response[AliasBody | Problem]:
    """One alias.

    Args:
        database (str):
        alias (str):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[AliasBody | Problem]
    """

    kwargs = _get_kwargs(
        database=database,
        alias=alias,
    )

    response = await client.get_async_httpx_client().request(**kwargs)

    return _build_response(client=client, response=response)


async def asyncio(
    database: str,
    alias: str,
    *,
    client: AuthenticatedClient,
) -> AliasBody | Problem | None:
    """One alias.

    Args:
        database (str):
        alias (str):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        AliasBody | Problem
    """

    return (
        await asyncio_detailed(
            database=database,
            alias=alias,
            client=client,
        )
    ).parsed
