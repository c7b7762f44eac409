"""The stability of a plain system in any number of states: one result, from the strategies that speak of it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

from nonsmooth.proofs.falling_function import FallingFunction, claims_about
from nonsmooth.proofs.findings import Equilibrium, Record, Translation
from nonsmooth.proofs.kernel.cells import BeyondReachError
from nonsmooth.proofs.kernel.search import NotShownError
from nonsmooth.proofs.many_states.examination import ExaminedLyapunov, are_about_forms
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.proofs.systems.domain import DecayKind
from nonsmooth.proofs.systems.findings import (
    CheckedPoint,
    DecidedSystem,
    ExaminedFunction,
    Finding,
    Findings,
    Method,
    PlaneFunction,
    Reach,
    Strategy,
)
from nonsmooth.symbolic.files.system_builder import with_order, without_waves
from nonsmooth.symbolic.formulas.piecewise import SignOf, parse_piecewise
from nonsmooth.symbolic.formulas.trees import ExpressionError
from nonsmooth.symbolic.messages.notebook import html_table
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.messages.under_way import tell
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import BEYOND_FLOATS
from nonsmooth.symbolic.systems.switched_system import MOST_ORDER, Enclosed, SwitchedSystem, with_known_numbers

if TYPE_CHECKING:
    from nonsmooth.proofs.parts import CascadeBlock, Parts

STABILITY = "stability"
REQUIRABLE = (STABILITY, "attraction", "everywhere", "approach")  # what exit status 0 may be asked to say
MOST_PARTS = 32  # that are kept
MOST_HALVINGS = 20  # of the cube, until switching surfaces that do not hold the point lie outside
NARROW = 1  # half-width of a square on which the first terms enclose sines closely


@dataclass(frozen=True, repr=False)
class StabilityResult(DecidedSystem):
    """The stability of the checked point with everything that was found."""

    @property
    def exit_status(self) -> int:
        """0 stable, 1 unstable or no equilibrium, 3 undecided."""
        return self.status([STABILITY])

    def status(self, required: Sequence[str]) -> int:
        """0 where all that is required is shown, 1 where some of it is refuted, else 3.

        Args:
            required: of REQUIRABLE: that solutions stay near; come from near, or from everywhere; approach equilibria.
        """
        attracts = self.verdict is Translation.ASYMPTOTICALLY_STABLE
        shown = {
            STABILITY: attracts or self.verdict is Translation.STABLE,
            "attraction": attracts,
            "everywhere": self.reach.everywhere,
            "approach": attracts or self.reach.approach is not None,
        }
        refuted = set(REQUIRABLE) if self.verdict is Translation.UNSTABLE else set()
        if self.deciding.refutes:
            refuted |= {"attraction", "everywhere"}
        missing = {name for name in required if not shown[name]}
        return 1 if missing & refuted else 3 if missing else 0

    def __repr__(self) -> str:
        said = f"verdict={str(self.verdict)!r}, method={str(self.method)!r}, reason={self.reason!r}"
        return f"{type(self).__name__}({said}, findings=<{len(self.findings)} entries>)"

    def _repr_html_(self) -> str:
        rows = [(self.verdict, self.method, self.reason)]
        return html_table(f"{self.scene.name}: strong stability", ("verdict", "by", "reason"), rows)

    def check(self) -> bool:
        """Whether the stand-alone checker accepts the certificate of what is said.

        Where there is none (undecided, irrational numbers, no theorem for which evidence is found), or it leaves out
        some of it, the point is decided once more: that refuses what was changed since, and repeats an error.
        """
        from nonsmooth.proofs.kernel.subject import NoCertificateError
        from nonsmooth.proofs.system_certificates import certificate_of, left_out
        from nonsmooth.proofs.verified import UnverifiedError

        try:
            certificate = certificate_of(self)
        except NoCertificateError:
            return decide_system(self.scene) == self
        except UnverifiedError:
            return False
        shown = {"stability": str(self.verdict)} in certificate["statement"]["claims"]
        return shown and (not left_out(certificate) or decide_system(self.scene) == self)


def decide_system(system: SwitchedSystem) -> StabilityResult:
    """Decide the stability of the checked point.

    Where it stays open it is looked at nearer, without surfaces that do not hold it, and with further terms of sines.

    Raises:
        SceneError: for formulas that cannot be used, and for denominators that may vanish.
    """
    result = _decided(system)
    nearer = _without_far_surfaces(system) if result.verdict is Translation.UNDECIDED else None
    if nearer is not None:
        again = _decided(nearer)
        result = result if again.verdict is Translation.UNDECIDED else again
    for order in range(system.rewriting.order + 1, MOST_ORDER + 1):
        if result.verdict is not Translation.UNDECIDED or not system.hangs_on_order:
            break
        with suppress(SceneError):
            finer = with_order(system, order)
            if not _may_hang_on_order(system, finer):
                break
            again = _decided(finer)
            result = result if again.verdict is Translation.UNDECIDED else again
    return _with_arrival(result)


def _with_arrival(result: StabilityResult) -> StabilityResult:
    """With a bound of the time after which solutions are at the point, of a homogeneous field of negative degree."""
    known = result.reach.homogeneous
    if known is None or not known.arrives:
        return result
    from nonsmooth.proofs.kernel.arrival import find_arrival

    arrival = find_arrival(with_known_numbers(result.scene), known)
    return replace(result, reach=replace(result.reach, arrival=arrival))


def _without_far_surfaces(system: SwitchedSystem) -> SwitchedSystem | None:
    """The system on a smaller cube that no switching surface reaches but those through the point; None without others.

    Near the point it is smooth there, if only those others switch it: more theorems are about such systems.
    """
    if system.by_roots is not None:
        return None
    surfaces = [s for member in system.members for s in member.surfaces(system.displaced(system.states))]
    share = 0
    for surface in surfaces:
        sizes = {exponents: abs(float(c)) for exponents, c in surface.terms.items()}
        centre = sizes.pop((0,) * len(system.states), 0.0)
        while centre and share < MOST_HALVINGS:
            radius = system.check.half_width / 2**share
            if sum(size * radius ** sum(exponents) for exponents, size in sizes.items()) < centre:
                break
            share += 1
    if not share:
        return None
    return replace(system, check=replace(system.check, radius=system.check.radius / 2**share))


def _may_hang_on_order(system: SwitchedSystem, finer: SwitchedSystem) -> bool:
    """Whether further terms of sines and cosines may decide: on a wide square, of a stated V, and of small first terms.

    Near the point they may where they change a term that has none of a lower degree beside it, in some of its states:
    ``x**5`` counts in ``sin(x) - x + x**3/6``, and not in ``sin(x)``.
    """
    if system.check.radius > NARROW or not system.check.is_default:
        return True
    states = system.displaced(system.states)
    for coarse, other in zip(system.members, finer.members, strict=True):
        for side in (1, -1):
            fields = (member.velocity(_answering(side), states) for member in (coarse, other))
            for first, changed in zip(*fields, strict=True):
                if any(_stands_alone(term, first.terms) for term in (changed - first).terms):
                    return True
    return False


def _answering(side: int) -> SignOf:
    return lambda _: side


def _stands_alone(term: Sequence[int], terms: Iterable[Sequence[int]]) -> bool:
    """Whether no other term of a lower degree has its states alone."""
    lower = (exponents for exponents in terms if sum(exponents) < sum(term))
    return not any(all(b for a, b in zip(exponents, term, strict=True) if a) for exponents in lower)


def _decided(system: SwitchedSystem) -> StabilityResult:
    point = checked_point(system)
    _ask_strategies(point)
    findings = point.known.findings or (_open(point),)
    deciding = point.known.standing or findings[-1]
    equilibrium, given = _equilibrium(point, deciding.verdict), point.given
    if given is not None and given.decrease is Decrease.WEAK and not point.is_covered_within(given.domain.radius):
        given = None  # it may grow along solutions that stay where a root of a state is zero
    return StabilityResult(point.system, equilibrium, findings, given, reach_of(point, deciding))


@lru_cache(maxsize=MOST_PARTS)
def _decided_part(system: SwitchedSystem) -> StabilityResult:
    """The stability of a part; it may be met again as a part of another one."""
    return _decided(system)


def checked_point(system: SwitchedSystem) -> CheckedPoint:
    """The checked point with what strategies share.

    Raises:
        SceneError: for formulas that cannot be used, and for denominators that may vanish.
    """
    if len(system.states) == 1:
        from nonsmooth.proofs.systems.scalar_stability import LinePoint

        return LinePoint(system)
    if system.is_planar:
        from nonsmooth.proofs.systems.system_stability import PlanePoint

        return PlanePoint(system)
    from nonsmooth.proofs.many_states.decision import SpacePoint

    return SpacePoint(system)


def _ask_strategies(point: CheckedPoint) -> None:
    """Note what the strategies find, one after the other, until one says that none says more."""
    for strategy in STRATEGIES:
        tell(strategy.name)
        try:
            finding = strategy.decide(point)
        except (BeyondReachError, NotShownError):
            continue
        if finding is not None:
            point.known = Findings((*point.known.findings, finding))
            if finding.is_final:
                break


def _open(point: CheckedPoint) -> Finding:
    """That nothing decides, and why."""
    return Finding(Method.NONE, Translation.UNDECIDED, point.open_reason)


def _equilibrium(point: CheckedPoint, verdict: Translation) -> Equilibrium:
    """Whether 0 is in F: it is where solutions stay near; where denominators are zero there nothing else tells.

    Nor does it where F is larger than that of the field, because unit vectors are enclosed.
    """
    if verdict in (Translation.STABLE, Translation.ASYMPTOTICALLY_STABLE):
        return Equilibrium.HOLDS
    if Enclosed.UNITS in point.system.rewriting.encloses and point.equilibrium is Equilibrium.HOLDS:
        return Equilibrium.UNDECIDED
    return Equilibrium.UNDECIDED if point.system.vanishing else point.equilibrium


UNCOVERED = "not every solution crosses where the root of a state is zero: what is proved of the roots says nothing"


def leave_uncovered(point: CheckedPoint) -> Finding | None:
    """What is proved of roots of states says nothing about the states."""
    return None if point.is_covered else Finding(Method.NONE, Translation.UNDECIDED, UNCOVERED)


def decide_rooted_cascade(point: CheckedPoint) -> Finding | None:
    """The parts of a system with roots of states; in more than two states where these show nothing of the whole."""
    in_plane = point.system.is_planar
    is_asked = point.system.by_roots is not None and (in_plane or not point.is_covered)
    return decide_by_cascade(point) if is_asked else None


def decide_by_cascade(point: CheckedPoint) -> Finding | None:
    """Blocks of states one after the other, with those that drive them at the point.

    A block that none drives says that the whole is unstable where it is, and may rest; others have to attract, or to
    be stable and driven by what comes fast to the point.  One that stable ones drive says it too, of one field.

    States that velocities jump with are in one block with these; where that shows nothing, velocities may jump with
    states of earlier blocks, if the checker accepts how they do.
    """
    together = _blocks(point, jumping=False)
    finding = _decided_by_blocks(point, together)
    if finding is not None:
        return finding
    apart = _blocks(point, jumping=True)
    return _decided_by_blocks(point, apart) if len(apart) > len(together) else None


def _blocks(point: CheckedPoint, *, jumping: bool) -> list[CascadeBlock]:
    """The blocks of a cascade; none where formulas cannot be used with other states at the point.

    A field with a denominator that is zero at the point is not continuous there in any state, as theorems on parts ask;
    nor does one that divides by norms say in its formulas where it jumps.
    """
    from nonsmooth.proofs.parts import cascade

    if point.system.vanishing or point.system.rewriting.divides_by_norms:
        return []
    try:
        return list(cascade(point.system, jumping=jumping))
    except (SceneError, ExpressionError):
        return []


def _decided_by_blocks(point: CheckedPoint, blocks: Sequence[CascadeBlock]) -> Finding | None:
    """What several blocks say of the whole."""
    from nonsmooth.proofs.parts import Parts

    if len(blocks) < 2:
        return None
    results: list[StabilityResult] = []
    is_open = False
    for block in blocks:
        if block.is_driven and is_open:
            continue  # what is driven says nothing of the whole any more
        results.append(_decided_part(block.system))
        if results[-1].verdict is Translation.UNSTABLE and not block.is_driven:
            return Finding(Method.STATES, Translation.UNSTABLE, _said(block, results[-1]), proofs=Parts((results[-1],)))
        if results[-1].verdict is Translation.UNSTABLE and len(point.system.stated_lists) == 1:
            said, parts = _said(block, results[-1]), _parts(blocks, results)
            return _if_accepted(point, Finding(Method.CASCADE, Translation.UNSTABLE, said, proofs=parts))
        is_open |= results[-1].exit_status != 0
    if is_open:
        return None
    rests = [result for result in results if result.verdict is Translation.STABLE]
    method = Method.CASCADE if any(block.is_driven for block in blocks) else Method.STATES
    reason = "; ".join(map(_said, blocks, results))
    verdict = Translation.STABLE if rests else Translation.ASYMPTOTICALLY_STABLE
    refutes = "a state by itself rests near" if any(result.deciding.refutes for result in rests) else ""
    whole = Finding(method, verdict, reason, proofs=_parts(blocks, results), refutes=refutes)
    return _if_accepted(point, whole)


def _parts(blocks: Sequence[CascadeBlock], results: Sequence[StabilityResult]) -> Parts:
    """The first blocks with their results, and how they depend on each other."""
    from nonsmooth.proofs.parts import Parts

    leaves = results[-1].verdict is Translation.UNSTABLE
    pairs = list(enumerate(zip(blocks, results, strict=False)))
    rest = frozenset(k for k, (block, part) in pairs if block.is_driven and part.verdict is Translation.STABLE)
    jumping = frozenset(k for k, (block, _) in pairs if block.jumps)
    return Parts(tuple(results), carried=frozenset() if leaves else rest, jumping=jumping)


def _if_accepted(point: CheckedPoint, finding: Finding) -> Finding | None:
    """A finding by parts; where one is carried by others, or jumps with these, only if the checker accepts it."""
    from nonsmooth.proofs.checker.roots import read_subject
    from nonsmooth.proofs.kernel.subject import NoCertificateError, about
    from nonsmooth.proofs.parts import Parts
    from nonsmooth.proofs.system_certificates import by_parts

    parts = finding.proofs
    if not isinstance(parts, Parts) or not (parts.carried or parts.jumping):
        return finding
    with suppress(NoCertificateError, NotShownError):
        by_parts(parts, read_subject(about(point.system)))
        return finding
    return None


def _said(block: CascadeBlock, result: StabilityResult) -> str:
    from nonsmooth.proofs.parts import names_of

    states = result.scene.stated_states
    it, itself = ("it", "itself") if len(states) == 1 else ("them", "themselves")
    how = f", with what drives {it} at the equilibrium" if block.is_driven else f" by {itself}"
    return f"{names_of(states)}{how}: {result.reason}"


def decide_by_sliding(point: CheckedPoint) -> Finding | None:
    """On a surface that all solutions near the point come to, the states that are left."""
    from nonsmooth.proofs.parts import Parts, slides

    system = point.system
    if system.by_roots is not None:
        return None
    with suppress(SceneError, ExpressionError):
        for slide in slides(system):
            result = _decided_part(slide.system)
            if result.verdict is not Translation.UNDECIDED:
                reason = f"solutions near the equilibrium come to {slide.words}: {result.reason}"
                refutes = result.deciding.refutes
                return Finding(Method.SLIDING, result.verdict, reason, proofs=Parts((result,), slide), refutes=refutes)
    return None


def decide_by_exact_sides(point: CheckedPoint) -> Finding | None:
    """Those of several right-hand sides that hold no sine: where they alone leave, so does the system.

    A sine is enclosed, so the right-hand sides with one show by themselves that solutions stay, not that one leaves.
    """
    system, rewriting = point.system, point.system.rewriting
    if rewriting.order or not (rewriting.waves and len(rewriting.written) > 1):
        return None
    with suppress(SceneError):
        exact = without_waves(system)
        if exact is not None:
            decided = _decided(exact)
            if decided.verdict is Translation.UNSTABLE:
                reason = f"the right-hand sides without sines of states suffice: {decided.reason}"
                return Finding(Method.CHOICE, Translation.UNSTABLE, reason)
    return None


# ---- how far and how fast solutions come to a point that attracts --------------------------------
#
# By the V that shows it, in any number of states.
#
# *Region*: if ``V >= c`` on the border of the cube, a solution that starts inside with ``V < c`` stays inside and
# reaches the point.
#
# *Rate*: ``V' <= -kappa V^p`` with p = 0, 1 or 2: each claim about ``-V'`` is asked again with this shift.
#
# *Gain*: ``V' <= -kappa V + gamma |d|`` along ``x' in F(x) + d`` where ``|grad V| <= gamma`` on the cube.
#
# All are claims of theorem ``lyapunov`` (:mod:`nonsmooth.proofs.falling_function`).  A region ``V < c`` may reach
# beyond the square on which V is proved to fall; the rate there is asked below its level.


MOST_DEGREE = 6  # of V' whose sign is asked for below a level of a searched V: beyond that it takes too long


def reach_of(point: CheckedPoint, finding: Finding) -> Reach:
    """How far and how fast a finding carries: by the V that decides, and as far as the field is homogeneous."""
    known = point.reach(finding)
    if finding.verdict is Translation.STABLE:
        return replace(known, approach=_approach(point.system, finding.function))
    if finding.verdict is not Translation.ASYMPTOTICALLY_STABLE:
        return known
    from nonsmooth.proofs.kernel.homogeneity import homogeneity_of

    reach = known if len(point.system.states) == 1 else _reach_by_function(point, finding, known)
    homogeneity = homogeneity_of(point.system)
    in_time = reach.rate is not None and reach.rate.decay is DecayKind.FINITE
    if homogeneity is None or (reach.everywhere and (in_time or not homogeneity.arrives)):
        return reach
    return replace(
        reach, everywhere=True, in_finite_time=reach.in_finite_time or homogeneity.arrives, homogeneous=homogeneity
    )


def _approach(system: SwitchedSystem, function: ExaminedFunction | None) -> Record | None:
    """That solutions approach the set of equilibria, by the V that shows stability, or else by an energy."""
    if len(system.states) == 1:
        return None
    from nonsmooth.proofs.approach_to_rest import find_approach

    if function is None:
        return find_approach(system)
    return find_approach(system, (function.formula, function.stated_on.radius or system.check.radius))


def _reach_by_function(point: CheckedPoint, finding: Finding, known: Reach) -> Reach:
    """What the point knows of a finding, with the reach of the V that decides."""
    system, function = point.system, finding.function
    reach = Reach()
    if function is not None and (function.decrease is Decrease.STRICT or finding.entry is None):
        reach = _reach_of_function(system, function)
    if not point.is_covered_within(system.check.radius):
        reach = Reach(in_finite_time=reach.in_finite_time)
    entry = finding.entry if finding.is_global else None
    if not known.everywhere and entry is None:
        from nonsmooth.proofs.kernel.whole_space import find_global_attraction
        from nonsmooth.proofs.systems.energies import energies

        formula = None if function is None else function.formula
        entry = find_global_attraction(system, (formula, system.check.lyapunov), energies(system))
    everywhere, in_time = known.everywhere or entry is not None, known.in_finite_time or reach.in_finite_time
    reach = replace(reach, everywhere=everywhere, global_entry=entry, in_finite_time=in_time)
    return _with_rate(system, finding.entry or entry, reach) if everywhere and function is None else reach


def _with_rate(system: SwitchedSystem, entry: Record | None, reach: Reach) -> Reach:
    """With the rate of a V that stands in evidence alone, as every start comes to the point and no V decides."""
    function = None if entry is None else entry["hypotheses"].get("function")
    others = {"denominator", "roots"}  # of which V is no formula of the coordinates
    if entry is None or not isinstance(function, str) or others & entry["hypotheses"].keys():
        return reach
    from nonsmooth.proofs.many_states.decision import SpacePoint

    formula = parse_piecewise(function, system.states)
    examined = SpacePoint(system).examine(formula, system.check.radius, Effort.STRICT)
    if examined is None or examined.decrease is not Decrease.STRICT:
        return reach
    of_function = _reach_of_function(system, examined)
    if of_function.rate is None:
        return reach
    return replace(reach, near=of_function.near, rate=replace(of_function.rate, function=function))


@BEYOND_FLOATS
def _reach_of_function(system: SwitchedSystem, function: ExaminedFunction) -> Reach:
    """Region, rate and gain of a V that falls; in two states the region may reach beyond the square on which it does.

    Where V falls in the whole space, which is the region, level, rate and gain are those on the checked cube.  The rate
    holds in the space where it is one of forms.
    """
    is_whole, checked = function.domain.radius is None, system.check.radius
    falling = _falling(system, function, function.stated_on.radius or checked)
    near = None if falling is None else falling.largest_sublevel()
    beyond = _beyond(system, function) if isinstance(function, PlaneFunction) else None
    far = None if beyond is None else beyond.largest_sublevel(falls=False)
    region = near if far is None or (near is not None and near.level >= far.level) else far
    reach = Reach() if is_whole else Reach(near=near, region=region)
    is_scaled = system.rewriting.scale is not None  # then the field has another rate
    rate = None if falling is None or is_scaled else falling.decay_rate()
    if falling is None or rate is None:
        return reach
    if system.by_roots is not None:  # in the time of the roots
        from nonsmooth.proofs.systems.system_stability import has_rooted_axis

        in_time = rate.decay is not DecayKind.ALGEBRAIC and has_rooted_axis(system)
        return replace(reach, in_finite_time=in_time)
    scales = is_whole and are_about_forms(falling.rate_claims(rate.decay, rate.kappa))
    rate = replace(rate, domain=function.domain) if scales else rate
    return replace(
        reach,
        near=None if scales else near,
        rate=rate,
        region_rate=None if beyond is None or far is None or region is near else beyond.region_rate(far),
        gain=falling.disturbance_gain(rate, near),
    )


def _beyond(system: SwitchedSystem, function: PlaneFunction) -> FallingFunction | None:
    """A V that is proved to fall on a smaller square, on the checked one; None where nothing is asked of it there.

    That is so for a V that was searched where its derivative has a high degree, as that of enclosed sines.
    """
    domain, checked = function.domain, system.check.radius
    if domain.radius is None or domain.radius == checked:
        return None
    if not function.is_given and system.rewriting.waves:
        return None
    falling = _falling(system, function, checked)
    is_short = function.is_given or (falling is not None and falling.degree <= MOST_DEGREE)
    return falling if is_short else None


def _falling(system: SwitchedSystem, function: ExaminedFunction, radius: Number) -> FallingFunction | None:
    """The claims about V on a cube; None where no certificate can name the system, V or the cube."""
    if isinstance(function, ExaminedLyapunov):
        evidence = {question.claim.name: question.found for question in function.asked if question.found is not None}
        return FallingFunction(function.radius, function.conditions, evidence)
    return claims_about(system, function, radius)


# ---- the registry --------------------------------------------------------------------------------
#
# A strategy asks one theorem.  It is a function from the checked point, with what is known, to a finding, and a line of
# :data:`STRATEGIES`, which says for how many states it speaks and where the function is: a module is imported when the
# first of its strategies is asked.  What a strategy finds it has confirmed exactly, or in balls; one that raises
# NotShownError or BeyondReachError finds nothing.  The last finding decides, as a strategy is asked only for more than
# is known: some while nothing is, some while whether the point attracts is open.  A V that does not increase decides
# only where there is no other.

ONE, TWO, MORE, SEVERAL = range(1, 2), range(2, 3), range(3, 9), range(2, 9)  # states
KERNEL = "nonsmooth.proofs.kernel_strategies"
LINE = "nonsmooth.proofs.systems.scalar_stability"
IN_PLANE = "nonsmooth.proofs.systems.system_stability"
IN_SPACE = "nonsmooth.proofs.many_states.decision"
SILENT, OPEN = Findings.is_silent, Findings.leaves_attraction_open

STRATEGIES = [
    Strategy("right-hand sides without sines", ONE, __name__, "decide_by_exact_sides", SILENT),
    Strategy("signs on either side", ONE, LINE, "decide_by_signs"),
    Strategy("no equilibrium", TWO, IN_PLANE, "decide_no_equilibrium"),
    Strategy("no equilibrium", MORE, IN_SPACE, "decide_no_equilibrium"),
    Strategy("cascade, of roots", SEVERAL, __name__, "decide_rooted_cascade", SILENT),
    Strategy("function of roots, in the time of the states", SEVERAL, KERNEL, "decide_uncovered_by_roots", SILENT),
    Strategy("uncovered axes of roots", SEVERAL, __name__, "leave_uncovered"),
    Strategy("relative degree of a relay", MORE, IN_SPACE, "decide_by_relay"),
    Strategy("linearization", MORE, IN_SPACE, "decide_by_linearization"),
    Strategy("stated quotient", SEVERAL, KERNEL, "decide_by_stated_quotient"),
    Strategy("linear system", SEVERAL, KERNEL, "decide_linear"),
    Strategy("stated V", TWO, IN_PLANE, "decide_by_stated_function"),
    Strategy("stated V", MORE, IN_SPACE, "decide_by_stated_function"),
    Strategy("invariance principle, beside curves", TWO, IN_PLANE, "decide_by_stated_invariance"),
    Strategy("fan of cones", TWO, IN_PLANE, "decide_by_fan"),
    Strategy("leading terms", TWO, IN_PLANE, "decide_by_leading_terms"),
    Strategy("centre manifold", TWO, KERNEL, "decide_beside_stable_subspace", OPEN),
    Strategy("curve of equilibria", TWO, KERNEL, "decide_beside_curve_of_rest", OPEN),
    Strategy("reversing symmetry, with sines", TWO, KERNEL, "decide_enclosed_centre", SILENT),
    Strategy("ray along which solutions leave", MORE, IN_SPACE, "decide_by_escape", SILENT),
    Strategy("solution that leaves", SEVERAL, KERNEL, "decide_by_solution", SILENT),
    Strategy("searched V", TWO, IN_PLANE, "search_function"),
    Strategy("searched V", MORE, IN_SPACE, "search_function"),
    Strategy("sum of squares of the states", MORE, IN_SPACE, "decide_by_sum_of_squares"),
    Strategy("energy", MORE, KERNEL, "decide_by_energy", SILENT),
    Strategy("curve of equilibria", MORE, KERNEL, "decide_beside_curve_of_rest", OPEN),
    Strategy("first integrals", MORE, KERNEL, "decide_by_first_integrals", SILENT),
    Strategy("rest beside the point", MORE, KERNEL, "decide_rest_beside"),
    Strategy("surface on which solutions slide", MORE, __name__, "decide_by_sliding", SILENT),
    Strategy("function that shows instability", MORE, KERNEL, "decide_by_growth", SILENT),
    Strategy("invariance principle", TWO, KERNEL, "search_attraction", OPEN),
    Strategy("invariance principle", MORE, IN_SPACE, "decide_by_invariance", OPEN),
    Strategy("integral of motion", TWO, KERNEL, "decide_by_integral", OPEN),
    Strategy("centre manifold", SEVERAL, KERNEL, "decide_by_center_manifold", OPEN),
    Strategy("cascade", SEVERAL, __name__, "decide_by_cascade", SILENT),
    Strategy("right-hand sides without sines", SEVERAL, __name__, "decide_by_exact_sides", SILENT),
    Strategy("surface on which solutions slide", TWO, __name__, "decide_by_sliding", SILENT),
    Strategy("choice among right-hand sides", SEVERAL, KERNEL, "decide_by_choice", SILENT),
    Strategy("V by sums of squares", TWO, KERNEL, "decide_by_squares", OPEN),
    Strategy("energy that first terms keep", TWO, KERNEL, "decide_by_kept_energy", OPEN),
    Strategy("function that shows instability", TWO, KERNEL, "decide_by_growth", SILENT),
    Strategy("quotient of forms", SEVERAL, KERNEL, "decide_by_quotient", OPEN),
    Strategy("energy with its sign turned", SEVERAL, KERNEL, "decide_by_turned_energy", SILENT),
    Strategy("energy on circles", range(1, 9), KERNEL, "decide_by_circles", SILENT),
    Strategy("reversing symmetry", TWO, KERNEL, "decide_by_symmetry", OPEN),
    Strategy("function of roots, in the time of the states", SEVERAL, KERNEL, "decide_by_roots", SILENT),
    Strategy("searched V, in large programs", MORE, IN_SPACE, "search_large_function"),
    Strategy("function that shows instability, in large programs", MORE, KERNEL, "decide_by_large_growth", SILENT),
]
