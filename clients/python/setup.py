"""Generate `landmarkd/_generated` from the service's OpenAPI document while the package is built.

A wheel gets it in its build folder, a source distribution in its tree, an editable install in this folder (where git
ignores it). A build from a source distribution, which holds it already, generates nothing.
"""

import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist

HERE = Path(__file__).resolve().parent
DOCUMENT = Path(os.environ.get("LANDMARKD_DOCUMENT", HERE / ".." / ".." / "openapi" / "landmarkd.json"))
GENERATED = Path("landmarkd", "_generated")


def generate(root: Path) -> None:
    """Replace `landmarkd/_generated` below `root`, if the document is there; refuse if there is neither."""
    target = root / GENERATED
    if not DOCUMENT.is_file():
        if not (HERE / GENERATED).is_dir():
            sys.exit(f"{DOCUMENT}, from which {GENERATED} is generated, is not there; LANDMARKD_DOCUMENT may name it")
        return
    scripts = sysconfig.get_path("scripts")
    environment = os.environ | {"PATH": os.pathsep.join([os.environ.get("PATH", ""), scripts])}
    with tempfile.TemporaryDirectory() as work:
        document, made = Path(work, "document.json"), Path(work, "made")
        subprocess.run([sys.executable, HERE.parent / "document.py", DOCUMENT, document], check=True)
        generator = [sys.executable, "-m", "openapi_python_client", "generate", "--meta", "none", "--fail-on-warning"]
        paths = ["--path", document, "--config", HERE / "generate.yaml", "--output-path", made]
        subprocess.run([*generator, *paths], check=True, env=environment)
        shutil.rmtree(target, ignore_errors=True)
        shutil.copytree(made, target, ignore=shutil.ignore_patterns(".ruff_cache"))


class Build(build_py):
    """Builds the package and the generated part of it."""

    def run(self) -> None:  # noqa: D102
        super().run()
        generate(HERE if self.editable_mode else Path(self.build_lib))


class SourceDistribution(sdist):
    """Packs the generated part as well, because the document is outside the package's folder."""

    def make_release_tree(self, base_dir: str, files: list[str]) -> None:  # noqa: D102
        super().make_release_tree(base_dir, files)
        generate(Path(base_dir))


setup(cmdclass={"build_py": Build, "sdist": SourceDistribution})
