"""The motion at the checked point under every load of a set, for the rules that minimize D.

Loads enter D linearly, so "a twist minimizes D" is a convex condition on them: it holds for all of them iff it holds
at the corners of their set, and where a function of the wheels alone implies it (module ``wheel_pulls``), no corner is
needed.  Where it fails, one load of the set is the witness: under it the exact decision for known loads finds that the
point is no equilibrium.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

from nonsmooth.analysis.cells.load_sets import Loads, LoadSet, load_set
from nonsmooth.analysis.contact_rule import CellRule, rule_of
from nonsmooth.proofs.boxes.linearization import Slope, spin_candidates
from nonsmooth.proofs.clauses.at_point.balance import rest_balance
from nonsmooth.proofs.clauses.at_point.ellipse import common_twist, ellipse_point, is_carried
from nonsmooth.proofs.clauses.cocircular import cocircular_array
from nonsmooth.proofs.clauses.every_load.box_slopes import build_slopes, is_driven_away, moving_loads
from nonsmooth.proofs.clauses.every_load.wheel_pulls import common_slope, under_load, wheel_slips
from nonsmooth.proofs.verdicts import Equilibrium
from nonsmooth.symbolic.constraints import Twist, rows_with_friction, scene_rows
from nonsmooth.symbolic.number_text import brief_text
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.scene import Scene

MOST_SHOWN = 8  # wheels whose loads are all written into a sentence
FEW_SHOWN = 3  # of more wheels


class EveryLoad(StrEnum):
    """What the body does at the point, whatever the load."""

    CARRIED = "carried by all wheels without slip"
    SMOOTH = "smooth minimizer"
    UNIQUE = "held: no other motion near the point"
    TIED = "a minimizer, under some loads not the only one"
    MOVED = "driven away under some load"
    OPEN = "not decided"


@dataclass(frozen=True)
class EveryLoadPoint:
    """The situation at the point with its evidence.

    Attributes:
        scene: the array, centred.
        loads: the set of loads.
        situation: see :class:`EveryLoad`.
        twist: a minimizer of D under every load, where one is known.
        slope: B, where ``pull_i = B p_i`` (smooth minimizers).
        witness: a load under which the point is no equilibrium.
        reason: one sentence for people.
    """

    scene: Scene
    loads: LoadSet
    situation: EveryLoad
    twist: Twist | None
    slope: Slope | None
    witness: Loads | None
    reason: str

    @property
    def equilibrium(self) -> Equilibrium:
        """Whether the translation part of the motion vanishes at the point under every load."""
        if self.situation is EveryLoad.OPEN:
            return Equilibrium.UNDECIDED
        if self.situation is EveryLoad.MOVED or self.twist is None or any(self.twist.velocity):
            return Equilibrium.FAILS
        return Equilibrium.HOLDS

    def undecided(self, reason: str) -> EveryLoadPoint:
        """The same point without a claim."""
        return replace(self, situation=EveryLoad.OPEN, twist=None, slope=None, witness=None, reason=reason)


def is_admissible(scene: Scene, loads: Loads) -> bool:
    """``N >= 0, sum N_i = 1, sum N_i p_i = 0``."""
    zero = scene.field.zero
    pairs = list(zip(loads, (wheel.position for wheel in scene.wheels), strict=True))
    moments = (sum((n * p[axis] for n, p in pairs), zero) for axis in (0, 1))
    return all(n >= 0 for n in loads) and sum(loads, zero) == 1 and not any(moments)


def every_load_point(scene: Scene) -> EveryLoadPoint:
    """Decide the situation at the point of a centred scene whose loads are unknown.

    Raises:
        LoadError: where the loads do not exist, or are too many.
    """
    loads = load_set(scene)
    if isinstance(rule_of(scene), CellRule):
        return _box_point(scene, loads)
    return _smooth_point(scene, loads)


def _smooth_point(scene: Scene, loads: LoadSet) -> EveryLoadPoint:
    zero = scene.field.zero
    region = under_load(scene, loads.reached.middle)
    carried = common_twist(scene, region)
    if carried is not None:
        reason = f"the twist ({', '.join(map(brief_text, carried))}) satisfies every row with friction of every wheel"
        # the wheels that carry fix the motion iff ``sum N_i a_k a_k^T``, linear in the loads, is positive definite
        corners = loads.bound.corners or (loads.bound.least,)
        fixed = all(is_carried(scene, under_load(scene, corner), carried) for corner in corners)
        situation = EveryLoad.CARRIED if fixed else EveryLoad.TIED
        return EveryLoadPoint(scene, loads, situation, carried, None, None, reason)
    if _rests_by_sticking(scene, loads):
        reason = "under every load the sticking wheels balance the others strictly inside their friction limits"
        return EveryLoadPoint(scene, loads, EveryLoad.UNIQUE, Twist(zero, zero, zero), None, None, reason)
    rates = spin_candidates(scene, region)
    for rate in rates:
        slips = wheel_slips(scene, rate)
        slope = None if slips is None else common_slope(slips)
        if slope is not None:
            return EveryLoadPoint(
                scene, loads, EveryLoad.SMOOTH, Twist(zero, zero, rate), slope, None, _balance_text(rate)
            )
    for load in _suspects(scene, loads, rates):
        if _is_refuted(scene, load):
            return _moved(scene, loads, load)
    reason = "forces do not balance alike under every load, but no load is found under which the body leaves the point"
    return EveryLoadPoint(scene, loads, EveryLoad.OPEN, None, None, None, reason)


def _balance_text(rate: Number) -> str:
    what = f"the spin {brief_text(rate)}" if rate else "rest"
    return f"at {what} the friction of every wheel is linear in its place, so that it balances under every load"


def _moved(scene: Scene, loads: LoadSet, load: Loads) -> EveryLoadPoint:
    reason = f"under the load {load_text(load)} the body is driven away from the point"
    return EveryLoadPoint(scene, loads, EveryLoad.MOVED, None, None, load, reason)


def load_text(loads: Loads) -> str:
    """The shares of the weight, rounded: of all wheels, of many those that carry most."""
    if len(loads) > MOST_SHOWN:
        heaviest = sorted(range(len(loads)), key=lambda k: -float(loads[k]))[:FEW_SHOWN]
        named = ", ".join(f"{float(loads[k]):.4g} on wheel {k + 1}" for k in heaviest)
        return f"({named}, the rest on others)"
    return f"({', '.join(f'{float(load):.4g}' for load in loads)})"


def _rolls(scene: Scene, twist: Twist) -> bool:
    """Whether every row with friction holds: D = 0, whatever the load and wherever the body is."""
    return not any(row.residual(twist) for row in rows_with_friction(scene))


def _rests_by_sticking(scene: Scene, loads: LoadSet) -> bool:
    """Whether sticking wheels hold the body at every corner of the set; strictly inside is a convex condition too."""
    if all(wheel.scaled_speed and wheel.friction.roll for wheel in scene.wheels) or loads.bound.corners is None:
        return False
    return all(rest_balance(scene, under_load(scene, corner)).strict for corner in loads.bound.corners)


def _suspects(scene: Scene, loads: LoadSet, rates: Sequence[Number]) -> Iterator[Loads]:
    """Loads under which a spin at one of the rates is far from balance; every wheel carries under them."""
    reached = loads.reached
    yield reached.middle
    for rate in rates:
        slips = wheel_slips(scene, rate)
        for axis in range(3) if slips is not None else ():
            prices = [slip.pull[axis] for slip in slips or ()]
            for side in (1, -1):
                yield mixed(reached.lowest([price * side for price in prices]), reached.middle)


def mixed(first: Loads, second: Loads) -> Loads:
    """The mean of two loads."""
    return tuple((a + b) / 2 for a, b in zip(first, second, strict=True))


def _is_refuted(scene: Scene, load: Loads) -> bool:
    """Whether the point is no equilibrium under one load that may be, decided as for loads that are known."""
    if not is_admissible(scene, load):
        return False
    if isinstance(rule_of(scene), CellRule):
        return is_driven_away(scene, load)
    return ellipse_point(scene, (under_load(scene, load),)).equilibrium is Equilibrium.FAILS


def _box_point(scene: Scene, loads: LoadSet) -> EveryLoadPoint:
    """Slopes of D at a motion about the point are linear in the loads: exact linear programs over their set.

    Where a slope vanishes under some load, other motions minimize D there too, and beside the point all velocities may
    point to one side; the lemma on inward rims, c . v <= 0, excludes that, and so does a motion with D = 0, which is
    least beside the point too.
    """
    zero = scene.field.zero
    for rate in _box_rates(scene):
        slopes = build_slopes(scene, rate)
        least = -1 if slopes is None else slopes.least_sign(loads.bound)
        rolls = _rolls(scene, Twist(zero, zero, rate))
        if least > 0 or (least == 0 and (rolls or cocircular_array(scene) is not None)):
            situation = EveryLoad.UNIQUE if least > 0 else EveryLoad.TIED
            what = f"the spin {brief_text(rate)}" if rate else "rest"
            how = "D rises in every direction" if least > 0 else "D falls in no direction"
            reason = f"at {what} {how}, under every load"
            return EveryLoadPoint(scene, loads, situation, Twist(zero, zero, rate), None, None, reason)
    for load in moving_loads(scene, loads):
        if _is_refuted(scene, load):
            return _moved(scene, loads, load)
    reason = "rest is not shown to be the motion under every load, nor is a load found that drives the body away"
    return EveryLoadPoint(scene, loads, EveryLoad.OPEN, None, None, None, reason)


def _box_rates(scene: Scene) -> list[Number]:
    """Rest, and the spins at which a wheel rolls without slip."""
    rates = {scene.field.zero: None}
    for row in scene_rows(scene):
        if row.normal[2]:
            rates[row.rhs / row.normal[2]] = None
    return list(rates)
