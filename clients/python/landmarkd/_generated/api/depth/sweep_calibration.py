from http import HTTPStatus
from typing import Any
from urllib.parse import quote

import httpx

from ...client import AuthenticatedClient, Client
from ...models.job_body import JobBody
from ...models.problem import Problem
from ...models.sweep_form import SweepForm
from ...types import Response


def _get_kwargs(
    name: str,
    *,
    body: SweepForm,
) -> dict[str, Any]:
    headers: dict[str, Any] = {}

    _kwargs: dict[str, Any] = {
        "method": "post",
        "url": "/v1/calibrations/{name}/sweep".format(
            name=quote(str(name), safe=""),
        ),
    }

    _kwargs["files"] = body.to_multipart()

    _kwargs["headers"] = headers
    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> JobBody | Problem:
    if response.status_code == 202:
        response_202 = JobBody.from_dict(response.json())

        return response_202

    response_default = Problem.from_dict(response.json())

    return response_default


def _build_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> Response[JobBody | Problem]:
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
    body: SweepForm,
) -> Response[JobBody | Problem]:
    """Measure the rig's table: textured planes that face the camera, at known depths. Answers at once with
    a job. Planes
    that are too few, or don't reach past both focus distances, are refused at once; a sweep that isn't
    monotone fails
    the job.

    Args:
        name (str):
        body (SweepForm): A form with a manifest, and one part for each picture that it names.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[JobBody | Problem]
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
    body: SweepForm,
) -> JobBody | Problem | None:
    """Measure the rig's table: textured planes that face the camera, at known depths. Answers at once with
    a job. Planes
    that are too few, or don't reach past both focus distances, are refused at once; a sweep that isn't
    monotone fails
    the job.

    Args:
        name (str):
        body (SweepForm): A form with a manifest, and one part for each picture that it names.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        JobBody | Problem
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
    body: SweepForm,
) -> Response[JobBody | Problem]:
    """Measure the rig's table: textured planes that face the camera, at known depths. Answers at once with
    a job. Planes
    that are too few, or don't reach past both focus distances, are refused at once; a sweep that isn't
    monotone fails
    the job.

    Args:
        name (str):
        body (SweepForm): A form with a manifest, and one part for each picture that it names.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[JobBody | Problem]
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
    body: SweepForm,
) -> JobBody | Problem | None:
    """Measure the rig's table: textured planes that face the camera, at known depths. Answers at once with
    a job. Planes
    that are too few, or don't reach past both focus distances, are refused at once; a sweep that isn't
    monotone fails
    the job.

    Args:
        name (str):
        body (SweepForm): A form with a manifest, and one part for each picture that it names.

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        JobBody | Problem
    """

    return (
        await asyncio_detailed(
            name=name,
            client=client,
            body=body,
        )
    ).parsed
