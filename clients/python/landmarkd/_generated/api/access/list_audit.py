from http import HTTPStatus
from typing import Any

import httpx

from ...client import AuthenticatedClient, Client
from ...models.page_audit_body import PageAuditBody
from ...models.problem import Problem
from ...types import UNSET, Response, Unset


def _get_kwargs(
    *,
    database: str | Unset = UNSET,
    key: str | Unset = UNSET,
    action: str | Unset = UNSET,
    limit: int | Unset = 100,
    cursor: str | Unset = UNSET,
) -> dict[str, Any]:

    params: dict[str, Any] = {}

    params["database"] = database

    params["key"] = key

    params["action"] = action

    params["limit"] = limit

    params["cursor"] = cursor

    params = {k: v for k, v in params.items() if v is not UNSET and v is not None}

    _kwargs: dict[str, Any] = {
        "method": "get",
        "url": "/v1/audit",
        "params": params,
    }

    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> PageAuditBody | Problem:
    if response.status_code == 200:
        response_200 = PageAuditBody.from_dict(response.json())

        return response_200

    response_default = Problem.from_dict(response.json())

    return response_default


def _build_response(
    *, client: AuthenticatedClient | Client, response: httpx.Response
) -> Response[PageAuditBody | Problem]:
    return Response(
        status_code=HTTPStatus(response.status_code),
        content=response.content,
        headers=response.headers,
        parsed=_parse_response(client=client, response=response),
    )


def sync_detailed(
    *,
    client: AuthenticatedClient,
    database: str | Unset = UNSET,
    key: str | Unset = UNSET,
    action: str | Unset = UNSET,
    limit: int | Unset = 100,
    cursor: str | Unset = UNSET,
) -> Response[PageAuditBody | Problem]:
    """Who changed what, the newest first: databases, aliases, versions, keys, calibrations, workcells,
    jobs and everything
    that was deleted. An entry is written with its change, and can't be changed or deleted.

    Args:
        database (str | Unset):
        key (str | Unset):
        action (str | Unset):
        limit (int | Unset):  Default: 100.
        cursor (str | Unset):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[PageAuditBody | Problem]
    """

    kwargs = _get_kwargs(
        database=database,
        key=key,
        action=action,
        limit=limit,
        cursor=cursor,
    )

    response = client.get_httpx_client().request(
        **kwargs,
    )

    return _build_response(client=client, response=response)


def sync(
    *,
    client: AuthenticatedClient,
    database: str | Unset = UNSET,
    key: str | Unset = UNSET,
    action: str | Unset = UNSET,
    limit: int | Unset = 100,
    cursor: str | Unset = UNSET,
) -> PageAuditBody | Problem | None:
    """Who changed what, the newest first: databases, aliases, versions, keys, calibrations, workcells,
    jobs and everything
    that was deleted. An entry is written with its change, and can't be changed or deleted.

    Args:
        database (str | Unset):
        key (str | Unset):
        action (str | Unset):
        limit (int | Unset):  Default: 100.
        cursor (str | Unset):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        PageAuditBody | Problem
    """

    return sync_detailed(
        client=client,
        database=database,
        key=key,
        action=action,
        limit=limit,
        cursor=cursor,
    ).parsed


async def asyncio_detailed(
    *,
    client: AuthenticatedClient,
    database: str | Unset = UNSET,
    key: str | Unset = UNSET,
    action: str | Unset = UNSET,
    limit: int | Unset = 100,
    cursor: str | Unset = UNSET,
) -> Response[PageAuditBody | Problem]:
    """Who changed what, the newest first: databases, aliases, versions, keys, calibrations, workcells,
    jobs and everything
    that was deleted. An entry is written with its change, and can't be changed or deleted.

    Args:
        database (str | Unset):
        key (str | Unset):
        action (str | Unset):
        limit (int | Unset):  Default: 100.
        cursor (str | Unset):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[PageAuditBody | Problem]
    """

    kwargs = _get_kwargs(
        database=database,
        key=key,
        action=action,
        limit=limit,
        cursor=cursor,
    )

    response = await client.get_async_httpx_client().request(**kwargs)

    return _build_response(client=client, response=response)


async def asyncio(
    *,
    client: AuthenticatedClient,
    database: str | Unset = UNSET,
    key: str | Unset = UNSET,
    action: str | Unset = UNSET,
    limit: int | Unset = 100,
    cursor: str | Unset = UNSET,
) -> PageAuditBody | Problem | None:
    """Who changed what, the newest first: databases, aliases, versions, keys, calibrations, workcells,
    jobs and everything
    that was deleted. An entry is written with its change, and can't be changed or deleted.

    Args:
        database (str | Unset):
        key (str | Unset):
        action (str | Unset):
        limit (int | Unset):  Default: 100.
        cursor (str | Unset):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        PageAuditBody | Problem
    """

    return (
        await asyncio_detailed(
            client=client,
            database=database,
            key=key,
            action=action,
            limit=limit,
            cursor=cursor,
        )
    ).parsed
