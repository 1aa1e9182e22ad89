from http import HTTPStatus
from typing import Any

import httpx

from ...client import AuthenticatedClient, Client
from ...models.list_jobs_state import ListJobsState
from ...models.page_job_body import PageJobBody
from ...models.problem import Problem
from ...types import UNSET, Response, Unset


def _get_kwargs(
    *,
    database: str | Unset = UNSET,
    calibration: str | Unset = UNSET,
    state: ListJobsState | Unset = UNSET,
    limit: int | Unset = 100,
    cursor: str | Unset = UNSET,
) -> dict[str, Any]:

    params: dict[str, Any] = {}

    params["database"] = database

    params["calibration"] = calibration

    json_state: str | Unset = UNSET
    if not isinstance(state, Unset):
        json_state = state

    params["state"] = json_state

    params["limit"] = limit

    params["cursor"] = cursor

    params = {k: v for k, v in params.items() if v is not UNSET and v is not None}

    _kwargs: dict[str, Any] = {
        "method": "get",
        "url": "/v1/jobs",
        "params": params,
    }

    return _kwargs


def _parse_response(*, client: AuthenticatedClient | Client, response: httpx.Response) -> PageJobBody | Problem:
    if response.status_code == 200:
        response_200 = PageJobBody.from_dict(response.json())

        return response_200

    response_default = Problem.from_dict(response.json())

    return response_default


def _build_response(
    *, client: AuthenticatedClient | Client, response: httpx.Response
) -> Response[PageJobBody | Problem]:
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
    calibration: str | Unset = UNSET,
    state: ListJobsState | Unset = UNSET,
    limit: int | Unset = 100,
    cursor: str | Unset = UNSET,
) -> Response[PageJobBody | Problem]:
    """Jobs, the newest first.

    Args:
        database (str | Unset):
        calibration (str | Unset):
        state (ListJobsState | Unset): The life of a job.
        limit (int | Unset):  Default: 100.
        cursor (str | Unset):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[PageJobBody | Problem]
    """

    kwargs = _get_kwargs(
        database=database,
        calibration=calibration,
        state=state,
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
    calibration: str | Unset = UNSET,
    state: ListJobsState | Unset = UNSET,
    limit: int | Unset = 100,
    cursor: str | Unset = UNSET,
) -> PageJobBody | Problem | None:
    """Jobs, the newest first.

    Args:
        database (str | Unset):
        calibration (str | Unset):
        state (ListJobsState | Unset): The life of a job.
        limit (int | Unset):  Default: 100.
        cursor (str | Unset):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        PageJobBody | Problem
    """

    return sync_detailed(
        client=client,
        database=database,
        calibration=calibration,
        state=state,
        limit=limit,
        cursor=cursor,
    ).parsed


async def asyncio_detailed(
    *,
    client: AuthenticatedClient,
    database: str | Unset = UNSET,
    calibration: str | Unset = UNSET,
    state: ListJobsState | Unset = UNSET,
    limit: int | Unset = 100,
    cursor: str | Unset = UNSET,
) -> Response[PageJobBody | Problem]:
    """Jobs, the newest first.

    Args:
        database (str | Unset):
        calibration (str | Unset):
        state (ListJobsState | Unset): The life of a job.
        limit (int | Unset):  Default: 100.
        cursor (str | Unset):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        Response[PageJobBody | Problem]
    """

    kwargs = _get_kwargs(
        database=database,
        calibration=calibration,
        state=state,
        limit=limit,
        cursor=cursor,
    )

    response = await client.get_async_httpx_client().request(**kwargs)

    return _build_response(client=client, response=response)


async def asyncio(
    *,
    client: AuthenticatedClient,
    database: str | Unset = UNSET,
    calibration: str | Unset = UNSET,
    state: ListJobsState | Unset = UNSET,
    limit: int | Unset = 100,
    cursor: str | Unset = UNSET,
) -> PageJobBody | Problem | None:
    """Jobs, the newest first.

    Args:
        database (str | Unset):
        calibration (str | Unset):
        state (ListJobsState | Unset): The life of a job.
        limit (int | Unset):  Default: 100.
        cursor (str | Unset):

    Raises:
        errors.UnexpectedStatus: If the server returns an undocumented status code and Client.raise_on_unexpected_status is True.
        httpx.TimeoutException: If the request takes longer than Client.timeout.

    Returns:
        PageJobBody | Problem
    """

    return (
        await asyncio_detailed(
            client=client,
            database=database,
            calibration=calibration,
            state=state,
            limit=limit,
            cursor=cursor,
        )
    ).parsed
