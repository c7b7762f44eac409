"""The wheel that `pip install .` builds: the whole package with its data, and nothing else."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.thorough import keep

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("symbolic", "analysis", "proofs", "reports")
AT_THE_TOP = ("__init__.py", "__main__.py", "py.typed", "pyproject.toml", "README.md", "LICENSE")
NOT_PACKAGED = ("tests", "docs", ".venv", "build")


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the sources with what must not be packaged beside them, so that nothing is built in the repository."""
    folder = tmp_path_factory.mktemp("source")
    for package in PACKAGES:
        shutil.copytree(ROOT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
    for name in AT_THE_TOP:
        shutil.copy(ROOT / name, folder)
    for name in NOT_PACKAGED:
        (folder / name).mkdir()
        (folder / name / "other.py").write_text("", encoding="utf-8")
    return folder


# what pip calls in the end (PEP 517), and pip
BACKEND = ["-c", "import sys; from setuptools import build_meta; build_meta.build_wheel(sys.argv[1])"]
PIP = ["-m", "pip", "wheel", ".", "--no-deps", "--no-build-isolation", "--no-index", "-q", "-w"]


@pytest.mark.parametrize("build", keep(1, [BACKEND, PIP]), ids=["backend", "pip"])
def test_the_wheel_holds_the_package_and_nothing_else(source: Path, tmp_path: Path, build: list[str]) -> None:
    command = [sys.executable, *build, str(tmp_path)]
    done = subprocess.run(command, cwd=source, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (wheel,) = tmp_path.glob("nonsmooth-*-py3-none-any.whl")
    with zipfile.ZipFile(wheel) as archive:
        held = {name for name in archive.namelist() if ".dist-info/" not in name}
    files = {path.relative_to(ROOT) for package in PACKAGES for path in (ROOT / package).rglob("*") if path.is_file()}
    tracked = {f"nonsmooth/{path.as_posix()}" for path in files if "__pycache__" not in path.parts}
    assert held == tracked | {"nonsmooth/__init__.py", "nonsmooth/__main__.py", "nonsmooth/py.typed"}
