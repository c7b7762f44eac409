"""Published regions beside those that are certified here: one table, in one run (tests/proofs/published_regions.py)."""

from __future__ import annotations

import time

import pytest

from nonsmooth.proofs.larger_region import find_larger_region
from tests.benchmarks.conftest import Stopwatch
from tests.proofs.published_regions import PUBLISHED, Published, area, exact_level, system_of


@pytest.mark.parametrize("published", PUBLISHED, ids=lambda published: published.name)
def test_published_and_certified_regions(published: Published, stopwatch: Stopwatch) -> None:
    system = system_of(published)
    exact = exact_level(system)
    assert exact is not None
    assert exact.point is not None
    begin = time.perf_counter()
    own = find_larger_region(system, published.degree)
    seconds = time.perf_counter() - begin
    assert own is not None
    sizes = [
        area(text, float(level), published.radius)
        for text, level in (
            (published.potential, published.level),
            (published.potential, exact.level),
            (own.formula.text, own.region.level),
        )
    ]
    point = ", ".join(f"{float(x):.5f}" for x in exact.point)
    stopwatch.report(f"{published.name}: {published.source}")
    stopwatch.report(f"  V = {published.potential} < {published.level}: area {sizes[0]:.2f}")
    stopwatch.report(f"  exactly V < {exact.level}: area {sizes[1]:.2f}")
    stopwatch.report(f"  at ({point}) V is at most {exact.refuted} and does not fall")
    stopwatch.report(f"  own V of degree {published.degree} < {own.region.level}: area {sizes[2]:.2f}, {seconds:.1f} s")
    stopwatch.report(f"  V = {own.formula.text}")
    assert sizes[0] <= sizes[1] * 1.001
