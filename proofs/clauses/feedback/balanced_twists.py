"""Balanced twists: the motions that some speeds of the wheels impose under a rule without cells.

A twist xi minimizes D at c* for some speeds iff friction forces ``(rho_i, tau_i)``, in units of the half-axes of the
friction sets, balance there ::

    sum_i N_i (rho_i alpha_i a_i + tau_i beta_i b_i) = 0,     a_i = [d_i; d_i . J p_i],  b_i = [n_i; n_i . J p_i]

where a wheel with side slip ``b_i . xi != 0`` carries a force on that side of the border of its set (the speed of its
rim chooses which), and one without any force in the set.  Over ``-1 < t < 1`` that side of the border is ::

    rho = 2t/(1 + t^2),    tau = s min((1 - t^2)/(1 + t^2), kappa)

the open half circle, and between the corners of a cut one (rule ``roller``, rollers that turn) the straight side.  On
the circle the speed of the rim turns the force, on the straight side the rim does not slip.  A rim without friction
turns no force, however fast it runs: the force of such a wheel is all across, ``tau = s kappa``, at every t.

*Imposed.*  If the forces of the wheels that stick are inside their sets, no other is at a corner, and three of the
derivatives of the balance by t, rho and tau are independent, then xi is the only minimizer: D grows along every
direction that moves a sticking wheel, or turns the slip of another.  (At a corner, where rollers turn and the rim
slips, it need not: a force there stays one when the slip turns.)  A minimizer that is unique depends continuously on c,
so near c* the same speeds impose a motion near xi.  Floats propose the forces; an interval Newton step in balls, in
three of the unknowns with independent derivatives, proves that forces exist beside the proposal.

*Excluded.*  A wheel that slips across carries a force on an open half circle, which is not convex; over all of it a
separating direction sees at least the half disc, and that holds small forces.  So the half circles are cut into arcs,
for t between two rationals.  Each arc is enclosed by the triangle of its ends and the point where the tangents there
meet, an uncut half circle by a rectangle; where the friction set is cut, tau stops at ``s kappa``, and so does what
encloses it.  For every combination of arcs a direction y is given in which the largest forces of all wheels add up to
less than nothing; wheels that stick reach ``|(y . a, y . b)|``, with a cut at most ``|(y . a, y . b - t)| + kappa |t|``
for any t.  Linear programs propose y, balls verify it, and where there is none the widest arc is halved.  Then there
are none near c* either.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, reduce
from itertools import permutations
from typing import TypeAlias, TypeVar

import numpy as np
from flint import arb, arb_mat, ctx

from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.cells.loads import LoadRegion
from nonsmooth.analysis.fields.contact_model import FloatShape
from nonsmooth.analysis.minimizers.friction_search import RimDemand, search_forces
from nonsmooth.proofs.clauses.feedback.rational_bounds import ball_of
from nonsmooth.proofs.inequalities.linear_program import solve_program
from nonsmooth.symbolic.mechanics.contact_states import Triple, inner, roll_row, scaled, side_row
from nonsmooth.symbolic.mechanics.friction_set import CutEllipse, FrictionSet
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane_arrays import Floats, float_points

PRECISION = 256  # bits of balls
BITS = 50  # of proposed values
BUDGET = 200  # linear programs for one twist
# Of the arcs that are halved: over narrower ones all forces differ by less than the tolerance of the linear programs
# (1e-7), so that a search which came so far without success will have none.
NARROWEST = 2.0**-24
FACETS = 16  # of the polygon around a disc in a linear program
HALVES = (Fraction(-1), Fraction(1))

Arc: TypeAlias = tuple[Fraction, Fraction]
Force: TypeAlias = tuple[arb, arb]  # rho, tau
Coordinate = TypeVar("Coordinate", Fraction, arb)
Real = TypeVar("Real")

# Of the box in which forces are proved: far above the rounding of floats, far below room; more where loads vary.
_RADII = tuple(arb(0, 2.0**-k) for k in (40, 20, 8, 4))


@dataclass(frozen=True)
class WheelForces:
    """What one loaded wheel can contribute to the balance while the body moves with a twist.

    Attributes:
        index: number of the wheel.
        along: ``N alpha a``.
        across: ``N beta b``.
        side: sign of its side slip.
        limits: its friction set.
        nearby: N at other places of the body, over N at the point.
    """

    index: int
    along: Triple
    across: Triple
    side: int
    limits: FrictionSet
    nearby: arb = field(default_factory=lambda: arb(1), compare=False)

    @cached_property
    def balls(self) -> tuple[tuple[arb, ...], tuple[arb, ...]]:
        """The columns, as balls that hold those of all places that are meant."""
        with ctx.workprec(PRECISION):
            return tuple(x.ball() * self.nearby for x in self.along), tuple(x.ball() * self.nearby for x in self.across)

    @cached_property
    def unit_set(self) -> CutEllipse[arb]:
        """The set in units of its half-axes, as balls.

        Raises:
            RefusalError: for a shape of which nothing is proved.
        """
        if isinstance(self.limits, FloatShape):
            self.limits.refuse()
        with ctx.workprec(PRECISION):
            return CutEllipse(arb(1), arb(1), self.limits.cut.ball() if self.limits.is_cut else arb(1))

    @property
    def cut(self) -> arb:
        """kappa; one where nothing is cut off."""
        return self.unit_set.cut

    @property
    def grips_along(self) -> bool:
        """Whether the speed of the rim turns the force."""
        return bool(self.limits.along)

    def is_straight(self, t: arb) -> bool | None:
        """Whether the force at t is on the straight side; None where balls do not tell."""
        if not self.grips_along or not self.limits.is_cut:
            return not self.grips_along
        _, height = on_circle(t, 1)
        return True if height > self.cut else False if height < self.cut else None

    def on_border(self, t: arb) -> Force:
        """``rho, tau``."""
        rho, tau = on_circle(t, self.side)
        return (rho, self.side * self.cut) if self.is_straight(t) else (rho, tau)

    def border_slope(self, t: arb) -> Force:
        """Derivatives of rho and tau by t."""
        size = (1 + t * t) ** 2
        return 2 * (1 - t * t) / size, arb(0) if self.is_straight(t) else -4 * self.side * t / size

    def admits(self, values: Sequence[arb]) -> bool:
        """Whether a force inside the set, or one on the border off the corners, is certainly meant."""
        if not self.side:
            return self.unit_set.holds_strictly(*values)
        (t,) = values
        return bool(t * t < 1) and self.is_straight(t) is not None

    def slip_ratio(self, t: Fraction) -> float:
        """Slip along over slip across the rim at which the force is that of t.

        It is zero on the straight side, and of a rim without friction, whose speed does not count.
        """
        if not self.grips_along or (self.limits.is_cut and 1 - t * t > self.limits.cut * (1 + t * t)):
            return 0.0
        axes = float(self.limits.across / self.limits.along)
        return axes * float(2 * t / (1 - t * t)) * self.side


def wheel_forces(scene: Scene, region: LoadRegion, twist: Triple) -> tuple[WheelForces, ...]:
    """The wheels that are loaded at the centred equilibrium, while the body moves with a twist."""
    forces: list[WheelForces] = []
    rule = smooth_rule_of(scene)
    for wheel, form in zip(scene.wheels, region.forces, strict=True):
        if form[0]:
            roll, side = roll_row(wheel), side_row(wheel)
            limits = rule.friction_set(wheel.friction)
            along = scaled(roll.unit_normal, form[0] * limits.along)
            across = scaled(side.unit_normal, form[0] * limits.across)
            forces.append(WheelForces(wheel.index, along, across, inner(side.normal, twist).sign(), limits))
    return tuple(forces)


def on_circle(t: Coordinate, side: int) -> tuple[Coordinate, Coordinate]:
    """``rho, tau`` on the half circle."""
    size = 1 + t * t
    return 2 * t / size, side * (1 - t * t) / size


# ---- imposed -----------------------------------------------------------------------------


@dataclass(frozen=True)
class BalancedTwist:
    """A twist with a proposal of forces, or without.

    Attributes:
        twist: xi.
        wheels: the loaded wheels.
        values: t of each wheel that slips across; rho, tau of each that does not; wheel by wheel.
        is_excluded: whether it is proved to be no minimizer at c*, for any speeds.
    """

    twist: Triple
    wheels: tuple[WheelForces, ...]
    values: tuple[Fraction, ...] = ()
    is_excluded: bool = False

    @cached_property
    def is_unique(self) -> bool:
        """Whether it is proved to be the only minimizer at c* for some speeds.

        So it is where balls around the values hold forces in balance within their limits (interval Newton).
        """
        wide = any(wheel.nearby.rad() > 0 for wheel in self.wheels)
        with ctx.workprec(PRECISION):
            return bool(self.values) and any(map(self._is_unique_within, _RADII if wide else _RADII[:1]))

    def _is_unique_within(self, radius: arb) -> bool:
        """The same by a box of forces with a radius."""
        centre = [ball_of(value) for value in self.values]
        pivots = _best_pivots(self._slopes(centre))
        box = [x + radius if k in pivots else x for k, x in enumerate(centre)]
        slopes = self._slopes(box)
        try:
            matrix = arb_mat([[slopes[k][r] for k in pivots] for r in range(3)])
            step = matrix.solve(arb_mat([[entry] for entry in self._force(centre)]))
        except ZeroDivisionError:
            return False
        inside = all(radius.contains_interior(step[row, 0]) for row in range(3))
        return inside and all(wheel.admits(part) for wheel, part in self._parts(box))

    @property
    def slip_ratios(self) -> dict[int, float]:
        """Slip along over slip across the rim, of each wheel that slips across, by its number."""
        return {wheel.index: wheel.slip_ratio(part[0]) for wheel, part in self._parts(self.values) if wheel.side}

    def around(self, loads: Mapping[int, arb]) -> BalancedTwist:
        """The same at all places of a disc about the point, with the loads there over those at the point, by wheel."""
        wheels = tuple(replace(wheel, nearby=loads[wheel.index]) for wheel in self.wheels)
        return replace(self, wheels=wheels, is_excluded=False)

    def _parts(self, values: Sequence[Real]) -> Iterator[tuple[WheelForces, list[Real]]]:
        remaining = list(values)
        for wheel in self.wheels:
            count = 1 if wheel.side else 2
            yield wheel, remaining[:count]
            del remaining[:count]

    def _force(self, values: Sequence[arb]) -> list[arb]:
        total = [arb(0), arb(0), arb(0)]
        for wheel, part in self._parts(values):
            rho, tau = wheel.on_border(part[0]) if wheel.side else part
            for r, (a, b) in enumerate(zip(*wheel.balls, strict=True)):
                total[r] += rho * a + tau * b
        return total

    def _slopes(self, values: Sequence[arb]) -> list[list[arb]]:
        """Derivative of the balance by each value."""
        columns: list[list[arb]] = []
        for wheel, part in self._parts(values):
            along, across = wheel.balls
            if wheel.side:
                rho, tau = wheel.border_slope(part[0])
                columns.append([rho * a + tau * b for a, b in zip(along, across, strict=True)])
            else:
                columns += [list(along), list(across)]
        return columns


def balance_twist(scene: Scene, region: LoadRegion, twist: Triple) -> BalancedTwist:
    """The twist with forces that balance, where floats find any."""
    wheels = wheel_forces(scene, region, twist)
    if sum(1 if wheel.side else 2 for wheel in wheels) < 3:
        return BalancedTwist(twist, wheels)  # too few forces to fix a motion
    along = float_points(wheel.along for wheel in wheels)
    across = float_points(wheel.across for wheel in wheels)
    cuts = np.array([float(wheel.limits.cut) for wheel in wheels])
    forces = search_forces(
        along, across, np.array([wheel.side for wheel in wheels]), cuts, _demand(scene, wheels, twist)
    )
    if forces is None:
        return BalancedTwist(twist, wheels)
    angles, sticking = iter(forces.angles), iter(forces.sticking)
    values: list[float] = []
    for wheel in wheels:
        values += [np.tan(np.pi / 4 - next(angles) / 2)] if wheel.side else list(next(sticking))
    return BalancedTwist(twist, wheels, tuple(map(rounded, values)))


def _demand(scene: Scene, wheels: Sequence[WheelForces], twist: Triple) -> RimDemand:
    """What speeds the forces ask of the rims while the body moves with a twist."""
    carrying = [scene.wheels[scene.places[wheel.index]] for wheel in wheels]
    rolling = [float(inner(roll_row(wheel).unit_normal, twist)) for wheel in carrying]
    across = [abs(float(inner(side_row(wheel).unit_normal, twist))) for wheel in carrying]
    axes = [float(wheel.limits.across / wheel.limits.along) if wheel.grips_along else 0 for wheel in wheels]
    return RimDemand(np.array(rolling), np.array(across) * np.array(axes))


def _best_pivots(slopes: Sequence[Sequence[arb]]) -> list[int]:
    """Three values whose derivatives of the balance are well conditioned: each farthest from the span of those before.

    They are the pivots of a QR factorization; SciPy's would take a third of a whole check to import.
    """
    left = float_points(slopes)
    chosen: list[int] = []
    for _ in range(3):
        lengths = np.hypot.reduce(left, axis=1)
        lengths[chosen] = -1.0
        chosen.append(int(lengths.argmax()))
        if lengths[chosen[-1]] > 0:
            direction = left[chosen[-1]] / lengths[chosen[-1]]
            left = left - np.outer(left @ direction, direction)
    return chosen


def rounded(value: float) -> Fraction:
    """A dyadic rational beside a float."""
    return Fraction(round(float(value) * 2**BITS), 2**BITS)


# ---- excluded ----------------------------------------------------------------------------


def exclude_twist(trial: BalancedTwist) -> BalancedTwist:
    """The twist, excluded where the budget proves that no forces balance."""
    excluded = bool(trial.wheels) and ExclusionSearch(trial.wheels).excludes([HALVES] * len(trial.wheels))
    return replace(trial, is_excluded=excluded)


class ExclusionSearch:
    """Depth first over arcs of all wheels, with one budget of linear programs."""

    def __init__(self, wheels: Sequence[WheelForces]) -> None:
        self.wheels = wheels
        self.left = BUDGET
        columns = np.array([[[float(x) for x in wheel.along], [float(x) for x in wheel.across]] for wheel in wheels])
        size = np.abs(columns).max(axis=(0, 1))  # moments have another unit than forces
        self.units = [Fraction(float(x)) if x else Fraction(1) for x in size]
        self.columns = columns / np.where(size, size, 1)
        self.sizes = np.linalg.norm(self.columns, axis=(1, 2))
        self._forces: dict[tuple[int, Arc], Floats] = {}

    def excludes(self, arcs: Sequence[Arc]) -> bool:
        """Whether no forces of these arcs balance, as far as the budget lasts."""
        if self.left <= 0:
            return False
        self.left -= 1
        direction = self._proposed_direction(arcs)
        if direction is not None and separates(direction, self.wheels, arcs):
            return True
        widths = [float(arc[1] - arc[0]) if wheel.side else 0.0 for wheel, arc in zip(self.wheels, arcs, strict=True)]
        widest = int(np.argmax(self.sizes * widths))
        if widths[widest] < NARROWEST:
            return False
        low, high = arcs[widest]
        middle = (low + high) / 2
        halves = ([*arcs[:widest], half, *arcs[widest + 1 :]] for half in ((low, middle), (middle, high)))
        return all(self.excludes(half) for half in halves)

    def _proposed_direction(self, arcs: Sequence[Arc]) -> list[Fraction] | None:
        """The y that minimizes the sum of the largest products with the forces over the box ``|y| <= 1``."""
        forces = [self._forces_of(k, arc) for k, arc in enumerate(arcs)]
        largest = np.repeat(-np.eye(len(arcs)), list(map(len, forces)), axis=0)
        rows = np.hstack([np.concatenate(forces), largest])
        cost = np.concatenate([np.zeros(3), np.ones(len(arcs))])
        bounds = [(-1, 1)] * 3 + [(None, None)] * len(arcs)
        solution = solve_program(cost, A_ub=rows, b_ub=np.zeros(len(rows)), bounds=bounds)
        if solution.x is None or solution.fun >= 0:
            return None
        return [rounded(x) / unit for x, unit in zip(solution.x[:3], self.units, strict=True)]

    def _forces_of(self, k: int, arc: Arc) -> Floats:
        """The corners of a polygon around the forces of a wheel, (m, 3); of the arcs of a search only one changes."""
        if (k, arc) not in self._forces:
            shares = np.array(list(self._corners(k, arc)))
            self._forces[k, arc] = shares[:, :1] * self.columns[k, 0] + shares[:, 1:] * self.columns[k, 1]
        return self._forces[k, arc]

    def _corners(self, k: int, arc: Arc) -> Iterator[tuple[float, float]]:
        """The same as shares of its two columns."""
        if self.wheels[k].side:
            yield from ((float(rho), float(tau)) for rho, tau in border_enclosure(self.wheels[k], arc))
        else:
            angles = np.arange(FACETS) * 2 * np.pi / FACETS
            size, cut = 1 / np.cos(np.pi / FACETS), float(self.wheels[k].limits.cut) * np.ones(FACETS)
            heights = np.clip(size * np.sin(angles), -size * cut, size * cut)
            yield from zip(size * np.cos(angles), heights, strict=True)


def separates(direction: Sequence[Fraction], wheels: Sequence[WheelForces], arcs: Sequence[Arc]) -> bool:
    """Whether all forces of the arcs add up to less than nothing in a direction, by balls."""
    with ctx.workprec(PRECISION):
        y = [ball_of(entry) for entry in direction]
        reach = (_most_along(wheel, y, arc) for wheel, arc in zip(wheels, arcs, strict=True))
        return bool(sum(reach, arb(0)) < 0)


def _most_along(wheel: WheelForces, direction: Sequence[arb], arc: Arc) -> arb:
    """A bound of ``y . force`` over the forces of the arc, or of the disc where the wheel sticks."""
    a, b = (sum((x * y for x, y in zip(column, direction, strict=True)), arb(0)) for column in wheel.balls)
    if wheel.side:
        return reduce(arb.max, (rho * a + tau * b for rho, tau in border_enclosure(wheel, arc)))
    t = arb(0)
    if wheel.limits.is_cut:  # about the best
        steep = float(wheel.cut) / float(wheel.limits.corner)
        t = arb(math.copysign(max(0.0, abs(float(b)) - steep * abs(float(a))), float(b)))
    return (a * a + (b - t) ** 2).sqrt() + abs(t) * wheel.cut


def border_enclosure(wheel: WheelForces, arc: Arc) -> list[Force]:
    """Points ``(rho, tau)`` whose hull holds the forces of an arc; of a cut border the image of what holds the arc."""
    corners = [(ball_of(rho), wheel.side * ball_of(tau)) for rho, tau in enclosure(arc, wheel.side)]
    if not wheel.limits.is_cut:
        return [(rho, wheel.side * height) for rho, height in corners]
    cut, points = wheel.cut, []
    for rho, height in corners:
        points += [(rho, height)] if not height > cut else []
        points += [(rho, cut)] if not height < cut else []
    for (rho, low), (far, high) in permutations(corners, 2):
        if low < cut and high > cut:
            points.append((rho + (cut - low) / (high - low) * (far - rho), cut))
    return [(rho, wheel.side * height) for rho, height in points]


def enclosure(arc: Arc, side: int) -> tuple[tuple[Fraction, Fraction], ...]:
    """``(rho, tau)`` at the ends of an arc, and where the tangents there meet: the triangle holds the arc."""
    s, t = arc
    if arc == HALVES:  # the tangents are parallel
        return tuple((x, y) for x in HALVES for y in (Fraction(0), Fraction(side)))
    return (*(on_circle(x, side) for x in arc), ((s + t) / (1 + s * t), side * (1 - s * t) / (1 + s * t)))
