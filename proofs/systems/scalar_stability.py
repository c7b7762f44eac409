"""Stability of a system in one state: the signs of the field on either side of the point decide, exactly.

Near the point the field is one polynomial on either side.  With s and t the signs of the fields just right and just
left of it: an outward sign (s > 0 or t < 0) is a solution that leaves; s < 0 < t attracts; where one is zero that side
rests.  The point is an equilibrium iff 0 lies between the values that the fields tend to.  Under arbitrary switching
every member counts.  The region of attraction reaches to the first point at which some field does not lead inward:
roots of polynomials in one variable, isolated exactly.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np

from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE
from nonsmooth.proofs.findings import Equilibrium, Fact, Quantity, Record, Translation
from nonsmooth.proofs.inequalities.real_roots import RealRoot, dense, germ_sign, positive_roots, separated
from nonsmooth.proofs.kernel.cells import BeyondReachError, stated_cells, surfaces_of
from nonsmooth.proofs.kernel.search import NotShownError, Search, stability_hypotheses
from nonsmooth.proofs.kernel.whole_space import find_global_attraction, rational_subject
from nonsmooth.proofs.systems.domain import DecayKind, DecayRate, DisturbanceGain, Domain, rates_below, slowest_ratio
from nonsmooth.proofs.systems.findings import NOT_ATTRACTING, CheckedPoint, Finding, Method, Reach
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, SignOf, parse_piecewise
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import brief_text
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

# ---- how far and how fast solutions of a system in one state come to a point that attracts -------
#
# V is the distance from the point.  ``V' <= -kappa`` or ``V' <= -kappa V`` is asked on the whole line where every start
# comes to the point, then on an interval about it; ``|grad V| = 1``, so a disturbance d adds ``|d|`` at most.  Where
# neither holds, solutions come like ``s' = -s^q``, and ``V' <= -kappa V^2`` is asked of ``V = s^(q-1)``.  The claims
# are those of theorem ``lyapunov``; floats propose kappa.


FAR = 1 << 10  # half-widths of the interval, for rates on the whole line


def line_reach(scene: SwitchedSystem, half: Fraction) -> Reach:
    """Whether every start comes to the point, with a rate and a gain of the distance.

    Args:
        scene: in one state; of right-hand sides that were scaled, or in the root of the state, no rate is known.
        half: every start nearer than this comes to the point.
    """
    (name,) = scene.states
    entry = find_global_attraction(scene, [parse_piecewise(f"{name}**2", scene.states)])
    everywhere = Reach(everywhere=entry is not None, global_entry=entry)
    if scene.rewriting.scale is not None or scene.by_roots is not None:
        return everywhere
    pair = rational_subject(scene)
    if pair is None:
        return everywhere
    (system, subject), search = pair, Search()
    on, order = [(Domain(None), FAR * half)] if entry is not None else [], _order(scene)
    for (domain, farthest), decay in product((*on, (Domain(scene.field(half)), half)), DecayKind):
        power = max(order - 1, 1) if decay is DecayKind.ALGEBRAIC else 1
        for kappa in rates_below(slowest(scene, farthest, decay, power)):
            rate = DecayRate(decay, kappa, domain, _distance_text(name, power))
            level = None if domain.radius is None else half
            reach = replace(everywhere, rate=rate)
            stated: Record = {"rate": rate.record, "level": None}
            if decay is not DecayKind.ALGEBRAIC:
                gain = DisturbanceGain(Fraction(1), rate, domain, level)
                reach = replace(reach, gain=gain)
                stated |= {"gain": "1", "level": None if level is None else str(level)}
            with suppress(BeyondReachError, NotShownError):
                search.entry(subject, "lyapunov", distance_hypotheses(system, rate) | stated)
                return reach
    return everywhere


def _distance_text(state: str, power: int) -> str:
    """A power of the distance as a formula."""
    distance = f"Abs({state})" if power % 2 else state
    return distance if power == 1 else f"{distance}**{power}"


def distance_hypotheses(scene: SwitchedSystem, rate: DecayRate) -> dict[str, Any]:
    """Of theorem ``lyapunov``, with the power of the distance from the point of a rate.

    Raises:
        BeyondReachError: for too many cells.
    """
    cells = stated_cells(scene, rate.domain.radius, surfaces_of(scene, parse_piecewise(rate.function, scene.states)))
    return stability_hypotheses(cells.record, rate.function, ASYMPTOTICALLY_STABLE)


# ---- signs on either side ------------------------------------------------------------------------


PLACES, HALVINGS = 4, 20  # at which speeds are looked at: so many in each quarter of the distance, and quarters
FINE = 1 << 20  # an end with roots is certified up to this part of its distance
LINE = ("x",)  # the displacement of one state, measured away from the point on either side


@dataclass(frozen=True)
class Side:
    """The fields on one side of the point.

    Attributes:
        outward: of each member, the sign of its speed away from the point, near the point.
        values: the limits of these speeds at the point.
        reach: every start nearer than this goes to the point; None where not even near ones do.
    """

    outward: tuple[int, ...]
    values: tuple[Number, ...]
    reach: Number | Fraction | None


@dataclass(frozen=True)
class ScalarSides:
    """What the signs of the fields on both sides of the point rest on.

    Attributes:
        right: where the state is larger.
        left: where it is smaller.
    """

    right: Side
    left: Side


class LinePoint(CheckedPoint):
    """The checked point of a system in one state; no V is looked at."""

    given = None
    open_reason = ""

    def __init__(self, system: SwitchedSystem) -> None:
        """Refuse denominators that may vanish.

        Raises:
            SceneError: for these, and for formulas that cannot be used.
        """
        for formula in system.rewriting.denominators:
            ends = system.between_norms(formula)
            if not all(_is_positive(system, end, turn) for end in ends for turn in (1, -1)):
                expected = "a denominator that does not vanish on the checked interval (a smaller check.radius?)"
                raise SceneError(system.origin, "system.rhs", expected, system.rewriting.stated_text(formula))
        self.system = system

    @cached_property
    def sides(self) -> ScalarSides:
        """The fields on both sides."""
        return ScalarSides(_side(self.system, 1), _side(self.system, -1))

    @property
    def equilibrium(self) -> Equilibrium:
        """Whether 0 is in F."""
        return _equilibrium(self.sides.right, self.sides.left)

    def reach(self, finding: Finding) -> Reach:
        """Whether every start comes to the point, and how fast."""
        right, left = self.sides.right.reach, self.sides.left.reach
        if right is None or left is None:
            return Reach()
        return line_reach(self.system, min(within(right), within(left)))


def decide_by_signs(point: LinePoint) -> Finding:
    """The stability of a point in one state."""
    sides = point.sides
    verdict, reason = _conclude(point.system, point.equilibrium, sides.right, sides.left)
    refutes = reason.removeprefix(NOT_ATTRACTING) if verdict is Translation.STABLE else ""
    return Finding(Method.SIGNS, verdict, reason, proofs=sides, facts=(_region(point.system, sides),), refutes=refutes)


def _region(scene: SwitchedSystem, sides: ScalarSides) -> Fact:
    """The interval of starts that are certified to reach the point."""
    right, left = sides.right.reach, sides.left.reach
    if right is None or left is None:
        return Fact("region")
    (state,), (at,) = scene.stated_states, scene.check.equilibrium
    ends = at - left, at + right
    low, high = ends if scene.by_roots is None else (scene.by_roots.roots.stated(state, end) for end in ends)
    words = f"every start with {brief_text(low)} < {state} < {brief_text(high)} reaches the equilibrium"
    record = {"from": Quantity(low), "to": Quantity(high), "text": words}
    return Fact("region", record, words, row="region")


def _equilibrium(right: Side, left: Side) -> Equilibrium:
    """Whether 0 lies between the limits; those on the left are measured to the left."""
    signs = {v.sign() for v in right.values} | {-v.sign() for v in left.values}
    return Equilibrium.HOLDS if 0 in signs or {1, -1} <= signs else Equilibrium.FAILS


def _conclude(scene: SwitchedSystem, holds: Equilibrium, right: Side, left: Side) -> tuple[Translation, str]:
    if holds is Equilibrium.FAILS:
        return Translation.UNSTABLE, "0 is not in F there, so every solution leaves it"
    sides = (("right", right), ("left", left))
    for name, side in sides:
        if scene.only_encloses and len(set(side.outward)) > 1:
            return Translation.UNDECIDED, f"the enclosed field has no sure sign on the {name}"
    for name, side in sides:
        if max(side.outward) > 0:
            return Translation.UNSTABLE, f"a solution leaves to the {name}"
    for name, side in sides:
        if max(side.outward) == 0:
            return Translation.STABLE, f"{NOT_ATTRACTING}it rests everywhere near on the {name}"
    return Translation.ASYMPTOTICALLY_STABLE, "the field leads back on both sides"


def _side(scene: SwitchedSystem, turn: int) -> Side:
    """The fields on one side, as polynomials in the distance from the point."""
    near = [_outward(member, turn, germ_sign) for member in scene.members]
    signs = tuple(map(germ_sign, near))
    values = tuple(p.at_origin for p in near)
    if max(signs) >= 0:
        return Side(signs, values, None)
    first = _first_stop(scene, turn)
    if first is None:
        return Side(signs, values, scene.check.radius)
    exact = first.exact()
    return Side(signs, values, first.low if exact is None else exact)


def _distance(scene: SwitchedSystem, turn: int) -> Polynomial:
    """The state as a polynomial in the distance to one side."""
    return Polynomial.variable(scene.field, LINE, LINE[0]) * turn + scene.check.equilibrium[0]


def _outward(member: SwitchedSystem, turn: int, sign_of: SignOf) -> Polynomial:
    """The speed away from the point, on one side."""
    return member.velocity(sign_of, [_distance(member, turn)])[0] * turn


def _first_stop(scene: SwitchedSystem, turn: int) -> RealRoot | None:
    """The nearest point within the checked interval at which some field does not lead inward; None without one."""
    marks = _marks(scene, turn)
    for mark in marks:
        for member in scene.members:
            before, after = (_outward(member, turn, _sign_at(place)) for place in (mark.low, mark.high))
            at_mark = [mark.sign_of(dense(field)) for field in (before, after)]
            if max(at_mark) >= 0 or _value(after, mark.high).sign() >= 0:
                return mark
    return None


def _marks(scene: SwitchedSystem, turn: int) -> list[RealRoot]:
    """Where a field may switch or vanish, inside the checked interval, ascending."""
    surfaces = [s for s in scene.surfaces([_distance(scene, turn)]) if s.degree]
    switching = _inside(scene, surfaces)
    places = [Fraction(0), *(mark.high for mark in switching)]
    starts = [switching[0].low, *places[1:]] if switching else [_inner(scene)]
    fields = [_outward(member, turn, _sign_at(place)) for place in starts for member in scene.members]
    return _inside(scene, [*surfaces, *(f for f in fields if f.degree)])


def _order(scene: SwitchedSystem) -> int:
    """q, where the slowest solutions near the point come like ``s' = -s^q``."""
    near = _sign_at(within(clear_distance(scene)) / 2)
    fields = [_outward(member, turn, near) for turn in (1, -1) for member in scene.members]
    return max(min((sum(exponents) for exponents in field.terms), default=0) for field in fields)


def slowest(scene: SwitchedSystem, farthest: Fraction, decay: DecayKind, m: int) -> Fraction:
    """The largest kappa that some places allow; proves nothing.

    In ``V' <= -kappa V^p`` V is the power ``s^m`` of the distance: then kappa is at most ``m s^(m - 1 - m p)`` times
    the speed toward the point.
    """
    power = 1 - m + m * decay.power
    places = [farthest * Fraction(k, PLACES) / 4**j for k in range(1, PLACES + 1) for j in range(HALVINGS)]
    speeds = [
        -_value(_outward(member, turn, _sign_at(place)), place) * m / place**power
        for place in places
        for turn in (1, -1)
        for member in scene.members
    ]
    distances = np.repeat([float(place) for place in places], len(speeds) // len(places))
    return slowest_ratio(np.array([float(speed) for speed in speeds]), distances)


def clear_distance(scene: SwitchedSystem) -> Number | Fraction:
    """A distance up to which nothing switches, and no field vanishes, beside the point."""
    distances: list[Number | Fraction] = [scene.check.radius]
    for turn in (1, -1):
        distances += [mark.low for mark in _marks(scene, turn)]
    return min(distances)


def _inner(scene: SwitchedSystem) -> Fraction:
    """A rational point inside the checked interval."""
    small = Fraction(1)
    while not scene.check.radius > small:
        small /= 2
    return small


def _inside(scene: SwitchedSystem, polynomials: Sequence[Polynomial]) -> list[RealRoot]:
    """Distinct positive roots below the half-width, with bounds below it."""
    roots = separated(root for p in polynomials for root in positive_roots(dense(p)))
    radius = scene.check.radius
    return [_below(root, radius) for root in roots if root.sign_of([-radius, scene.field.one]) <= 0]


def _below(root: RealRoot, radius: Number) -> RealRoot:
    """The same root with bounds below the half-width, unless it is that."""
    while root.sign_of([-radius, radius.field.one]) < 0 and not radius > root.high:
        root = root.halved()
    return root


def _sign_at(place: Fraction) -> SignOf:
    return lambda polynomial: _value(polynomial, place).sign()


def _value(polynomial: Polynomial, place: Number | Fraction) -> Number:
    return polynomial.field(polynomial((place,))) if polynomial else polynomial.field.zero


def _is_positive(scene: SwitchedSystem, formula: PiecewiseExpression, turn: int) -> bool:
    """Whether a denominator is positive from the point to the end of the checked interval."""
    blank = (formula,)
    system = SwitchedSystem(scene.name, scene.field, scene.states, blank, scene.check, scene.source)
    marks = _marks(system, turn)
    ends: list[Number | Fraction] = [scene.check.radius, Fraction(0), *(m.low for m in marks), *(m.high for m in marks)]
    pieces = [(place, system.velocity(_sign_at_or_one(place), [_distance(system, turn)])[0]) for place in ends]
    return all(_value(p, place).sign() > 0 for place, p in pieces) and not any(
        not m.sign_of(dense(p)) for m in marks for _, p in pieces
    )


def _sign_at_or_one(place: Number | Fraction) -> SignOf:
    return lambda polynomial: _value(polynomial, place).sign() or 1


def within(reach: Number | Fraction) -> Fraction:
    """A rational distance: the same, or where it has roots one a little smaller."""
    rational_distance = reach if isinstance(reach, Fraction) else reach.as_rational()
    if rational_distance is not None:
        return Fraction(int(rational_distance.numerator), int(rational_distance.denominator))
    unit = Fraction(1)
    while not reach > unit * FINE:
        unit /= 2
    while reach > unit * FINE * 2:
        unit *= 2
    return unit * (FINE - 1 + bisect_left(range(FINE, 2 * FINE), True, key=lambda k: not reach > unit * k))
