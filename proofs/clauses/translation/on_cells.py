"""Clause 2: stability of (x, y) by ``V = |c|^2``, exactly, on closed cells.

On each closed cell with constant twist ``V* = 2 c . v`` is linear, so its sign is decided at the vertices; values
on open cells would not do (Filippov's F on an edge holds the velocities of both sides).  Near the equilibrium
only the cells whose closure holds it matter:

- ``V* < 0`` at all their nonzero vertices: asymptotically stable, and in finite time, since ``V* <= -kappa |c|``;
- ``V* <= 0``: stable.  A ray of the equilibrium on which V* vanishes and the velocities of two cells oppose each
  other consists of equilibria: then the stability is not asymptotic;
- ``V* > 0`` somewhere: ``V = |c|^2`` is refuted as a certificate, with that vertex as witness.  This says nothing
  about stability itself.

Where V leaves the question open, the fan of cones at the equilibrium decides (module ``fan``).
The region is the largest disc in the square on which the inequality holds.  For an array that meets the hypotheses of
module ``cocircular``, V* <= 0 is known beforehand and only the rest area at the equilibrium is
looked at.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple, TypeAlias

from flint import arb

from nonsmooth.analysis.cells.fan import build_fan
from nonsmooth.analysis.cells.filippov import CellDerivative, RelativeRate, cell_derivatives
from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.analysis.cells.polygon import HalfPlane, Point
from nonsmooth.analysis.cells.support import Support, limiting_support
from nonsmooth.proofs.clauses.at_point.cocircular import CocircularArray
from nonsmooth.proofs.clauses.clause import Witness
from nonsmooth.proofs.clauses.translation.fan_stability import FanResult, decide_fan
from nonsmooth.proofs.clauses.translation.quadratic import QuadraticCertificate, find_quadratic
from nonsmooth.proofs.findings import Translation
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.numbers.enclosures import enclosure, rational_below, short_below, square_root
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.number_text import brief_text
from nonsmooth.symbolic.numbers.plane import around, between, cross, dot, minus, squared_distance
from nonsmooth.symbolic.numbers.rounded import either_way

# ---- the disc about the equilibrium on which V* of ``V = |c|^2`` is negative, or not positive ----
#
# On a closed cell V* is linear, so where it is not as required is a polygon; the disc ends at the nearest of them.


def region_radius(
    derivatives: Sequence[CellDerivative], *, strict: bool, within: Number, limit: Number | None = None
) -> Number:
    """Radius of the largest disc, up to the given one, on which V* < 0 (or <= 0); ``limit`` bounds its square too.

    A rational just below it where its exact form is out of reach.
    """
    nearest = squared_reach(derivatives, strict=strict, within=within)
    nearest = nearest if limit is None else min(nearest, limit)
    if nearest == within * within:
        return within
    root = square_root(nearest)
    return root if isinstance(root, Number) else within.field.rational(rational_below(root))


def squared_reach(derivatives: Sequence[CellDerivative], *, strict: bool, within: Number) -> Number:
    """Squared distance of the nearest violation from the equilibrium; the square of ``within`` where it is farther."""
    segments = [segment for d in derivatives for segment in _violating_segments(d, strict=strict)]
    with either_way(within.field):  # of ends that are as near any will do
        return min([within * within, *(squared_distance(*segment) for segment in segments)])


def _violating_segments(derivative: CellDerivative, *, strict: bool) -> Iterator[tuple[Point, Point]]:
    """Boundary segments of the part of the closed cell where V* is not as required (without the equilibrium)."""
    worst, _ = derivative.largest
    polygon = derivative.cell.polygon
    zero = worst.field.zero
    if worst.sign() < 0 or (not strict and not worst) or polygon.contains((zero, zero)):
        return
    vx, vy = derivative.twist.velocity
    part = polygon.clipped(HalfPlane((-vx, -vy), zero)) if vx or vy else polygon
    if part is None:  # V* vanishes on a side or at a vertex only
        flat = [p for p, rate in zip(polygon.vertices, derivative.rates, strict=True) if not rate]
        yield flat[0], flat[-1]
        return
    yield from around(part.vertices)


# ---- the decision --------------------------------------------------------------------------------


LYAPUNOV = "x**2 + y**2"


@dataclass(frozen=True)
class TranslationResult:
    """Verdict with its evidence.

    Attributes:
        verdict: strong stability of (x, y).
        derivatives: V* at the vertices of every closed cell: the certificate, or its refutation.
        worst: largest ``V*/|c|`` over the checked square.
        region_radius: radius of the disc on which V* is as the verdict says; None where there is none.
        witness: a point where V* > 0, or an equilibrium beside c* (stable, not asymptotically).
        reason: one sentence for people.
        fan: the decision by cones, where V leaves the question open.
        lemma: the certificate of V* <= 0 that spares the other cells, where there is one.
        support: the support polygon, where the checked square leaves it: beyond its border the body tips.
        quadratic: another Lyapunov function, with rate and region, where the fan attracts and |c|^2 is no certificate.
    """

    verdict: Translation
    derivatives: tuple[CellDerivative, ...]
    worst: RelativeRate
    region_radius: Number | None
    witness: Witness | None
    reason: str
    fan: FanResult | None = None
    lemma: CocircularArray | None = None
    quadratic: QuadraticCertificate | None = None
    support: Support | None = None

    @property
    def support_note(self) -> str:
        """What the support polygon leaves of the square, in one sentence; empty where the square lies inside."""
        if self.support is None:
            return ""
        if not self.support.stands:
            return (
                "the body tips at c*, which is not inside the support polygon: this is said of the contact rule alone"
            )
        distance = brief_text(self.support.distance)
        return f"the square leaves the support polygon, {distance} from c*: beyond its border the body tips"

    @property
    def worst_rate(self) -> Number | arb:
        """``max V*/|c|`` over the square, exactly; a ball where the exact form is out of reach."""
        return self.worst.value

    @property
    def sampled(self) -> None:
        """Nothing is sampled: V* is exact on the cells."""

    @property
    def decay_rate(self) -> Number | arb | None:
        """Kappa > 0 with ``V* <= -kappa |c|`` on the whole square, where there is one."""
        return -self.worst_rate if self.worst.sign() < 0 else None

    @property
    def home_radius(self) -> Number | None:
        """Radius of a disc of starts from which every solution comes home; None where only near starts do."""
        if self.verdict is not Translation.ASYMPTOTICALLY_STABLE:
            return None
        if self.quadratic is not None:
            return self.quadratic.disc_radius
        return self.region_radius if self.fan is None else None

    @property
    def swing_radius(self) -> Number | None:
        """A distance that no body from within ``home_radius`` exceeds on its way; None where that radius is not known.

        Where ``|c|`` does not grow it is that radius itself; elsewhere the level set of V bounds it.
        """
        within = self.home_radius
        if within is None or self.quadratic is None:
            return within
        shrinks = self.region_radius is not None and within <= self.region_radius
        return within if shrinks else self.quadratic.swing_radius

    @property
    def arrival_per_distance(self) -> Number | Fraction | None:
        """Bound on the time of arrival per unit of ``|c_0|``, from starts within ``home_radius``.

        ``V = |c|^2`` with ``V* <= -kappa |c|`` gives ``d|c|/dt <= -kappa/2``, so ``2/kappa``.  Where the exact kappa is
        out of reach, a rational below it serves.
        """
        if self.home_radius is None:
            return None
        if self.quadratic is not None:
            return self.quadratic.arrival_per_distance
        kappa = self.decay_rate
        if kappa is None or isinstance(kappa, Number):
            return None if kappa is None else 2 / kappa
        return 2 / rational_below(kappa)

    @property
    def exponential_rate(self) -> None:
        """None: with constant velocities a body arrives, or not; it does not approach exponentially."""


def decide_translation(partition: Partition, lemma: CocircularArray | None = None) -> TranslationResult:
    """Decide the translation clause for a centred partition: by ``V = |c|^2``, then by the fan.

    Args:
        partition: all cells of the square, or only those at the equilibrium where the lemma covers the others.
        lemma: certificate of ``V* <= 0`` for the whole square.
    """
    derivatives = cell_derivatives(partition)
    support = limiting_support(partition)
    local = list(_local_rates(derivatives))
    with either_way(partition.scene.field):  # of rates that are as large any will do
        worst = max(derivative.relative() for derivative in derivatives)
        point, highest = max(local, key=lambda pair: pair[1])
    worst.sign()  # of which the time of arrival makes use
    if highest.sign() > 0:
        fan = decide_fan(partition)
        witness = Witness(point, highest, "V* > 0")
        reason = f"{fan.reason}; V = |c|^2 is no certificate: V* = {brief_text(highest)} > 0 at {_place(point)}"
        quadratic = _quadratic(partition, fan, support)
        return TranslationResult(fan.verdict, derivatives, worst, None, witness, reason, fan, None, quadratic, support)
    strict = max(rate.sign() for _, rate in local) < 0
    radius = _supported_radius(partition, derivatives, support, strict=strict)
    if strict:
        reason = "V* < 0 at every nonzero vertex of the closed cells that meet at the equilibrium"
        verdict = Translation.ASYMPTOTICALLY_STABLE
        return TranslationResult(verdict, derivatives, worst, radius, None, reason, support=support)
    rest = _equilibrium_ray(derivatives)
    fan = decide_fan(partition)
    attracts = fan.verdict is Translation.ASYMPTOTICALLY_STABLE
    quadratic = _quadratic(partition, fan, support)
    verdict = Translation.ASYMPTOTICALLY_STABLE if attracts else Translation.STABLE
    reason = _weak_reason(partition, rest, fan, lemma)
    return TranslationResult(verdict, derivatives, worst, radius, rest, reason, fan, lemma, quadratic, support)


def _supported_radius(
    partition: Partition, derivatives: tuple[CellDerivative, ...], support: Support | None, *, strict: bool
) -> Number | None:
    """Radius of the disc on which V* keeps its sign and the body does not tip; None where it tips at the point."""
    if support is not None and not support.stands:
        return None
    limit = None if support is None else support.squared_distance
    return region_radius(derivatives, strict=strict, within=partition.scene.check.radius, limit=limit)


def _quadratic(partition: Partition, fan: FanResult, support: Support | None) -> QuadraticCertificate | None:
    """Another V with a region, where the fan attracts and the body stands at the point."""
    if fan.verdict is not Translation.ASYMPTOTICALLY_STABLE or (support is not None and not support.stands):
        return None
    return find_quadratic(build_fan(partition), () if support is None else support.sides)


def _weak_reason(partition: Partition, rest: Witness | None, fan: FanResult, lemma: CocircularArray | None) -> str:
    """In words: why V* <= 0, and whether the equilibrium attracts."""
    shown = "V* <= 0 by the lemma on inward rims on one circle" if lemma else "V* <= 0 on the closed cells at the point"
    area = rest_area(partition)
    if area is not None:
        return f"{shown}; not asymptotically: the point lies in a rest area of size {brief_text(area)}"
    if rest is not None:
        ray = _place(rest.point)
        return f"{shown}; not asymptotically: every point of the ray through {ray} near c* is an equilibrium"
    if fan.verdict is Translation.ASYMPTOTICALLY_STABLE:
        return f"{shown}, and {fan.reason}"
    return f"{shown}; whether the point attracts is not decided: {fan.reason}"


def _place(point: Point) -> str:
    return f"({brief_text(point[0])}, {brief_text(point[1])})"


def rest_area(partition: Partition) -> Number | None:
    """Area of the cells at rest whose closure holds the equilibrium, where there are any."""
    zero = partition.scene.field.zero
    cells = [cell for cell in partition.meeting if cell.rests]
    return sum((cell.polygon.area for cell in cells), zero) if cells else None


def local_derivatives(derivatives: tuple[CellDerivative, ...]) -> Iterator[CellDerivative]:
    """Those of the cells whose closure holds the equilibrium."""
    for derivative in derivatives:
        zero = derivative.twist.omega.field.zero
        if derivative.cell.polygon.contains((zero, zero)):
            yield derivative


def _local_rates(derivatives: tuple[CellDerivative, ...]) -> Iterator[tuple[Point, Number]]:
    """(vertex, V*) at the nonzero vertices of the cells that meet at the equilibrium.

    The directions to these vertices span the cell's cone there, and V* is linear: they decide its sign.
    """
    for derivative in local_derivatives(derivatives):
        for vertex, rate in zip(derivative.cell.polygon.vertices, derivative.rates, strict=True):
            if any(vertex):
                yield vertex, rate


def _equilibrium_ray(derivatives: tuple[CellDerivative, ...]) -> Witness | None:
    """A direction whose points near the equilibrium all have 0 in F, if V* vanishes along one.

    On such a ray the velocities with zero radial part are tangential; two opposite ones, or a rest, hold 0 in
    their hull (the term ``omega J c`` is of higher order near the equilibrium).
    """
    for vertex, rate in _local_rates(derivatives):
        if not rate and _rests_on_ray(derivatives, vertex):
            return Witness(vertex, rate, "0 in F on the ray")
    return None


def _rests_on_ray(derivatives: tuple[CellDerivative, ...], point: Point) -> bool:
    """Whether the velocities with zero radial part beside the ray hold two opposite ones, or a rest."""
    twists = [
        derivative.twist
        for derivative in local_derivatives(derivatives)
        if _borders(derivative.cell, point) and not dot(derivative.twist.velocity, point)
    ]
    turns = {cross(point, twist.velocity).sign() for twist in twists}
    return any(not any(twist) for twist in twists) or {1, -1} <= turns


def _borders(cell: Cell, direction: Point) -> bool:
    """Whether a cell whose closure holds the equilibrium holds the points near it along the direction."""
    return all(side.slack(direction).sign() >= 0 for side in cell.polygon.sides if not side.offset)


# ---- the disc as a checker can follow it ---------------------------------------------------------
#
# The disc of the translation clause as a checker can follow it: a squared radius, and barriers where V* grows.
#
# Inside the disc ``V* = 2 c . v`` must not be positive (not even zero, where the verdict rests on ``V* < 0``).  On a
# cell where it is, at some vertex, a barrier shows that this happens beyond the disc only: numbers ``(a, b, t)`` with
# ::
#
#     a x + b y >= 1  at all corners of the cell,   t >= 0,   |n|^2 <= 1/squared_radius  for  n = (a, b) + t v
#
# so ``n . c >= 1`` where ``v . c >= 0`` in the cell, hence ``|c|^2 >= squared_radius`` there.  Floats find the
# barriers, the checker verifies them exactly.  Where V* limits the disc, the squared radius is a short rational just
# below it.


Floats: TypeAlias = tuple[float, float]
State: TypeAlias = tuple[int, int]  # position of a cell, and of a state in it

# Relative margin that a disc leaves for the rounding of its barriers; they are verified exactly.
MARGIN = 2.0**-20
BARRIER_BITS = 48
SIMPLE = 1_000  # denominators of a rate that may be the exact one


class CertifiedDisc(NamedTuple):
    """A disc about the checked point.

    Attributes:
        squared_radius: of the disc; None where V* does not keep its sign near the point.
        barriers: by state, where V* grows outside of the disc.
        strictly: whether V* is negative off the point, or only not positive.
        rate: at which ``|c|`` falls in the whole square; None where there is none.
    """

    squared_radius: Number | None
    barriers: dict[State, list[Fraction]]
    strictly: bool = False
    rate: Fraction | None = None


def certified_disc(partition: Partition) -> CertifiedDisc:
    """The largest disc in the square on which V* is as on the closed cells at the checked point, or a little less.

    It lies in the support polygon too: beyond, the body tips.

    Raises:
        OverflowError: for lengths or speeds beyond the range of floats.
    """
    radius = partition.scene.check.radius
    local = partition.meeting
    highest = max(_largest_sign(cell, twist) for cell in local for twist in cell.twists)
    here = {cell.index for cell in local}
    growing = {
        (k, s): _Growth.of(cell, twist)
        for k, cell in enumerate(partition.cells)
        for s, twist in enumerate(cell.twists)
        if cell.index not in here and _largest_sign(cell, twist) > highest
    }
    nearest = min((growth.distance for growth in growing.values()), default=math.inf)
    squared = radius * radius
    support = limiting_support(partition)
    if support is not None:
        squared = min(squared, support.squared_distance)
    size = math.sqrt(float(squared))
    if nearest * (1 - MARGIN) < size:
        size = nearest * (1 - MARGIN)
        squared = partition.scene.field.rational(_rounded(size * size * (1 - MARGIN)))
    barriers = {state: growth.barrier(size) for state, growth in growing.items()}
    return CertifiedDisc(squared, barriers, highest < 0, None if growing else _falling_rate(partition))


def _falling_rate(partition: Partition) -> Fraction | None:
    """A short ``rate > 0`` with ``c . v <= -rate |c|`` at all corners of all cells, hence in the square; else None."""
    pairs = [
        (-dot(twist.velocity, vertex), dot(vertex, vertex))
        for cell in partition.cells
        for vertex in cell.polygon.vertices
        if any(vertex)
        for twist in cell.twists
    ]
    least = min(rational_below(enclosure(inward) / enclosure(square).sqrt()) for inward, square in pairs)
    if least <= 0:
        return None
    simple = least.limit_denominator(SIMPLE)
    is_near = abs(simple - least) < least * Fraction(MARGIN)
    is_exact = is_near and all(sign(inward * inward - square * (simple * simple)) >= 0 for inward, square in pairs)
    return simple if is_exact else short_below(least)


def _largest_sign(cell: Cell, twist: Twist) -> int:
    """Largest sign of V* at the vertices other than the checked point."""
    return max(sign(dot(twist.velocity, vertex)) for vertex in cell.polygon.vertices if any(vertex))


class _Growth(NamedTuple):
    """A cell in floats, with the point of its part ``v . c >= 0`` that is nearest to the checked point."""

    vertices: tuple[Floats, ...]
    velocity: Floats
    nearest: Floats

    @classmethod
    def of(cls, cell: Cell, twist: Twist) -> _Growth:
        """The part follows from exact signs: floats could miss a vertex or side on which V* vanishes."""
        vertices = tuple((float(x), float(y)) for x, y in cell.polygon.vertices)
        signs = [sign(dot(twist.velocity, vertex)) for vertex in cell.polygon.vertices]
        v = float(twist.vx), float(twist.vy)
        part: list[Floats] = []
        for (p, here), (q, after) in around(list(zip(vertices, signs, strict=True))):
            if here >= 0:
                part.append(p)
            if here * after < 0:
                part.append(_crossing(p, q, v))
        return cls(vertices, v, min((_nearest(p, q) for p, q in around(part)), key=lambda p: math.hypot(*p)))

    @property
    def distance(self) -> float:
        """Distance of the part from the checked point (length)."""
        return math.hypot(*self.nearest)

    def barrier(self, size: float) -> list[Fraction]:
        """A barrier for the disc of this size, midway between what the disc and what the part allow."""
        scale = math.sqrt(self.distance / size) / self.distance / self.distance
        n, v = (self.nearest[0] * scale, self.nearest[1] * scale), self.velocity
        lower, upper = 0.0, math.inf
        for p in self.vertices:
            rate, slack = dot(v, p), dot(n, p) - 1
            if rate > 0:
                upper = min(upper, slack / rate)
            elif rate < 0:
                lower = max(lower, slack / rate)
        t = (lower + upper) / 2 if upper < math.inf else 2 * lower
        return [_rounded(x) for x in (n[0] - t * v[0], n[1] - t * v[1], t)]


def _crossing(p: Floats, q: Floats, v: Floats) -> Floats:
    """The point of a segment where ``v . c`` changes sign."""
    a, b = abs(dot(v, p)), abs(dot(v, q))
    return between(p, q, a / (a + b) if a + b else 0.5)


def _nearest(p: Floats, q: Floats) -> Floats:
    """The point of a segment that is nearest to the origin."""
    along = minus(q, p)
    length = dot(along, along)
    return between(p, q, min(1.0, max(0.0, -dot(p, along) / length)) if length else 0.0)


def _rounded(value: float) -> Fraction:
    """A short rational within ``2^-BARRIER_BITS`` of the value, relatively."""
    if not math.isfinite(value):
        raise OverflowError("required lengths and speeds within the range of floats")
    mantissa, exponent = math.frexp(value)
    return Fraction(round(mantissa * 2**BARRIER_BITS)) * Fraction(2) ** (exponent - BARRIER_BITS)
