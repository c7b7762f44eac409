"""The arrangement of rows behind rule ``box``: its vertices, the slopes of D at them, and its edges.

For weights ``beta_k`` the functional ``D = sum_k beta_k |a_k . xi - b_k|`` is piecewise linear, so a minimizer is a
vertex xi of the arrangement ``a_k . xi = b_k``.  With Z all rows xi satisfies and ``s_k`` the sign of the other
residuals, the slope of D along a direction m is ::

    D'(xi; m) = m . g + sum_{k in Z} beta_k |m . a_k|,      g = sum_{k not in Z} beta_k s_k a_k

and xi is optimal iff the slope is non-negative along ``+-m`` for the directions ``m = a_k x a_l`` of the edges at xi
(the facet normals of the zonotope ``sum_Z [-1, 1] beta_k a_k``).  The weights are affine in the centre of mass, hence
so is each slope.

Floats sort ratios and decide clear signs; every doubtful sign and every tie is exact.  The slopes at one vertex:
:mod:`nonsmooth.analysis.cells.slopes`.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.loads import Affine, LoadRegion, value_at
from nonsmooth.analysis.cells.nearest import SMALLEST_NORMAL
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.symbolic.mechanics.constraints import (
    Row,
    Triple,
    Twist,
    added,
    cross_product,
    inner,
    scaled,
    scene_rows,
    subtracted,
)
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.coefficients import rational_quotient
from nonsmooth.symbolic.numbers.lazy import FLOAT_DOUBT, clear_sign, is_clear, sure_float
from nonsmooth.symbolic.numbers.number import Number, sign

# Relative: residuals and rates beyond the doubt above carry seven correct digits, so do their ratios; ratios closer
# than this are compared exactly.
STEP_DOUBT = 2.0**-16

beyond_floats = np.errstate(over="ignore", invalid="ignore")  # nothing is sure there, and signs are exact

Lexicographic: TypeAlias = tuple[int, int]


@dataclass(frozen=True)
class SlopeOfD:
    """``D'(xi; direction)`` as an affine form of c; non-negative where xi is optimal along the direction.

    Attributes:
        pair: numbers of two rows that xi satisfies, and that stay so along the direction.
    """

    pair: tuple[int, int]
    direction: Triple
    form: Affine


@dataclass(frozen=True, eq=False)
class Vertex:
    """A vertex of the arrangement: the twist xi, and the signs of the residuals of all rows there.

    Attributes:
        twist: xi.
        signs: of all rows, exactly.
        floats: xi, rounded.
        residuals: those that floats know to some seven digits, and nan for the others.
    """

    twist: Twist
    signs: NDArray[np.int_]
    floats: NDArray[np.float64]
    residuals: NDArray[np.float64]

    @cached_property
    def tight(self) -> tuple[int, ...]:
        """Numbers of all rows it satisfies (Z)."""
        return tight_rows(self.signs)


@dataclass(frozen=True)
class Beside:
    """Just beside a point: at ``point + epsilon outward`` for all small epsilon > 0.

    Attributes:
        point: often a lazy quotient, whose exact form is long.
        outward: a direction.
        line: a form that vanishes along a line through the point, where one is known: that its multiples vanish
            there too needs no quotient.
    """

    point: Point
    outward: Point
    line: Affine | None = None


class Arrangement:
    """Rows and weights of an array in one load region."""

    def __init__(self, scene: Scene, region: LoadRegion) -> None:
        self.scene = scene
        self.region = region
        self.rows = scene_rows(scene)
        self.weights = [_weight(row, region.forces[scene.places[row.wheel.index]]) for row in self.rows]
        self.moments = [
            [tuple(b * entry for b in weight) for entry in row.normal]
            for row, weight in zip(self.rows, self.weights, strict=True)
        ]
        self.normals = np.array([normal_floats(row.normal) for row in self.rows])
        self.rhs = np.array(normal_floats([row.rhs for row in self.rows]))
        self.float_weights = np.array([normal_floats(weight) for weight in self.weights])
        self.sizes = np.abs(self.normals)
        self.moment_sizes = self.sizes.T @ np.abs(self.float_weights)
        self.corners = float_corners(region.polygon.vertices)
        self._vertices: dict[Twist, Vertex] = {}
        self._edges: dict[tuple[int, int], Triple] = {}
        self._last_pull = np.zeros(len(self.rows), dtype=int), [_zero_form(scene) for _ in range(3)]

    def vertex(self, twist: Twist, holding: Collection[int] = ()) -> Vertex:
        """The vertex at a twist that solves three independent rows (cached).

        Args:
            twist: xi.
            holding: numbers of rows that are known to hold there.
        """
        if twist not in self._vertices:
            self._vertices[twist] = self._vertex(twist, holding)
        return self._vertices[twist]

    @beyond_floats
    def _vertex(self, twist: Twist, holding: Collection[int]) -> Vertex:
        """Floats decide the clear signs."""
        floats = np.array(normal_floats(twist))
        residuals = self.normals @ floats - self.rhs
        clear = np.abs(residuals) > (self.sizes @ np.abs(floats) + np.abs(self.rhs)) * FLOAT_DOUBT + SMALLEST_NORMAL
        signs = np.where(clear, np.sign(residuals), 0).astype(int)
        for k in (~clear).nonzero()[0].tolist():
            signs[k] = 0 if k in holding else self.rows[k].residual(twist).sign()
        return Vertex(twist, signs, floats, np.where(clear, residuals, np.nan))

    def edge(self, pair: tuple[int, int]) -> Triple:
        """``a_k x a_l`` of two rows by their numbers, the direction along which both stay as they are (cached)."""
        if pair not in self._edges:
            self._edges[pair] = cross_product(self.rows[pair[0]].normal, self.rows[pair[1]].normal)
        return self._edges[pair]

    @beyond_floats
    def float_dissipation(self, twist: Twist, point: Point) -> float:
        """D at a centre of mass, rounded."""
        residuals = self.normals @ np.array([float(x) for x in twist]) - self.rhs
        weights = self.float_weights @ np.array([1.0, float(point[0]), float(point[1])])
        return float(weights @ np.abs(residuals))

    def slopes_along(self, pair: tuple[int, int], signs: NDArray[np.int_]) -> tuple[SlopeOfD, SlopeOfD]:
        """The slopes along the edge of a pair and back, exactly, where the residuals of the rows have these signs."""
        direction = self.edge(pair)
        kept = along = _zero_form(self.scene)
        for k in tight_rows(signs):
            reach = None if k in pair else abs(inner(self.rows[k].normal, direction))
            if reach:
                kept = added(kept, scaled(self.weights[k], reach))
        for entry, part in zip(direction, self._pull(signs), strict=True):
            if entry:
                along = added(along, scaled(part, entry))
        return SlopeOfD(pair, direction, added(kept, along)), SlopeOfD(pair, minus(direction), subtracted(kept, along))

    def _pull(self, signs: NDArray[np.int_]) -> list[Affine]:
        """``g``: three affine forms.  From vertex to vertex few signs change, so the last sum is corrected."""
        last, pull = self._last_pull
        if np.count_nonzero(signs != last) > np.count_nonzero(signs):
            last, pull = np.zeros_like(signs), [_zero_form(self.scene) for _ in range(3)]
        changes = signs - last
        for k in changes.nonzero()[0].tolist():
            change = added if changes[k] > 0 else subtracted
            for _ in range(abs(int(changes[k]))):  # once, or twice where the sign turns
                pull = [change(form, part) for form, part in zip(pull, self.moments[k], strict=True)]
        self._last_pull = signs, pull
        return pull

    def line_search(self, vertex: Vertex, slope: SlopeOfD, place: Beside) -> tuple[Vertex, SlopeOfD]:
        """First vertex along the direction beyond which D no longer falls, and the slope back from there."""
        form = before = slope.form
        for reached in self.breakpoints(vertex, slope.direction):
            _, crossed = reached
            before = form
            for k in crossed:
                turn = 2 * abs(inner(self.rows[k].normal, slope.direction))
                form = added(form, scaled(self.weights[k], turn))
            if order(form, place) >= (0, 0):
                break
        back = SlopeOfD(slope.pair, minus(slope.direction), minus(before))
        return self._reached(vertex, slope, *reached), back

    def next_vertex(self, vertex: Vertex, slope: SlopeOfD) -> Vertex:
        """The first vertex along the direction of a slope."""
        return self._reached(vertex, slope, *next(self.breakpoints(vertex, slope.direction)))

    def _reached(self, vertex: Vertex, slope: SlopeOfD, step: Number, crossed: Collection[int]) -> Vertex:
        """The vertex so many steps along the direction of a slope, where those rows hold beside the slope's own."""
        twist = Twist(*(x + step * m for x, m in zip(vertex.twist, slope.direction, strict=True)))
        return self.vertex(twist, (*slope.pair, *crossed))

    def breakpoints(self, vertex: Vertex, direction: Triple) -> Iterator[tuple[Number, list[int]]]:
        """Steps t > 0 at which rows change sign along ``xi + t direction``, ascending, with those rows."""
        steps = self._float_steps(vertex, direction)
        candidates = sorted((k for k, step in enumerate(steps) if step > 0), key=steps.__getitem__)
        while candidates:
            limit = steps[candidates[0]] * (1 + STEP_DOUBT)
            near = [k for k in candidates if steps[k] <= limit]
            exact = {k: self._step(vertex, direction, k) for k in near}
            valid = {k: t for k, t in exact.items() if t is not None}
            if valid:
                step = min(valid.values())
                crossed = [k for k, t in valid.items() if t == step]
                yield step, crossed
                candidates = [k for k in candidates if k not in crossed and (k in valid or k not in near)]
            else:
                candidates = [k for k in candidates if k not in near]

    def _float_steps(self, vertex: Vertex, direction: Triple) -> list[float]:
        """The steps to all rows, rounded, and minus one to those that are not reached; clear ones by floats."""
        m = np.array(normal_floats(direction))
        rates = self.normals @ m
        clear = np.abs(rates) > self.sizes @ np.abs(m) * FLOAT_DOUBT + SMALLEST_NORMAL
        clear &= ~np.isnan(vertex.residuals)
        steps = np.divide(-vertex.residuals, rates, out=np.full(len(rates), -1.0), where=clear)
        clear &= np.isfinite(steps) & (np.abs(steps) > SMALLEST_NORMAL)  # what is beyond floats is no ratio
        for k in (~clear & (vertex.signs != 0)).nonzero()[0].tolist():  # rows that hold are not crossed
            step = self._step(vertex, direction, k)
            steps[k] = -1.0 if step is None else max(float(step), SMALLEST_NORMAL)
        found: list[float] = steps.tolist()
        return found

    def _step(self, vertex: Vertex, direction: Triple, k: int) -> Number | None:
        """Exact positive step to row k, or None where the direction leads away from it."""
        rate = inner(self.rows[k].normal, direction)
        if not rate:
            return None
        step = -self.rows[k].residual(vertex.twist) / rate
        return step if step.sign() > 0 else None


def order(form: Affine, place: Beside) -> Lexicographic:
    """Signs of an affine form at a point and of its derivative along a direction."""
    constant, a, b = map(sure_float, form)
    here = clear_sign(constant, *(c * sure_float(x) for c, x in zip((a, b), place.point, strict=True)))
    if not here:
        value = value_at(form, place.point)
        vanishes = place.line is not None and not is_clear(value) and is_multiple(form, place.line)
        here = 0 if vanishes else sign(value)
    return here, 0 if here else sign(form[1] * place.outward[0] + form[2] * place.outward[1])


def is_multiple(form: Affine, line: Affine) -> bool:
    """Whether one affine form is a multiple of another that is not zero: a rational one, else by minors.

    Products of long numbers are many: where floats show that a minor does not vanish, there are none.
    """
    minors = (1, 2), (0, 1), (0, 2)
    a, b = [sure_float(x) for x in form], [sure_float(x) for x in line]
    if any(clear_sign(a[i] * b[j], -a[j] * b[i]) for i, j in minors):
        return False
    factor = next(rational_quotient(a.terms, b.terms) for a, b in zip(form, line, strict=True) if b)
    if factor is not None and all(a == b * factor for a, b in zip(form, line, strict=True)):
        return True
    return not any(form[i] * line[j] - form[j] * line[i] for i, j in minors)


def normal_floats(numbers: Collection[Number]) -> list[float]:
    """Numbers as floats that err by less than ``2^-52`` of themselves, and nan for those that have none.

    Nothing that is made of nan is ever sure, so that what lies beyond the range of floats is left to exact arithmetic.
    """
    found = ((number, float(number)) for number in numbers)
    return [value if SMALLEST_NORMAL <= abs(value) < math.inf or not number else math.nan for number, value in found]


def float_corners(points: Sequence[Point]) -> NDArray[np.float64]:
    """Points as rows ``(1, x, y)``."""
    return np.array([[1.0, *normal_floats(point)] for point in points]).reshape(-1, 3)


def tight_rows(signs: NDArray[np.int_]) -> tuple[int, ...]:
    """Numbers of the rows without residual."""
    return tuple((signs == 0).nonzero()[0].tolist())


def _weight(row: Row, force: Affine) -> Affine:
    """``mu_k N_i / |A_i|`` for a row scaled by ``|A_i|``."""
    return scaled(force, row.friction / row.wheel.grip_length)


def minus(vector: Triple) -> Triple:
    """``-a``."""
    return -vector[0], -vector[1], -vector[2]


def _zero_form(scene: Scene) -> Affine:
    zero = scene.field.zero
    return zero, zero, zero
