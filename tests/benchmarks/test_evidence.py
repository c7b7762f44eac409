"""Every row of the evidence page, computed anew: measured data within a minute, the physics engine at large."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from tests.benchmarks.conftest import Stopwatch
from tests.evidence.engine import ARRAYS, engine_errors
from tests.evidence.page import gather, page_tables

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "evidence.md").read_text(encoding="utf-8")
SECONDS = 60  # for all 400 pushes, both ways and under every model
MEDIANS = {("fixed wheels", "ellipse"): 1e-3, ("free plate", "ellipse"): 1e-3, ("rollers", "roller"): 1e-3}


def test_all_pushes_and_claims_are_those_of_the_page(stopwatch: Stopwatch) -> None:
    start = time.perf_counter()
    found = gather()
    seconds = time.perf_counter() - start
    stopwatch.report(f"the evidence pack: {seconds:.0f} s")
    assert seconds < SECONDS
    tables = page_tables(found, [])
    assert all(tables[part] in PAGE for part in ("vehicles", "pushes", "ranking", "claims"))


def test_a_hundred_random_arrays_of_each_kind(stopwatch: Stopwatch) -> None:
    kinds = engine_errors()
    for kind in kinds:
        stopwatch.report("{} under rule {}: {} arrays, median {}, nine of ten below {}, largest {}".format(*kind.row()))
        assert len(kind.errors) == ARRAYS
        limit = MEDIANS.get((kind.name, kind.rule))
        assert limit is None or np.median(kind.errors) < limit
