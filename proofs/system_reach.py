"""How far and how fast solutions come to a point that attracts, by the V that shows it, in any number of states.

*Region*: if ``V >= c`` on the border of the cube, a solution that starts inside with ``V < c`` stays inside and reaches
the point.

*Rate*: ``V' <= -kappa V^p`` with p = 0, 1 or 2: each claim about ``-V'`` is asked again with this shift.

*Gain*: ``V' <= -kappa V + gamma |d|`` along ``x' in F(x) + d`` where ``|grad V| <= gamma`` on the cube.

All are claims of theorem ``lyapunov`` (:mod:`nonsmooth.proofs.falling_function`).  A region ``V < c`` may reach beyond
the square on which V is proved to fall; the rate there is asked below its level.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from nonsmooth.proofs.falling_function import FallingFunction, claims_about
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.kernel.whole_space import find_global_attraction
from nonsmooth.proofs.many_states.decision import SpacePoint
from nonsmooth.proofs.many_states.examination import ExaminedLyapunov, are_about_forms
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.proofs.systems.decay_rate import DecayKind
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.proofs.systems.domain import Domain
from nonsmooth.proofs.systems.energies import energies
from nonsmooth.proofs.systems.findings import CheckedPoint, ExaminedFunction, Finding, PlaneFunction, Reach
from nonsmooth.proofs.systems.lyapunov_rows import BEYOND_FLOATS
from nonsmooth.proofs.systems.system_stability import has_rooted_axis
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

MOST_DEGREE = 6  # of V' whose sign is asked for below a level of a searched V: beyond that it takes too long


def reach_of(point: CheckedPoint, found: Finding) -> Reach:
    """How far and how fast a finding carries: what the point knows of it, with the reach of the V that decides."""
    known, system, function = point.reach(found), point.system, found.function
    if found.verdict is not Translation.ASYMPTOTICALLY_STABLE or len(system.states) == 1:
        return known
    reach = Reach()
    if function is not None and (function.decrease is Decrease.STRICT or found.entry is None):
        reach = _reach_of_function(system, function)
    if not point.speaks_of_states:
        reach = Reach(in_finite_time=reach.in_finite_time)
    entry = found.entry if found.is_global else None
    if not known.everywhere and entry is None:
        own = None if function is None else function.formula
        entry = find_global_attraction(system, (own, system.check.lyapunov), energies(system))
    everywhere, in_time = known.everywhere or entry is not None, known.in_finite_time or reach.in_finite_time
    reach = replace(reach, everywhere=everywhere, global_entry=entry, in_finite_time=in_time)
    return _with_rate(system, found.entry or entry, reach) if everywhere and function is None else reach


def _with_rate(system: SwitchedSystem, entry: dict[str, Any] | None, reach: Reach) -> Reach:
    """With the rate of a V that stands in evidence alone, as every start comes to the point and no V decides."""
    function = None if entry is None else entry["hypotheses"].get("function")
    if entry is None or not isinstance(function, str) or "denominator" in entry["hypotheses"]:
        return reach
    formula = parse_piecewise(function, system.states)
    examined = SpacePoint(system).examine(formula, system.check.radius, Effort.STRICT)
    if examined is None or examined.decrease is not Decrease.STRICT:
        return reach
    own = _reach_of_function(system, examined)
    if own.rate is None:
        return reach
    rate = replace(own.rate, function=function)
    return replace(reach, near=own.near, rate=rate, rate_domain=examined.stated_on)


@BEYOND_FLOATS
def _reach_of_function(system: SwitchedSystem, function: ExaminedFunction) -> Reach:
    """Region, rate and gain of a V that falls; in two states the region may reach beyond the square on which it does.

    Where V falls in the whole space, which is the region, level, rate and gain are those on the checked cube.  The rate
    holds in the space where it is one of forms.
    """
    is_whole, checked = function.domain.radius is None, system.check.radius
    cube = Domain(function.stated_on.radius or checked).rational
    found = _falling(system, function, cube.radius or checked)
    near = None if found is None else found.largest_sublevel()
    beyond = _beyond(system, function) if isinstance(function, PlaneFunction) else None
    far = None if beyond is None else beyond.largest_sublevel(falls=False)
    region = near if far is None or (near is not None and near.level >= far.level) else far
    reach = Reach() if is_whole else Reach(near=near, region=region)
    rate = None if found is None or system.scale is not None else found.decay_rate()  # a scaled field has another one
    if found is None or rate is None:
        return reach
    if system.by_roots is not None:  # in the time of the roots
        in_time = rate.decay is not DecayKind.ALGEBRAIC and has_rooted_axis(system)
        return replace(reach, in_finite_time=in_time)
    scales = is_whole and are_about_forms(found.rate_claims(rate.decay, rate.kappa))
    return replace(
        reach,
        near=None if scales else near,
        rate=rate,
        rate_domain=function.domain if scales else cube,
        region_rate=None if beyond is None or far is None or region is near else beyond.region_rate(far),
        gain=found.disturbance_gain(rate, near),
        gain_domain=cube,
    )


def _beyond(system: SwitchedSystem, function: PlaneFunction) -> FallingFunction | None:
    """A V that is proved to fall on a smaller square, on the checked one; None where nothing is asked of it there.

    That is so for a V that was searched where its derivative has a high degree, as that of enclosed sines.
    """
    domain, checked = function.domain, system.check.radius
    if domain.radius is None or domain.radius == checked:
        return None
    if not function.is_given and (system.waves or function.formula is None):  # of pieces, known on the smaller one
        return None
    found = _falling(system, function, checked)
    is_short = function.is_given or (found is not None and found.degree <= MOST_DEGREE)
    return found if is_short else None


def _falling(system: SwitchedSystem, function: ExaminedFunction, radius: Number) -> FallingFunction | None:
    """The claims about V on a cube; None where no certificate can name the system, V or the cube."""
    if isinstance(function, ExaminedLyapunov):
        found = {own.claim.name: own.found for own in function.asked if own.found is not None}
        return FallingFunction(function.radius, function.conditions, found)
    return claims_about(system, function, radius)
