"""Certificates of the built-in scenes in numbers."""

from __future__ import annotations

import subprocess
import sys
from functools import partial
from pathlib import Path

from nonsmooth.proofs import checker
from nonsmooth.proofs.certificate import build_certificate, certificate_text
from nonsmooth.symbolic.files.documents import builtin_scenes
from tests.array_certificates import evidence, subject
from tests.benchmarks.conftest import Stopwatch
from tests.built_in import checked


def test_sizes_and_times(stopwatch: Stopwatch, tmp_path: Path) -> None:
    """Checked by the file alone, interpreter included."""
    stopwatch.report(f"{'certificate':26} {'cells':>5} {'generators':>10} {'KiB':>7} {'seconds':>8}")
    for name, rule in sorted((name, rule) for name in builtin_scenes() for rule in ("nearest", "box")):
        certificate = build_certificate(checked(name, rule))
        path = tmp_path / "certificate.json"
        path.write_text(certificate_text(certificate), encoding="utf-8")
        run = partial(subprocess.run, [sys.executable, "-I", "-S", checker.__path__[0], str(path)], check=True)
        seconds = stopwatch.best(partial(run, capture_output=True), runs=2)
        counts = f"{len(evidence(certificate)['cells']):5} {len(subject(certificate)['field']):10}"
        stopwatch.report(f"{name + ' ' + rule:26} {counts} {path.stat().st_size / 1024:7.1f} {seconds:8.2f}")
        if name.startswith("four-wheel"):
            assert seconds < 1
