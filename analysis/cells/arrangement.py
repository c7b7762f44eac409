"""The arrangement of rows behind rule ``box``: its vertices, the slopes of D at them, and its edges.

For weights ``beta_k`` the functional ``D = sum_k beta_k |a_k . xi - b_k|`` is piecewise linear, so a minimizer is a
vertex xi of the arrangement ``a_k . xi = b_k``.  With Z all rows xi satisfies and ``s_k`` the sign of the other
residuals, the slope of D along a direction m is ::

    D'(xi; m) = m . g + sum_{k in Z} beta_k |m . a_k|,      g = sum_{k not in Z} beta_k s_k a_k

and xi is optimal iff the slope is non-negative along ``+-m`` for the directions ``m = a_k x a_l`` of the edges at xi
(the facet normals of the zonotope ``sum_Z [-1, 1] beta_k a_k``).  The weights are affine in the centre of mass, hence
so is each slope.

Floats sort ratios, decide clear signs and drop slopes that certainly stay positive in the region; every doubtful
sign, every tie and every kept slope is exact.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.loads import Affine, LoadRegion, value_at
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.cells.polygon import Point, Polygon
from nonsmooth.symbolic.constraints import Row, Triple, Twist, added, inner, leading_one, outer, scaled, scene_rows
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.scene import Scene

# Relative to the sum of absolute terms, whose rounding error stays below 1e-12 for up to a thousand terms:
# a float value beyond this bound has a certain sign, a value within it is computed exactly.
FLOAT_DOUBT = 1e-9
# Relative: residuals and rates beyond the doubt above carry seven correct digits, so do their ratios; ratios closer
# than this are compared exactly.
STEP_DOUBT = 1e-5

MOST_TIGHT = 300  # rows that hold at one twist: their pairs times their number are held in memory, in floats

Lexicographic: TypeAlias = tuple[int, int]


@dataclass(frozen=True)
class SlopeOfD:
    """``D'(xi; direction)`` as an affine form of c; non-negative where xi is optimal along the direction."""

    direction: Triple
    form: Affine

    @cached_property
    def floats(self) -> NDArray[np.float64]:
        """The form's coefficients, correctly rounded."""
        return np.array([float(x) for x in self.form])


@dataclass(frozen=True)
class Vertex:
    """A vertex of the arrangement with what decides where it is optimal.

    Attributes:
        twist: the point xi.
        tight: numbers of all rows it satisfies (Z).
        slopes: those that can vanish in the load region; the others are positive there.
    """

    twist: Twist
    tight: tuple[int, ...]
    slopes: tuple[SlopeOfD, ...]

    def doubtful(self, points: NDArray[np.float64], among: Sequence[int] | None = None) -> list[int]:
        """Numbers of the slopes (of those given) that are not certainly positive at all points ``(1, x, y)``."""
        numbers = np.arange(len(self.slopes)) if among is None else np.array(among, dtype=int)
        forms = self._floats[numbers]
        doubt = np.abs(points) @ np.abs(forms).T * FLOAT_DOUBT
        return numbers[~(points @ forms.T > doubt).all(axis=0)].tolist()

    @cached_property
    def _floats(self) -> NDArray[np.float64]:
        return np.array([slope.floats for slope in self.slopes]).reshape(-1, 3)

    @property
    def flat(self) -> tuple[SlopeOfD, ...]:
        """Directions along which D does not change, whatever c: twists that tie on the whole cell."""
        return tuple(slope for slope in self.slopes if not any(slope.form))


class Arrangement:
    """Rows and weights of an array in one load region."""

    def __init__(self, scene: Scene, region: LoadRegion) -> None:
        self.scene = scene
        self.region = region
        self.rows = scene_rows(scene)
        self.weights = [_weight(row, region.forces[row.wheel.index - 1]) for row in self.rows]
        self.moments = [
            [tuple(b * entry for b in weight) for entry in row.normal]
            for row, weight in zip(self.rows, self.weights, strict=True)
        ]
        self.normals = np.array([[float(x) for x in row.normal] for row in self.rows])
        self.rhs = np.array([float(row.rhs) for row in self.rows])
        self.float_weights = np.array([[float(x) for x in weight] for weight in self.weights])
        self.corners = float_corners(region.polygon)
        self.corner_weights = self.float_weights @ self.corners.T
        self._vertices: dict[Twist, Vertex] = {}

    def vertex(self, twist: Twist) -> Vertex:
        """The vertex at a twist that solves three independent rows (cached)."""
        if twist not in self._vertices:
            signs = self._residual_signs(twist)
            self._vertices[twist] = Vertex(twist, _tight(signs), self.slopes(signs))
        return self._vertices[twist]

    def float_dissipation(self, twist: Twist, point: Point) -> float:
        """D at a centre of mass, rounded."""
        with np.errstate(over="ignore", invalid="ignore"):
            residuals = self.normals @ np.array([float(x) for x in twist]) - self.rhs
            weights = self.float_weights @ np.array([1.0, float(point[0]), float(point[1])])
            return float(weights @ np.abs(residuals))

    def slopes(self, signs: NDArray[np.int_]) -> tuple[SlopeOfD, ...]:
        """The slopes of D that can vanish in the region, where the residuals of the rows have these signs.

        Nothing else of the twist and of the speeds counts.
        """
        return tuple(self._slopes(signs, _tight(signs)))

    def _residual_signs(self, twist: Twist) -> NDArray[np.int_]:
        """Exact signs of all residuals; floats decide the clear ones."""
        values = np.array([float(x) for x in twist])
        residuals = self.normals @ values - self.rhs
        doubt = (np.abs(self.normals) @ np.abs(values) + np.abs(self.rhs)) * FLOAT_DOUBT
        signs = np.sign(residuals).astype(int)
        for k in np.flatnonzero(~(np.abs(residuals) > doubt)):
            signs[k] = self.rows[k].residual(twist).sign()
        return signs

    def falling_slope(self, signs: NDArray[np.int_]) -> SlopeOfD | None:
        """The slope that is clearly negative, and most of all, where the centre of mass is at the origin."""
        tight = _tight(signs)
        pairs = _pairs(tight)
        m = np.cross(self.normals[pairs[:, 0]], self.normals[pairs[:, 1]])
        weights = self.float_weights[:, 0]
        kept = np.abs(m @ self.normals[list(tight)].T) @ weights[list(tight)]
        margin = kept - np.abs(m @ ((weights * signs) @ self.normals))
        bound = (kept + np.abs(m) @ (weights @ np.abs(self.normals))) * FLOAT_DOUBT
        clear = np.flatnonzero(margin < -bound)
        if not len(clear):
            return None
        a, b = pairs[clear[np.argmin(margin[clear] / bound[clear])]]
        direction = outer(self.rows[a].normal, self.rows[b].normal)
        return min(self._slopes_along(direction, tight, self._pull(signs)), key=lambda slope: slope.form[0])

    def _slopes(self, signs: NDArray[np.int_], tight: tuple[int, ...]) -> Iterator[SlopeOfD]:
        pull = self._pull(signs)
        for direction in self._directions(signs, tight):
            yield from self._slopes_along(direction, tight, pull)

    def _slopes_along(self, direction: Triple, tight: tuple[int, ...], pull: Sequence[Affine]) -> Iterator[SlopeOfD]:
        """The slopes along a direction and back."""
        kept = _zero_form(self.scene)
        for k in tight:
            reach = abs(inner(self.rows[k].normal, direction))
            if reach:
                kept = added(kept, scaled(self.weights[k], reach))
        along = _zero_form(self.scene)
        for entry, part in zip(direction, pull, strict=True):
            along = added(along, scaled(part, entry))
        yield SlopeOfD(direction, added(kept, along))
        yield SlopeOfD((-direction[0], -direction[1], -direction[2]), added(kept, scaled(along, -1)))

    def _pull(self, signs: NDArray[np.int_]) -> list[Affine]:
        """``g``: three affine forms."""
        pull = [_zero_form(self.scene) for _ in range(3)]
        for k in np.flatnonzero(signs):
            for axis in range(3):
                part = self.moments[k][axis]
                pull[axis] = added(pull[axis], part if signs[k] > 0 else scaled(part, -1))
        return pull

    def _directions(self, signs: NDArray[np.int_], tight: tuple[int, ...]) -> list[Triple]:
        """Edge directions at the vertex, without those whose slopes are certainly positive in the region."""
        pairs = _pairs(tight)
        m = np.cross(self.normals[pairs[:, 0]], self.normals[pairs[:, 1]])
        reach = np.abs(m @ self.normals[list(tight)].T)
        kept = reach @ self.corner_weights[list(tight)]
        pull = (self.corner_weights.T * signs) @ self.normals
        margin = kept - np.abs(m @ pull.T)
        bound = (kept + np.abs(m) @ (np.abs(self.corner_weights.T) @ np.abs(self.normals)).T) * FLOAT_DOUBT
        doubtful = np.flatnonzero(~(margin > bound).all(axis=1))
        directions: dict[Triple, Triple] = {}
        for i in doubtful:
            direction = outer(self.rows[pairs[i, 0]].normal, self.rows[pairs[i, 1]].normal)
            if any(direction):
                directions.setdefault(leading_one(direction) if len(tight) > 3 else direction, direction)
        return list(directions.values())

    def line_search(self, vertex: Vertex, slope: SlopeOfD, point: Point, outward: Point) -> Twist:
        """First vertex along the direction beyond which D no longer falls."""
        form, twist = slope.form, vertex.twist
        for step, crossed in self.breakpoints(vertex, slope.direction):
            twist = Twist(*(x + step * m for x, m in zip(vertex.twist, slope.direction, strict=True)))
            for k in crossed:
                turn = 2 * abs(inner(self.rows[k].normal, slope.direction))
                form = added(form, scaled(self.weights[k], turn))
            if order(form, point, outward) >= (0, 0):
                return twist
        return twist

    def breakpoints(self, vertex: Vertex, direction: Triple) -> Iterator[tuple[Number, list[int]]]:
        """Steps t > 0 at which rows change sign along ``xi + t direction``, ascending, with those rows."""
        m = np.array([float(x) for x in direction])
        xi = np.array([float(x) for x in vertex.twist])
        rates, residuals = self.normals @ m, self.normals @ xi - self.rhs
        flat = np.abs(rates) <= np.abs(self.normals) @ np.abs(m) * FLOAT_DOUBT
        close = np.abs(residuals) <= (np.abs(self.normals) @ np.abs(xi) + np.abs(self.rhs)) * FLOAT_DOUBT
        doubtful = flat | close
        steps = np.full(len(rates), -1.0)
        np.divide(-residuals, rates, out=steps, where=~doubtful)
        for k in np.flatnonzero(doubtful):
            step = self._step(vertex, direction, int(k))
            steps[k] = -1.0 if step is None else float(step)
        tight = set(vertex.tight)
        candidates = [int(k) for k in np.argsort(steps) if k not in tight and steps[k] > 0]
        while candidates:
            best = steps[candidates[0]]
            near = [k for k in candidates if steps[k] <= best * (1 + STEP_DOUBT)]
            exact = {k: self._step(vertex, direction, k) for k in near}
            valid = {k: t for k, t in exact.items() if t is not None}
            if valid:
                step = min(valid.values())
                crossed = [k for k, t in valid.items() if t == step]
                yield step, crossed
                candidates = [k for k in candidates if k not in crossed and (k in valid or k not in near)]
            else:
                candidates = [k for k in candidates if k not in near]

    def _step(self, vertex: Vertex, direction: Triple, k: int) -> Number | None:
        """Exact positive step to row k, or None where the direction leads away from it."""
        rate = inner(self.rows[k].normal, direction)
        if not rate:
            return None
        step = -self.rows[k].residual(vertex.twist) / rate
        return step if step.sign() > 0 else None


def order(form: Affine, point: Point, outward: Point) -> Lexicographic:
    """Signs of an affine form at a point and of its derivative along a direction."""
    here = sign(value_at(form, point))
    return here, 0 if here else sign(form[1] * outward[0] + form[2] * outward[1])


def float_corners(polygon: Polygon) -> NDArray[np.float64]:
    """Vertices as rows ``(1, x, y)``."""
    return np.array([[1.0, float(x), float(y)] for x, y in polygon.vertices])


def _pairs(tight: tuple[int, ...]) -> NDArray[np.int_]:
    """All pairs of rows that a twist satisfies: they span the directions of edges there.

    Raises:
        RefusalError: for so many rows that the table of slopes would not fit into memory.
    """
    if len(tight) > MOST_TIGHT:
        raise RefusalError(
            f"wheels: required at most {MOST_TIGHT} rows that hold at one motion (at rest all side rows do), "
            f"received {len(tight)}"
        )
    return np.array(list(combinations(tight, 2)), dtype=int).reshape(-1, 2)


def _tight(signs: NDArray[np.int_]) -> tuple[int, ...]:
    """Numbers of the rows without residual."""
    return tuple(int(k) for k in np.flatnonzero(signs == 0))


def _weight(row: Row, force: Affine) -> Affine:
    """``mu_k N_i / |D_i|`` for a row scaled by ``|D_i|``."""
    return scaled(force, row.friction / row.wheel.length)


def _zero_form(scene: Scene) -> Affine:
    zero = scene.field.zero
    return zero, zero, zero
