"""How far and how fast solutions of a system in one state come to a point that attracts.

V is the distance from the point.  ``V' <= -kappa`` or ``V' <= -kappa V`` is asked on the whole line where every start
comes to the point, then on an interval about it; ``|grad V| = 1``, so a disturbance d adds ``|d|`` at most.  Where
neither holds, solutions come like ``s' = -s^q``, and ``V' <= -kappa V^2`` is asked of ``V = s^(q-1)``.  The claims are
those of theorem ``lyapunov``; floats propose kappa.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any, TypeAlias

from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE
from nonsmooth.proofs.kernel.cells import BeyondReachError, stated_cells, surfaces_of
from nonsmooth.proofs.kernel.search import NotShownError, Search, stability_hypotheses
from nonsmooth.proofs.kernel.whole_space import find_global_attraction, rational_subject
from nonsmooth.proofs.systems.decay_rate import DecayKind, DecayRate, DisturbanceGain, rates_below
from nonsmooth.proofs.systems.domain import Domain
from nonsmooth.proofs.systems.findings import Reach
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

FAR = 1 << 10  # half-widths of the interval, for rates on the whole line

Slowest: TypeAlias = Callable[[Fraction, DecayKind, int], Fraction]


def line_reach(scene: SwitchedSystem, half: Fraction, order: int, slowest: Slowest) -> Reach:
    """Whether every start comes to the point, with a rate and a gain of the distance.

    Args:
        scene: in one state; of right-hand sides that were scaled, or in the root of the state, no rate is known.
        half: every start nearer than this comes to the point.
        order: q, of the slowest solutions near the point.
        slowest: the largest kappa that floats allow up to a distance, for a kind and a power of the distance.
    """
    (name,) = scene.states
    entry = find_global_attraction(scene, [parse_piecewise(f"{name}**2", scene.states)])
    everywhere = Reach(everywhere=entry is not None, global_entry=entry)
    if scene.scale is not None or scene.by_roots is not None:
        return everywhere
    known = rational_subject(scene)
    if known is None:
        return everywhere
    (system, subject), search = known, Search()
    on = [(Domain(None), FAR * half)] if entry is not None else []
    for (domain, farthest), decay in product((*on, (Domain(scene.field(half)), half)), DecayKind):
        power = max(order - 1, 1) if decay is DecayKind.ALGEBRAIC else 1
        for kappa in rates_below(slowest(farthest, decay, power)):
            rate = DecayRate(decay, kappa, _distance_text(name, power))
            level = None if domain.radius is None else half
            gain = None
            if decay is not DecayKind.ALGEBRAIC:
                gain = DisturbanceGain(Fraction(1), rate, level, everywhere=domain.radius is None)
            if _is_shown(system, subject, search, domain, rate, gain):
                gain_domain = None if gain is None else domain
                return replace(everywhere, rate=rate, rate_domain=domain, gain=gain, gain_domain=gain_domain)
    return everywhere


def _distance_text(state: str, power: int) -> str:
    """A power of the distance as a formula."""
    distance = f"Abs({state})" if power % 2 else state
    return distance if power == 1 else f"{distance}**{power}"


def distance_hypotheses(scene: SwitchedSystem, domain: Domain, rate: DecayRate) -> dict[str, Any]:
    """Of theorem ``lyapunov``, with the power of the distance from the point of a rate.

    Raises:
        BeyondReachError: for too many cells.
    """
    cells = stated_cells(scene, domain.radius, surfaces_of(scene, parse_piecewise(rate.function, scene.states)))
    return stability_hypotheses(cells.record, rate.function, ASYMPTOTICALLY_STABLE)


def _is_shown(
    scene: SwitchedSystem,
    subject: System,
    search: Search,
    domain: Domain,
    rate: DecayRate,
    gain: DisturbanceGain | None,
) -> bool:
    level = None if gain is None or gain.level is None else str(gain.level)
    more = {"rate": rate.record, "level": level} | ({} if gain is None else {"gain": str(gain.gamma)})
    try:
        search.entry(subject, "lyapunov", distance_hypotheses(scene, domain, rate) | more)
    except (BeyondReachError, NotShownError):
        return False
    return True
