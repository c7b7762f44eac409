"""Rule ``box``: the exact minimizer of ``D = sum_k beta_k |a_k . xi - b_k|``, one twist per polygon of the plane.

The rows ``a_k`` are the roll and side rows of all wheels, the weights ``beta_k(c) = mu_k N_i(c)`` are affine in the
centre of mass (per load region).  For fixed weights this is a weighted L1 fit in three unknowns, so a minimizer
is a vertex xi of the arrangement ``a_k . xi = b_k``.  With Z all rows xi satisfies and ``s_k`` the sign of the other
residuals, the slope of D along a direction m is ::

    D'(xi; m) = m . g + sum_{k in Z} beta_k |m . a_k|,      g = sum_{k not in Z} beta_k s_k a_k

and xi is optimal iff the slope is non-negative along ``+-m`` for the directions ``m = a_k x a_l`` of the edges at xi
(the facet normals of the zonotope ``sum_Z [-1, 1] beta_k a_k``).  Each slope is affine in c: the cell of xi is a convex
polygon in explicit half-plane form.  Where a slope vanishes, D is flat along m up to the next vertex of the
arrangement: that vertex owns the cell beyond.  So the partition is found by walking from cell to neighbouring
cell, one ratio test per side, never by trying all C(2n, 3) triples.  Ties beyond a side (symmetric arrays) are
resolved by comparing slopes just outside the side: value first, then derivative along the outward normal.

Floats sort ratios and drop half-planes that certainly cut nothing; every kept inequality, every tie and the
total area are exact.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.loads import Affine, LoadRegion, at_least_zero, load_regions, value_at
from nonsmooth.analysis.nearest import pair_states
from nonsmooth.analysis.partition import Cell, Partition
from nonsmooth.analysis.polygon import HalfPlane, Point, Polygon, square
from nonsmooth.symbolic.constraints import Row, Triple, Twist, inner, outer, scene_rows
from nonsmooth.symbolic.contact_states import ContactState
from nonsmooth.symbolic.lazy import Lazy
from nonsmooth.symbolic.number_field import Number, sign
from nonsmooth.symbolic.scene import Rule, Scene

# Relative to the sum of absolute terms, whose rounding error stays below 1e-12 for up to a thousand terms:
# a float value beyond this bound has a certain sign, a value within it is computed exactly.
FLOAT_DOUBT = 1e-9
# With more independent square roots than this, vertices stay unevaluated quotients (see nonsmooth.symbolic.lazy).
FEW_ROOTS = 2

Lexicographic: TypeAlias = tuple[int, int]


@dataclass(frozen=True)
class Slope:
    """``D'(xi; direction)`` as an affine form of c; non-negative where xi is optimal along the direction."""

    direction: Triple
    form: Affine

    @cached_property
    def floats(self) -> NDArray[np.float64]:
        """The form's coefficients, correctly rounded."""
        return np.array([float(x) for x in self.form])

    def clear_signs(self, points: NDArray[np.float64]) -> NDArray[np.int_]:
        """Signs at points ``(1, x, y)`` given as floats; 0 where floats leave a doubt."""
        terms = points * self.floats
        values = terms.sum(axis=-1)
        doubt = np.abs(terms).sum(axis=-1) * FLOAT_DOUBT
        return np.where(np.abs(values) > doubt, np.sign(values), 0).astype(int)


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
    slopes: tuple[Slope, ...]

    @property
    def flat(self) -> tuple[Slope, ...]:
        """Directions along which D does not change, whatever c: twists that tie on the whole cell."""
        return tuple(slope for slope in self.slopes if not any(slope.form))


def build_box_partition(scene: Scene) -> Partition:
    """Cells of rule ``box`` in the checked square.

    Raises:
        nonsmooth.analysis.loads.LoadError: where the loads do not exist.
    """
    regions = load_regions(scene)
    cells: list[Cell] = []
    for region in regions:
        for states, polygon in _Walk(scene, region).cells():
            cells.append(Cell(len(cells) + 1, polygon, states))
    domain = square(scene.check.equilibrium, scene.check.radius)
    return Partition(scene, Rule.BOX, domain, tuple(cells), len(scene.wheels))


class _Walk:
    """The cells of one load region."""

    def __init__(self, scene: Scene, region: LoadRegion) -> None:
        self.scene = scene
        self.region = region
        self.rows = scene_rows(scene)
        self.weights = [_weight(row, region.forces[row.wheel.index - 1]) for row in self.rows]
        self.moments = [
            [tuple(b * entry for b in weight) for entry in row.normal]
            for row, weight in zip(self.rows, self.weights, strict=True)
        ]
        self.lazy = len(scene.field.radicands) > FEW_ROOTS
        self.normals = np.array([[float(x) for x in row.normal] for row in self.rows])
        self.rhs = np.array([float(row.rhs) for row in self.rows])
        self.float_weights = np.array([[float(x) for x in weight] for weight in self.weights])
        self.corners = _float_corners(region.polygon)
        self.corner_weights = self.float_weights @ self.corners.T
        self.vertices: dict[Twist, Vertex] = {}

    # ---- the walk ------------------------------------------------------------------------

    def cells(self) -> Iterator[tuple[tuple[ContactState, ...], Polygon]]:
        """Cells (tied states, polygon) of the region, each once."""
        done: set[Twist] = set()
        waiting = [self._first()]
        while waiting:
            vertex = waiting.pop()
            if vertex.twist in done:
                continue
            face = self._face(vertex)
            done.update(v.twist for v in face)
            polygon, origins = self._polygon(vertex)
            if polygon is None:
                continue
            yield tuple(self._state(v) for v in face), polygon
            for k, side in enumerate(polygon.sides):
                slope = origins.get(side.label)
                if slope is not None:
                    waiting.append(self._neighbour(vertex, slope, _midpoint(polygon, k), side.normal))

    def _first(self) -> Vertex:
        """Descend to the optimal vertex just beside the centre of the region, from the nearest wheels' state."""
        centre = self.region.polygon.centre
        # two nearest wheels to start with: any independent rows would do
        wheels = sorted(self.scene.wheels, key=lambda w: sum(float(p) ** 2 for p in w.position))
        state = pair_states(wheels[0], wheels[1])[0]
        one = self.scene.field.one
        outward = (one, one * 7 / 11)  # a direction along no usual symmetry axis: it only breaks ties
        return self._descend(self._vertex(state.twist), centre, outward)

    def _neighbour(self, vertex: Vertex, slope: Slope, point: Point, outward: Point) -> Vertex:
        """The vertex that is optimal just beyond a side of the cell."""
        twist = self._line_search(vertex, slope, point, outward)
        return self._descend(self._vertex(twist), point, outward)

    def _descend(self, vertex: Vertex, point: Point, outward: Point) -> Vertex:
        """Exact descent at ``point + epsilon outward``: every step lowers D, so it ends at the minimizer."""
        while True:
            place = np.array([1.0, float(point[0]), float(point[1])])
            doubtful = (s for s in vertex.slopes if s.clear_signs(place) <= 0)
            falling = next((s for s in doubtful if _order(s.form, point, outward) < (0, 0)), None)
            if falling is None:
                return vertex
            vertex = self._vertex(self._line_search(vertex, falling, point, outward))

    def _line_search(self, vertex: Vertex, slope: Slope, point: Point, outward: Point) -> Twist:
        """First vertex along the direction beyond which D no longer falls."""
        form, twist = slope.form, vertex.twist
        for step, crossed in self._breakpoints(vertex, slope.direction):
            twist = Twist(*(x + step * m for x, m in zip(vertex.twist, slope.direction, strict=True)))
            for k in crossed:
                turn = 2 * abs(inner(self.rows[k].normal, slope.direction))
                form = _added(form, _scaled(self.weights[k], turn))
            if _order(form, point, outward) >= (0, 0):
                return twist
        return twist

    def _breakpoints(self, vertex: Vertex, direction: Triple) -> Iterator[tuple[Number, list[int]]]:
        """Steps t > 0 at which rows change sign along ``xi + t direction``, ascending, with those rows."""
        m = np.array([float(x) for x in direction])
        rates = self.normals @ m
        residuals = self.normals @ np.array([float(x) for x in vertex.twist]) - self.rhs
        doubtful = (np.abs(rates) <= np.abs(self.normals) @ np.abs(m) * FLOAT_DOUBT) | (rates == 0)
        steps = np.full(len(rates), -1.0)
        np.divide(-residuals, rates, out=steps, where=~doubtful)
        for k in np.flatnonzero(doubtful):
            step = self._step(vertex, direction, k)
            steps[k] = -1.0 if step is None else float(step)
        tight = set(vertex.tight)
        candidates = [int(k) for k in np.argsort(steps) if k not in tight and steps[k] > 0]
        while candidates:
            best = steps[candidates[0]]
            near = [k for k in candidates if steps[k] <= best * (1 + FLOAT_DOUBT)]
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

    # ---- one vertex ----------------------------------------------------------------------

    def _vertex(self, twist: Twist) -> Vertex:
        if twist not in self.vertices:
            signs = self._residual_signs(twist)
            tight = tuple(int(k) for k in np.flatnonzero(signs == 0))
            self.vertices[twist] = Vertex(twist, tight, tuple(self._slopes(signs, tight)))
        return self.vertices[twist]

    def _residual_signs(self, twist: Twist) -> NDArray[np.int_]:
        """Exact signs of all residuals; floats decide the clear ones."""
        values = np.array([float(x) for x in twist])
        residuals = self.normals @ values - self.rhs
        doubt = (np.abs(self.normals) @ np.abs(values) + np.abs(self.rhs)) * FLOAT_DOUBT
        signs = np.sign(residuals).astype(int)
        for k in np.flatnonzero(~(np.abs(residuals) > doubt)):
            signs[k] = self.rows[k].residual(twist).sign()
        return signs

    def _slopes(self, signs: NDArray[np.int_], tight: tuple[int, ...]) -> Iterator[Slope]:
        pull = self._pull(signs)
        for direction in self._directions(signs, tight):
            kept = _zero_form(self.scene)
            for k in tight:
                reach = abs(inner(self.rows[k].normal, direction))
                if reach:
                    kept = _added(kept, _scaled(self.weights[k], reach))
            along = _zero_form(self.scene)
            for entry, part in zip(direction, pull, strict=True):
                along = _added(along, _scaled(part, entry))
            yield Slope(direction, _added(kept, along))
            yield Slope((-direction[0], -direction[1], -direction[2]), _added(kept, _scaled(along, -1)))

    def _pull(self, signs: NDArray[np.int_]) -> list[Affine]:
        """``g``: three affine forms."""
        pull = [_zero_form(self.scene) for _ in range(3)]
        for k in np.flatnonzero(signs):
            for axis in range(3):
                part = self.moments[k][axis]
                pull[axis] = _added(pull[axis], part if signs[k] > 0 else _scaled(part, -1))
        return pull

    def _directions(self, signs: NDArray[np.int_], tight: tuple[int, ...]) -> list[Triple]:
        """Edge directions at the vertex, without those whose slopes are certainly positive in the region."""
        pairs = np.array(list(combinations(tight, 2)))
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
                directions.setdefault(_projective(direction) if len(tight) > 3 else direction, direction)
        return list(directions.values())

    # ---- one cell ------------------------------------------------------------------------

    def _polygon(self, vertex: Vertex) -> tuple[Polygon | None, dict[str, Slope]]:
        """The vertex's cell, and the slope behind each of its inner sides, by label."""
        polygon = self.region.polygon
        origins = {f"slope {k}": slope for k, slope in enumerate(vertex.slopes) if any(slope.form)}
        corners = self.corners
        for label, slope in origins.items():
            if slope.clear_signs(corners).min() > 0:
                continue
            clipped = polygon.clipped(self._half_plane(slope.form, label))
            if clipped is None:
                return None, origins
            if clipped is not polygon:
                polygon, corners = clipped, _float_corners(clipped)
        return polygon, origins

    def _half_plane(self, form: Affine, label: str) -> HalfPlane:
        if self.lazy:
            form = (Lazy.of(form[0]), Lazy.of(form[1]), Lazy.of(form[2]))
        return at_least_zero(form, label)

    def _face(self, vertex: Vertex) -> list[Vertex]:
        """All vertices that tie with this one on its whole cell (Theorem 2: their hull minimizes D)."""
        face, waiting = [vertex], [vertex]
        while waiting:
            here = waiting.pop()
            for slope in here.flat:
                step, _ = next(self._breakpoints(here, slope.direction))
                twist = Twist(*(x + step * m for x, m in zip(here.twist, slope.direction, strict=True)))
                if all(twist != known.twist for known in face):
                    face.append(self._vertex(twist))
                    waiting.append(face[-1])
        return face

    def _state(self, vertex: Vertex) -> ContactState:
        return ContactState(tuple(self.rows[k] for k in vertex.tight), vertex.twist)


def _weight(row: Row, force: Affine) -> Affine:
    """``mu_k N_i / |D_i|`` for a row scaled by ``|D_i|``."""
    friction = row.wheel.friction.roll if row.kind == "R" else row.wheel.friction.side
    return _scaled(force, friction / row.wheel.length)


def _order(form: Affine, point: Point, outward: Point) -> Lexicographic:
    """Signs of an affine form at a point and of its derivative along a direction."""
    here = sign(value_at(form, point))
    return here, 0 if here else sign(form[1] * outward[0] + form[2] * outward[1])


def _float_corners(polygon: Polygon) -> NDArray[np.float64]:
    """Vertices as rows ``(1, x, y)``."""
    return np.array([[1.0, float(x), float(y)] for x, y in polygon.vertices])


def _midpoint(polygon: Polygon, k: int) -> Point:
    (x1, y1), (x2, y2) = polygon.vertices[k], polygon.vertices[(k + 1) % len(polygon.vertices)]
    return (x1 + x2) / 2, (y1 + y2) / 2


def _projective(direction: Triple) -> Triple:
    """Canonical representative of a line through the origin."""
    lead = next(x for x in direction if x).inverse()
    return direction[0] * lead, direction[1] * lead, direction[2] * lead


def _zero_form(scene: Scene) -> Affine:
    zero = scene.field.zero
    return zero, zero, zero


def _added(a: Affine, b: Affine) -> Affine:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _scaled(form: Affine, factor: Any) -> Affine:
    return form[0] * factor, form[1] * factor, form[2] * factor


def rest_cells(partition: Partition) -> Sequence[Cell]:
    """Cells whose twist is zero: the dead zone."""
    return [cell for cell in partition.cells if any(not any(twist) for twist in cell.twists)]
