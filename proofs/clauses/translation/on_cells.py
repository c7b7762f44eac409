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

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import arb

from nonsmooth.analysis.cells.fan import build_fan
from nonsmooth.analysis.cells.filippov import CellDerivative, RelativeRate, cell_derivatives
from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.analysis.cells.polygon import HalfPlane, Point
from nonsmooth.analysis.cells.support import Support, limiting_support
from nonsmooth.proofs.clauses.clause import Witness
from nonsmooth.proofs.clauses.every_load.cocircular import CocircularArray
from nonsmooth.proofs.clauses.translation.fan_stability import FanResult, decide_fan
from nonsmooth.proofs.clauses.translation.quadratic import QuadraticCertificate, find_quadratic
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.symbolic.numbers.enclosures import rational_below, square_root
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import brief_text
from nonsmooth.symbolic.numbers.plane import around, cross, dot, minus
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


def squared_distance(start: Point, end: Point) -> Number:
    """Squared distance of the origin from a segment."""
    along = minus(end, start)
    length, shift = dot(along, along), -dot(start, along)
    if shift.sign() <= 0:
        return dot(start, start)
    if shift >= length:
        return dot(end, end)
    area = cross(start, along)
    return area * area / length


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
    cells = [cell for cell in partition.cells_at((zero, zero)) if cell.rests]
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
    for derivative in local_derivatives(derivatives):
        for vertex, rate in zip(derivative.cell.polygon.vertices, derivative.rates, strict=True):
            if any(vertex) and not rate and _rests_on_ray(derivatives, vertex):
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
