"""Strategies of the kernel: linear systems, and points that the theory of their number of states leaves open.

In two states the theory of the plane is asked first (:mod:`nonsmooth.proofs.systems.system_stability`).  What it leaves
open is often smooth and degenerate: ``x' = -x + y^2, y' = -y^3`` has ``V = x^2 + y^2``, whose derivative
``-2 (x^2 - x y^2 + y^4)`` no subdivision shows to be negative beside the point, where a sum of squares does.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import chain, islice
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.switched_cells import lyapunov_cells
from nonsmooth.proofs.findings import Fact, Record, Translation, function_facts, row_fact
from nonsmooth.proofs.inequalities.subdivision import shared_effort
from nonsmooth.proofs.kernel.bases import quadratic_text
from nonsmooth.proofs.kernel.kept_energies import find_by_next_terms
from nonsmooth.proofs.kernel.quotients import find_quotient, quotient_text, signed_roots_of
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.proofs.systems.derivatives import EFFORT, Decrease, LyapunovResult, examine
from nonsmooth.proofs.systems.domain import SHRINKING, Domain, cube_text
from nonsmooth.proofs.systems.findings import (
    KEPT,
    NOT_ATTRACTING,
    CheckedPoint,
    ExaminedFunction,
    Finding,
    Method,
    PlaneFunction,
    falling_finding,
    weak_finding,
)
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, no_sign, parse_piecewise
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.plane_arrays import Floats, are_finite
from nonsmooth.symbolic.numbers.polynomial import BEYOND_FLOATS, float_slopes
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem, with_known_numbers

if TYPE_CHECKING:
    from nonsmooth.proofs.many_states.decision import SpacePoint
    from nonsmooth.proofs.many_states.examination import ExaminedLyapunov
    from nonsmooth.proofs.systems.system_stability import PlanePoint


def decide_by_center_manifold(point: CheckedPoint) -> Finding | None:
    """A V that the reduced field on the centre manifold suggests."""
    from nonsmooth.proofs.many_states.center_manifold import show_by_center_manifold

    shown = show_by_center_manifold(with_known_numbers(point.system))
    if shown is None:
        return None
    proposal, evidence = shown
    if not isinstance(evidence, dict):
        reason, function = f"{proposal.words}; {evidence.reason}", _of_point(point, evidence)
        return Finding(Method.CENTER, Translation.ASYMPTOTICALLY_STABLE, reason, function, proofs=proposal)
    verdict = Translation.UNSTABLE
    reason = f"{proposal.words}; where V is negative, at points at all distances, it falls"
    if proposal.attracts:
        verdict = Translation.ASYMPTOTICALLY_STABLE
        reason = f"{proposal.words}; V is positive and decreases everywhere but at the equilibrium"
    facts = entry_facts(point.system, evidence)
    return Finding(Method.CENTER, verdict, reason, proofs=proposal, entry=evidence, facts=facts)


def decide_beside_stable_subspace(point: CheckedPoint) -> Finding | None:
    """The same in two states, before long searches.

    A focus is left to these: a positive V that grows shows that all solutions leave, which says more.
    """
    finding = decide_by_center_manifold(point)
    return None if finding is None or finding.proofs.is_whole else finding


@shared_effort(EFFORT)
def search_attraction(point: PlanePoint) -> Finding | None:
    """By a V that does not increase, where nothing else decides whether solutions attract.

    The scene's is asked on the checked square and on the smaller one, then one is searched.
    """
    from nonsmooth.proofs.systems.system_stability import attraction_by, conclude_function

    given, radius = point.known.function, point.system.check.radius
    if given is not None and point.rays:
        return None
    if given is not None:
        shown = attraction_by(point, given)
        if shown is None and given.domain.radius == radius:
            shown = attraction_by(point, point.given_on(Domain(radius * SHRINKING)))
        if shown is not None:
            return shown
    function = find_weak_function(point, may_attract=not point.rays)
    if function is None:
        return None
    shown = None if point.rays else attraction_by(point, function)
    return shown or (conclude_function(point, function) if given is None else None)


MOST_AUDITS = 32  # of proposals in one search


def find_weak_function(point: PlanePoint, *, may_attract: bool = True) -> PlaneFunction | None:
    """A V that does not increase: one that shows attraction by LaSalle's principle, else the first; None without one.

    Args:
        point: of a system in two states.
        may_attract: whether the equilibrium may attract; otherwise the first V serves.
    """
    from nonsmooth.proofs.many_states.weak_functions import energies_near
    from nonsmooth.proofs.systems.lyapunov_search import MAX_CELLS, audited_weakly, square_cells

    system, first = point.system, None
    for formula, radius in islice(energies_near(with_known_numbers(system)), MOST_AUDITS):
        cells = square_cells(system, radius)
        result = audited_weakly(system, cells, formula) if len(cells) <= MAX_CELLS else None
        if result is None:
            continue
        function = PlaneFunction(result, Domain(radius), formula, system.states)
        if not may_attract or point.attraction(function) is not None:
            return function
        first = first or function
    return first


def decide_by_squares(point: CheckedPoint) -> Finding | None:
    """The V of the scene and one that is searched, in two states, where sums of squares show that it falls."""
    from nonsmooth.proofs.many_states.decision import SpacePoint
    from nonsmooth.proofs.many_states.lyapunov_search import find_lyapunov

    space = SpacePoint(point.system)
    stated = space.examine(point.system.check.lyapunov, point.system.check.radius, Effort.STRICT)
    for function in (stated, find_lyapunov(space.system)):
        if function is not None and function.decrease is Decrease.STRICT:
            return falling_finding(_of_point(point, function))
    return None


def decide_by_quotient(point: CheckedPoint) -> Finding | None:
    """A quotient of forms."""
    return _by_quotient(point, stated=False)


def decide_by_stated_quotient(point: CheckedPoint) -> Finding | None:
    """The quotient of polynomials that the scene names."""
    return _by_quotient(point, stated=True)


def _by_quotient(point: CheckedPoint, *, stated: bool) -> Finding | None:
    entry = find_quotient(with_known_numbers(point.system), stated=stated)
    return _of_entry(point, entry and entry[0])


def decide_by_kept_energy(point: CheckedPoint) -> Finding | None:
    """An energy that the first terms of the field keep, with further terms that decide.

    Where its conditions are shown again by what regions and rates need, these follow from it.
    """
    from nonsmooth.proofs.many_states.decision import SpacePoint

    space = SpacePoint(point.system)
    entry = find_by_next_terms(space.system)
    if entry is not None and entry[0]["theorem"] != "instability":
        hypotheses = entry[0]["hypotheses"]
        formula, within = parse_piecewise(hypotheses["function"], point.system.states), hypotheses["cells"]["within"]
        examined = space.examine(formula, point.system.field(Fraction(within)), Effort.STRICT)
        if examined is not None and examined.decrease is Decrease.STRICT:
            return falling_finding(_of_point(point, examined))
    return _of_entry(point, entry and entry[0])


def decide_uncovered_by_roots(point: CheckedPoint) -> Finding | None:
    """A V about roots of the states, where not every solution crosses the zeros of those in the formulas."""
    return None if point.system.by_roots is None or point.is_covered else decide_by_roots(point)


def decide_by_roots(point: CheckedPoint) -> Finding | None:
    """A V about roots of the states of which all have one weight, in the time of the states."""
    from nonsmooth.proofs.kernel.rooted_functions import find_function_of_states

    entry = find_function_of_states(with_known_numbers(point.system))
    return _of_entry(point, entry and entry[0])


def _of_entry(point: CheckedPoint, entry: Record | None, *, directed: bool = False) -> Finding | None:
    """What a V shows with its evidence: that the point attracts, or is unstable; see :func:`entry_facts`."""
    if entry is None:
        return None
    facts = entry_facts(point.system, entry, directed=directed)
    if entry["theorem"] != "instability":
        in_time = ", in the time of the states" if "roots" in entry["hypotheses"] else ""
        reason = f"V is positive and falls along every solution{in_time}"
        return Finding(Method.LYAPUNOV, Translation.ASYMPTOTICALLY_STABLE, reason, entry=entry, facts=facts)
    reason = "V falls along every solution, from negative values at all distances"
    if "speed" in entry["hypotheses"]:
        reason = "where V is negative, at points at all distances, it falls along every solution"
    elif entry["hypotheses"]["second"] is not None:
        reason = "V does not rise, is negative at points at all distances, and nothing stays where it is kept"
    return Finding(Method.INSTABILITY, Translation.UNSTABLE, reason, entry=entry, facts=facts)


def decide_by_energy(point: SpacePoint) -> Finding | None:
    """A positive V that does not rise."""
    from nonsmooth.proofs.many_states.decision import conclude_function
    from nonsmooth.proofs.many_states.weak_functions import find_weak_lyapunov

    function = find_weak_lyapunov(point.system)
    return None if function is None else conclude_function(point, function)


def decide_rest_beside(point: SpacePoint) -> Finding | None:
    """Of a stable point, that it does not attract, as others of rest lie at all distances."""
    from nonsmooth.proofs.many_states.rest_beside import ray_of_rest

    standing = point.known.standing
    ray = ray_of_rest(point.system) if standing is not None and standing.is_weak else None
    if standing is None or ray is None:
        return None
    through = ", ".join(map(str, ray))
    refutes = f"every point of the ray through ({through}) near the equilibrium is an equilibrium"
    return weak_finding(standing.function, refutes)


def decide_beside_curve_of_rest(point: CheckedPoint) -> Finding | None:
    """Whether a curve of equilibria passes through the point, to which everything beside it falls back.

    A positive V that does not increase is found with it, unless one is known.
    """
    system, standing = with_known_numbers(point.system), point.known.standing
    if system.only_encloses:
        return None
    from nonsmooth.proofs.many_states.rest_beside import beside_curve_of_rest

    curve = beside_curve_of_rest(system, with_function=standing is None)
    if curve is None:
        return None
    refutes = f"every point of the curve {curve.words} near the equilibrium is an equilibrium"
    if curve.entry is not None:
        reason = f"V is positive and does not increase; {NOT_ATTRACTING}{refutes}"
        entry, facts = curve.entry, entry_facts(system, curve.entry)
        return Finding(Method.LYAPUNOV, Translation.STABLE, reason, entry=entry, facts=facts, refutes=refutes)
    function = _of_point(point, curve.function) if curve.function is not None else point.known.function
    return weak_finding(function, refutes)


def decide_by_first_integrals(point: SpacePoint) -> Finding | None:
    """A positive polynomial that solutions keep, or a form of one weight with absolute values."""
    from nonsmooth.proofs.many_states.decision import conclude_function
    from nonsmooth.proofs.many_states.weak_functions import find_kept_form, find_kept_function

    system = with_known_numbers(point.system)
    function = find_kept_function(system) or find_kept_form(system)
    return None if function is None else conclude_function(point, function)


def decide_by_growth(point: CheckedPoint) -> Finding | None:
    """A V that falls, or falls where it is negative, and is negative near the point."""
    from nonsmooth.proofs.many_states.lyapunov_search import find_growing_product, find_growth

    system = with_known_numbers(point.system)
    return _of_entry(point, find_growth(system) or find_growing_product(system), directed=True)


def decide_by_large_growth(point: CheckedPoint) -> Finding | None:
    """The same in large programs, after all that takes less time."""
    from nonsmooth.proofs.many_states.lyapunov_search import LARGE, find_growth

    return _of_entry(point, find_growth(point.system, LARGE), directed=True)


def decide_by_solution(point: CheckedPoint) -> Finding | None:
    """One solution that leaves, of a mixture of right-hand sides inside a cell or along a face."""
    system = with_known_numbers(point.system)
    if system.only_encloses:  # a solution of an enclosure may be none of the system
        return None
    from nonsmooth.proofs.kernel.escapes import show_escape_of

    entry, _ = show_escape_of(system, str(Translation.UNSTABLE))
    direction = ", ".join(entry["hypotheses"]["direction"])
    reason = f"from as near the point as one likes a solution leaves, at first along ({direction})"
    return Finding(Method.ESCAPE, Translation.UNSTABLE, reason, entry=entry)


def decide_by_choice(point: CheckedPoint) -> Finding | None:
    """A switching law among several right-hand sides under which the point is unstable."""
    system = with_known_numbers(point.system)
    if system.only_encloses or not system.others:
        return None
    from nonsmooth.proofs.theorem_searches import choice_words, show_choice_of

    entry, _ = show_choice_of(system)
    reason = "under one of the fields that may act, or one on each side of a surface, the point is unstable"
    facts = (row_fact("choice", choice_words(entry["hypotheses"]["choice"])),)
    return Finding(Method.CHOICE, Translation.UNSTABLE, reason, entry=entry, facts=facts)


def decide_by_symmetry(point: CheckedPoint) -> Finding:
    """A reflection that reverses time, where all solutions turn about the point."""
    from nonsmooth.proofs.kernel.centres import reflection_text, show_reversible_of

    entry, _ = show_reversible_of(point.system)
    image = reflection_text(entry["hypotheses"]["mirror"], point.system.states)
    return _closed_orbits(point, Method.SYMMETRY, entry, f"the reflection to {image} reverses them")


def decide_enclosed_centre(point: CheckedPoint) -> Finding | None:
    """The same before long searches, of a system with sines, of which an energy on circles says more.

    Around closed orbits no V falls, and none of polynomials is kept by all fields between which sines lie.
    """
    centre = decide_by_symmetry(point) if point.system.rewriting.waves else None
    return None if centre is None else decide_by_circles(point) or centre


def decide_by_integral(point: CheckedPoint) -> Finding:
    """An integral of motion that an integrating factor defines, where all solutions turn about the point."""
    from nonsmooth.proofs.kernel.centres import factor_text, show_integral_of

    entry, _ = show_integral_of(point.system)
    factor = row_fact("integrating factor", factor_text(entry["hypotheses"]))
    return _closed_orbits(point, Method.INTEGRAL, entry, "an integral of motion is kept", factor)


def _closed_orbits(point: CheckedPoint, method: Method, entry: Record, why: str, *more: Fact) -> Finding:
    """That the point is stable and does not attract."""
    refutes = f"orbits near it are closed, as they turn, and {why}"
    within = point.system.field(Fraction(entry["hypotheses"]["cells"]["within"]))
    facts = (*more, row_fact("on", cube_text(within, point.system.states)))
    reason = f"{NOT_ATTRACTING}{refutes}"
    return Finding(method, Translation.STABLE, reason, entry=entry, facts=facts, refutes=refutes)


def decide_by_turned_energy(point: CheckedPoint) -> Finding | None:
    """A V that does not rise and is negative near the point, with further functions."""
    from nonsmooth.proofs.many_states.weak_functions import find_weak_growth

    entry = find_weak_growth(with_known_numbers(point.system))
    return _of_entry(point, entry and entry[0], directed=True)


def decide_by_circles(point: CheckedPoint) -> Finding | None:
    """An energy with sines and cosines that does not rise, which enclosures of these cannot show."""
    from nonsmooth.proofs.many_states.weak_functions import find_energy_on_circles

    energy = find_energy_on_circles(point.system)
    if energy is None:
        return None
    entry, function, domain, is_kept = energy
    reason = f"V = {function} is positive and does not rise"
    refutes = KEPT if is_kept else ""
    reason += f"; {NOT_ATTRACTING}{refutes}" if refutes else ""
    facts = (row_fact("on", domain),)
    return Finding(Method.CIRCLES, Translation.STABLE, reason, entry=entry, facts=facts, refutes=refutes)


def entry_facts(system: SwitchedSystem, entry: Record, *, directed: bool = False) -> tuple[Fact, Fact]:
    """V of a theorem, and where its claims hold.

    Args:
        system: for the names of its states.
        entry: of a certificate.
        directed: whether it is also said in which direction V is negative.
    """
    from nonsmooth.proofs.many_states.center_manifold import coordinates_in

    hypotheses, where = entry["hypotheses"], "the whole space"
    cells, roots = hypotheses["cells"], signed_roots_of(hypotheses, system.stated_states)
    names = coordinates_in(cells, system.states) if roots is None else roots.seen_states
    if roots is not None:
        box = ", ".join(f"abs({name}) <= {width}" for name, width in zip(names, cells["within"], strict=True))
        where = f"{box}, in the time of the states, with {' and '.join(roots.meanings)}"
    elif cells["within"] is not None:
        where = cube_text(system.field(Fraction(cells["within"])), names)
    if directed:
        where += f"; V < 0 in the direction ({', '.join(hypotheses['direction'])})"
    return function_facts(quotient_text(hypotheses), where)


def _of_point(point: CheckedPoint, function: ExaminedLyapunov) -> ExaminedFunction:
    """A V with its conditions as results in two states hold it: with its polynomials on the cells of the square."""
    if not point.system.is_planar:
        return function
    from nonsmooth.proofs.systems.lyapunov_search import searched_cells

    cells = searched_cells(point.system, function.formula, function.radius)
    shown = LyapunovResult(cells, (), (), function.decrease, None, function.reason)
    return PlaneFunction(shown, Domain(function.radius), function.formula, point.system.states)


# ---- linear systems that attract -----------------------------------------------------------------
#
# A quadratic V with short coefficients, which falls nearly as fast as solutions do.
#
# Let all eigenvalues of A have real parts of at most -s, s > 0, one of them -s.  Of ``x' = A x`` no V has
# ``V' <= -kappa V`` with ``kappa > 2 s``, and for each ``mu`` in ``[0, s)`` one P with
#
#     (A + mu I)^T P + P (A + mu I) = -I
#
# is positive, so that ``V = x^T P x`` has ``V' = -2 mu V - |x|^2`` (Lyapunov).  P is solved in floats for some mu.
# Whole numbers near its multiples are proposed, the sum of squares before all: the smallest that keep nine tenths of
# the rate 2 s, or else three quarters, and so on; long ones where no short ones do.  The exact audit decides.


SHARES = (0.97, 0.85, 0.6, 0.3, 0.0)  # of s: mu of the forms that are rounded
SHORT, LONG = tuple(range(1, 65)), (1 << 9, 1 << 12, 1 << 18, 1 << 24)  # multiples of the largest coefficient
# With multiples of each kind: shares of the rate 2 s that a proposal has at least, tried in turn.
KEPT_SHARES = ((SHORT, (0.9, 0.75, 0.5, 0.25)), (LONG, (0.9, 0.5, 0.0)))
MOST_PROPOSALS = 3


def decide_linear(point: CheckedPoint) -> Finding | None:
    """A quadratic V of a linear system, where the scene names none."""
    system = point.system
    matrix = linear_matrix(system) if system.check.is_default else None
    for form in () if matrix is None else short_forms(matrix):
        function = _examined(point, parse_piecewise(quadratic_text(form.tolist(), system.states), system.states))
        if function is not None and function.decrease is Decrease.STRICT:
            return falling_finding(function)
    return None


@BEYOND_FLOATS
def linear_matrix(system: SwitchedSystem) -> Floats | None:
    """A of a system ``x' = A x`` in the displacement; None of any other, and beyond floats."""
    states = system.displaced(system.states)
    if system.others or system.rewriting.scale is not None or system.by_roots is not None or system.surfaces(states):
        return None
    try:
        field = system.velocity(no_sign, states)
    except SceneError:  # a sign that is the same beside the point bounds no cells: that of x**2 + y**2
        return None
    if any(sum(exponents) != 1 for part in field for exponents in part.terms):
        return None
    matrix = float_slopes(field)
    return matrix if are_finite(matrix) else None


def short_forms(matrix: Floats) -> Iterator[NDArray[np.int64]]:
    """Symmetric matrices 2 P of whole numbers, with even diagonals, of a good rate: the smallest first."""
    slowest = -float(np.linalg.eigvals(matrix).real.max())
    if not slowest > 0:
        return
    from nonsmooth.proofs.kernel.first_terms import lyapunov_solution

    scaled, identity = matrix / slowest, np.eye(len(matrix))  # whatever the unit of time
    solved = [form for mu in SHARES if (form := lyapunov_solution(scaled, -mu, identity)) is not None]
    served = chain.from_iterable(_served(scaled, solved, *shares) for shares in KEPT_SHARES)
    for _, form in zip(range(MOST_PROPOSALS), served, strict=False):
        yield form.astype(np.int64)


def _served(
    matrix: Floats, solved: Sequence[Floats], multiples: Sequence[int], kept: Sequence[float]
) -> Iterator[Floats]:
    """Rounded forms whose rates are at least a share of the best one, 2 in the given units, for each share in turn."""
    forms = [2 * np.eye(len(matrix)), *(_rounded(form, multiple) for multiple in multiples for form in solved)]
    rates = [rate_of(form, matrix) / 2 for form in forms]
    for share in kept:
        yield from (form for form, rate in zip(forms, rates, strict=True) if rate >= share and rate > 0)


def _rounded(solution: Floats, multiple: int) -> Floats:
    """2 P with the coefficients of V as whole numbers, the largest of which is given."""
    coefficients = 2 * solution - np.diag(np.diag(solution))
    rounded = np.round(coefficients / np.abs(coefficients).max() * multiple)
    return rounded + np.diag(np.diag(rounded))


def rate_of(form: NDArray[Any], matrix: Floats) -> float:
    """The largest kappa with ``V' <= -kappa V`` for ``V = x^T P x`` along ``x' = A x``; 0 where P is not positive."""
    try:
        units = np.linalg.inv(np.linalg.cholesky(form)).T  # in these P is the identity
    except np.linalg.LinAlgError:
        return 0.0
    falls = -(matrix.T @ form + form @ matrix)
    return float(np.linalg.eigvalsh(units.T @ falls @ units).min())


def _examined(point: Any, formula: PiecewiseExpression) -> ExaminedFunction | None:
    """V with its conditions: on the plane, or on the cube, where they are about forms."""
    system: SwitchedSystem = point.system
    if system.is_planar:
        cells = lyapunov_cells(point.cells, formula, system.states, system.origin)
        return PlaneFunction(examine(cells), Domain(None), formula, system.states)
    examined: ExaminedLyapunov | None = point.examine(formula, system.check.radius, Effort.STRICT)
    return examined
