"""Bounds of the motion of bodies under a rule with loads, by friction forces that balance a pull.

At a place c let the forces ``y_i`` be within the limits of the wheels, ``y_i = N_i f_i`` with ``f_i`` in the friction
set, and let them balance a pull G up to a small rest: ``sum_i y_i . row_i = G + rho``.  Since
``D(xi) >= sum_i y_i . slip_i(xi)`` for every twist, every minimizer xi of D, and any other twist ``xi^``, obey ::

    G . xi  <=  D(xi^) + sum_i y_i . u_i - rho . xi,

``u_i`` the speed of the surface.  The forces that make the right side least are those at the minimizer of ``D - G .
xi``: the bound is sharp (Fenchel's duality).  With a covector g and ``c' = v + omega J c``, ``G = lambda (g, g . J c)``
makes it a bound of ``lambda g . c'``.

Loads are affine in c.  So forces at the corners of a polygon, mixed, are forces at each of its points, and where G is
affine on it the bounds at the corners, with one ``xi^`` and one lambda, mixed, bound ``lambda g . c'`` all over it.

Floats find the forces, with the minimizer (:mod:`nonsmooth.analysis.minimizers.sum_of_supports`); intervals bound what
follows.  The twist itself is bounded by ``D(xi) <= D(0)``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np
from flint import arb, arb_mat, ctx

from nonsmooth.analysis.cells.contact_rule import friction_sets
from nonsmooth.proofs.boxes.intervals import Intervals
from nonsmooth.symbolic.mechanics.contact_states import inner
from nonsmooth.symbolic.mechanics.friction_set import Box, FrictionSets, UnitDiscs, float_sets, joined
from nonsmooth.symbolic.mechanics.load_model import Arithmetic
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.springs import MeasuredTable, load_model
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane_arrays import (
    Floats,
    cross,
    finite_rows,
    norm,
    norms,
    point_velocities,
    row_products,
)

Triple: TypeAlias = tuple[Intervals, Intervals, Intervals]

PRECISION = 128  # bits of the balls
SHARES = (0.25, 0.6, 0.1)  # of the friction of all wheels, by which bodies are pulled
STRENGTHS = (0.1, 0.03, 0.01, 0.003, 0.001, 0.0003)  # the same, where that is to slow them little
INSIDE = 1 - 2.0**-40  # of its limit: the largest friction force that is proposed
ROUNDING = 2.0**-24  # of the fastest surface: slips over which edges of D are rounded where it is differentiated
PASSES = 30  # of multipliers, for pulls that smoothing does not finish: most of them are beyond all friction
TINY, HUGE = 2.0**-1000, 2.0**300


def _enclosed(numbers: Sequence[Number]) -> Intervals:
    """Exact numbers; ones stay exact, by which whole ellipses are known."""
    about, ones = Intervals.about([number.ball() for number in numbers]), np.array([number == 1 for number in numbers])
    return Intervals(np.where(ones, 1.0, about.low), np.where(ones, 1.0, about.high))


def _least_eigenvalue(rows: arb_mat) -> float:
    """A lower bound of the least eigenvalue of ``sum_k row_k row_k^T``: ``4 det/trace^2``, all three positive."""
    gram = rows.transpose() * rows
    trace = gram[0, 0] + gram[1, 1] + gram[2, 2]
    return max(float(rational_below(4 * gram.det() / (trace * trace))) * (1 - 2.0**-40), 0.0)


class Balanced(NamedTuple):
    """About where ``D - G . xi`` is least.

    Attributes:
        twists: ``(v, length omega)``, shape (m, 3).
        forces: per unit of load, inside the friction sets, along and across, (m, wheels) each.
    """

    twists: Floats
    forces: tuple[Floats, Floats]


class BalancedForces:
    """A centred scene with known loads under ``box``, ``ellipse`` or ``roller``, or the last two mixed.

    Numbers that were rounded are intervals.

    Raises:
        ArithmeticError: where springs do not fix the loads, and for a wheel with a row without friction.
    """

    def __init__(self, scene: Scene) -> None:
        with ctx.workprec(PRECISION):
            loads = load_box(scene, arb(0))
            if loads is None:
                raise ArithmeticError("required springs that fix the loads")
            wheels = scene.wheels
            self.forms = [Intervals.about([form[k] for form in loads.forms]) for k in range(3)]
            axes = [tuple(entry.ball() for entry in wheel.unit_grip) for wheel in wheels]
            places = [tuple(entry.ball() for entry in wheel.position) for wheel in wheels]
            self.length = math.sqrt(np.mean([float(x) ** 2 + float(y) ** 2 for x, y in places])) or 1.0
            rows, levers = [], []
            for (a, b), (x, y) in zip(axes, places, strict=True):
                rows.append([(a, b), (-b, a)])
                levers.append([(x * b - y * a) / self.length, (x * a + y * b) / self.length])
            # slips by (v, length omega): along and across the axis of each wheel
            self.rows = [
                [Intervals.about([row[kind][k] for row in rows]) for k in range(2)]
                + [Intervals.about([lever[kind] for lever in levers])]
                for kind in range(2)
            ]
            speeds = [tuple(entry.ball() for entry in wheel.slip_speeds) for wheel in wheels]
            self.speeds = [Intervals.about([speed[kind] for speed in speeds]) for kind in range(2)]
            sets = friction_sets(scene)
            self.enclosed_sets = joined(sets, _enclosed)
            if not (self.enclosed_sets.along.low > 0).all() or not (self.enclosed_sets.across.low > 0).all():
                raise ArithmeticError("required friction along and across each rim")
            every = [[*row[kind], lever[kind]] for row, lever in zip(rows, levers, strict=True) for kind in range(2)]
            self._gram = _least_eigenvalue(arb_mat(every))
        self.sets = float_sets(sets)
        self.fastest = float(max(abs(speed.middle).max() for speed in self.speeds)) or 1.0

    @classmethod
    def of(cls, scene: Scene) -> BalancedForces | None:
        """Those of a scene; None where it is refused, or its loads are not known."""
        if scene.contact.loads_are_unknown:
            return None
        try:
            return cls(scene)
        except ArithmeticError:
            return None

    # ---- floats: what is proposed -----------------------------------------------------------------

    @cached_property
    def _float_rows(self) -> tuple[Floats, Floats]:
        """Along and across, (wheels, 3) each."""
        along, across = (np.stack([entry.middle for entry in row], axis=1) for row in self.rows)
        return along, across

    def float_loads(self, places: Floats) -> Floats:
        """(..., wheels)."""
        one, by_x, by_y = (form.middle for form in self.forms)
        return one + places[..., :1] * by_x + places[..., 1:] * by_y

    def slips(self, twists: Floats) -> tuple[Floats, Floats]:
        """Along and across the axes of all wheels, (m, wheels) each."""
        along, across = self._float_rows
        return twists @ along.T - self.speeds[0].middle, twists @ across.T - self.speeds[1].middle

    def minimizers(self, places: Floats) -> Floats:
        """About the twists ``(v, length omega)`` at which D is least, (m, 3)."""
        return self.against(places, np.zeros((len(places), 3))).twists

    def velocities(self, places: Floats) -> Floats:
        """About the velocities ``v + omega J c`` of the centre of mass at places, (m, 2)."""
        return point_velocities(self.minimizers(places) / (1, 1, self.length), places)

    @cached_property
    def _discs(self) -> tuple[Floats, Floats, FrictionSets]:
        """Maps, targets and sets of a sum of support functions that is D, of slips in units of the fastest surface.

        A disc for each wheel; where forces along and across have limits of their own two, of each of which one row is
        left: the sum of two segments is a box.
        """
        halves = np.stack([self.sets.along, self.sets.across], axis=1)
        maps = halves[:, :, None] * np.stack(self._float_rows, axis=1)
        targets = halves * np.stack([speed.middle for speed in self.speeds], axis=1) / self.fastest
        if not isinstance(self.sets, Box):
            return maps, targets, self.sets.searched(self.sets.cut)
        maps, targets = (_row_by_row(entries) for entries in (maps, targets))
        return maps, targets, UnitDiscs(np.ones(len(maps)))

    def against(self, places: Floats, pulls: Floats) -> Balanced:
        """About where ``D - G . xi`` is least.

        Args:
            places: of the body (m, 2).
            pulls: G (m, 3).
        """
        from nonsmooth.analysis.minimizers.sum_of_supports import by_smoothing

        maps, targets, sets = self._discs
        loads = np.maximum(self.float_loads(places), 0.0)
        weights = np.tile(loads, len(maps) // loads.shape[1])
        y, shares = by_smoothing(weights, maps, targets, sets, PASSES, pulls)
        if isinstance(self.sets, Box):
            along, across = np.split(shares[:, :, 0], 2, axis=1)
        else:
            along, across = np.moveaxis(shares, -1, 0)
        return Balanced(self.fastest * y, (INSIDE * self.sets.along * along, INSIDE * self.sets.across * across))

    def pulls_at_rest(self, places: Floats, slopes: Floats) -> Floats:
        """About the force against a covector, per its length, on a body held at a place, turning as at the origin, (m).

        Args:
            places: of the body (m, 2).
            slopes: the covectors (m, 2).
        """
        still = self.minimizers(np.zeros((1, 2)))
        still[:, :2] = 0.0
        along, across = self._float_rows
        f, g = self.sets.rounded_gradient(*self.slips(still), self._rounding)
        loads = self.float_loads(places)
        gradient = (loads * f) @ along + (loads * g) @ across
        return row_products(gradient[:, :2], slopes) / norms(slopes)

    def hessians(self, places: Floats, twists: Floats) -> Floats:
        """About those of D by the twist, (m, 3, 3), at places (m, 2) and twists (m, 3)."""
        along, across = self._float_rows
        loads, bends = self.float_loads(places), self.sets.rounded_hessian(*self.slips(twists), self._rounding)
        by_r, mixed, by_s = (loads * entry for entry in bends)
        slope = np.einsum("mw,wi,wj->mij", by_r, along, along) + np.einsum("mw,wi,wj->mij", by_s, across, across)
        both = np.einsum("mw,wi,wj->mij", mixed, along, across)
        return slope + both + both.transpose(0, 2, 1)

    @property
    def _rounding(self) -> Floats:
        """Of slips times friction along each rim."""
        return np.asarray(self.sets.along * ROUNDING * self.fastest)

    def compliance(self, places: Floats, slopes: Floats, twists: Floats) -> Floats:
        """About how much faster ``g . c'`` becomes per unit of a pull along a covector g, (m).

        Args:
            places: of the body (m, 2).
            slopes: the covectors (m, 2).
            twists: about those of least D (m, 3).
        """
        turns = (cross(places, slopes)) / self.length
        pulls = np.column_stack([slopes, turns])
        bend = self.hessians(places, twists)
        bend = bend + 2.0**-40 * np.trace(bend, axis1=1, axis2=2)[:, None, None] * np.eye(3)
        return row_products(pulls, np.linalg.solve(bend, pulls[:, :, None])[:, :, 0])

    @property
    def largest_friction(self) -> Floats:
        """Of each wheel, per unit of load, (wheels,)."""
        return np.maximum(self.sets.along, self.sets.across)

    # ---- intervals: what follows ------------------------------------------------------------------

    def covector(self, x: Intervals, y: Intervals, moment: Intervals) -> Triple:
        """One about twists, by ``(v, length omega)``."""
        return x, y, moment * Intervals.of(np.array(1 / self.length)).widened

    def powers(self, corners: Floats, pulls: Triple, forces: tuple[Floats, Floats], free: Floats) -> Floats:
        """Upper bounds of ``G . xi`` at the corners of quadrangles, (pieces, 4), for all minimizers xi of D.

        Args:
            corners: (pieces, 4, 2).
            pulls: G by ``(v, length omega)``, affine in the place on each quadrangle; (pieces, 4) each.
            forces: per unit of load that about balance G, (4 pieces, wheels) each.
            free: ``xi^`` (pieces, 3).
        """
        x, y = (Intervals.of(corners[:, :, k])[..., None] for k in range(2))
        one, by_x, by_y = self.forms
        loads = one + by_x * x + by_y * y
        f, g = (each.reshape(len(corners), 4, -1) for each in forces)
        along, across = (loads * force for force in self._inside(f, g))
        rest = [(along * self.rows[0][k] + across * self.rows[1][k]).sum(axis=-1) - pulls[k] for k in range(3)]
        missing = (rest[0].square + rest[1].square + rest[2].square).sqrt()
        twist = [Intervals.of(free[:, None, k : k + 1]) for k in range(3)]
        r, s = (inner(row, twist) - speed for row, speed in zip(self.rows, self.speeds, strict=True))
        dissipation = loads * self.enclosed_sets.support(r, s)
        driven = along * self.speeds[0] + across * self.speeds[1]
        bound = (dissipation + driven).sum(axis=-1) + missing * self._largest_twist(loads)
        carried = (loads.low >= 0).all(axis=-1)
        return np.where(carried, bound.high, np.inf)

    def largest_powers(self, corners: Floats, covector: Triple, shares: Sequence[float] = SHARES) -> Floats:
        """Upper bounds of ``g . xi`` for all motions over quadrangles, (pieces,), by pulls of some strengths.

        Args:
            corners: of the quadrangles (pieces, 4, 2).
            covector: g about one by ``(v, length omega)``, affine in the place on each, at the corners.
            shares: of the friction of all wheels, by which bodies are pulled.
        """
        free = self.minimizers(corners.mean(axis=1))
        total = float(self.float_loads(np.zeros((1, 2))).sum() * self.largest_friction.max())
        # neighbours share their corners, and forces there where they are pulled alike
        asked = np.column_stack([corners.reshape(-1, 2), *(entry.middle.reshape(-1) for entry in covector)])
        places, first, number = np.unique(asked, axis=0, return_index=True, return_inverse=True)
        number = number.reshape(-1)
        best = np.full(len(corners), np.inf)
        for share in shares:
            strength = Intervals.of(np.array(share * total))
            pulls = strength * covector[0], strength * covector[1], strength * covector[2]
            middle = np.stack([pull.middle for pull in pulls], axis=-1).reshape(-1, 3)
            along, across = self.against(places[:, :2], middle[first]).forces
            shown = self.powers(corners, pulls, (along[number], across[number]), free) / (share * total)
            shown = shown + 2.0**-40 * np.abs(shown)
            best = np.fmin(best, np.where(finite_rows(shown), shown.max(axis=1), np.inf))
        return best

    @property
    def moves_from_the_origin(self) -> bool:
        """Whether every motion of a body at the origin has a velocity, along about that of the minimizer in floats."""
        velocity = self.minimizers(np.zeros((1, 2)))[0, :2]
        size = norm(velocity)
        if not 0 < size < math.inf:
            return False
        back = [Intervals.of(np.full((1, 4), entry)) for entry in (*(-velocity / size), 0.0)]
        return bool(self.largest_powers(np.zeros((1, 4, 2)), (back[0], back[1], back[2]), STRENGTHS) < 0)

    def _inside(self, f: Floats, g: Floats) -> tuple[Intervals, Intervals]:
        """Forces near given ones that are within the limits, whatever the coefficients are in their intervals."""
        sets = self.enclosed_sets
        shares = f / self.sets.along, g / self.sets.across  # of the half-axes: they are what is chosen
        least = type(self.sets)(1.0, 1.0, sets.cut.low)
        size = np.maximum(least.gauge(*shares) / INSIDE, 1.0)
        return Intervals.of(shares[0] / size) * sets.along, Intervals.of(shares[1] / size) * sets.across

    def _largest_twist(self, loads: Intervals) -> Intervals:
        """A bound of ``|(v, length omega)|`` for every minimizer in a quadrangle, from ``D(xi) <= D(0)``.

        ``D(xi) >= sum_i N_i m (|(row_i . xi)| - |u_i|)`` with m the least coefficient, and ``sum_i |row_i . xi| >=
        sqrt(xi . gram xi)``.
        """
        roll, side = self.enclosed_sets.along, self.enclosed_sets.across * self.enclosed_sets.cut
        least = float(np.minimum(roll.low, side.low).min())
        fastest = (self.speeds[0].square + self.speeds[1].square).sqrt()
        total = (loads * roll * fastest + loads * side * fastest).sum(axis=-1).high
        weakest = loads.low.min(axis=-1).min(axis=1, keepdims=True)
        pull = weakest * least * math.sqrt(self._gram) * (1 - 2.0**-30)
        with np.errstate(divide="ignore", invalid="ignore"):
            bound = np.where(pull > 0, 2 * total.max(axis=1, keepdims=True) / pull * (1 + 2.0**-30), HUGE)
        return Intervals.of(bound)


def _row_by_row(entries: Floats) -> Floats:
    """Entries of all wheels by row (n, 2, ...), each row alone, the other one zero: those along, then those across."""
    rows = np.zeros((2, *entries.shape))
    rows[0, :, 0], rows[1, :, 0] = entries[:, 0], entries[:, 1]
    return rows.reshape(-1, *entries.shape[1:])


# ---- loads over a box ----------------------------------------------------------------------------
#
# Loads over a box of wheel positions and of places of the body, as long as every wheel carries.


@dataclass(frozen=True)
class LoadBox:
    """Loads as affine functions of c, with enclosures of their coefficients.

    Attributes:
        forms: ``(c0, cx, cy)`` of every wheel, balls.
    """

    forms: tuple[tuple[arb, arb, arb], ...]

    def at(self, place: Sequence[arb]) -> list[arb]:
        """Loads at a place (x, y), balls."""
        x, y = place
        return [c0 + cx * x + cy * y for c0, cx, cy in self.forms]


def load_box(scene: Scene, step: arb, carrying: Sequence[int] | None = None) -> LoadBox | None:
    """Loads of a scene whose positions may be off by ``step``; None where the springs do not fix them.

    Measured loads balance at their own centre, ``sum N_i p_i``, which is off with the wheels.

    Args:
        scene: the array.
        step: tolerance of each coordinate.
        carrying: the places of the wheels that carry, where not all do; of the others what springs would push.
    """
    off = step * arb(0, 1)
    moments = [(arb(1), x.ball() + off, y.ball() + off) for x, y in scene.positions]
    model = load_model(scene)
    if isinstance(model, MeasuredTable) and step != 0:
        forms = model.under(moments, BALLS)
    else:
        forms = model.forms(moments, range(len(moments)) if carrying is None else carrying, BALLS)
    return None if forms is None else LoadBox(tuple(forms))


def _inverse(*rows: tuple[arb, arb, arb]) -> list[tuple[arb, arb, arb]] | None:
    """Of a symmetric matrix, by elimination, which loses less than cofactors where balls are wide.

    Powers of two make its diagonal about one: so elimination takes its rows in the same order, and loses as little, in
    every unit of length.
    """
    scale = arb_mat(3, 3)
    for k, row in enumerate(rows):
        scale[k, k] = arb(2) ** -(math.frexp(float(row[k].mid()))[1] // 2)
    try:
        inverse = scale * (scale * arb_mat([list(row) for row in rows]) * scale).inv() * scale
    except ZeroDivisionError:
        return None
    return [(inverse[0, c], inverse[1, c], inverse[2, c]) for c in range(3)]


BALLS: Arithmetic[arb] = Arithmetic(lambda number: number.ball(), _inverse, lambda load: (load > 0) - (load < 0))
