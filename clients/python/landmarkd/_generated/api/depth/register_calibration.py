from http import HTTPStatus
from typing import Any
from urllib.parse import quote

import httpx

from ...client import AuthenticatedClient, Client
from ...models.calibration_body import CalibrationBody
from ...models.problem import Problem
from ...models.registration_form import RegistrationForm
from ...types import Response


def _get_kwargs(
    name: str,
    *,
    body: RegistrationForm,
) -> dict[str, Any]:
    headers: dict[str, Any] = {}

    _kwargs: dict[str, Any] = {
        "method": "post",
        "url": "/v1/calibrations/{name}/registration".format(
            name=quote(str(name), safe=""),
        ),
    }

    _kwargs["files"] = body.to_multipart()

    _kwargs["headers"] = headers
    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> CalibrationBody | Problem:
    if response.status_code == 200:
        response_200 = CalibrationBody.from_dict(response.json())

        return response_200

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
    body: RegistrationForm,
) -> Response[CalibrationBody | Problem]:
    """Register the rig's two pictures by one textured target, and match their brightness. A table measured
    before is
    dropped: it was measured with another registration.

    Args:
        name (str):
        body (RegistrationForm): Pictures to register by.

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
    body: RegistrationForm,
) -> CalibrationBody | Problem | None:
    """Register the rig's two pictures by one textured target, and match their brightness. A table measured
    before is
    dropped: it was measured with another registration.

    Args:
        name (str):
        body (RegistrationForm): Pictures to register by.

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
    body: RegistrationForm,
) -> Response[CalibrationBody | Problem]:
    """Register the rig's two pictures by one textured target, and match their brightness. A table measured
    before is
    dropped: it was measured with another registration.

    Args:
        name (str):
        body (RegistrationForm): Pictures to register by.

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
    body: RegistrationForm,
) -> CalibrationBody | Problem | None:
    """Register the rig's two pictures by one textured target, and match their brightness. A table measured
    before is
    dropped: it was measured with another registration.

    Args:
        name (str):
        body (RegistrationForm): Pictures to register by.

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
