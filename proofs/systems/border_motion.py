"""What solutions do on the straight borders between the cells of a plain system: cross, slide, leave, or touch.

Along a border the normal parts of polynomial fields are polynomials in one parameter, so the signs are constant between
their real roots, which are isolated exactly.  Borders along curves are not looked at.

With sines and cosines of states the normal part of each field is a function of one parameter t between 0 and 1.  On a
part of the border its sign is proved where its ball excludes zero, or where that of its derivative does and the signs
at both ends are known; then a change of sign is one root, which is enclosed.  Other parts are halved.  Roots have no
name in the field, so the ends of what is found lie close to them; stretches shorter than ``SHORT`` are left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from itertools import combinations, pairwise
from typing import Any

from flint import arb, arb_series, ctx, fmpq

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.region import Segment, affine, common_edges, on_edge
from nonsmooth.analysis.cells.switched_cells import FieldCell
from nonsmooth.analysis.fields.stated_field import StatedField, StatedWave
from nonsmooth.proofs.inequalities.real_roots import (
    RealRoot,
    along_edge,
    positive_roots,
    samples_between,
    separated,
    trimmed,
    value,
)
from nonsmooth.proofs.orbits.ball_steps import in_balls
from nonsmooth.symbolic.formulas.enclosed_functions import ONE_AT_ZERO
from nonsmooth.symbolic.mechanics.contact_states import cross_product
from nonsmooth.symbolic.numbers.lazy import evaluated
from nonsmooth.symbolic.numbers.plane import between, dot
from nonsmooth.symbolic.numbers.polynomial import Polynomial


class BorderKind(StrEnum):
    """What solutions do on a part of a border."""

    CROSSING = "crossing"
    SLIDING = "sliding"  # both fields push onto it
    REPELLING = "repelling"  # both fields push away; solutions may stay on it, and leave at any time
    TOUCHED = "touched"  # a field runs along it
    UNDECIDED = "undecided"  # the sign of a normal part of sines and cosines was not found


@dataclass(frozen=True)
class BorderPart:
    """A part of a border between two cells.

    Attributes:
        start: one end.
        end: the other end.
        kind: what solutions do between.
        is_exact: whether the ends are exact; otherwise they are close to a root that has no name in the field.
        normal: into the cell of the first field.
        fields: the field on each side, the first one where several act.
    """

    start: Point
    end: Point
    kind: BorderKind
    is_exact: bool
    normal: Point
    fields: tuple[StatedField, StatedField]


def border_parts(cells: Sequence[FieldCell]) -> Iterator[BorderPart]:
    """All parts of straight borders across which the field changes."""
    for first, second in combinations(cells, 2):
        if first.velocities == second.velocities or are_parted(first, second):
            continue
        for edge in common_edges(first.region, second.region):
            yield from _parts(first, second, edge)


def are_parted(first: FieldCell, second: FieldCell) -> bool:
    """Whether two cells lie on two sides of a curve."""
    return any(not g + h for g in first.region.guards for h in second.region.guards)


def _parts(first: FieldCell, second: FieldCell, edge: Segment) -> Iterator[BorderPart]:
    a, b, _ = cross_product(*edge)  # positive inside the first cell
    normal = [[trimmed(along_edge(f * a + g * b, edge)) for f, g in cell.velocities] for cell in (first, second)]
    curves = [curve for side in normal for curve in side if curve]
    roots = separated(root for curve in curves if len(curve) > 1 for root in positive_roots(curve))
    ends: list[tuple[Point, bool]] = [(affine(edge[0]), True), *(_root_point(r, edge) for r in roots)]
    ends.append((affine(edge[1]), True))
    for t, ((start, known), (end, named)) in zip(samples_between(roots), pairwise(ends), strict=True):
        signs = [{value(curve, t).sign() if curve else 0 for curve in side} for side in normal]
        fields = StatedField(first.velocities[0]), StatedField(second.velocities[0])
        yield BorderPart(start, end, border_kind(*signs), known and named, (a, b), fields)


def sliding_velocity(part: BorderPart, place: Point) -> Point:
    """The mixture of both fields that is tangent to the border, ``((n . g) f - (n . f) g)/(n . g - n . f)``.

    Args:
        part: a border onto which both fields push, or from which both push away.
        place: on it.

    Raises:
        ZeroDivisionError: where both fields have the same normal part.
    """
    f, g = (field.at(place) for field in part.fields)
    a, b = part.normal
    normal = (float(a), float(b)) if any(field.waves for field in part.fields) else part.normal
    across_f, across_g = (dot(normal, velocity) for velocity in (f, g))
    first, second = ((across_g * a - across_f * b) / (across_g - across_f) for a, b in zip(f, g, strict=True))
    return (first, second)


def border_kind(first: set[int], second: set[int]) -> BorderKind:
    """From the signs of the normal parts; positive points into the first cell."""
    if 0 in first | second:
        return BorderKind.TOUCHED
    if first == {-1} and second == {1}:
        return BorderKind.SLIDING
    if first == {1} and second == {-1}:
        return BorderKind.REPELLING
    return BorderKind.CROSSING


def _root_point(root: RealRoot, edge: Segment) -> tuple[Point, bool]:
    exact = root.exact()
    return on_edge(edge, root.low if exact is None else exact), exact is not None


SHORT = Fraction(1, 2**20)  # of a border: parts that are left out
NARROW = Fraction(1, 2**40)  # of a border: what encloses a root
CUTS = (Fraction(1, 2), Fraction(3, 7))  # of what encloses it: the second one where the root is in the middle
MOST_PARTS = 400  # of a border that are looked at for one sign
BITS = 128


@dataclass(frozen=True)
class BorderStretch:
    """A part of a border on which the sign of a function is known.

    Attributes:
        low: where it begins, between 0 and 1.
        high: where it ends.
        sign: of the function inside; None where it was not found.
    """

    low: Fraction
    high: Fraction
    sign: int | None


class NormalPart:
    """The part of a field across a border, as a function of t.

    Args:
        rate: a polynomial in x, y and the waves.
        waves: what its further variables are.
        start: of the border, where t = 0.
        end: of the border, where t = 1.
    """

    def __init__(self, rate: Polynomial, waves: Sequence[StatedWave], start: Point, end: Point) -> None:
        self._rate, self._waves, self._ends = rate, waves, (start, end)
        self._at = in_balls(rate)
        self._arguments = [(wave.kind, in_balls(wave.argument)) for wave in waves]
        self._place = [(evaluated(a).ball(), evaluated(b - a).ball()) for a, b in zip(start, end, strict=True)]

    def stretches(self) -> Iterator[BorderStretch]:
        """Signs from 0 to 1, in order; narrow gaps hold roots."""
        if not self._rate:
            yield BorderStretch(Fraction(0), Fraction(1), 0)
            return
        stretches, waiting, remaining = [], [(Fraction(0), Fraction(1))], MOST_PARTS
        while waiting:
            low, high = waiting.pop(0)
            remaining -= 1
            pieces = self._signs_on(low, high)
            if pieces is not None:
                stretches += pieces
            elif remaining > 0 and high - low > SHORT:
                waiting += [(low, (low + high) / 2), ((low + high) / 2, high)]
            else:
                stretches.append(BorderStretch(low, high, None))
        yield from _joined(sorted(stretches, key=lambda stretch: stretch.low))

    def _signs_on(self, low: Fraction, high: Fraction) -> list[BorderStretch] | None:
        """The signs on a part; None where they do not follow from one ball of the function and its derivative."""
        value, slope = self._over(low, high)
        if not value.contains(0):
            return [BorderStretch(low, high, _sign(value))]
        if slope.contains(0):
            return None
        ends = self._sign_at(low), self._sign_at(high)
        if None in ends:
            return None
        first, last = ends
        if not first or not last or first == last:
            return [BorderStretch(low, high, first or last)]
        before, after = self._root_between(low, high, first)
        return [BorderStretch(low, before, first), BorderStretch(after, high, last)]

    def _root_between(self, low: Fraction, high: Fraction, first: int | None) -> tuple[Fraction, Fraction]:
        """A narrow enclosure of the one root between ends with different signs."""
        while high - low > NARROW:
            signs = ((at, self._sign_at(at)) for at in (low + share * (high - low) for share in CUTS))
            cut, here = next((pair for pair in signs if pair[1]), (low, None))
            if here is None:  # too near to the root to tell
                return low, high
            low, high = (cut, high) if here == first else (low, cut)
        return low, high

    def _sign_at(self, t: Fraction) -> int | None:
        """The sign at a place: exact 0 only where the function is known to vanish at an end; None if not found."""
        value, _ = self._over(t, t)
        if not value.contains(0):
            return _sign(value)
        return 0 if t in {0, 1} and self._vanishes_at(self._ends[int(t)]) else None

    def _vanishes_at(self, place: Point) -> bool:
        """Whether the function is exactly zero at a place at which all arguments of its waves are."""
        if any(evaluated(wave.argument(place)) for wave in self._waves):
            return False
        return not evaluated(self._rate([*place, *(int(wave.kind in ONE_AT_ZERO) for wave in self._waves)]))

    def _over(self, low: Fraction, high: Fraction) -> tuple[Any, Any]:
        """Balls of the function and of its derivative on a part."""
        middle, half = (low + high) / 2, (high - low) / 2
        t = arb(fmpq(middle.numerator, middle.denominator), fmpq(half.numerator, half.denominator))
        place = [arb_series([a + t * b, b], prec=2) for a, b in self._place]
        waves = []
        for kind, inner in self._arguments:
            argument = inner(place)
            waves.append(1 - 2 / ((2 * argument).exp() + 1) if kind == "tanh" else getattr(argument, kind)())
        value = arb_series([0], prec=2) + self._at([*place, *waves])
        return value[0], value[1]


def wave_border_parts(cells: Sequence[FieldCell], fields: Sequence[StatedField]) -> Iterator[BorderPart]:
    """All parts of straight borders across which the field changes.

    Args:
        cells: of a system with sines or cosines of states.
        fields: the field of each.
    """
    for (first, f), (second, g) in combinations(zip(cells, fields, strict=True), 2):
        if f == g or are_parted(first, second):
            continue
        for edge in common_edges(first.region, second.region):
            with ctx.workprec(BITS):
                parts = list(_wave_parts(f, g, edge))
            yield from parts


def _wave_parts(first: StatedField, second: StatedField, edge: Segment) -> Iterator[BorderPart]:
    a, b, _ = cross_product(*edge)  # positive inside the first cell
    start, end = map(affine, edge)
    (f, g), (h, k) = first.rates, second.rates
    signs = [
        list(NormalPart(across, field.waves, start, end).stretches())
        for across, field in ((f * a + g * b, first), (h * a + k * b, second))
    ]
    for one in signs[0]:
        for other in signs[1]:
            low, high = max(one.low, other.low), min(one.high, other.high)
            if high - low > SHORT:
                places = [between(start, end, t) for t in (low, high)]
                exact = low == 0 and high == 1
                kind = _kind(one.sign, other.sign)
                yield BorderPart(places[0], places[1], kind, exact, (a, b), (first, second))


def _kind(first: int | None, second: int | None) -> BorderKind:
    return BorderKind.UNDECIDED if first is None or second is None else border_kind({first}, {second})


def _joined(stretches: Sequence[BorderStretch]) -> Iterator[BorderStretch]:
    """Neighbours of one sign as one."""
    last: BorderStretch | None = None
    for stretch in stretches:
        if last is not None and last.sign == stretch.sign and last.high == stretch.low:
            last = BorderStretch(last.low, stretch.high, last.sign)
            continue
        if last is not None:
            yield last
        last = stretch
    if last is not None:
        yield last


def _sign(ball: Any) -> int:
    return 1 if ball > 0 else -1
