"""The generated code is what the script makes of the service's document."""

from __future__ import annotations

import filecmp
import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parents[1]
DOCUMENT = Path(os.environ.get("LANDMARKD_DOCUMENT", HERE.parents[1] / "openapi" / "landmarkd.json"))


def differences(left: Path, right: Path, under: str = "") -> list[str]:
    """Files that are not the same in both folders."""
    compared = filecmp.dircmp(left / under, right / under, ignore=["__pycache__"], hide=[])
    _, other, strange = filecmp.cmpfiles(left / under, right / under, compared.common_files, shallow=False)
    found = [os.path.join(under, name) for name in compared.left_only + compared.right_only + other + strange]
    for folder in compared.common_dirs:
        found += differences(left, right, os.path.join(under, folder))
    return found


@pytest.mark.skipif(not DOCUMENT.exists(), reason="the service's document isn't here")
@pytest.mark.skipif(
    importlib.util.find_spec("openapi_python_client") is None, reason="pip install '.[generate]' for this one"
)
def test_generated_code_is_current(tmp_path: Path) -> None:
    made = tmp_path / "_generated"
    subprocess.run([HERE / "generate.sh", made], check=True, env=os.environ | {"PYTHON": sys.executable})
    assert differences(made, HERE / "landmarkd" / "_generated") == [], "run generate.sh"
