from http import HTTPStatus
from typing import Any
from urllib.parse import quote

import httpx

from ...client import AuthenticatedClient, Client
from ...models.alias_body import AliasBody
from ...models.new_alias import NewAlias
from ...models.problem import Problem
from ...types import Response


def _get_kwargs(
    database: str,
    alias: str,
    *,
    body: NewAlias,
) -> dict[str, Any]:
    headers: dict[str, Any] = {}

    _kwargs: dict[str, Any] = {
        "method": "put",
        "url": "/v1/databases/{database}/aliases/{alias}".format(
            database=quote(str(database), safe=""),
            alias=quote(str(alias), safe=""),
        ),
    }

    _kwargs["json"] = body.to_dict()

    headers["Content-Type"] = "application/json"

    _kwargs["headers"] = headers
    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> AliasBody | Problem:
    if response.status_code == 200:
        response_200 = AliasBody.from_dict(response.json())

        return response_200

    if response.status_code == 201:
        response_201 = AliasBody.from_dict(response.json())

        return response_201

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
    body: NewAlias,
) -> Response[AliasBody | Problem]:
    """Point an alias to a version. The answer comes when this process serves it.

    Args:
        database (str):
        alias (str):
        body (NewAlias): Where an alias shall point.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[AliasBody | Problem]
    """

    kwargs = _get_kwargs(
        database=database,
        alias=alias,
        body=body,
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
    body: NewAlias,
) -> AliasBody | Problem | None:
    """Point an alias to a version. The answer comes when this process serves it.

    Args:
        database (str):
        alias (str):
        body (NewAlias): Where an alias shall point.

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
        body=body,
    ).parsed


async def asyncio_detailed(
    database: str,
    alias: str,
    *,
    client: AuthenticatedClient,
    body: NewAlias,
) -> Response[AliasBody | Problem]:
    """Point an alias to a version. The answer comes when this process serves it.

    Args:
        database (str):
        alias (str):
        body (NewAlias): Where an alias shall point.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[AliasBody | Problem]
    """

    kwargs = _get_kwargs(
        database=database,
        alias=alias,
        body=body,
    )

    response = await client.get_async_httpx_client().request(**kwargs)

    return _build_response(client=client, response=response)


async def asyncio(
    database: str,
    alias: str,
    *,
    client: AuthenticatedClient,
    body: NewAlias,
) -> AliasBody | Problem | None:
    """Point an alias to a version. The answer comes when this process serves it.

    Args:
        database (str):
        alias (str):
        body (NewAlias): Where an alias shall point.

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
            body=body,
        )
    ).parsed
