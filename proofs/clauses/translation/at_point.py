"""Clause 2 under a rule without cells: exact linearization at the point, or rest.

V* over the square is exact only where the lemma on inward rims covers it; otherwise it is sampled with the numerical
minimizer and said to be sampled.  Where loads are unknown, stability is shown under every load, or a
load that throws the body out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING

from flint import arb

from nonsmooth.analysis.bodies.gyration import squared_radius_of_disc
from nonsmooth.analysis.cells.load_sets import AdmissibleLoads, LoadPolytope, Loads, LoadSet, SpringLoads, priced
from nonsmooth.analysis.cells.loads import LoadRegion
from nonsmooth.analysis.cells.polygon import HalfPlane
from nonsmooth.proofs.boxes.enclosures import is_positive_definite
from nonsmooth.proofs.boxes.linearization import Linearization, Slip, Slope, hessian, inward_pull
from nonsmooth.proofs.clauses.at_point.cocircular import CocircularArray
from nonsmooth.proofs.clauses.at_point.ellipse import EllipsePoint
from nonsmooth.proofs.clauses.at_point.every_load import (
    EveryLoad,
    EveryLoadPoint,
    is_admissible,
    load_text,
    mixed,
    wheel_slips,
)
from nonsmooth.proofs.clauses.at_point.mass import MassLimit, decide_mass_limit
from nonsmooth.proofs.findings import Equilibrium, Translation
from nonsmooth.symbolic.mechanics.contact_states import cross_product, inner
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import Real, brief_text
from nonsmooth.symbolic.numbers.plane import dot
from nonsmooth.symbolic.numbers.rounded import BY_ROUNDING, either_way

if TYPE_CHECKING:
    from nonsmooth.analysis.minimizers.sampling import SampledDerivative


class WithoutCells:
    """What a result of clause 2 without cells does not have, and what follows of the disc that it has."""

    region_radius: Number | None

    @property
    def quadratic(self) -> None:
        """No other Lyapunov function is looked for."""

    @property
    def witness(self) -> None:
        """None: no single point refutes."""

    @property
    def support_note(self) -> str:
        """Empty: a square that leaves the support polygon is refused under rules that need loads."""
        return ""

    @property
    def arrival_per_distance(self) -> None:
        """None: the point is approached, and not reached in finite time."""

    @property
    def home_radius(self) -> Number | None:
        """Radius of a disc of starts that come home; None where only starts close by are known to."""
        return self.region_radius

    @property
    def swing_radius(self) -> Number | None:
        """Largest distance of bodies from within ``home_radius``: that radius, for the distance does not grow there."""
        return self.home_radius


@dataclass(frozen=True)
class EllipseTranslation(WithoutCells):
    """Clause 2: stability of (x, y) by exact linearization, or by rest.

    Attributes:
        point: the situation at the equilibrium.
        lemma: certificate of ``V* <= 0`` on the whole square, where the array meets its hypotheses.
        sampled: V* at random points of the square, where it is not known exactly.
        mass: up to which mass a body is attracted under full dynamics; None where the point does not attract, or
            where that is not decided.
        region_radius: of a disc in which the distance falls strictly, so that every body comes home from it; or of one
            in which bodies turn about the point, or rest.
    """

    point: EllipsePoint
    lemma: CocircularArray | None
    sampled: SampledDerivative | None = field(compare=False)
    mass: MassLimit | None = None
    region_radius: Number | None = None

    @property
    def verdict(self) -> Translation:
        """Strong stability of (x, y)."""
        return self.point.translation

    @property
    def home_radius(self) -> Number | None:
        """Radius of a disc of starts that come home; None where only starts close by are known to."""
        return self.region_radius if self.verdict is Translation.ASYMPTOTICALLY_STABLE else None

    @property
    def worst_rate(self) -> Number | None:
        """Supremum of ``V*/|c|`` over the square: zero by the lemma (the field vanishes at the equilibrium)."""
        return self.point.scene.field.zero if self.lemma is not None else None

    @property
    def exponential_rate(self) -> Real | None:
        """``-max Re lambda(A)`` where the point attracts: close by, |c| shrinks at any rate below it."""
        linear = self.point.linearization or self.point.rest
        attracts = self.verdict is Translation.ASYMPTOTICALLY_STABLE
        return -linear.spectral_abscissa if attracts and linear is not None else None

    @property
    def reason(self) -> str:
        """One sentence for people."""
        linear, rest = self.point.linearization, self.point.rest
        if rest is not None:
            if self.verdict is Translation.UNDECIDED:
                return f"{BY_ROUNDING}in c' = A (c - c_0) A may have eigenvalues on either side of zero"
            top = brief_text(rest.spectral_abscissa)
            return (
                "c' = A (c - c_0) to first order about the place of rest, and the eigenvalues of A have real parts up "
                f"to {top} (in balls)"
            )
        if self.verdict is Translation.UNDECIDED or linear is None:
            return self.point.summary
        abscissa = linear.spectral_abscissa
        return f"c' = A c to first order, and the eigenvalues of A have real parts up to {brief_text(abscissa)}"


def decide_translation_at(
    point: EllipsePoint, lemma: CocircularArray | None, *, samples: int = 0, always: bool = False
) -> EllipseTranslation:
    """Decide the clause from the motion at the point.

    Args:
        point: the exact motion there.
        lemma: the certificate of ``V* <= 0`` on the square, where the array meets its hypotheses.
        samples: random points at which V* is evaluated where the lemma does not apply; 0 for none.
        always: sample also where the lemma applies.
    """
    sampled = None
    if samples and (lemma is None or always):
        from nonsmooth.analysis.minimizers.sampling import sample_smooth_derivative

        with either_way(point.scene.field):  # no sample decides anything
            sampled = sample_smooth_derivative(point.scene, samples)
    linear, mass = point.linearization, None
    if point.translation is Translation.ASYMPTOTICALLY_STABLE and linear is not None:
        mass = decide_mass_limit(linear, squared_radius_of_disc(point.scene))
    disc = home_disc(point.scene, point.region, linear) if mass is not None else None
    if point.equilibrium is Equilibrium.HOLDS and point.turns_within is not None:
        disc = turning_disc(point, point.turns_within)
    inertia = point.scene.inertia
    if inertia is not None and inertia.centre_height is not None:
        mass = None  # it is that of a body whose centre of mass is at the wheels; the answer on inertia says more
    return EllipseTranslation(point, lemma, sampled, mass, region_radius=disc)


# ---- a disc by convexity -------------------------------------------------------------------------
#
# About a smooth minimizer ``xi_0 = (0, 0, omega)`` at the point let the slope of D be ``G c = (beta c, 0)`` with beta
# above zero.  The slips of ``xi_0`` do not depend on c: while the loads keep their affine forms, this is the slope of D
# at ``xi_0`` for every c.  D is convex: every minimizer ``xi = (v, omega')`` obeys ::
#
#     D(xi_0) >= D(xi) >= D(xi_0) + beta c . v,      so  c . v <= 0,
#
# and equality would make ``xi_0`` a minimizer, whose slope is ``beta c``: so ``c . v < 0`` off the point.  Minimizers
# depend on c upper semicontinuously, hence ``V = |c|^2`` falls strictly, and its level sets in that part are left
# inward.


def home_disc(scene: Scene, region: LoadRegion, linearization: Linearization | None) -> Number | None:
    """Radius of the disc about a centred scene's point; None where the slope does not point inward.

    Args:
        scene: the array.
        region: where the loads are affine; it holds the point.
        linearization: at the point.
    """
    if linearization is None or inward_pull(linearization.slope) is None:
        return None
    radius = _disc_of_loads(scene, region)
    return radius if radius.sign() > 0 else None


def _disc_of_loads(scene: Scene, region: LoadRegion) -> Number:
    """Radius of a disc about the point in the square, in which loads are affine; zero where there is none."""
    radius = scene.check.radius
    for side in region.polygon.sides:
        if (side.offset * side.offset - radius * radius * dot(side.normal, side.normal)).sign() < 0:
            radius = min(radius, _distance_below(scene, side))
    return radius


def turning_disc(point: EllipsePoint, within: arb) -> Number | None:
    """Radius of the disc in which wheels impose a spin, or rest; None where there is none.

    Args:
        point: at which they do.
        within: a radius within which the forces of the wheels allow it.
    """
    radius = _disc_of_loads(point.scene, point.region)
    if not within.lower() >= radius.ball():
        radius = min(radius, point.scene.field.rational(max(rational_below(within), Fraction(0))))
    return radius if radius.sign() > 0 else None


def _distance_below(scene: Scene, side: HalfPlane) -> Number:
    """A rational number that is not above the distance of a line from the origin."""
    square = (side.offset * side.offset / dot(side.normal, side.normal)).ball()
    return scene.field.rational(max(rational_below(square.sqrt()), Fraction(0)))


# ---- whether (x, y) decays under every load ------------------------------------------------------
#
# Where loads are unknown clause 2 asks for stability under every load, or for a load that throws the body out.  One
# spin minimizes D smoothly at the point under all of them.  With B, ``pull_i``, ``bend_i`` and ``w_i`` of module
# ``at_point.every_load``, ``xi_0 = (0, 0, omega)``:
#
# *Forces to the middle*, ``B c = (beta c, 0)`` with ``beta > 0``.  D is convex, so at every centre of mass c, under
# every admissible load and for every minimizer ``xi = (v, omega')`` ::
#
#     D(xi) >= D(xi_0) + (B c) . (xi - xi_0) = D(xi_0) + beta c . v,      D(xi) <= D(xi_0),      so  c . v <= 0.
#
# Equality would make ``xi_0`` a minimizer, but D is smooth there with the slope ``beta c``: so ``c . v < 0`` for c !=
# 0. The minimizers depend on (c, N) upper semicontinuously and the loads are a compact set: ``V = |c|^2`` falls at a
# rate that no load undercuts, even one that changes with time.  Near the point ``D(xi_0 + (-t c, 0)) = D(xi_0) - t beta
# |c|^2 + t^2/2 c . H_vv c + O(t^3 |c|^3)`` bounds D(xi) from above; with ``t = beta/L``, ``L = max_i bend_i |w_i|_v^2``
# above H_vv under every load, ``c . v <= -beta/(2 L) |c|^2`` to first order: the distance decays at least at that rate.
#
# *Any other B*, about rest.  ``c' = A(N) c`` to first order, ``A = -W^T H^-1 B`` with W the first two axes.  Where H is
# positive definite, with ``m = B_x x B_y`` (compound matrices) ::
#
#     det A det H   = e_z . H m                                             linear in N
#     -tr A det H   = sum_{i<j} N_i N_j bend_i bend_j (q_x q . B_x + q_y q . B_y),   q = w_i x w_j     quadratic in N
#
# Both positive under every load of the set: A is Hurwitz for all of them, so the point attracts under every load that
# is a continuous function of the pose (near the point it is nearly that of the point).  One load with ``det A < 0`` or
# ``tr A > 0`` throws the body out.


MOST_CORNERS = 100  # of the set of loads: the form is evaluated at all pairs
SHARES = (1, 2, 4, 8)  # parts of a corner in a load beside it under which every wheel carries


@dataclass(frozen=True)
class DecayUnderLoads:
    """The linearization about rest as a function of the loads.

    Attributes:
        slips: every wheel about rest.
        slope: B.
        loads: the set of loads.
    """

    slips: tuple[Slip[Number], ...]
    slope: Slope
    loads: LoadSet

    def is_definite(self, loads: Loads) -> bool:
        """Whether ``H(N)`` is positive definite."""
        return is_positive_definite(hessian(loads[0].field.zero, self.slips, loads))

    @cached_property
    def soft_load(self) -> Loads | None:
        """A load under which H is singular; None where it is positive definite under every load of the set.

        H is linear in the loads: it is definite on a hull where it is at the corners, and where it is under the least
        loads of all wheels.
        """
        bound = self.loads.bound
        corners = bound.corners
        if corners is None:
            return None if self.is_definite(bound.least) else bound.middle
        return next((corner for corner in corners if not self.is_definite(corner)), None)

    @cached_property
    def determinant_prices(self) -> list[Number]:
        """``e_z . H m`` per load."""
        normal = cross_product(*self.slope)
        return [wheel.bend * wheel.w[2] * inner(wheel.w, normal) for wheel in self.slips]

    @cached_property
    def trace_terms(self) -> list[list[Number]]:
        """The symmetric matrix of the quadratic ``-tr A det H`` in the loads."""
        zero = self.slips[0].bend.field.zero
        matrix = [[zero] * len(self.slips) for _ in self.slips]
        for i, j in combinations(range(len(self.slips)), 2):
            first, second = self.slips[i], self.slips[j]
            q = cross_product(first.w, second.w)
            spread = q[0] * inner(q, self.slope[0]) + q[1] * inner(q, self.slope[1])
            matrix[i][j] = matrix[j][i] = first.bend * second.bend * spread / 2
        return matrix

    def is_hurwitz_for_all(self) -> bool:
        """Whether A is Hurwitz under every load of the set; False also where that is not shown."""
        prices = self.determinant_prices
        if self.soft_load is not None or priced(prices, self.loads.bound.lowest(prices)).sign() <= 0:
            return False
        return is_positive_on_set(self.trace_terms, self.loads.bound)

    def throws_out(self, loads: Loads) -> bool:
        """Whether A has an eigenvalue with a positive real part under one load."""
        if not self.is_definite(loads):
            return False
        return priced(self.determinant_prices, loads).sign() < 0 or _form(self.trace_terms, loads, loads).sign() < 0

    def throwing_load(self) -> Loads | None:
        """A load that throws the body out and under which every wheel carries; None where none is found."""
        return next((load for load in self._suspects() if self.throws_out(load)), None)

    def _suspects(self) -> Iterator[Loads]:
        """The middle of the set, and loads between it and the corners, the least determinant first."""
        reached = self.loads.reached
        middle = reached.middle
        yield middle
        for corner in (reached.lowest(self.determinant_prices), *(reached.corners or ())[:MOST_CORNERS]):
            for share in SHARES:
                yield mixed(corner, middle, share)


def is_positive_on_set(matrix: Sequence[Sequence[Number]], loads: LoadPolytope) -> bool:
    """Whether a quadratic form is shown to be positive at every load of a set."""
    match loads:
        case AdmissibleLoads():
            if len(loads.vertices) > MOST_CORNERS:
                return False
            gram = [[_form(matrix, v, w) for w in loads.vertices] for v in loads.vertices]
            return is_positive_on_hull(gram)
        case SpringLoads():
            # N = centre + sum of s_k g_k, |s_k| <= 1, term by term
            reach = loads.centre[0].field.zero
            for k, g in enumerate(loads.generators):
                reach += 2 * abs(_form(matrix, loads.centre, g))
                reach += sum((abs(_form(matrix, g, other)) for other in loads.generators[k + 1 :]), reach * 0) * 2
                reach += abs(_form(matrix, g, g))
            return (_form(matrix, loads.centre, loads.centre) - reach).sign() > 0
        case _:
            return False


def _form(matrix: Sequence[Sequence[Number]], v: Loads, w: Loads) -> Number:
    """``v . M w``."""
    zero = v[0].field.zero
    return sum((a * priced(row, w) for a, row in zip(v, matrix, strict=True) if a), zero)


# ---- quadratic forms on a hull -------------------------------------------------------------------


MOST_PARTS = 400  # simplices that are looked at

Gram = Sequence[Sequence[Number]]


def is_positive_on_hull(gram: Gram) -> bool:
    """Whether ``sum l_v l_w gram[v][w] > 0`` is shown for all weights ``l >= 0`` that are not all zero.

    It is so where the diagonal is positive and no entry negative.  Otherwise the edge of the most negative entry is
    halved, which gives two simplices with the middle of the edge in place of one of its ends.
    """
    waiting, parts = [gram], 0
    while waiting:
        part = waiting.pop()
        parts += 1
        if parts > MOST_PARTS or any(row[k].sign() <= 0 for k, row in enumerate(part)):
            return False
        edges = [(part[v][w], v, w) for v in range(len(part)) for w in range(v)]
        worst = min(edges, key=lambda edge: edge[0], default=None)
        if worst is not None and worst[0].sign() < 0:
            waiting += [_halved(part, worst[1], worst[2]), _halved(part, worst[2], worst[1])]
    return True


def _halved(gram: Gram, replaced: int, kept: int) -> Gram:
    """The form in the corners of which one is replaced by its middle with another."""
    count = len(gram)
    middle = [(gram[replaced][k] + gram[kept][k]) / 2 for k in range(count)]
    middle[replaced] = (gram[replaced][replaced] + 2 * gram[replaced][kept] + gram[kept][kept]) / 4
    rows = [list(row) for row in gram]
    for k in range(count):
        rows[k][replaced] = rows[replaced][k] = middle[k]
    return rows


# ---- the verdict under every load ----------------------------------------------------------------


INWARD = (
    "the friction of every wheel points to the middle at the motion about the point, so c . v < 0 under every load, "
    "also one that changes with time"
)
HURWITZ = "c' = A c to first order, and A is Hurwitz for every load of the set: for loads that depend on the pose alone"
LEMMA = "c . v <= 0 under every load, by the lemma on inward rims on one circle"


@dataclass(frozen=True)
class EveryLoadTranslation(WithoutCells):
    """Clause 2 with its evidence.

    Attributes:
        point: the situation at the point.
        verdict: strong stability of (x, y): under every load, and of every solution.
        reason: one sentence for people.
        lemma: certificate of ``V* <= 0`` on the whole square, where the array meets its hypotheses.
        load: a load that throws the body out (unstable).
        region_radius: of a disc in which ``|c|`` does not grow, whatever the load.
        comes_home: whether every body of that disc comes home.
        exponential_rate: a rate at which the distance decays close by, at least.
    """

    point: EveryLoadPoint
    verdict: Translation
    reason: str
    lemma: CocircularArray | None = None
    load: Loads | None = None
    region_radius: Number | None = None
    comes_home: bool = False
    exponential_rate: Number | None = None

    @property
    def worst_rate(self) -> Number | None:
        """Supremum of ``V*/|c|`` over the square: zero where V never grows."""
        return self.point.scene.field.zero if self.lemma is not None or self.comes_home else None

    @property
    def home_radius(self) -> Number | None:
        """Radius of a disc of starts from which every body comes home."""
        return self.region_radius if self.comes_home else None

    @property
    def sampled(self) -> None:
        """Nothing is sampled."""


def decide_for_every_load(point: EveryLoadPoint, lemma: CocircularArray | None) -> EveryLoadTranslation:
    """Decide the clause from the situation at the point."""
    radius = None if lemma is None else point.scene.check.radius
    if point.equilibrium is not Equilibrium.HOLDS or point.twist is None:
        return EveryLoadTranslation(point, Translation.UNDECIDED, point.reason, lemma)
    if point.situation in (EveryLoad.CARRIED, EveryLoad.UNIQUE):
        reason = f"{point.situation}: {point.reason}"
        return EveryLoadTranslation(point, Translation.STABLE, reason, lemma, region_radius=radius)
    if point.situation is EveryLoad.SMOOTH:
        return _smooth(point, lemma)
    if lemma is not None:
        return EveryLoadTranslation(point, Translation.STABLE, LEMMA, lemma, region_radius=radius)
    return EveryLoadTranslation(point, Translation.UNDECIDED, point.reason)


def _smooth(point: EveryLoadPoint, lemma: CocircularArray | None) -> EveryLoadTranslation:
    """By forces to the middle, else by the linearization about rest."""
    slips = None if point.twist is None else wheel_slips(point.scene, point.twist.omega)
    if slips is None or point.slope is None:
        return EveryLoadTranslation(point, Translation.UNDECIDED, point.reason, lemma)
    beta = inward_pull(point.slope)
    if beta is not None and all(wheel.bend for wheel in slips):
        radius = point.scene.check.radius if _are_outside(slips, point.scene.check.radius) else None
        rate = beta / (2 * max(wheel.bend * _squared_reach(wheel) for wheel in slips))
        return EveryLoadTranslation(
            point,
            Translation.ASYMPTOTICALLY_STABLE,
            INWARD,
            lemma,
            region_radius=radius,
            comes_home=True,
            exponential_rate=rate,
        )
    return _by_linearization(point, lemma)


def _are_outside(slips: tuple[Slip[Number], ...], radius: Number) -> bool:
    """Whether no wheel lies in the disc: under a wheel that carries alone the twist is not determined."""
    return all((dot(wheel.position, wheel.position) - radius * radius).sign() > 0 for wheel in slips)


def _squared_reach(slip: Slip[Number]) -> Number:
    """``|w|^2`` of its first two entries."""
    return dot(slip.w, slip.w)


def _decay(point: EveryLoadPoint) -> DecayUnderLoads | None:
    """The linearization about rest; None where the point spins or is not smooth."""
    if point.twist is None or point.slope is None or point.twist.omega:
        return None
    slips = wheel_slips(point.scene, point.twist.omega)
    return None if slips is None else DecayUnderLoads(slips, point.slope, point.loads)


def _by_linearization(point: EveryLoadPoint, lemma: CocircularArray | None) -> EveryLoadTranslation:
    decay = _decay(point)
    if decay is None:
        reason = "the body spins at the point, and its friction does not point to the middle there"
        return EveryLoadTranslation(point, Translation.UNDECIDED, reason, lemma)
    if decay.is_hurwitz_for_all():
        return EveryLoadTranslation(point, Translation.ASYMPTOTICALLY_STABLE, HURWITZ, lemma)
    load = decay.throwing_load()
    if load is not None and is_admissible(point.scene, load):
        reason = f"under the load {load_text(load)} the linearization has an eigenvalue with a positive real part"
        return EveryLoadTranslation(point, Translation.UNSTABLE, reason, lemma, load)
    return EveryLoadTranslation(point, Translation.UNDECIDED, _why_open(decay), lemma)


def _why_open(decay: DecayUnderLoads) -> str:
    if decay.soft_load is not None:
        return f"under the load {load_text(decay.soft_load)} the Hessian of D is singular at the point"
    return "bounds of trace and determinant over all loads do not show that the linearization is Hurwitz"


def decays_everywhere(translation: EveryLoadTranslation) -> bool:
    """Whether the twist is of the order of the distance under every load, so that it adds up to little on the way."""
    decay = _decay(translation.point)
    return translation.verdict is Translation.ASYMPTOTICALLY_STABLE and decay is not None and decay.soft_load is None


def soft_load_of(translation: EveryLoadTranslation) -> Loads | None:
    """A load under which the motion near the point is not determined to first order."""
    decay = _decay(translation.point)
    return None if decay is None else decay.soft_load
