"""Folders of frames that aren't as they should be."""

import threading
from pathlib import Path

import pytest

from landmarkd.frames import played, watched


def test_an_empty_folder_is_said_to_hold_no_picture(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="holds no picture"):
        next(played(tmp_path, 0))


def test_a_frame_that_is_gone_is_passed_over(tmp_path: Path) -> None:
    (tmp_path / "gone.png").symlink_to(tmp_path / "nowhere")
    (tmp_path / "here.png").write_bytes(b"a picture")
    stop = threading.Event()
    frame = next(watched(tmp_path, stop, 0.001))
    stop.set()
    assert (frame.id, frame.picture) == ("here.png", b"a picture")
