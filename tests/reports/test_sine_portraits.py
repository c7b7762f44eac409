"""Phase portraits, maps and reports of systems with sines and cosines of states, beside the formulas in NumPy."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.border_motion import BorderKind, BorderPart, sliding_velocity
from nonsmooth.proofs.systems.domain import plane_cells
from nonsmooth.proofs.systems.ray_moves import RayKind, resting_edges
from nonsmooth.proofs.systems.system_stability import PlanePoint
from nonsmooth.reports.checks.phase_portrait import PhasePortrait, sampled_rates
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.reports.conftest import Invoke

SIGNS = {"sin": np.sin, "cos": np.cos, "pi": math.pi, "Abs": np.abs, "sgn": np.sign}
NORMAL_STEP = 1e-9  # to either side of a border

SYSTEMS = [
    ("y", "-sin(x) - y - sgn(y)/4"),  # dry friction: slides where |sin(x)| < 1/4
    ("y", "sin(x) - 2*sgn(x + y)"),  # bang-bang: slides between -1 and 1
    ("y", "-sgn(x) - sin(y)"),  # a relay: crosses
    ("sin(y) - x/2", "-sin(2*x)*cos(y) - 3*sgn(y)/4"),
    ("y/(1 + x**2)", "sgn(y)*(1/8 - sin(x)**2)"),  # escapes near the point, slides farther out
    ("sin(x + pi) + y", "cos(x) - 1 - sgn(2*x - y)*cos(3*y)"),
    ("cos(x - pi/2) - sgn(x)", "sin(x*y) - y*Abs(sgn(x))"),
]


def built(rhs: Any, **check: Any) -> SwitchedSystem:
    data = {"system": {"states": ["x", "y"], "rhs": list(rhs)}, "check": {"radius": "3/2", **check}}
    return build_system(data, "t", Path("t.toml"))


def field_at(rhs: tuple[str, str], x: Any, y: Any) -> tuple[Any, Any]:
    """The formulas in NumPy."""
    places = {"x": x, "y": y}
    first, second = (eval(text, dict(SIGNS), places) for text in rhs)  # noqa: S307 - this file's own formulas
    return np.broadcast_to(first, np.shape(x)), np.broadcast_to(second, np.shape(x))


@pytest.mark.parametrize("rhs", SYSTEMS)
def test_rates_are_those_of_the_formulas(rhs: tuple[str, str]) -> None:
    portrait = PhasePortrait(built(rhs))
    xs, ys = np.random.default_rng(7).uniform(-1.5, 1.5, (2, 400))
    found, stated = np.array(sampled_rates(portrait.cells, portrait.fields, xs, ys)), np.array(field_at(rhs, xs, ys))
    scale = 1 + xs**2 if "/(1 + x**2)" in rhs[0] else 1.0  # fractions are cleared
    assert np.allclose(found, stated * scale, atol=1e-12)


@pytest.mark.parametrize("rhs", SYSTEMS)
def test_borders_agree_with_samples_beside_them(rhs: tuple[str, str]) -> None:
    parts = PhasePortrait(built(rhs)).borders
    assert parts
    for part in parts:
        assert {_sampled_kind(rhs, part, share) for share in np.linspace(0.001, 0.999, 57)} == {part.kind}


def test_borders_miss_nothing_but_roots() -> None:
    """The parts of each border follow each other, and together are as long as the border."""
    for rhs in SYSTEMS[:3]:
        parts = PhasePortrait(built(rhs)).borders
        length = sum(math.dist(*(list(map(float, end)) for end in (part.start, part.end))) for part in parts)
        border = 3.0 if "x + y" not in rhs[1] else 3 * math.sqrt(2)
        assert math.isclose(length, border, rel_tol=1e-6)


def _sampled_kind(rhs: tuple[str, str], part: BorderPart, share: float) -> BorderKind:
    """From the formulas a little to both sides of a border."""
    start, end, normal = (np.array([float(v) for v in ends]) for ends in (part.start, part.end, part.normal))
    place, across = start + share * (end - start), normal / np.linalg.norm(normal)
    inner, outer = (
        float(np.dot(across, np.array(field_at(rhs, *(place + side * NORMAL_STEP * across))))) for side in (1, -1)
    )
    if min(abs(inner), abs(outer)) < 1e-7:
        return BorderKind.TOUCHED
    if inner * outer > 0:
        return BorderKind.CROSSING
    return BorderKind.SLIDING if inner < 0 else BorderKind.REPELLING


def test_an_end_of_a_slide_is_the_root_of_the_sine() -> None:
    slides = [part for part in PhasePortrait(built(SYSTEMS[0])).borders if part.kind is BorderKind.SLIDING]
    assert sorted(float(part.end[0] + part.start[0]) for part in slides) == pytest.approx(
        [-math.asin(0.25), math.asin(0.25)], abs=1e-11
    )
    assert not any(part.is_exact for part in slides)


def test_a_slide_is_the_mixture_that_is_tangent() -> None:
    (slide, _) = [part for part in PhasePortrait(built(SYSTEMS[1])).borders if part.kind is BorderKind.SLIDING]
    place = slide.start
    x, y = map(float, place)
    assert sliding_velocity(slide, place) == pytest.approx((y, -y))
    assert x == -y


def test_a_sign_that_is_not_found_is_called_undecided() -> None:
    """``sin^2 + cos^2 - 1`` is zero, which no ball shows."""
    (part, *_) = PhasePortrait(built(["x*sgn(y)", "(sin(x)**2 + cos(x)**2 - 1)*sgn(y)"])).borders
    assert part.kind is BorderKind.UNDECIDED


def test_dry_friction_rests_beside_the_hanging_pendulum() -> None:
    result = decide_system(built(["y", "-2*sin(x) - sgn(y)"]))
    assert result.verdict is Translation.STABLE
    assert {ray.kind for ray in PlanePoint(result.scene).rays} == {RayKind.REST}
    assert "not asymptotically" in result.reason
    assert result.check()
    assert result.function is result.given  # there is no V that falls: none is searched


def test_a_rest_of_the_enclosing_fields_alone_is_none() -> None:
    """On y = 0 the fields are near ``x**5/240`` and three times that, while polynomials between which they lie rest."""
    for factor in ("1", "(2 + sgn(y))"):
        cells = plane_cells(built(["y", f"(sin(x) - x + x**3/6 - x**5/240)*{factor} - y"]))
        assert list(resting_edges(cells))
        assert not list(resting_edges(cells, enclosing=True))


def test_partition_map_and_report(tmp_path: Path, invoke: Invoke) -> None:
    scene = tmp_path / "pendulum.toml"
    rhs = '["y", "-sin(x) - y - sgn(y)/4"]'
    scene.write_text(f'[system]\nstates = ["x", "y"]\nrhs = {rhs}\n[check]\nradius = "1"\n', encoding="utf-8")
    listed = invoke("partition", str(scene))
    assert "-y - sin(x) - 1/4" in listed.out
    assert "(0.2527, 0)" in listed.out
    assert ns.load(scene).map(grid=3, until=1.0).to_dict()["shares"]["nearer"] > 0.5
    report = invoke("derive", str(scene))
    assert r"-y - \sin\left(x\right) - \frac{1}{4}" in report.out
    assert "(0.2527, 0)" in report.out


def test_arbitrary_switching_of_sines_has_no_portrait() -> None:
    with pytest.raises(SceneError, match="one right-hand side"):
        PhasePortrait(built([["y", "-sin(x) - y"], ["y", "-2*sin(x) - y"]]))


def test_a_picture_with_nothing_to_name_has_no_legend() -> None:
    """Warnings are errors here: Matplotlib gives one of an empty legend."""
    assert not PhasePortrait(built(("x", "y"))).figure().legends
