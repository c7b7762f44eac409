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

Floats find the forces, by Newton's method on D with its edges rounded (whose gradient is a force inside the limits,
whatever the rounding); intervals bound what follows.  The twist itself is bounded by ``D(xi) <= D(0)``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from flint import arb, ctx
from numpy.typing import NDArray

from nonsmooth.proofs.boxes.intervals import Intervals
from nonsmooth.proofs.boxes.load_box import load_box
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.scene import Scene

Floats: TypeAlias = NDArray[np.float64]
Triple: TypeAlias = tuple[Intervals, Intervals, Intervals]

PRECISION = 128  # bits of the balls
INSIDE = 1 - 2.0**-40  # of its limit: the largest friction force that is proposed
ROUNDINGS = tuple(2.0**-k for k in range(3, 25, 3))  # of the fastest surface: slips over which edges are rounded
STEPS = 16  # of Newton's method for each of them
LONGEST = 4.0  # step, in speeds of the fastest surface
TINY, HUGE = 2.0**-1000, 2.0**300
HALVINGS = 12  # of a step


@dataclass(frozen=True)
class FrictionShape:
    """The friction sets of all wheels, in floats; the last axis is that of the wheels.

    Attributes:
        is_box: whether all are boxes; else each is an ellipse, or the disc of ``roll`` cut by the strip of ``side``.
        rolls: which are such discs, of wheels with rollers.
        roll: coefficient along the friction axis.
        side: coefficient across it.
    """

    is_box: bool
    rolls: NDArray[np.bool_]
    roll: Floats
    side: Floats

    @property
    def strip(self) -> tuple[Floats, Floats]:
        """Half-width of the strip within the disc, and of the disc where it ends there."""
        edge = np.minimum(self.roll, self.side)
        return edge, np.sqrt(np.maximum(self.roll * self.roll - edge * edge, 0.0))

    def force(self, r: Floats, s: Floats, width: float) -> tuple[Floats, Floats]:
        """A force inside the set, per unit of load: the gradient of the support function of a slip with a third part.

        The third part, ``width`` times the coefficient, rounds the edge where slips vanish:
        ``sqrt((a r)^2 + (b s)^2 + (a width)^2)`` on the arc, ``sqrt(a^2 - e^2) sqrt(r^2 + width^2) + e |s|`` at a
        corner of height e.

        Args:
            r: slip along the axis.
            s: slip across it.
            width: of the slips over which edges are rounded.
        """
        a, b = self.roll, self.side
        if self.is_box:
            return a * r / np.hypot(r, width), b * s / np.hypot(s, width)
        size = np.hypot(np.hypot(a * r, b * s), a * width)
        along, across = a * a * r / size, b * b * s / size
        if not self.rolls.any():
            return along, across
        edge, most = self.strip
        size = np.hypot(np.hypot(r, s), width)
        cut = a * s / size
        straight = np.where(np.abs(cut) > edge, most * r / np.hypot(r, width), a * r / size)
        return np.where(self.rolls, straight, along), np.where(self.rolls, np.clip(cut, -edge, edge), across)

    def stiffness(self, r: Floats, s: Floats, width: float) -> tuple[Floats, Floats, Floats]:
        """The derivatives of the force: along by r, across by s, and along by s, which is across by r."""
        a, b = self.roll, self.side
        if self.is_box:
            return a * width**2 / np.hypot(r, width) ** 3, b * width**2 / np.hypot(s, width) ** 3, 0.0 * r
        p, q = np.where(self.rolls, r, a * r), np.where(self.rolls, s, b * s)
        size = np.hypot(np.hypot(p, q), np.where(self.rolls, width, a * width))
        x, y = p / size, q / size
        first, second = np.where(self.rolls, a, a * a), np.where(self.rolls, a, b * b)
        mixed = np.where(self.rolls, a, a * b)
        by_r, by_s, both = first * (1 - x * x) / size, second * (1 - y * y) / size, -mixed * x * y / size
        if not self.rolls.any():
            return by_r, by_s, both
        edge, most = self.strip
        turns = self.rolls & (np.abs(a * s / size) > edge)
        straight, turning = (size * width**2 / np.hypot(q, width) ** 3 for size, q in ((most, r), (edge, s)))
        # where rollers turn D is straight in s, but Newton's method must not lose where that begins
        return np.where(turns, straight, by_r), np.where(turns, turning, by_s), np.where(turns, 0.0, both)

    def support(self, r: Intervals, s: Intervals, roll: Intervals, side: Intervals) -> Intervals:
        """``max f . (r, s)`` over the friction set, per unit of load, for coefficients in intervals."""
        r, s = abs(r), abs(s)
        if self.is_box:
            return roll * r + side * s
        found = ((roll * r).square + (side * s).square).root
        if not self.rolls.any():
            return found
        edge = side.within(roll)
        across = (roll.square - edge.square).root
        turned, stood = across * r + edge * s, roll * (r.square + s.square).root
        stands, turns = edge.low * r.low >= across.high * s.high, edge.high * r.high < across.low * s.low
        # the strip only takes from the disc, and the corners of what is left are in it
        low = np.where(stands, stood.low, np.where(turns, turned.low, np.minimum(stood.low, turned.low)))
        high = np.where(turns, turned.high, stood.high)
        return Intervals(np.where(self.rolls, low, found.low), np.where(self.rolls, high, found.high))

    def inside(self, f: Floats, g: Floats, roll: Intervals, side: Intervals) -> tuple[Intervals, Intervals]:
        """Forces near given ones that are within the limits, whatever the coefficients are in their intervals."""
        first, second = f / self.roll, g / self.side  # shares of the limits are what is chosen
        if self.is_box:
            first, second = np.clip(first, -INSIDE, INSIDE), np.clip(second, -INSIDE, INSIDE)
        else:
            size = np.maximum(np.hypot(first, second) / INSIDE, 1.0)
            first, second = first / size, second / size
        along, across = Intervals.of(first) * roll, Intervals.of(second) * side
        if not self.rolls.any():
            return along, across
        a, edge = roll.low * INSIDE, np.minimum(roll.low, side.low) * INSIDE
        cut = np.clip(g, -edge, edge)
        most = np.sqrt(np.maximum(a * a - cut * cut, 0.0)) * INSIDE
        straight = np.clip(f, -most, most)
        return (
            Intervals(np.where(self.rolls, straight, along.low), np.where(self.rolls, straight, along.high)),
            Intervals(np.where(self.rolls, cut, across.low), np.where(self.rolls, cut, across.high)),
        )


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
            self.roll = Intervals.about([wheel.friction.roll.ball() for wheel in wheels])
            self.side = Intervals.about([wheel.friction.side.ball() for wheel in wheels])
            if not (self.roll.low > 0).all() or not (self.side.low > 0).all():
                raise ArithmeticError("required friction along and across each rim")
            self._gram = self._least_eigenvalue(rows, levers)
        rules = [scene.rule_of_wheel(wheel) for wheel in wheels]
        rolls = np.array([rule == "roller" for rule in rules])
        self.shape = FrictionShape("box" in rules, rolls, self.roll.middle, self.side.middle)
        self.fastest = float(max(abs(speed.middle).max() for speed in self.speeds)) or 1.0

    def _least_eigenvalue(self, rows: list[list[tuple[arb, arb]]], levers: list[list[arb]]) -> float:
        """A lower bound of the least eigenvalue of ``sum_i row_i row_i^T``: ``4 det/trace^2``, all three positive."""
        matrix = [[arb(0)] * 3 for _ in range(3)]
        for row, lever in zip(rows, levers, strict=True):
            for kind in range(2):
                entries = (*row[kind], lever[kind])
                for i in range(3):
                    for j in range(3):
                        matrix[i][j] += entries[i] * entries[j]
        (a, b, c), (_, d, e), (_, _, f) = matrix
        determinant = a * (d * f - e * e) - b * (b * f - e * c) + c * (b * e - d * c)
        trace = a + d + f
        return max(float(rational_below(4 * determinant / (trace * trace))) * (1 - 2.0**-40), 0.0)

    # ---- floats: what is proposed -----------------------------------------------------------------

    @cached_property
    def _float_rows(self) -> tuple[Floats, Floats]:
        """Along and across, (wheels, 3) each."""
        along, across = (np.stack([entry.middle for entry in row], axis=1) for row in self.rows)
        return along, across

    def float_loads(self, places: Floats) -> Floats:
        """(..., wheels)."""
        one, by_x, by_y = (form.middle for form in self.forms)
        return np.asarray(one + places[..., :1] * by_x + places[..., 1:] * by_y)

    def slips(self, twists: Floats) -> tuple[Floats, Floats]:
        """Along and across the axes of all wheels, (m, wheels) each."""
        along, across = self._float_rows
        return twists @ along.T - self.speeds[0].middle, twists @ across.T - self.speeds[1].middle

    def minimizers(self, places: Floats, pulls: Floats, start: Floats | None = None) -> Floats:
        """About the twists ``(v, length omega)`` at which ``D - G . xi`` is least, (m, 3).

        Args:
            places: of the body (m, 2).
            pulls: G (m, 3).
            start: where the search begins (m, 3).
        """
        twists = np.zeros((len(places), 3)) if start is None else start.copy()
        loads = self.float_loads(places)
        for rounding in ROUNDINGS:
            twists = self._newton(twists, loads, pulls, rounding * self.fastest)
        return twists

    def _newton(self, twists: Floats, loads: Floats, pulls: Floats, width: float) -> Floats:
        """Newton's method on the rounded D; a step is halved while the gradient along it does not point back."""
        open_ones = np.arange(len(twists))
        scale = loads.sum(axis=1).mean() * float(self.shape.roll.max())
        for _ in range(STEPS):
            now, load, pull = twists[open_ones], loads[open_ones], pulls[open_ones]
            gradient, slope = self._gradient(now, load, pull, width, hessian=True)
            trace = np.trace(slope, axis1=1, axis2=2)[:, None, None]
            slope = slope + (2.0**-36 * trace + 2.0**-60 * scale / self.fastest) * np.eye(3)
            step = -np.linalg.solve(slope, gradient[:, :, None])[:, :, 0]
            # far away D has no curvature, and steps would lead farther still
            size = np.minimum(LONGEST * self.fastest / np.maximum(np.abs(step).max(axis=1, keepdims=True), TINY), 1.0)
            for _ in range(HALVINGS):
                ahead, _ = self._gradient(now + size * step, load, pull, width, hessian=False)
                # D is convex along the step: its slope there must not be steeper ahead than it was behind
                worse = (ahead * step).sum(axis=1) > 0.5 * np.abs((gradient * step).sum(axis=1)) + 2.0**-44 * scale * (
                    np.abs(step).sum(axis=1)
                )
                if not worse.any():
                    break
                size = np.where(worse[:, None], size / 2, size)
            twists[open_ones] = now + size * step
            left = np.abs(gradient).max(axis=1) > 2.0**-46 * scale
            open_ones = open_ones[left]
            if not len(open_ones):
                break
        return twists

    def _gradient(
        self, twists: Floats, loads: Floats, pulls: Floats, width: float, *, hessian: bool
    ) -> tuple[Floats, Floats]:
        """Of ``D - G . xi``, (m, 3), and its derivative (m, 3, 3)."""
        along, across = self._float_rows
        r, s = self.slips(twists)
        f, g = self.shape.force(r, s, width)
        gradient = (loads * f) @ along + (loads * g) @ across - pulls
        if not hessian:
            return gradient, gradient
        by_r, by_s, mixed = (loads * entry for entry in self.shape.stiffness(r, s, width))
        slope = np.einsum("mw,wi,wj->mij", by_r, along, along) + np.einsum("mw,wi,wj->mij", by_s, across, across)
        both = np.einsum("mw,wi,wj->mij", mixed, along, across)
        return gradient, slope + both + both.transpose(0, 2, 1)

    def pulls_at_rest(self, places: Floats, slopes: Floats) -> Floats:
        """About the force against a covector, per its length, on a body held at a place, turning as at the origin, (m).

        Args:
            places: of the body (m, 2).
            slopes: the covectors (m, 2).
        """
        zero = np.zeros((1, 2))
        still = self.minimizers(zero, np.zeros((1, 3)))
        still[:, :2] = 0.0
        gradient, _ = self._gradient(
            np.repeat(still, len(places), axis=0),
            self.float_loads(places),
            np.zeros((len(places), 3)),
            ROUNDINGS[-1] * self.fastest,
            hessian=False,
        )
        return np.asarray((gradient[:, :2] * slopes).sum(axis=1) / np.hypot(slopes[:, 0], slopes[:, 1]))

    def compliance(self, places: Floats, slopes: Floats, twists: Floats) -> Floats:
        """About how much faster ``g . c'`` becomes per unit of a pull along a covector g, (m).

        Args:
            places: of the body (m, 2).
            slopes: the covectors (m, 2).
            twists: about those of least D (m, 3).
        """
        turns = (slopes[:, 1] * places[:, 0] - slopes[:, 0] * places[:, 1]) / self.length
        pulls = np.column_stack([slopes, turns])
        loads, nothing = self.float_loads(places), np.zeros_like(pulls)
        _, bend = self._gradient(twists, loads, nothing, ROUNDINGS[-1] * self.fastest, hessian=True)
        bend = bend + 2.0**-40 * np.trace(bend, axis1=1, axis2=2)[:, None, None] * np.eye(3)
        return np.asarray((pulls * np.linalg.solve(bend, pulls[:, :, None])[:, :, 0]).sum(axis=1))

    def forces(self, twists: Floats) -> tuple[Floats, Floats]:
        """Inside the friction sets, per unit of load, (m, wheels) each."""
        f, g = self.shape.force(*self.slips(twists), ROUNDINGS[-1] * self.fastest)
        return INSIDE * f, INSIDE * g

    # ---- intervals: what follows ------------------------------------------------------------------

    def powers(self, corners: Floats, pulls: Triple, pushed: Floats, free: Floats) -> Floats:
        """Upper bounds of ``G . xi`` at the corners of quadrangles, (pieces, 4), for all minimizers xi of D.

        Args:
            corners: (pieces, 4, 2).
            pulls: G by ``(v, length omega)``, affine in the place on each quadrangle; (pieces, 4) each.
            pushed: twists about where ``D - G . xi`` is least, (pieces, 4, 3).
            free: ``xi^`` (pieces, 3).
        """
        x, y = (Intervals.of(corners[:, :, k])[..., None] for k in range(2))
        one, by_x, by_y = self.forms
        loads = one + by_x * x + by_y * y
        f, g = (each.reshape(len(corners), 4, -1) for each in self.forces(pushed.reshape(-1, 3)))
        along, across = (loads * force for force in self.shape.inside(f, g, self.roll, self.side))
        rest = [(along * self.rows[0][k] + across * self.rows[1][k]).sum(axis=-1) - pulls[k] for k in range(3)]
        missing = (rest[0].square + rest[1].square + rest[2].square).root
        twist = [Intervals.of(free[:, None, k : k + 1]) for k in range(3)]
        r, s = (
            row[0] * twist[0] + row[1] * twist[1] + row[2] * twist[2] - speed
            for row, speed in zip(self.rows, self.speeds, strict=True)
        )
        dissipation = loads * self.shape.support(r, s, self.roll, self.side)
        driven = along * self.speeds[0] + across * self.speeds[1]
        bound = (dissipation + driven).sum(axis=-1) + missing * self._largest_twist(loads)
        carried = (loads.low >= 0).all(axis=-1)
        return np.where(carried, bound.high, np.inf)

    def _largest_twist(self, loads: Intervals) -> Intervals:
        """A bound of ``|(v, length omega)|`` for every minimizer in a quadrangle, from ``D(xi) <= D(0)``.

        ``D(xi) >= sum_i N_i m (|(row_i . xi)| - |u_i|)`` with m the least coefficient, and ``sum_i |row_i . xi| >=
        sqrt(xi . gram xi)``.
        """
        least = float(np.minimum(self.roll.low, self.side.low).min())
        fastest = (self.speeds[0].square + self.speeds[1].square).root
        total = (loads * self.roll * fastest + loads * self.side * fastest).sum(axis=-1).high
        weakest = loads.low.min(axis=-1).min(axis=1, keepdims=True)
        pull = weakest * least * math.sqrt(self._gram) * (1 - 2.0**-30)
        with np.errstate(divide="ignore", invalid="ignore"):
            bound = np.where(pull > 0, 2 * total.max(axis=1, keepdims=True) / pull * (1 + 2.0**-30), HUGE)
        return Intervals.of(bound)
