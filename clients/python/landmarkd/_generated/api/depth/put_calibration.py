from http import HTTPStatus
from typing import Any
from urllib.parse import quote

import httpx

from ...client import AuthenticatedClient, Client
from ...models.calibration_body import CalibrationBody
from ...models.optics_body import OpticsBody
from ...models.problem import Problem
from ...types import Response


def _get_kwargs(
    name: str,
    *,
    body: OpticsBody,
) -> dict[str, Any]:
    headers: dict[str, Any] = {}

    _kwargs: dict[str, Any] = {
        "method": "put",
        "url": "/v1/calibrations/{name}".format(
            name=quote(str(name), safe=""),
        ),
    }

    _kwargs["json"] = body.to_dict()

    headers["Content-Type"] = "application/json"

    _kwargs["headers"] = headers
    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> CalibrationBody | Problem:
    if response.status_code == 200:
        response_200 = CalibrationBody.from_dict(response.json())

        return response_200

    if response.status_code == 201:
        response_201 = CalibrationBody.from_dict(response.json())

        return response_201

    response_default = Problem.from_dict(response.json())

    return response_default


def _build_response(
    *, client: AuthenticatedClient | Client, response: httpx.Response
) -> Response[CalibrationBody | Problem]:
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
    body: OpticsBody,
) -> Response[CalibrationBody | Problem]:
    """Describe a rig by its optics. The same optics again changes nothing; another drops what was measured
    with the one
    before: registration, brightness and table.

    Args:
        name (str):
        body (OpticsBody): One lens before two sensors. Exactly one of `aperture_mm` and
            `f_number`, and exactly one of `near_plane_mm` and
            `near_focus_mm`.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[CalibrationBody | Problem]
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
    body: OpticsBody,
) -> CalibrationBody | Problem | None:
    """Describe a rig by its optics. The same optics again changes nothing; another drops what was measured
    with the one
    before: registration, brightness and table.

    Args:
        name (str):
        body (OpticsBody): One lens before two sensors. Exactly one of `aperture_mm` and
            `f_number`, and exactly one of `near_plane_mm` and
            `near_focus_mm`.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        CalibrationBody | Problem
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
    body: OpticsBody,
) -> Response[CalibrationBody | Problem]:
    """Describe a rig by its optics. The same optics again changes nothing; another drops what was measured
    with the one
    before: registration, brightness and table.

    Args:
        name (str):
        body (OpticsBody): One lens before two sensors. Exactly one of `aperture_mm` and
            `f_number`, and exactly one of `near_plane_mm` and
            `near_focus_mm`.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[CalibrationBody | Problem]
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
    body: OpticsBody,
) -> CalibrationBody | Problem | None:
    """Describe a rig by its optics. The same optics again changes nothing; another drops what was measured
    with the one
    before: registration, brightness and table.

    Args:
        name (str):
        body (OpticsBody): One lens before two sensors. Exactly one of `aperture_mm` and
            `f_number`, and exactly one of `near_plane_mm` and
            `near_focus_mm`.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        CalibrationBody | Problem
    """

    return (
        await asyncio_detailed(
            name=name,
            client=client,
            body=body,
        )
    ).parsed
