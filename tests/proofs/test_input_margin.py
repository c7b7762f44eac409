"""How far the contact state may be in doubt, against linear programs over all cells within reach."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import linprog

from nonsmooth.analysis.cells.fan import CellCone, build_fan
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult, InputMargin, decide_feedback
from nonsmooth.proofs.clauses.feedback.control_lyapunov import ControlLyapunov
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.conftest import Arrays
from tests.thorough import few, keep, thorough

ARRAYS = Arrays()
SEEDS = range(40)
NAMES = ("four-wheel", "rectangle", "ring-3", "ring-5", "ring-6", "elliptic", "spiral-30", "outward", "ring-8")
STATES = 60  # for each array, each one linear program
FEASIBLE = 1e-9  # of a linear program in covectors of length one and inputs up to one

Matrix = NDArray[np.float64]


@cache
def decided(key: str | int) -> tuple[tuple[CellCone, ...], FeedbackResult, int]:
    scene: Scene = load_scene(key).recentred() if isinstance(key, str) else ARRAYS.cocircular(key, (1, Fraction(1, 2)))
    partition = build_nearest_partition(scene)
    return build_fan(partition), decide_feedback(partition), len(scene.wheels)


def margin_of(key: str | int) -> InputMargin | None:
    return decided(key)[1].margin


class Literal:
    """The fan in floats: cells within reach of a direction, and the largest common decrease by a linear program."""

    def __init__(self, fan: Sequence[CellCone], wheels: int, lyapunov: ControlLyapunov) -> None:
        (e, f), w = (float(x) for x in lyapunov.shape), float(lyapunov.weight)
        self.p, self.w = np.array([[1 + e, f], [f, 1 - e]]), w
        self.rays = np.array([[[float(x) for x in ray] for ray in (cone.start, cone.end)] for cone in fan])
        self.fields = np.zeros((len(fan), wheels, 3))
        self.arms = np.array([[float(x) for x in cone.cell.states[0].rows[0].wheel.position] for cone in fan])
        for k, cone in enumerate(fan):
            for wheel, field in cone.cell.states[0].control_fields.items():
                self.fields[k, wheel - 1] = [float(x) for x in field]

    def distances(self, c: Matrix) -> Matrix:
        """Of c from each closed cone."""
        (a, b), found = np.moveaxis(self.rays, 1, 0), []
        for start, end in zip(a, b, strict=True):
            inside = np.cross([*start, 0], [*c, 0])[2] >= 0 and np.cross([*c, 0], [*end, 0])[2] >= 0
            feet = [ray * max(0.0, c @ ray) / (ray @ ray) for ray in (start, end)]
            found.append(0.0 if inside else min(float(np.hypot(*(c - foot))) for foot in feet))
        return np.array(found)

    def decrease(self, cells: NDArray[np.intp], c: Matrix, tau: float) -> float:
        """Largest t with ``alpha . u <= -t`` for the unit covectors of all cells, and ``|u_w| <= 1``."""
        slope = self.p @ c
        covectors = self.fields[cells] @ np.array([*slope, tau])
        covectors /= np.maximum(np.linalg.norm(covectors, axis=1), 1e-300)[:, None]
        count = covectors.shape[1]
        result = linprog(
            [*np.zeros(count), -1.0],
            A_ub=np.column_stack([covectors, np.ones(len(covectors))]),
            b_ub=np.zeros(len(covectors)),
            bounds=[*[(-1, 1)] * count, (None, 1)],
        )
        return float(result.x[-1])

    def trying_taus(self, c: Matrix, rng: np.random.Generator) -> list[float]:
        """Where some cell's second input vanishes, near it, and anywhere."""
        turned = np.column_stack([-self.arms[:, 1], self.arms[:, 0]])
        stalls = turned @ (self.p @ c)
        spread = float(np.ptp(stalls)) + 1.0
        return [*np.unique(stalls), *(stalls + rng.normal(0, 1e-3, len(stalls))), *rng.normal(0, spread, 6)]


def directions(rng: np.random.Generator, margin: InputMargin, sigma: float) -> list[Matrix]:
    """Unit vectors anywhere, and just within reach of the sides."""
    angles = list(rng.uniform(-np.pi, np.pi, 6))
    for side in margin.sides:
        x, y = (float(v) for v in side.cones[0].end)
        angles += [np.arctan2(y, x) + s * np.arcsin(sigma) * 0.999 for s in (-1, 1)]
    return [np.array([np.cos(t), np.sin(t)]) for t in angles]


@few(1)
@pytest.mark.parametrize("key", keep(8, [*NAMES[:4], *SEEDS[:12], *NAMES[4:]]))
def test_within_the_margin_all_cells_in_reach_have_a_common_input(key: str | int) -> None:
    fan, result, wheels = decided(key)
    margin = margin_of(key)
    if margin is None or not margin.value:
        return
    literal, rng = Literal(fan, wheels, result.lyapunov), np.random.default_rng(0)
    tried = 0
    for c in directions(rng, margin, margin.value):
        cells = np.flatnonzero(literal.distances(c) <= margin.value * 0.999)
        for tau in literal.trying_taus(c, rng):
            tried += 1
            assert literal.decrease(cells, c, tau) > FEASIBLE, (c, tau, cells)
            if tried % STATES == 0:
                break


@few(6)
@pytest.mark.parametrize("key", [*NAMES, *SEEDS])
def test_at_a_sides_distance_its_two_cells_have_no_common_input(key: str | int) -> None:
    """By a linear program at the witness, which lies at the stated angle from the side; just inside there is one."""
    fan, result, wheels = decided(key)
    margin = margin_of(key)
    if margin is None:
        return
    literal = Literal(fan, wheels, result.lyapunov)
    for side in margin.sides:
        c = np.array([float(x) for x in side.witness.point])
        ray = np.array([float(x) for x in side.cones[0].end])
        sine = abs(c[0] * ray[1] - c[1] * ray[0]) / (np.hypot(*c) * np.hypot(*ray))
        assert sine == pytest.approx(float(side.squared) ** 0.5, abs=1e-12)
        turning = (literal.p @ c) @ np.array([-c[1], c[0]])
        tau = literal.w * float(side.witness.value) + float(turning)
        cells = np.array([fan.index(cone) for cone in side.cones])
        covectors = literal.fields[cells] @ np.array([*(literal.p @ c), tau])
        sizes = np.linalg.norm(covectors, axis=1)
        vanishing = sizes.min() <= 1e-9 * (1 + sizes.max())
        assert vanishing or literal.decrease(cells, c, tau) <= FEASIBLE
        assert vanishing == (side.squared != 0)


def test_margins_in_closed_form() -> None:
    """Inward rims at angle 2 pi/n: a side is pi/n from each of its wheels, so the sine is cos(pi/n)."""
    exact = {
        "four-wheel": Fraction(1, 2),
        "outward": Fraction(1, 2),
        "ring-3": Fraction(1, 4),
        "rectangle": Fraction(1, 5),
    }
    for name, squared in exact.items():
        margin = margin_of(name)
        assert margin is not None
        assert margin.is_exact
        assert margin.squared == squared
    for count in (5, 6, 8):
        margin = margin_of(f"ring-{count}")
        assert margin is not None
        assert margin.is_exact
        assert margin.value == pytest.approx(np.cos(np.pi / count), abs=1e-12)
    bound = margin_of("elliptic")  # rims that do not meet: three nearest wheels come within reach, 60 degrees apart
    assert bound is not None
    assert not bound.is_exact
    assert bound.squared == Fraction(1, 4)
    spiral = margin_of("spiral-30")  # 45 degrees less 30
    assert spiral is not None
    assert spiral.value == pytest.approx(np.sin(np.pi / 12))


@thorough  # about all random cases, which `make bench` runs
def test_random_arrays_show_all_kinds() -> None:
    margins = [margin for key in SEEDS if (margin := margin_of(key)) is not None]
    assert {(bool(m.squared), m.is_exact) for m in margins} == {(False, True), (True, True), (True, False)}
