"""No friction forces of a rule without cells balance: proved piece by piece.

A wheel that slips across carries a force on an open half of the unit circle, which is not convex; over all of it a
separating direction sees at least the half disc, and that holds small forces.  So the half circles are cut into arcs,
``rho = 2t/(1 + t^2)``, ``tau = s (1 - t^2)/(1 + t^2)`` for t between two rationals.  Each arc is enclosed by the
triangle of its ends and the point where the tangents there meet, an uncut half circle by a rectangle.  Where the
friction set is cut at kappa (rule ``roller``), tau stops at ``s kappa``, and so does what encloses it.  For every
combination of arcs a direction y is given in which the largest forces of all wheels add up to less than nothing;
wheels that stick reach ``|(y . a, y . b)|``, with a cut at most ``|(y . a, y . b - t)| + kappa |t|`` for any t.  Linear
programs propose y, balls verify it, and where there is none the widest arc is halved.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from itertools import permutations
from typing import TypeAlias

import numpy as np
from flint import arb, ctx

from nonsmooth.proofs.clauses.feedback.wheel_forces import PRECISION, WheelForces, ball_of, on_circle, rounded

BUDGET = 200  # linear programs for one twist
# Of the arcs that are halved: over narrower ones all forces differ by less than the tolerance of the linear programs
# (1e-7), so that a search which came so far without success will have none.
NARROWEST = 2.0**-24
FACETS = 16  # of the polygon around a disc in a linear program
Arc: TypeAlias = tuple[Fraction, Fraction]
HALVES = (Fraction(-1), Fraction(1))


@dataclass(frozen=True)
class Excluded:
    """A direction y in which all forces of these arcs add up to less than nothing."""

    direction: tuple[Fraction, ...]


@dataclass(frozen=True)
class Divided:
    """One wheel's arc is halved, and both halves are excluded."""

    wheel: int
    lower: Exclusion
    upper: Exclusion


Exclusion: TypeAlias = Excluded | Divided


def excludes(exclusion: Exclusion, wheels: Sequence[WheelForces], arcs: Sequence[Arc] | None = None) -> bool:
    """Whether no forces of the arcs balance, exactly; at first the arcs are the whole half circles."""
    ranges = [HALVES] * len(wheels) if arcs is None else list(arcs)
    if isinstance(exclusion, Divided):
        low, high = _halved(ranges, exclusion.wheel)
        return excludes(exclusion.lower, wheels, low) and excludes(exclusion.upper, wheels, high)
    with ctx.workprec(PRECISION):
        y = [ball_of(entry) for entry in exclusion.direction]
        reach = (_most_along(wheel, y, arc) for wheel, arc in zip(wheels, ranges, strict=True))
        return bool(sum(reach, arb(0)) < 0)


def _most_along(wheel: WheelForces, direction: Sequence[arb], arc: Arc) -> arb:
    """A bound of ``y . force`` over the forces of the arc, or of the disc where the wheel sticks."""
    a, b = (sum((x * y for x, y in zip(column, direction, strict=True)), arb(0)) for column in wheel.balls)
    if not wheel.side:
        t = _best_speed(wheel, float(a), float(b))
        return (a * a + (b - t) ** 2).sqrt() + (abs(t) * wheel.cut if wheel.cut is not None else 0)
    return reduce(arb.max, (rho * a + tau * b for rho, tau in border_enclosure(wheel, arc)))


def _best_speed(wheel: WheelForces, a: float, b: float) -> arb:
    """The t of the least bound, about."""
    if wheel.cut is None:
        return arb(0)
    corner = float(wheel.limits.corner)
    return arb(math.copysign(max(0.0, abs(b) - float(wheel.cut) / corner * abs(a)), b))


def border_enclosure(wheel: WheelForces, arc: Arc) -> list[tuple[arb, arb]]:
    """Points ``(rho, tau)`` whose hull holds the forces of an arc; of a cut border the image of what holds the arc."""
    corners = [(ball_of(rho), wheel.side * ball_of(tau)) for rho, tau in enclosure(arc, wheel.side)]
    if wheel.cut is None:
        return [(rho, wheel.side * height) for rho, height in corners]
    cut, points = wheel.cut, []
    for rho, height in corners:
        points += [(rho, height)] if not height > cut else []
        points += [(rho, cut)] if not height < cut else []
    for (rho, low), (far, high) in permutations(corners, 2):
        if low < cut and high > cut:
            points.append((rho + (cut - low) / (high - low) * (far - rho), cut))
    return [(rho, wheel.side * height) for rho, height in points]


def search_exclusion(wheels: Sequence[WheelForces]) -> Exclusion | None:
    """An exclusion of all forces, where the budget finds one."""
    return ExclusionSearch(wheels).exclude([HALVES] * len(wheels)) if wheels else None


class ExclusionSearch:
    """Depth first, with one budget of linear programs."""

    def __init__(self, wheels: Sequence[WheelForces]) -> None:
        self.wheels = wheels
        self.left = BUDGET
        columns = np.array([[[float(x) for x in wheel.along], [float(x) for x in wheel.across]] for wheel in wheels])
        size = np.abs(columns).max(axis=(0, 1))  # moments have another unit than forces
        self.units = [Fraction(float(x)) if x else Fraction(1) for x in size]
        self.columns = columns / np.where(size, size, 1)
        self.sizes = np.linalg.norm(self.columns, axis=(1, 2))

    def exclude(self, arcs: Sequence[Arc]) -> Exclusion | None:
        """The tree below these arcs."""
        if self.left <= 0:
            return None
        self.left -= 1
        leaf = self._leaf(arcs)
        widths = [float(arc[1] - arc[0]) if wheel.side else 0.0 for wheel, arc in zip(self.wheels, arcs, strict=True)]
        wheel = int(np.argmax(self.sizes * widths))
        if leaf is not None or widths[wheel] < NARROWEST:
            return leaf
        low, high = _halved(arcs, wheel)
        lower = self.exclude(low)
        upper = None if lower is None else self.exclude(high)
        return None if lower is None or upper is None else Divided(wheel, lower, upper)

    def _leaf(self, arcs: Sequence[Arc]) -> Excluded | None:
        """Minimize the sum of the largest products with y over the box ``|y| <= 1``."""
        from scipy.optimize import linprog

        rows = []
        for k, arc in enumerate(arcs):
            for rho, tau in self._corners(k, arc):
                force = rho * self.columns[k, 0] + tau * self.columns[k, 1]
                rows.append(np.concatenate([force, -np.eye(len(arcs))[k]]))
        cost = np.concatenate([np.zeros(3), np.ones(len(arcs))])
        bounds = [(-1, 1)] * 3 + [(None, None)] * len(arcs)
        found = linprog(cost, A_ub=np.array(rows), b_ub=np.zeros(len(rows)), bounds=bounds)
        if found.x is None or found.fun >= 0:
            return None
        leaf = Excluded(tuple(rounded(x) / unit for x, unit in zip(found.x[:3], self.units, strict=True)))
        return leaf if excludes(leaf, self.wheels, arcs) else None

    def _corners(self, k: int, arc: Arc) -> Iterator[tuple[float, float]]:
        """A polygon around the forces of a wheel."""
        if self.wheels[k].side:
            yield from ((float(rho), float(tau)) for rho, tau in border_enclosure(self.wheels[k], arc))
        else:
            angles = np.arange(FACETS) * 2 * np.pi / FACETS
            size, cut = 1 / np.cos(np.pi / FACETS), float(self.wheels[k].limits.cut) * np.ones(FACETS)
            heights = np.clip(size * np.sin(angles), -size * cut, size * cut)
            yield from zip(size * np.cos(angles), heights, strict=True)


def enclosure(arc: Arc, side: int) -> tuple[tuple[Fraction, Fraction], ...]:
    """``(rho, tau)`` at the ends of an arc, and where the tangents there meet: the triangle holds the arc."""
    s, t = arc
    if arc == HALVES:  # the tangents are parallel
        return tuple((x, y) for x in HALVES for y in (Fraction(0), Fraction(side)))
    return (*(on_circle(x, side) for x in arc), ((s + t) / (1 + s * t), side * (1 - s * t) / (1 + s * t)))


def _halved(arcs: Sequence[Arc], wheel: int) -> tuple[list[Arc], list[Arc]]:
    low, high = arcs[wheel]
    middle = (low + high) / 2
    return (
        [*arcs[:wheel], (low, middle), *arcs[wheel + 1 :]],
        [*arcs[:wheel], (middle, high), *arcs[wheel + 1 :]],
    )
