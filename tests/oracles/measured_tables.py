"""Tables as they are measured, and small steps of a body on them by the words of the rules: an oracle for its ends.

Nothing here knows of rings, forces that balance, cells or clauses.  A body moves with the twist that its contact rule
names at each place: the rows of the two nearest wheels, or the least of D, whose norms are rounded by far less than
the speeds differ, by Newton's method with a line search on D itself.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Floats: TypeAlias = NDArray[np.float64]

ROUNDINGS = (1e-2, 1e-4, 1e-6)  # of the fastest rim
NEWTON = 60
SETTLED = 1e-11


@dataclass(frozen=True)
class MeasuredTable:
    """Millimetres, whole degrees, speeds in mm/s.

    Attributes:
        rows: x, y, heading and speed of every wheel.
        roll, side: coefficients of friction.
        rule: the contact rule.
    """

    rows: tuple[tuple[int, int, int, float], ...]
    roll: float
    side: float
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
    """A body on a table, from place to place."""

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
        self._twist = np.zeros(3)

    def velocity(self, place: Floats) -> Floats:
        """Of the centre of mass."""
        twist = self._nearest(place) if self.table.rule == "nearest" else self._least(place)
        omega = twist[2] / self.length
        return np.array([twist[0] - omega * place[1], twist[1] + omega * place[0]])

    def _nearest(self, place: Floats) -> Floats:
        """Both rows of the nearest wheel, then rows of the next ones, of larger friction first, while independent."""
        first, *others = np.argsort(((self.places - place) ** 2).sum(axis=1))
        rows, values = [self.along[first], self.across[first]], [self.speeds[first], 0.0]
        for k in others:
            own = [(self.along[k], self.speeds[k]), (self.across[k], 0.0)]
            for row, value in own if self.table.roll >= self.table.side else own[::-1]:
                if abs(np.linalg.det([*rows, row])) > 1e-9:
                    return np.linalg.solve([*rows, row], [*values, value])
        raise ValueError("no three independent rows")

    def _least(self, place: Floats) -> Floats:
        moments = np.column_stack([np.ones(len(self.places)), self.places])
        loads = moments @ np.linalg.solve(moments.T @ moments, np.array([1.0, *place]))
        twist, fastest = self._twist, self.speeds.max()
        for rounding in ROUNDINGS if not twist.any() else ROUNDINGS[-1:]:
            for _ in range(NEWTON):
                value, gradient, slope = self._dissipation(twist, loads, rounding * fastest)
                step = -np.linalg.solve(slope + 1e-12 * np.trace(slope) * np.eye(3), gradient)
                part = 1.0
                while part > 1e-10:
                    ahead, *_ = self._dissipation(twist + part * step, loads, rounding * fastest)
                    if ahead <= value + 1e-4 * part * (gradient @ step):
                        break
                    part /= 2
                twist = twist + part * step
                if np.abs(part * step).max() < SETTLED * fastest:
                    break
        self._twist = twist
        return twist

    def _dissipation(self, twist: Floats, loads: Floats, rounding: float) -> tuple[float, Floats, Floats]:
        """D with its norms rounded, its gradient and its second derivative."""
        a, b = self.table.roll, self.table.side
        r, s = self.along @ twist - self.speeds, self.across @ twist
        if self.table.rule == "ellipse":
            size = np.sqrt((a * r) ** 2 + (b * s) ** 2 + (a * rounding) ** 2)
            value, f, g = size, a * a * r / size, b * b * s / size
            by_r, by_s, mixed = a * a / size - f * f / size, b * b / size - g * g / size, -f * g / size
        else:  # rollers: they stand where the slip along them is small, else they turn against their friction
            w = math.sqrt(a * a - b * b)
            stands = np.abs(s) * w <= b * np.abs(r)
            both, one, other = (np.sqrt(q + rounding**2) for q in (r * r + s * s, r * r, s * s))
            value = np.where(stands, a * both, w * one + b * other)
            f, g = np.where(stands, a * r / both, w * r / one), np.where(stands, a * s / both, b * s / other)
            by_r = np.where(stands, a / both - a * r * r / both**3, w * rounding**2 / one**3)
            by_s = np.where(stands, a / both - a * s * s / both**3, b * rounding**2 / other**3)
            mixed = np.where(stands, -a * r * s / both**3, 0.0)
        gradient = self.along.T @ (loads * f) + self.across.T @ (loads * g)
        cross = (self.along.T * (loads * mixed)) @ self.across
        slope = (self.along.T * (loads * by_r)) @ self.along + (self.across.T * (loads * by_s)) @ self.across
        return float(loads @ value), gradient, slope + cross + cross.T

    def end(self, start: Floats, until: float, near: float) -> tuple[Floats, float]:
        """Where a body is after a time, and how far from the origin it was at most.

        Args:
            start: its place.
            until: the time.
            near: a length that matters; where the field jumps, steps are a small part of it.
        """
        if self.table.rule != "nearest":
            found = solve_ivp(lambda _, y: self.velocity(y), (0, until), start, method="RK23", rtol=1e-5, atol=1e-5)
            return found.y[:, -1], float(np.hypot(*found.y).max())
        place, time, farthest = start.copy(), 0.0, float(np.hypot(*start))
        while time < until * (1 - 1e-12):
            velocity = self.velocity(place)
            distance = float(np.hypot(*place))
            part = min(max(distance / 50, near / 25) / float(np.hypot(*velocity)), until - time)
            place, time, farthest = place + part * velocity, time + part, max(farthest, distance)
        return place, farthest
