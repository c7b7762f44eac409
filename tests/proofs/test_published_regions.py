"""Published Lyapunov functions and regions, audited exactly; the search for larger regions against paths."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from numpy.typing import NDArray

import nonsmooth as ns
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.larger_region import find_larger_region
from nonsmooth.proofs.system_audit import audit
from nonsmooth.proofs.system_decision import decide_system
from tests.proofs.published_regions import (
    GUIDE,
    GUIDE_POTENTIAL,
    HYPERBOLA,
    NO_POLYNOMIAL,
    PUBLISHED,
    VAN_DER_POL,
    Published,
    area,
    exact_level,
    published_cells,
    system_of,
)
from tests.thorough import keep, thorough


@pytest.mark.parametrize("published", PUBLISHED, ids=lambda published: published.name)
def test_a_published_level_is_certified_and_the_largest_is_the_limit(published: Published) -> None:
    found = exact_level(system_of(published))
    assert found is not None
    assert found.level >= published.level
    assert float(found.level) <= published.limit + 1e-5
    assert found.point is not None
    if np.isfinite(published.limit):  # else the border of the square refutes larger levels
        assert found.level == pytest.approx(published.limit, rel=1e-3)
        assert found.refuted == pytest.approx(published.limit, rel=1e-3)
        x, y = map(float, found.point)
        slope = eval(  # noqa: S307 - formulas of the tests
            " + ".join(f"({d})*({f})" for d, f in zip(gradient(published.potential), published.rhs, strict=True)),
            {"x": x, "y": y},
        )
        assert slope > -1e-9
    else:
        assert found.level == published.radius**2


def gradient(potential: str) -> tuple[str, str]:
    return {"x**2 + y**2": ("2*x", "2*y"), "3*x**2/2 - x*y + y**2": ("3*x - y", "2*y - x")}[potential]


@pytest.mark.parametrize("name", keep(1, [NO_POLYNOMIAL.name, VAN_DER_POL.name]))
def test_a_point_refutes_the_next_level(name: str) -> None:
    system = system_of(next(published for published in PUBLISHED if published.name == name))
    found, cells = exact_level(system), published_cells(system)
    assert found is not None
    assert found.refuted is not None
    assert found.point is not None
    here = [cell for cell in cells if cell.region.contains(found.point)]
    assert any(not cell.potential(found.point) > found.refuted for cell in here)
    rises = any(not rate(found.point) < 0 for cell in here for rate in cell.rates)
    assert rises or max(map(abs, found.point)) == found.radius


def test_the_v_of_the_guide_of_sostools_is_proved() -> None:
    system = ns.System(["x", "y", "z"], GUIDE, radius=2, lyapunov=GUIDE_POTENTIAL).system
    assert audit(system, GUIDE_POTENTIAL).proves is Translation.ASYMPTOTICALLY_STABLE
    result = decide_system(system)
    assert result.reach.region is not None
    assert Fraction(69, 10) < result.reach.region.level <= 4 * Fraction(17945, 10_000)
    assert result.check()


@thorough  # a region that is not there, and forged levels, are refused above and below
@pytest.mark.parametrize(("published", "degree", "least"), [(VAN_DER_POL, 2, 6.2), (HYPERBOLA, 4, 5.5)])
def test_a_larger_region_is_certified(published: Published, degree: int, least: float) -> None:
    """Paths from all over it come home."""
    system = system_of(published)
    found = find_larger_region(system, degree)
    assert found is not None
    level, text = found.region.level, found.formula.text
    assert area(text, float(level), published.radius) > least
    rng = np.random.default_rng(0)
    starts = [p for p in rng.uniform(-published.radius, published.radius, (60, 2)) if below(text, p, float(level))]
    assert len(starts) > 8
    for start in starts[:8]:
        path = ns.System(["x", "y"], list(published.rhs)).simulate(start.tolist(), 30.0).trajectory
        assert np.abs(path.at(30.0)).max() < 1e-2


def below(text: str, point: NDArray[np.float64], level: float) -> bool:
    return bool(eval(text, {"x": point[0], "y": point[1]}) < level)  # noqa: S307 - our own V


def test_no_region_where_nothing_comes_back() -> None:
    assert ns.System(["x", "y"], ["x", "-y"]).larger_region(2) is None


def test_a_degree_that_is_none_is_refused() -> None:
    with pytest.raises(ValueError, match="degree: required a whole number from 2 to 12, received 1"):
        ns.System(["x", "y"], ["-x", "-y"]).larger_region(1)


def test_a_region_is_found_in_a_line_of_python() -> None:
    """The disc of a contraction, whose level sets fill the square."""
    system = ns.System(["x", "y"], ["-x", "-y"])
    found = system.larger_region(2)
    assert found is not None
    assert repr(found).startswith(f"{found.region} on the square of half-width 1/2 about the point with V = ")
