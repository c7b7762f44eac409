"""Strong stability of the checked point of a plain system in three states and more.

1. ``0`` must be in F at the point; otherwise every solution leaves it.
2. A velocity that leads from the point into a cell, and the linearization, where there is one
   (:mod:`nonsmooth.proofs.many_states.first_terms`); a relay of relative degree three or more
   (:mod:`nonsmooth.proofs.many_states.relay_degree`).
3. The V that the scene names, on the checked cube (:mod:`nonsmooth.proofs.many_states.examination`).
4. A V that is searched (:mod:`nonsmooth.proofs.many_states.lyapunov_search`); for a linearization whose eigenvalues all
   have negative real parts its own quadratic form on smaller cubes, if nothing else is proved.
5. A V that shows instability (:mod:`nonsmooth.proofs.many_states.lyapunov_search`).
6. An energy that is searched (:mod:`nonsmooth.proofs.many_states.weak_functions`).  By a V that does not increase the
   point attracts where nothing else stays where V does not fall (:mod:`nonsmooth.proofs.kernel.second_function`);
   otherwise it is ``stable``, and whether it attracts is left open.
7. What the kernel finds beside (:mod:`nonsmooth.proofs.kernel_strategies`).

Rays, fans and leading terms are used for two states only.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from functools import cached_property

from nonsmooth.proofs.findings.verdicts import Equilibrium, Translation
from nonsmooth.proofs.inequalities.linear_program import best_mixture, mixtures_to_zero
from nonsmooth.proofs.kernel.cells import BeyondReachError, SignCells, adjoining, build_cells
from nonsmooth.proofs.kernel.denominators import require_denominators
from nonsmooth.proofs.many_states.examination import ExaminedLyapunov, examine
from nonsmooth.proofs.many_states.first_terms import (
    LinearPart,
    Spectrum,
    escaping_rate,
    escaping_velocity,
    linear_part,
    quadratic_text,
    unstable_mixture,
)
from nonsmooth.proofs.many_states.lyapunov_search import SCALES, find_growth, find_lyapunov
from nonsmooth.proofs.many_states.relay_degree import high_degree_relay
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.proofs.systems.findings import (
    KEPT,
    NOT_ATTRACTING,
    CheckedPoint,
    Finding,
    Known,
    Method,
    Reach,
    weak_finding,
)
from nonsmooth.proofs.systems.invariance import Staying
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.systems.enclosed_numbers import NoEnclosureError, enclose_numbers
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

SHOWN_BY_SPECTRUM = {
    Spectrum.UNSTABLE: Translation.UNSTABLE,
    Spectrum.GROWING: Translation.UNSTABLE,
    Spectrum.HURWITZ: Translation.ASYMPTOTICALLY_STABLE,
    Spectrum.NEUTRAL: Translation.STABLE,
}


class SpacePoint(CheckedPoint):
    """The checked point of a system in three states and more.

    Irrational numbers are enclosed between rational ones: what is found speaks of that system, and so of the stated
    one.
    """

    given: ExaminedLyapunov | None = None

    def __init__(self, system: SwitchedSystem) -> None:
        """Refuse denominators that may vanish.

        Raises:
            SceneError: for these.
        """
        require_denominators(system)
        with suppress(NoEnclosureError):
            system = enclose_numbers(system)
        self.system = system

    @cached_property
    def cells(self) -> SignCells:
        """The cells of the first cube that is looked at.

        Raises:
            BeyondReachError: where none is.
        """
        return first_cells(self.system)

    @cached_property
    def linear(self) -> LinearPart | None:
        """The linearization, or an unstable one under arbitrary switching."""
        return linear_part(self.cells) or unstable_mixture(self.system, self.cells)

    @property
    def spectrum(self) -> Spectrum | None:
        """What is known of the eigenvalues of the linearization."""
        return None if self.linear is None else self.linear.spectrum

    @cached_property
    def equilibrium(self) -> Equilibrium:
        """Whether 0 is in F."""
        try:
            return decide_equilibrium(self.system, self.cells)
        except BeyondReachError:
            return Equilibrium.UNDECIDED

    @property
    def open_reason(self) -> str:
        """What is said where nothing decides."""
        try:
            self.cells  # noqa: B018 - whether the system is looked at
        except BeyondReachError as error:
            return str(error)
        return "no Lyapunov function was found, and none that shows instability"

    def examine(self, formula: PiecewiseExpression, radius: Number, effort: Effort) -> ExaminedLyapunov | None:
        """A V with its conditions; None where it is not looked at."""
        try:
            return examine(self.system, formula, radius, effort=effort)
        except BeyondReachError:
            return None

    def reach(self, found: Finding) -> Reach:
        """Whether every start of the space reaches the point."""
        if found.verdict is not Translation.ASYMPTOTICALLY_STABLE:
            return Reach()
        try:
            linear = self.linear is not None and self.linear.is_whole
        except BeyondReachError:  # states that were decided by themselves
            linear = False
        return Reach(linear or (found.function is not None and found.function.is_homogeneous))


def first_cells(scene: SwitchedSystem) -> SignCells:
    """The cells of the checked cube, or of the first smaller one that is looked at.

    Raises:
        BeyondReachError: where none is, with what is said of the checked cube.
    """
    reasons = []
    for scale in SCALES:
        try:
            return build_cells(scene, scene.check.radius * scale)
        except BeyondReachError as error:
            reasons.append(error)
    raise reasons[0]


def decide_equilibrium(scene: SwitchedSystem, cells: SignCells) -> Equilibrium:
    """Whether 0 is a mixture of the velocities at the point.

    Beside curved surfaces a pattern of signs may have no cell: then a mixture may be none of F, and nothing is claimed.
    Nor is it where numbers are enclosed, unless all velocities vanish.
    """
    zero = (0,) * len(cells.states)
    near = adjoining(cells)
    velocities = {tuple(scene.field(p.get(zero, 0)) for p in field) for cell in near for field in cell.velocities}
    columns, target = mixtures_to_zero(sorted(velocities, key=str))
    if best_mixture(columns, target, [scene.field.zero] * len(columns)) is None:
        return Equilibrium.FAILS
    at_rest = not any(map(any, velocities))
    certain = at_rest or (all(surface.degree == 1 for surface in cells.surfaces) and not scene.encloses_numbers)
    return Equilibrium.HOLDS if certain else Equilibrium.UNDECIDED


# ---- what shows itself near the point --------------------------------------------------------------


def decide_no_equilibrium(point: SpacePoint, known: Known) -> Finding | None:
    """No mixture of the velocities at the point is zero."""
    if point.equilibrium is not Equilibrium.FAILS:
        return None
    return Finding(Method.EQUILIBRIUM, Translation.UNSTABLE, "0 is not in F there, so every solution leaves it")


def decide_by_escape(point: SpacePoint, known: Known) -> Finding | None:
    """A velocity at the point that leads into its cell, or a ray along which solutions leave."""
    velocity = escaping_velocity(point.system, point.cells)
    if velocity is not None:
        place = ", ".join(map(str, velocity))
        reason = f"a solution leaves the point with velocity ({place}), into a cell"
        return Finding(Method.ESCAPE, Translation.UNSTABLE, reason, proofs=velocity)
    rate = escaping_rate(point.system, point.cells) if point.linear is None else None
    if rate is None:
        return None
    reason = "solutions leave along a ray inside a cone with a linear field"
    return Finding(Method.ESCAPE, Translation.UNSTABLE, reason, proofs=rate)


def decide_by_relay(point: SpacePoint, known: Known) -> Finding | None:
    """A switching surface that shows instability by its relative degree."""
    relay = high_degree_relay(point.system, point.cells)
    if relay is None:
        return None
    order = f"derivative {relay.degree} of the switching function is the first that depends on its sign"
    reason = f"{order}, and a function of the others never falls"
    return Finding(Method.RELAY, Translation.UNSTABLE, reason, proofs=relay)


def decide_by_linearization(point: SpacePoint, known: Known) -> Finding | None:
    """The eigenvalues of the linearization; a V may show more of a point that is stable."""
    spectrum = point.spectrum
    verdict = None if spectrum is None else SHOWN_BY_SPECTRUM.get(spectrum)
    if verdict is None:
        return None
    refutes = str(spectrum) if verdict is Translation.STABLE else ""
    reason = f"{NOT_ATTRACTING}{refutes}" if refutes else str(spectrum)
    final = verdict is Translation.UNSTABLE
    return Finding(Method.LINEARIZATION, verdict, reason, proofs=point.linear, refutes=refutes, is_final=final)


# ---- functions -------------------------------------------------------------------------------------


def decide_by_stated_function(point: SpacePoint, known: Known) -> Finding | None:
    """The V of the scene; the sum of squares that nobody named is asked with little work."""
    return _by_stated_function(point, known, Effort.HASTY if point.system.check.is_default else Effort.FULL)


def search_function(point: SpacePoint, known: Known) -> Finding | None:
    """A V that falls, unless that is known to be impossible."""
    if known.attraction_is_refuted:
        return None
    function = find_lyapunov(point.system) or _quadratic(point)
    return None if function is None else conclude_function(known, function)


def decide_by_sum_of_squares(point: SpacePoint, known: Known) -> Finding | None:
    """The sum of squares that nobody named with all work, where nothing else is found."""
    spectrum, shown = point.spectrum, known.function is not None
    if not point.system.check.is_default or spectrum is Spectrum.HURWITZ or (spectrum is Spectrum.NEUTRAL and shown):
        return None
    hasty = point.given
    found = _by_stated_function(point, known, Effort.FULL)
    if found is None or found.is_final or known.function is None:
        return found
    point.given = hasty  # which shows the same
    return None


def _by_stated_function(point: SpacePoint, known: Known, effort: Effort) -> Finding | None:
    check = point.system.check
    point.given = point.examine(check.lyapunov, check.radius, effort) or point.given
    return None if point.given is None else conclude_function(known, point.given)


def _quadratic(point: SpacePoint) -> ExaminedLyapunov | None:
    """The quadratic form of a linearization whose eigenvalues all have negative real parts, on a smaller cube."""
    quadratic = None if point.linear is None else point.linear.quadratic
    if quadratic is None:
        return None
    formula = parse_piecewise(quadratic_text(quadratic, point.system.states), point.system.states)
    for scale in SCALES:
        examined = point.examine(formula, point.system.check.radius * scale, Effort.STRICT)
        if examined is not None and examined.decrease is Decrease.STRICT:
            return examined
    return None


def conclude_function(known: Known, function: ExaminedLyapunov) -> Finding | None:
    """What a V shows beside what is known; None where its conditions are not shown."""
    standing = known.standing
    if function.decrease is Decrease.STRICT:
        return Finding(Method.LYAPUNOV, Translation.ASYMPTOTICALLY_STABLE, function.reason, function)
    if function.decrease is not Decrease.WEAK:
        return None
    if standing is not None and not standing.is_weak:
        return replace(standing, function=function)
    return weak_finding(function, KEPT if function.is_kept else "")


def search_growth(point: SpacePoint, known: Known) -> Finding | None:
    """A V that shows instability, unless the point is known to be stable."""
    growth = find_growth(point.system) if known.standing is None else None
    if growth is None:
        return None
    facts, entry = growth.facts(point.system.states), growth.entry
    return Finding(Method.INSTABILITY, Translation.UNSTABLE, growth.reason, proofs=growth, entry=entry, facts=facts)


def decide_by_invariance(point: SpacePoint, known: Known) -> Finding | None:
    """Whether solutions leave where the V that shows stability does not fall."""
    function = known.function
    entry = function.attraction(point.system) if known.attraction_is_open and function is not None else None
    if entry is None:
        return None
    reason = f"{function.reason}, and {Staying.NONE}"
    return Finding(Method.INVARIANCE, Translation.ASYMPTOTICALLY_STABLE, reason, function, entry=entry)
