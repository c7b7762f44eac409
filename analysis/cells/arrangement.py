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
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from flint import fmpq

from nonsmooth.analysis.cells.loads import Affine, LoadRegion, value_at
from nonsmooth.analysis.cells.nearest import SMALLEST_NORMAL
from nonsmooth.analysis.cells.outline import ROUNDED, Filtered, Form, Three, known_sign, size_of, whole_numbers
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.symbolic.mechanics.contact_states import (
    Row,
    Triple,
    Twist,
    added,
    cross_product,
    in_rationals,
    independent,
    inner,
    scaled,
    scene_rows,
    solve_rows,
    subtracted,
)
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.coefficients import rational_quotient
from nonsmooth.symbolic.numbers.lazy import FLOAT_DOUBT, clear_sign, is_clear, sure_float
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices
from nonsmooth.symbolic.numbers.rounded import Rounded

# Relative: residuals and rates beyond the doubt above carry seven correct digits, so do their ratios; ratios closer
# than this are compared exactly.
STEP_DOUBT = 2.0**-16

beyond_floats = np.errstate(over="ignore", invalid="ignore")  # nothing is sure there, and signs are exact

FLOAT_ERROR = 2.0**-39  # of a sum of absolute terms: what a sum of up to ten thousand products may err by
EXACT_FLOATS = 2.0**52  # sums of whole numbers below this are floats
FEW = 16  # pairs of rows that are looked at one by one
SHORT = 2**20  # products of two whole numbers below this are 64-bit numbers, and so are their sums
NEXT, AFTER = [1, 2, 0], [2, 0, 1]  # the other coordinates, in turn

Lexicographic: TypeAlias = tuple[int, int]


class SlopeOfD(Form):
    """``D'(xi; direction)`` as an affine form of c; non-negative where xi is optimal along the direction.

    Attributes:
        pair: numbers of two rows that xi satisfies, and that stay so along the direction.
        sense: whether the direction is the edge of the pair (1), or back (-1).
        is_learned: whether it is taken over from the slope that led to xi.
    """

    def __init__(self, pair: tuple[int, int], sense: int, filtered: Filtered, build: Callable[[], Affine]) -> None:
        super().__init__(filtered, build)
        self.pair, self.sense = pair, sense
        self.is_learned = False


@dataclass(frozen=True, eq=False)
class Vertex:
    """A vertex of the arrangement: the signs of the residuals of all rows at a twist xi that solves three of them.

    Attributes:
        basis: numbers of three independent rows that hold.
        rows: these.
        signs: of all rows, exactly.
        residuals: those that floats know to some seven digits, and nan for the others; or of all, whole numbers in the
            same ratios.
    """

    basis: tuple[int, ...]
    rows: tuple[Row, Row, Row]
    signs: Indices
    residuals: Floats

    @cached_property
    def twist(self) -> Twist:
        """xi, exactly."""
        state = solve_rows(self.rows)
        if state is None:
            raise ValueError("required three independent rows")
        return state.twist

    @cached_property
    def tight(self) -> tuple[int, ...]:
        """Numbers of all rows it satisfies (Z)."""
        return tight_rows(self.signs)


class Beside(NamedTuple):
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


class FilteredPlace(NamedTuple):
    """The same by floats or whole numbers, exact on demand.

    Attributes:
        point: of which the entries are in the order of the coefficients of a form.
        outward: the direction, with a zero before it.
        exactly: makes it.
        line: a form that vanishes at the point, where one is known.
    """

    point: Filtered
    outward: Filtered
    exactly: Callable[[], Beside]
    line: Form | None = None

    def order(self, form: Form) -> Lexicographic:
        """Signs of an affine form at the point and of its derivative along the direction."""
        here = known_sign(form.filtered, self.point)
        along = 0 if here else known_sign(form.filtered, self.outward)
        return order(form.exact, self.exactly()) if here is None or along is None else (here, along)


class RowLines:
    """The rows of an array, exactly, whatever the loads.

    Attributes:
        rows: all of them.
        shares: ``mu_k / |A_k|``: a row's weight over the load of its wheel, for rows scaled by ``|A_k|``.
    """

    def __init__(self, scene: Scene) -> None:
        self.rows = scene_rows(scene)
        self.shares = [row.friction / row.wheel.grip_length for row in self.rows]
        self._edges: dict[tuple[int, int], Triple] = {}

    @cached_property
    def normals(self) -> Sequence[Any]:
        """Of all rows: of python-flint's rationals, which are much quicker, where all are rational."""
        normals = [in_rationals(row.normal) for row in self.rows]
        return normals if all(isinstance(a, fmpq) for a, _, _ in normals) else [row.normal for row in self.rows]

    @cached_property
    def whole_normals(self) -> Indices | None:
        """Whole multiples of all normals, where there are any, shape (2n, 3)."""
        lines = [whole_numbers(row.normal) for row in self.rows]
        if any(line is None for line in lines):
            return None
        most = max(abs(entry) for line in lines for entry in line or ())
        return np.array(lines, dtype=int if most < SHORT else object)

    def edge(self, pair: tuple[int, int]) -> Triple:
        """``a_k x a_l`` of two rows by their numbers, the direction along which both stay as they are (cached)."""
        if pair not in self._edges:
            self._edges[pair] = cross_product(self.normals[pair[0]], self.normals[pair[1]])
        return self._edges[pair]

    def ways(self, pairs: Indices) -> list[Three] | None:
        """Whole multiples of the edges of pairs of rows (m, 2), the same for all edges along a line.

        None where normals have no whole multiples; zeros for parallel rows.
        """
        if self.whole_normals is None:
            return None
        normals = self.whole_normals.take(pairs, 0)
        if len(pairs) <= FEW:
            return [_way(*pair) for pair in normals.tolist()]
        along = np.stack(cross_product(*normals.transpose(1, 2, 0)))
        leading = np.where(along[0] != 0, along[0], np.where(along[1] != 0, along[1], along[2]))
        factors = np.gcd.reduce(along) * np.sign(leading)
        p, q, r = (along // np.where(factors == 0, 1, factors)).tolist()
        return list(zip(p, q, r, strict=True))


class Arrangement:
    """Rows and weights of an array in one load region.

    In floats all normals, all right sides and all weights are taken times a factor for each of the three.  Where these
    are whole numbers so small that sums of their products are floats as well, floats make no error (``whole``).

    Args:
        scene: the array.
        region: where the loads are affine.
        lines: the rows, where they are there already.

    Attributes:
        rows: all of them.
        lines: the same whatever the loads.
        weights: ``beta_k``, affine forms.
        whole: see above.
        is_exact: whether no number stands for others close by.
        error: of the affine forms in floats, in units of the sums of absolute terms.
        corners: of the load region, as rows ``(1, x, y)``.
        corner_sizes: the sizes of these.
        reach: the largest of these.
    """

    def __init__(self, scene: Scene, region: LoadRegion, lines: RowLines | None = None) -> None:
        self.scene = scene
        self.region = region
        self.lines = lines or RowLines(scene)
        self.rows = self.lines.rows
        forces = (region.forces[scene.places[row.wheel.index]] for row in self.rows)
        self.weights = [scaled(force, share) for force, share in zip(forces, self.lines.shares, strict=True)]
        numbers = (
            [x for row in self.rows for x in row.normal],
            [row.rhs for row in self.rows],
            [x for weight in self.weights for x in weight],
        )
        whole_normals, whole_rhs, whole_weights = map(whole_numbers, numbers)
        wholes = whole_normals or [0], whole_rhs or [0], whole_weights or [0]
        self.whole = bool(whole_normals and whole_rhs and whole_weights) and _are_short(*wholes)
        floats = [
            np.array(whole if self.whole else normal_floats(part), dtype=float)
            for part, whole in zip(numbers, wholes, strict=True)
        ]
        sizes = [
            np.abs(values) if self.whole else _sizes(part, values) for part, values in zip(numbers, floats, strict=True)
        ]
        (normals, self.rhs, weights), (normal_sizes, self.rhs_sizes, weight_sizes) = floats, sizes
        self.normals, self.float_weights = normals.reshape(-1, 3), weights.reshape(-1, 3)
        self.sizes, self.weight_sizes = normal_sizes.reshape(-1, 3), weight_sizes.reshape(-1, 3)
        self.crossing, self.crossing_sizes = np.zeros((2, len(self.rows), 3, 3))  # a x b = crossing(a) b
        self.crossing[:, NEXT, AFTER], self.crossing[:, AFTER, NEXT] = -self.normals, self.normals
        self.crossing_sizes[:, NEXT, AFTER] = self.crossing_sizes[:, AFTER, NEXT] = self.sizes
        self.moment_sizes = self.sizes.T @ self.weight_sizes
        self.is_exact = all(type(x) is Number for part in numbers for x in part)
        self.error = 0 if self.whole else FLOAT_ERROR if self.is_exact else ROUNDED
        self.corners = float_corners(region.polygon.vertices)
        coordinates = [x for vertex in region.polygon.vertices for x in (scene.field.one, *vertex)]
        self.corner_sizes = _sizes(coordinates, self.corners.ravel()).reshape(-1, 3)
        self.reach = self.corner_sizes.max(axis=0)
        self._vertices: dict[bytes, Vertex] = {}
        self._rates: dict[tuple[int, int], tuple[Floats, Floats]] = {}
        self._last_pull = np.zeros(len(self.rows), dtype=int), [_zero_form(scene) for _ in range(3)]

    @cached_property
    def moments(self) -> list[list[Affine]]:
        """``beta_k a_k``: of each row three affine forms."""
        return [
            [(b * entry, b_x * entry, b_y * entry) for entry in normal]
            for normal, (b, b_x, b_y) in zip(self.lines.normals, self.weights, strict=True)
        ]

    def vertex_at(self, twist: Twist) -> Vertex | None:
        """The vertex at a twist; None where fewer than three independent rows hold."""
        tight = [k for k, row in enumerate(self.rows) if not row.residual(twist).sign()]
        basis = tuple(tight[k] for k in independent(self.rows[k].normal for k in tight))
        return self.vertex(basis, tight) if len(basis) == 3 else None

    def vertex(self, basis: tuple[int, ...], holding: Collection[int]) -> Vertex:
        """The vertex at which three independent rows hold, each once.

        Args:
            basis: their numbers.
            holding: numbers of rows that are known to hold there.
        """
        i, j, k = basis
        first, second = [j, k, i], [k, i, j]
        rates = self.directions(first, second) @ self.normals.T
        rhs, determinant = self.rhs.take(basis), float(rates[0, i])
        residuals = known = (rhs @ rates - self.rhs * determinant) * math.copysign(1.0, determinant)
        if not self.whole:
            sizes = self.direction_sizes(first, second) @ self.sizes.T
            bounds = self.rhs_sizes.take(basis) @ sizes + self.rhs_sizes * sizes[0][i]
            clear = np.abs(residuals) > bounds * FLOAT_DOUBT + SMALLEST_NORMAL
            clear &= abs(determinant) > sizes[0][i] * FLOAT_DOUBT + SMALLEST_NORMAL
            known = np.where(clear, residuals, 0.0)
            residuals = np.where(clear, residuals / abs(determinant), np.nan)
        signs = np.sign(known).astype(int)
        found = Vertex(basis, (self.rows[i], self.rows[j], self.rows[k]), signs, residuals)
        for n in [] if self.whole else np.isnan(residuals).nonzero()[0].tolist():
            signs[n] = 0 if n in holding else self.rows[n].residual(found.twist).sign()
        return self._vertices.setdefault(signs.tobytes(), found)

    def directions(self, first: Indices | list[int], second: Indices | list[int]) -> Floats:
        """``a_k x a_l`` of pairs of rows by their numbers, in floats, shape (m, 3)."""
        return (self.crossing.take(first, 0) @ self.normals.take(second, 0)[:, :, None])[:, :, 0]

    def direction_sizes(self, first: Indices | list[int], second: Indices | list[int]) -> Floats:
        """Their sums of absolute terms, which bound the errors."""
        return (self.crossing_sizes.take(first, 0) @ self.sizes.take(second, 0)[:, :, None])[:, :, 0]

    def rates(self, pair: tuple[int, int]) -> tuple[Floats, Floats]:
        """How fast residuals change along an edge, in floats with the sums of absolute terms (cached)."""
        if pair not in self._rates:
            direction = self.crossing[pair[0]] @ self.normals[pair[1]]
            sizes = self.crossing_sizes[pair[0]] @ self.sizes[pair[1]]
            self._rates[pair] = self.normals @ direction, self.sizes @ sizes
        return self._rates[pair]

    def spans(self, pair: tuple[int, int], k: int) -> bool:
        """Whether a row is independent of two others that are."""
        rates, sizes = self.rates(pair)
        is_clear = abs(rates[k]) > sizes[k] * FLOAT_DOUBT + SMALLEST_NORMAL
        return bool(is_clear) or bool(inner(self.lines.normals[k], self.lines.edge(pair)))

    def slopes_along(self, pair: tuple[int, int], signs: Indices) -> tuple[Affine, Affine]:
        """The slopes along the edge of a pair and back, exactly, where the residuals of the rows have these signs."""
        direction = self.lines.edge(pair)
        tight = [k for k in tight_rows(signs) if k not in pair]
        reaches = [abs(inner(self.lines.normals[k], direction)) for k in tight]
        kept = self._weighted(reaches, [self.weights[k] for k in tight])
        along = self._weighted(direction, self._pull(signs))
        return added(kept, along), subtracted(kept, along)

    def _weighted(self, factors: Sequence[Any], forms: Sequence[Affine]) -> Affine:
        """``sum_k f_k form_k``."""
        if self.is_exact and isinstance(self.lines.normals[0][0], fmpq):
            constant, x, y = (self.scene.field.combination(factors, [form[k] for form in forms]) for k in range(3))
            return constant, x, y
        total = _zero_form(self.scene)
        for factor, form in zip(factors, forms, strict=True):
            if not _is_always_zero(factor):
                total = added(total, scaled(form, factor))
        return total

    def _pull(self, signs: Indices) -> list[Affine]:
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

    def line_search(self, vertex: Vertex, slope: SlopeOfD, place: FilteredPlace) -> tuple[Vertex, Form]:
        """First vertex along the direction beyond which D no longer falls, and the slope of D before it is reached."""
        form: Form = slope
        passed: list[int] = []
        for reached in self.breakpoints(vertex, slope):
            crossed, before = reached, form
            if form is place.line and any(known_sign(self._loads[k], place.point) == 1 for k in crossed):
                break  # from zero it rises
            passed += crossed
            form = self._beyond(before, slope, crossed, tuple(passed))
            if place.order(form) >= (0, 0):
                break
        return self._reached(slope, crossed), before

    @cached_property
    def _loads(self) -> list[Filtered]:
        """The weights of all rows."""
        weights, sizes = self.numbers(self.float_weights), self.numbers(self.weight_sizes)
        return [Filtered.bounded(*pair, self.error) for pair in zip(weights, sizes, strict=True)]

    def _beyond(self, form: Form, slope: SlopeOfD, crossed: Sequence[int], passed: Sequence[int]) -> Form:
        """The slope of D along the same direction beyond rows that are crossed, and others that were passed before."""
        (rates, bounds), chosen = self.rates(slope.pair), list(crossed)
        values = 2 * np.abs(rates[chosen]) @ self.float_weights[chosen]
        sizes = 2 * bounds[chosen] @ self.weight_sizes[chosen]
        gained = Filtered.bounded(self.numbers(values), self.numbers(sizes), self.error)

        def build() -> Affine:
            edge = self.lines.edge(slope.pair)
            base, rows = (form, crossed) if "exact" in vars(form) else (slope, passed)  # no recursion over many rows
            turns = [scaled(self.weights[k], 2 * abs(inner(self.lines.normals[k], edge))) for k in rows]
            return reduce(added, turns, base.exact)

        return Form(form.filtered.plus(gained), build)

    def numbers(self, floats: Floats) -> Any:
        """As a list of floats, or of the whole numbers that they are."""
        return (floats.astype(int) if self.whole else floats).tolist()

    def next_vertex(self, vertex: Vertex, slope: SlopeOfD) -> Vertex:
        """The first vertex along the direction of a slope."""
        return self._reached(slope, next(self.breakpoints(vertex, slope)))

    def _reached(self, slope: SlopeOfD, crossed: Sequence[int]) -> Vertex:
        """The vertex along the direction of a slope where those rows hold beside the slope's own."""
        return self.vertex((*slope.pair, crossed[0]), (*slope.pair, *crossed))

    def breakpoints(self, vertex: Vertex, slope: SlopeOfD) -> Iterator[list[int]]:
        """The rows that change sign along a slope's direction from a vertex, in the order in which they do."""
        steps = self._float_steps(vertex, slope)
        candidates = sorted((k for k, step in enumerate(steps) if step > 0), key=steps.__getitem__)
        while candidates:
            limit = steps[candidates[0]] * (1 + STEP_DOUBT)
            near = [k for k in candidates if steps[k] <= limit]
            crossed = near if len(near) == 1 else self._first_of(vertex, slope, near)
            yield crossed
            candidates = [k for k in candidates if k not in crossed]

    def _first_of(self, vertex: Vertex, slope: SlopeOfD, near: Sequence[int]) -> list[int]:
        """Of rows to which the steps are about the same those that are reached first."""
        if self.whole:
            rates = self.rates(slope.pair)[0]
            steps: list[Any] = [fmpq(abs(int(vertex.residuals[k])), abs(int(rates[k]))) for k in near]
        else:
            steps = [self._step(vertex, slope, k) for k in near]
        least = min(steps)
        return [k for k, step in zip(near, steps, strict=True) if step == least]

    def _float_steps(self, vertex: Vertex, slope: SlopeOfD) -> list[float]:
        """The steps to all rows, rounded, and minus one to those that are not reached; clear ones by floats."""
        rates, bounds = self.rates(slope.pair)
        if self.whole:
            pairs = zip(vertex.residuals.tolist(), rates.tolist(), strict=True)
            return [-slope.sense * residual / rate if rate else -1.0 for residual, rate in pairs]
        clear = (np.abs(rates) > bounds * FLOAT_DOUBT + SMALLEST_NORMAL) & ~np.isnan(vertex.residuals)
        steps = np.divide(-slope.sense * vertex.residuals, rates, out=np.full(len(rates), -1.0), where=clear)
        clear &= np.isfinite(steps) & (np.abs(steps) > SMALLEST_NORMAL)  # what is beyond floats is no ratio
        for k in (~clear & (vertex.signs != 0)).nonzero()[0].tolist():  # rows that hold are not crossed
            step = self._step(vertex, slope, k)
            steps[k] = -1.0 if step is None else max(float(step), SMALLEST_NORMAL)
        found: list[float] = steps.tolist()
        return found

    def _step(self, vertex: Vertex, slope: SlopeOfD, k: int) -> Number | None:
        """Exact positive step to row k, or None where the direction leads away from it."""
        rate = inner(self.lines.normals[k], self.lines.edge(slope.pair))
        if not rate:
            return None
        step = -slope.sense * self.rows[k].residual(vertex.twist) / rate
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

    Products of long numbers are many: where floats show that a minor does not vanish, there are none.  Of rounded
    numbers every member has a quotient of its own, so there minors alone are the same question for all of them.
    """
    minors = (1, 2), (0, 1), (0, 2)
    a, b = [sure_float(x) for x in form], [sure_float(x) for x in line]
    if any(clear_sign(a[i] * b[j], -a[j] * b[i]) for i, j in minors):
        return False
    if not any(isinstance(x, Rounded) for x in (*form, *line)):
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


def _is_always_zero(number: Number) -> bool:
    """Whether a number is zero, and so are all for which it stands: asking that decides nothing by rounding."""
    return type(number) is Number and not number


def _way(first: Three, second: Three) -> Three:
    """The cross product without a common factor, its first entry that is not zero positive."""
    along = cross_product(first, second)
    factor = math.gcd(*along) or 1
    if along < (0, 0, 0):
        factor = -factor
    return along[0] // factor, along[1] // factor, along[2] // factor


def _sizes(numbers: Sequence[Any], values: Floats) -> Floats:
    """Of numbers and their floats (m,), see :func:`size_of`."""
    return np.array([size_of(number, value) for number, value in zip(numbers, values.tolist(), strict=True)])


def float_corners(points: Sequence[Point]) -> Floats:
    """Points as rows ``(1, x, y)``."""
    return np.array([[1.0, *normal_floats(point)] for point in points]).reshape(-1, 3)


def tight_rows(signs: Indices) -> tuple[int, ...]:
    """Numbers of the rows without residual."""
    return tuple((signs == 0).nonzero()[0].tolist())


def minus(vector: Triple) -> Triple:
    """``-a``."""
    return -vector[0], -vector[1], -vector[2]


def _are_short(normals: Sequence[int], rhs: Sequence[int], weights: Sequence[int]) -> bool:
    """Whether all sums of products of these whole numbers that occur are floats."""
    normal, side, weight = (max(map(abs, part)) for part in (normals, rhs, weights))
    return bool(normal**2 * max(12 * len(rhs) * normal * weight, 24 * normal * side, 6 * normal) < EXACT_FLOATS)


def _zero_form(scene: Scene) -> Affine:
    zero = scene.field.zero
    return zero, zero, zero
