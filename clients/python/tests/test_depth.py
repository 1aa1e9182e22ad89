"""Depth maps as arrays."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

import httpx
import numpy as np
import pytest
from drawing import blurred, texture
from service import Service

from landmarkd import Client, DepthFlag, Optics, Problem
from landmarkd.picture import encoded

OPTICS = Optics(
    focal_length_mm=35, f_number=8, near_focus_mm=500, plane_separation_mm=0.4, pixel_pitch_um=10, telecentric=True
)


@pytest.fixture(scope="module")
def pair() -> tuple[np.ndarray, np.ndarray]:
    """A plane somewhere between the two focus distances."""
    plane = texture(1)
    near, far = blurred(plane, 1.2), blurred(plane, 1.0)
    # A hole without texture: it can't have a depth.
    near[:90, :90] = far[:90, :90] = 128
    return near, far


def test_arrays_are_those_of_the_file_byte_for_byte(
    client: Client, service: Service, pair: tuple[np.ndarray, np.ndarray]
) -> None:
    depth = client.depth(*pair, optics=OPTICS)
    optics = {name: value for name, value in dataclasses.asdict(OPTICS).items() if value is not None}
    files: dict[str, Any] = {
        "near": encoded(pair[0], False),
        "far": encoded(pair[1], False),
        "optics": (None, json.dumps(optics)),
    }

    def file(planes: str) -> bytes:
        url = f"{service.url}/v1/depth-maps?planes={planes}"
        answer = httpx.post(url, files=files, headers={"Accept": "application/x-npy"}, timeout=60)
        assert answer.headers["Content-Type"] == "application/x-npy"
        return answer.content

    assert file("depth").endswith(depth.depth_mm.tobytes())
    assert file("sigma").endswith(depth.sigma_mm.tobytes())
    assert file("flags").endswith(depth.flags.astype(np.float32).tobytes())


def test_two_apertures_and_stacks_are_measured(client: Client, pair: tuple[np.ndarray, np.ndarray]) -> None:
    sharp, blunt = pair[1], pair[0]
    iris = Optics(
        focal_length_mm=35, f_numbers=(2.8, 8), focus_mm=500, range_end_mm=540, pixel_pitch_um=10, telecentric=True
    )
    depth = client.depth(blunt, sharp, optics=iris, apertures=True)
    assert depth.depth_mm.shape == (160, 160)
    assert depth.near_focus_mm > 500
    stack = Optics(focal_length_mm=35, f_number=8, focuses_mm=(500, 583, 701), pixel_pitch_um=10, telecentric=True)
    joined = client.depth_of_stack([*pair, blurred(texture(1), 2.5)], optics=stack)
    assert joined.far_focus_mm == pytest.approx(701)
    with pytest.raises(Problem) as refused:
        client.depth_of_stack(pair, optics=stack)
    assert [error.pointer for error in refused.value.errors] == ["/stack"]


def test_a_pixel_has_a_depth_or_a_flag(client: Client, pair: tuple[np.ndarray, np.ndarray]) -> None:
    depth = client.depth(*pair, optics=OPTICS)
    assert depth.depth_mm.shape == depth.sigma_mm.shape == depth.flags.shape == (160, 160)
    assert [str(plane.dtype) for plane in (depth.depth_mm, depth.flags)] == ["float32", "uint8"]
    known = np.isfinite(depth.depth_mm)
    assert np.array_equal(known, depth.flags == 0)
    assert depth.coverage == pytest.approx(known.mean(), abs=1e-4)
    assert depth.coverage > 0.3
    assert depth.flags[45, 45] & DepthFlag.LOW_TEXTURE
    least, middle, largest = (depth.summary[name] for name in ("min_mm", "median_mm", "max_mm"))
    assert least is not None
    assert middle is not None
    assert largest is not None
    assert depth.near_focus_mm == pytest.approx(500)
    assert depth.near_focus_mm - 20 < least <= middle <= largest < depth.far_focus_mm + 20
    assert depth.summary["low_texture"] == np.count_nonzero(depth.flags & 1)


def test_options_and_their_faults_are_the_services(client: Client, pair: tuple[np.ndarray, np.ndarray]) -> None:
    assert client.depth(*pair, optics=OPTICS, options={"method": "stm", "median": 3}).coverage > 0
    with pytest.raises(Problem) as caught:
        client.depth(*pair, optics=OPTICS, options={"method": "guess"})
    assert (caught.value.status, caught.value.code) == (422, "invalid_field")
    with pytest.raises(Problem) as caught:
        client.depth(pair[0], pair[0], optics=OPTICS)
    assert caught.value.code == "identical_images"
    with pytest.raises(Problem) as caught:
        client.depth(*pair, calibration="nobody")
    assert caught.value.code == "unknown_calibration"


def test_an_optics_is_judged_before_it_is_built(client: Client) -> None:
    prediction = client.predict(OPTICS, contrast=30)
    assert len(prediction.distances) == 41
    working_range_mm = prediction.working_range_mm
    assert isinstance(working_range_mm, list)
    nearest, farthest = working_range_mm
    assert nearest < farthest
    assert prediction.advice
    with pytest.raises(Problem):
        client.predict(OPTICS, range_mm=(900, 600))
