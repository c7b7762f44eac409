"""Certificates of the built-in scenes in numbers, and ten thousand mutants: rejected, or proved to be true still."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeAlias

import pytest

from nonsmooth.proofs import checker
from nonsmooth.proofs.certificate import certificate_text
from nonsmooth.symbolic.files.scene_file import builtin_scenes
from tests.array_certificates import evidence, subject

if TYPE_CHECKING:
    from tests.benchmarks.conftest import Stopwatch

pytestmark = pytest.mark.benchmark

Record: TypeAlias = dict[str, Any]

MUTANTS = 10_000
SLOW = (("grid-4x4", "box"), ("elliptic", "box"), ("ring-8", "box"), ("ring-5", "box"), ("ring-6", "box"))


def _fast_tests() -> ModuleType:
    """The module of the fast tests, which holds the mutations and the proof of truth."""
    path = Path(__file__).parents[1] / "proofs" / "test_checker.py"
    spec = importlib.util.spec_from_file_location("fast_checker_tests", path)
    if spec is None or spec.loader is None:
        raise ImportError(str(path))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def fast() -> ModuleType:
    return _fast_tests()


@pytest.fixture(scope="module")
def certificates(fast: ModuleType) -> dict[tuple[str, str], Record]:
    arrays = sorted((name, rule) for name in builtin_scenes() for rule in ("nearest", "box"))
    return {array: fast.certificate_of(*array) for array in arrays}


def test_sizes_and_times(certificates: dict[tuple[str, str], Record], stopwatch: Stopwatch, tmp_path: Path) -> None:
    """Checked by the file alone, interpreter included."""
    stopwatch.report(f"{'certificate':26} {'cells':>5} {'generators':>10} {'KiB':>7} {'seconds':>8}")
    for (name, rule), certificate in certificates.items():
        path = tmp_path / "certificate.json"
        path.write_text(certificate_text(certificate), encoding="utf-8")
        run = partial(subprocess.run, [sys.executable, "-I", "-S", checker.__path__[0], str(path)], check=True)
        seconds = stopwatch.best(partial(run, capture_output=True), runs=2)
        counts = f"{len(evidence(certificate)['cells']):5} {len(subject(certificate)['field']):10}"
        stopwatch.report(f"{name + ' ' + rule:26} {counts} {path.stat().st_size / 1024:7.1f} {seconds:8.2f}")
        if name.startswith("four-wheel"):
            assert seconds < 1


def test_ten_thousand_mutants(
    certificates: dict[tuple[str, str], Record], fast: ModuleType, stopwatch: Stopwatch
) -> None:
    """Of all built-in certificates but the slowest ones, which would take most of the time."""
    subjects = {array: c for array, c in certificates.items() if array not in SLOW}
    rejected, accepted = fast.count_mutants(subjects, MUTANTS, seed=10)
    stopwatch.report(f"{MUTANTS} mutants of {len(subjects)} certificates: {rejected} rejected, {accepted} still true")
    assert rejected + accepted == MUTANTS
