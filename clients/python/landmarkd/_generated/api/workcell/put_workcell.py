from http import HTTPStatus
from typing import Any
from urllib.parse import quote

import httpx

from ...client import AuthenticatedClient, Client
from ...models.problem import Problem
from ...models.put_workcell import PutWorkcell
from ...models.workcell_body import WorkcellBody
from ...types import Response


def _get_kwargs(
    name: str,
    *,
    body: PutWorkcell,
) -> dict[str, Any]:
    headers: dict[str, Any] = {}

    _kwargs: dict[str, Any] = {
        "method": "put",
        "url": "/v1/workcells/{name}".format(
            name=quote(str(name), safe=""),
        ),
    }

    _kwargs["json"] = body.to_dict()

    headers["Content-Type"] = "application/json"

    _kwargs["headers"] = headers
    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> Problem | WorkcellBody:
    if response.status_code == 200:
        response_200 = WorkcellBody.from_dict(response.json())

        return response_200

    if response.status_code == 201:
        response_201 = WorkcellBody.from_dict(response.json())

        return response_201

    response_default = Problem.from_dict(response.json())

    return response_default


def _build_response(
    *, client: AuthenticatedClient | Client, response: httpx.Response
) -> Response[Problem | WorkcellBody]:
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
    body: PutWorkcell,
) -> Response[Problem | WorkcellBody]:
    """Describe a workcell; one of that name is replaced. The database must be there, trained or not, and
    of kind
    `objects`; so must the calibration, if one is named.

    Args:
        name (str):
        body (PutWorkcell): What is known of a workcell.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[Problem | WorkcellBody]
    """

    kwargs = _get_kwargs(
        name=name,
        body=body,
    )

    response = client.get_httpx_client().request(
        **kwargs,
    )

    return _build_response(client=client, response=response)


def sync(
    name: str,
    *,
    client: AuthenticatedClient,
    body: PutWorkcell,
) -> Problem | WorkcellBody | None:
    """Describe a workcell; one of that name is replaced. The database must be there, trained or not, and
    of kind
    `objects`; so must the calibration, if one is named.

    Args:
        name (str):
        body (PutWorkcell): What is known of a workcell.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Problem | WorkcellBody
    """

    return sync_detailed(
        name=name,
        client=client,
        body=body,
    ).parsed


async def asyncio_detailed(
    name: str,
    *,
    client: AuthenticatedClient,
    body: PutWorkcell,
) -> Response[Problem | WorkcellBody]:
    """Describe a workcell; one of that name is replaced. The database must be there, trained or not, and
    of kind
    `objects`; so must the calibration, if one is named.

    Args:
        name (str):
        body (PutWorkcell): What is known of a workcell.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[Problem | WorkcellBody]
    """

    kwargs = _get_kwargs(
        name=name,
        body=body,
    )

    response = await client.get_async_httpx_client().request(**kwargs)

    return _build_response(client=client, response=response)


async def asyncio(
    name: str,
    *,
    client: AuthenticatedClient,
    body: PutWorkcell,
) -> Problem | WorkcellBody | None:
    """Describe a workcell; one of that name is replaced. The database must be there, trained or not, and
    of kind
    `objects`; so must the calibration, if one is named.

    Args:
        name (str):
        body (PutWorkcell): What is known of a workcell.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Problem | WorkcellBody
    """

    return (
        await asyncio_detailed(
            name=name,
            client=client,
            body=body,
        )
    ).parsed
