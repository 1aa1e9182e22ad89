from http import HTTPStatus
from typing import Any
from urllib.parse import quote

import httpx

from ...client import AuthenticatedClient, Client
from ...models.problem import Problem
from ...models.version_body import VersionBody
from ...types import File, Response


def _get_kwargs(
    database: str,
    *,
    body: File,
) -> dict[str, Any]:
    headers: dict[str, Any] = {}

    _kwargs: dict[str, Any] = {
        "method": "post",
        "url": "/v1/databases/{database}/versions".format(
            database=quote(str(database), safe=""),
        ),
    }

    _kwargs["content"] = body.payload

    headers["Content-Type"] = "application/octet-stream"

    _kwargs["headers"] = headers
    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> Problem | VersionBody:
    if response.status_code == 200:
        response_200 = VersionBody.from_dict(response.json())

        return response_200

    if response.status_code == 201:
        response_201 = VersionBody.from_dict(response.json())

        return response_201

    response_default = Problem.from_dict(response.json())

    return response_default


def _build_response(
    *, client: AuthenticatedClient | Client, response: httpx.Response
) -> Response[Problem | VersionBody]:
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
) -> Response[Problem | VersionBody]:
    """Take in an artifact file: checked whole, then a new version. The same digest again is the same
    version.

    Args:
        database (str):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[Problem | VersionBody]
    """

    kwargs = _get_kwargs(
        database=database,
        body=body,
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
) -> Problem | VersionBody | None:
    """Take in an artifact file: checked whole, then a new version. The same digest again is the same
    version.

    Args:
        database (str):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Problem | VersionBody
    """

    return sync_detailed(
        database=database,
        client=client,
        body=body,
    ).parsed


async def asyncio_detailed(
    database: str,
    *,
    client: AuthenticatedClient,
    body: File,
) -> Response[Problem | VersionBody]:
    """Take in an artifact file: checked whole, then a new version. The same digest again is the same
    version.

    Args:
        database (str):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[Problem | VersionBody]
    """

    kwargs = _get_kwargs(
        database=database,
        body=body,
    )

    response = await client.get_async_httpx_client().request(**kwargs)

    return _build_response(client=client, response=response)


async def asyncio(
    database: str,
    *,
    client: AuthenticatedClient,
    body: File,
) -> Problem | VersionBody | None:
    """Take in an artifact file: checked whole, then a new version. The same digest again is the same
    version.

    Args:
        database (str):
        body (File):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Problem | VersionBody
    """

    return (
        await asyncio_detailed(
            database=database,
            client=client,
            body=body,
        )
    ).parsed
