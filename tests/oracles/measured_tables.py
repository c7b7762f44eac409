"""Tables as they are measured, and small steps of a body on them by the words of the rules: an oracle for its ends.

Nothing here knows of rings, forces that balance, cells or clauses.  A body moves with the twist that its contact rule
names at each place: the rows of the two nearest wheels, or the least of D.  Under rule ``box`` that is the best of all
motions without slip in three rows; under the others norms are rounded by far less than the speeds differ, and Newton's
method searches with a line search on D itself.
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import RK23

from tests.oracles.floats import Floats

ROUNDINGS = (1e-2, 1e-4, 1e-6)  # of the fastest rim
NEWTON = 60
SETTLED = 1e-11
RELATIVE = 1e-5  # error of a step, of the place and of the length that matters
MOST_EVALUATIONS = 3000  # for one stretch of bodies that move at one pace


@dataclass(frozen=True)
class MeasuredTable:
    """Millimetres, whole degrees, speeds in mm/s.

    Attributes:
        rows: x, y, heading and speed of every wheel.
        roll, side: coefficients of friction, of all wheels or (wheels,) where these differ.
        rule: the contact rule.
    """

    rows: tuple[tuple[float, float, float, float], ...]
    roll: float | Floats
    side: float | Floats
    rule: str

    @classmethod
    def random(cls, seed: int, rule: str, *, off: float = 0.0) -> MeasuredTable:
        """4 to 12 wheels about the middle, rims inward up to a few degrees, speeds within two per cent."""
        rng = random.Random(seed)
        count, begin = rng.randint(4, 12), rng.uniform(0, 360)
        rows = []
        for k in range(count):
            angle, radius = math.radians(begin + 360 * k / count), 140 if k % 2 else 100
            x, y = round(radius * math.cos(angle)), round(radius * math.sin(angle))
            heading = round(math.degrees(math.atan2(-y, -x)) + rng.uniform(-off, off))
            rows.append((x, y, heading, round(100 * (1 + rng.uniform(-0.02, 0.02)), 1)))
        return cls(tuple(rows), 0.8, rng.choice([0.2, 0.4, 0.5, 0.7]), rule)

    @classmethod
    def symmetric(cls, seed: int, rule: str) -> MeasuredTable:
        """4 to 12 wheels in pairs opposite each other, in every second one roughly inward: a half turn changes nothing.

        So D at the middle is the same for v and -v, and bodies rest there, turning at a rate that is no number of the
        scene; whether they come or go is open.
        """
        rng = random.Random(seed)
        rows: list[tuple[int, int, int, float]] = []
        for _ in range(rng.randint(2, 6)):
            x, y = rng.randint(-300, 300), rng.randint(-300, 300)
            inward = round(math.degrees(math.atan2(-y, -x))) + rng.randint(-40, 40)
            heading, speed = (inward if seed % 2 else rng.randint(0, 359)), rng.randint(50, 150)
            rows += [(x, y, heading, speed), (-x, -y, heading + 180, speed)]
        return cls(tuple(rows), 0.8, rng.choice([0.2, 0.4, 0.5, 0.7]), rule)

    @property
    def toml(self) -> str:
        """The scene file."""
        head = f'units = {{ length = "mm", angle = "deg" }}\ncontact = {{ rule = "{self.rule}" }}\n'
        friction = f"friction = {{ mu_roll = {self.roll}, mu_side = {self.side} }}\n"
        wheels = (f"[[wheel]]\nposition = [{x}, {y}]\nheading = {h}\nspeed = {u}\n" for x, y, h, u in self.rows)
        return head + friction + "".join(wheels)


class SmallSteps:
    """Bodies on a table, from place to place, all at once."""

    def __init__(self, table: MeasuredTable) -> None:
        self.places = np.array([row[:2] for row in table.rows], dtype=float)
        angles = np.radians([row[2] for row in table.rows])
        self.speeds = np.array([row[3] for row in table.rows])
        self.table = table
        along = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        across = np.stack([-along[:, 1], along[:, 0]], axis=1)
        turned = np.stack([-self.places[:, 1], self.places[:, 0]], axis=1)
        self.length = math.sqrt((self.places**2).sum(axis=1).mean())
        self.along, self.across = (
            np.column_stack([side, (side * turned).sum(axis=1) / self.length]) for side in (along, across)
        )
        moments = np.column_stack([np.ones(len(self.places)), self.places])
        self._springs = moments @ np.linalg.inv(moments.T @ moments)  # loads of identical springs, by (1, x, y)
        self._started = np.zeros((0, 3))  # the twists of the last call: where the next search begins

    def velocity(self, place: Floats) -> Floats:
        """Of the centre of mass, (2,) or (bodies, 2)."""
        places = np.atleast_2d(place)
        twists = self.twists(places)
        omega = twists[:, 2] / self.length
        found = np.stack([twists[:, 0] - omega * places[:, 1], twists[:, 1] + omega * places[:, 0]], axis=1)
        if self.table.rule != "nearest":
            found[self._stops(places)] = 0.0
        return found if place.ndim > 1 else found[0]

    def _stops(self, places: Floats) -> NDArray[np.bool_]:
        """Which bodies go no farther: a spring would have to pull."""
        return np.asarray((self._springs_at(places) < 0).any(axis=1))

    def twists(self, places: Floats) -> Floats:
        """``(v, length omega)`` of bodies at places, (bodies, 3)."""
        if self.table.rule == "nearest":
            return self._nearest(places)
        return self._corners(places) if self.table.rule == "box" else self._least(places)

    # ---- rule nearest ----------------------------------------------------------------------------

    def _nearest(self, places: Floats) -> Floats:
        """By the nearest wheel and the second of each body."""
        distances = ((self.places - places[:, None]) ** 2).sum(axis=2)
        bodies, first = np.arange(len(places)), distances.argmin(axis=1)
        distances[bodies, first] = np.inf
        second = distances.argmin(axis=1)
        found = self._of_pairs[first, second]
        if not np.isnan(found).any():
            return np.asarray(found)
        distances[bodies, first] = -1.0
        return np.array([self._in_order(order) for order in np.argsort(distances, axis=1)])

    @cached_property
    def _of_pairs(self) -> Floats:
        """Twists by the nearest wheel and the second, (wheels, wheels, 3); not a number where these do not fix it."""
        wheels = range(len(self.places))
        return np.array([[self._in_order([first, second]) for second in wheels] for first in wheels])

    def _in_order(self, wheels: Sequence[int]) -> Floats:
        """Both rows of the first wheel, then rows of the next ones, of larger friction first, while independent."""
        first, *others = wheels
        rows, values = [self.along[first], self.across[first]], [self.speeds[first], 0.0]
        for k in others:
            own = [(self.along[k], self.speeds[k]), (self.across[k], 0.0)]
            for row, value in own if self.table.roll >= self.table.side else own[::-1]:
                if abs(np.linalg.det([*rows, row])) > 1e-9:
                    return np.asarray(np.linalg.solve([*rows, row], [*values, value]))
        return np.full(3, np.nan)

    # ---- rules with loads ------------------------------------------------------------------------

    def _loads(self, places: Floats) -> Floats:
        """Of springs that are in touch; one that would pull carries nothing, and its body goes no farther."""
        return np.maximum(self._springs_at(places), 0.0)

    def _springs_at(self, places: Floats) -> Floats:
        return np.asarray(np.column_stack([np.ones(len(places)), places]) @ self._springs.T)

    @cached_property
    def _fits(self) -> tuple[Floats, Floats]:
        """Every twist without slip in three independent rows, and its dissipation on each wheel per unit of load.

        D is linear between the planes of rows without slip, so that its least value is at one of them.
        """
        rows = np.concatenate([self.along, self.across])
        values = np.concatenate([self.speeds, np.zeros(len(self.speeds))])
        threes = np.array(list(combinations(range(len(rows)), 3)))
        systems = rows[threes]
        kept = np.abs(np.linalg.det(systems)) > 1e-9
        twists = np.linalg.solve(systems[kept], values[threes[kept]][:, :, None])[:, :, 0]
        slips = np.abs(twists @ self.along.T - self.speeds), np.abs(twists @ self.across.T)
        return twists, self.table.roll * slips[0] + self.table.side * slips[1]

    def _corners(self, places: Floats) -> Floats:
        twists, each = self._fits
        return np.asarray(twists[(self._loads(places) @ each.T).argmin(axis=1)])

    def _least(self, places: Floats) -> Floats:
        loads, fastest = self._loads(places), self.speeds.max()
        goes_on = len(self._started) == len(places)
        twists = self._started.copy() if goes_on else np.zeros((len(places), 3))
        for rounding in ROUNDINGS[-1:] if goes_on else ROUNDINGS:
            twists = self._newton(twists, loads, rounding * fastest)
        self._started = twists
        return twists

    def _newton(self, twists: Floats, loads: Floats, rounding: float) -> Floats:
        """Newton's method with a line search on D itself, for all bodies whose twists have not settled."""
        twists, left = twists.copy(), np.arange(len(twists))
        value, gradient, slope = self._dissipation(twists, loads, rounding)
        for _ in range(NEWTON):
            now, load = twists[left], loads[left]
            trace = np.trace(slope, axis1=1, axis2=2)[:, None, None]
            step = -np.linalg.solve(slope + 1e-12 * trace * np.eye(3), gradient[:, :, None])[:, :, 0]
            falls, part = (gradient * step).sum(axis=1), np.ones(len(left))
            for _ in range(34):
                ahead = self._dissipation(now + part[:, None] * step, load, rounding)
                shorter = ahead[0] > value + 1e-4 * part * falls
                if not shorter.any():
                    break
                part = np.where(shorter, part / 2, part)
            twists[left] = now + part[:, None] * step
            goes_on = np.abs(part[:, None] * step).max(axis=1) >= SETTLED * self.speeds.max()
            if not goes_on.any():
                break
            left, (value, gradient, slope) = left[goes_on], (own[goes_on] for own in ahead)
        return twists

    def _dissipation(self, twists: Floats, loads: Floats, rounding: float) -> tuple[Floats, Floats, Floats]:
        """D with its norms rounded (bodies), its gradient (bodies, 3) and its second derivative (bodies, 3, 3)."""
        a, b = self.table.roll, self.table.side
        r, s = twists @ self.along.T - self.speeds, twists @ self.across.T
        if self.table.rule == "ellipse":
            size = np.sqrt((a * r) ** 2 + (b * s) ** 2 + (a * rounding) ** 2)
            value, f, g = size, a * a * r / size, b * b * s / size
            by_r, by_s, mixed = a * a / size - f * f / size, b * b / size - g * g / size, -f * g / size
        else:  # rollers: they stand where the slip along them is small, else they turn against their friction
            w = np.sqrt(a * a - b * b)
            stands = np.abs(s) * w <= b * np.abs(r)
            both, one, other = (np.sqrt(q + rounding**2) for q in (r * r + s * s, r * r, s * s))
            value = np.where(stands, a * both, w * one + b * other)
            f, g = np.where(stands, a * r / both, w * r / one), np.where(stands, a * s / both, b * s / other)
            by_r = np.where(stands, a / both - a * r * r / both**3, w * rounding**2 / one**3)
            by_s = np.where(stands, a / both - a * s * s / both**3, b * rounding**2 / other**3)
            mixed = np.where(stands, -a * r * s / both**3, 0.0)
        gradient = (loads * f) @ self.along + (loads * g) @ self.across
        cross = self._squares(loads * mixed, self.along, self.across)
        slope = self._squares(loads * by_r, self.along, self.along) + self._squares(
            loads * by_s, self.across, self.across
        )
        return (loads * value).sum(axis=1), gradient, slope + cross + cross.transpose(0, 2, 1)

    @staticmethod
    def _squares(weights: Floats, first: Floats, second: Floats) -> Floats:
        """``sum_w weight_w first_w second_w^T``, (bodies, 3, 3)."""
        return np.asarray((weights @ (first[:, :, None] * second[:, None, :]).reshape(-1, 9)).reshape(-1, 3, 3))

    # ---- paths -----------------------------------------------------------------------------------

    def paths(self, starts: Floats, times: Sequence[float], near: float) -> tuple[Floats, Floats]:
        """Where bodies are at times, (times, bodies, 2), and how far from the origin each was at most, (bodies).

        Args:
            starts: their places (bodies, 2).
            times: increasing.
            near: a length that matters; where the field jumps, steps are a small part of it.
        """
        places, farthest, now, found = starts.astype(float), np.hypot(*starts.T), 0.0, []
        follow = self._smooth_pace if self.table.rule in {"ellipse", "roller"} else self._paced
        for time in times:
            places, most = follow(places, time - now, near)
            farthest, now = np.maximum(farthest, most), time
            found.append(places)
        return np.array(found), farthest

    def _smooth_pace(self, places: Floats, duration: float, near: float) -> tuple[Floats, Floats]:
        """Where the field is continuous, by a method of low order, since it has kinks where a wheel begins to stick.

        Where bodies go to and fro over such a kink, and steps get too many, as where the field jumps.
        """
        self._started = np.zeros((0, 3))
        solver = RK23(
            lambda _, y: self.velocity(y.reshape(-1, 2)).ravel(),
            0.0,
            places.ravel(),
            duration,
            rtol=RELATIVE,
            atol=RELATIVE * near,
        )
        farthest = np.hypot(*places.T)
        while solver.status == "running" and solver.nfev < MOST_EVALUATIONS:
            if solver.step() is not None:
                raise ArithmeticError("the integrator stopped")
            farthest = np.maximum(farthest, np.hypot(*solver.y.reshape(-1, 2).T))
        ends = solver.y.reshape(-1, 2)
        if solver.status != "running":
            return ends, farthest
        paced, most = self._paced(ends, duration - float(solver.t), near)
        return paced, np.maximum(farthest, most)

    def _paced(self, places: Floats, duration: float, near: float) -> tuple[Floats, Floats]:
        """By steps along the velocity at their beginning, each body at its own pace."""
        places, left = places.copy(), np.full(len(places), float(duration))
        farthest = np.hypot(*places.T)
        while (moving := left > 1e-12 * duration).any():
            velocities = self.velocity(places[moving])
            distances = np.hypot(*places[moving].T)
            speeds = np.maximum(np.hypot(*velocities.T), 1e-300)
            part = np.minimum(np.maximum(distances / 50, near / 25) / speeds, left[moving])
            places[moving] += part[:, None] * velocities
            left[moving] -= part
            farthest[moving] = np.maximum(farthest[moving], np.hypot(*places[moving].T))
        return places, farthest

    def end(self, start: Floats, until: float, near: float) -> tuple[Floats, float]:
        """Where one body is after a time, and how far from the origin it was at most."""
        ends, farthest = self.paths(start[None], [until], near)
        return ends[0, 0], float(farthest[0])
