"""Rings about a point on which every body comes nearer, from where they begin to where they end, and how long it takes.

On each ring ``inner <= |c| <= outer`` let ``c . v <= -kappa |c|`` for every velocity that is possible there, of every
array of the box.  ``(c . c)' = 2 c . v``, also with exact kinematics, since ``c . J c = 0``.  So bodies that start in
the largest disc come to the smallest one, in the time that is the sum of (outer - inner)/kappa, and do not leave it.

One rate for all rings would make that time many times too long: near a place of rest bodies are slow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from flint import fmpq
from numpy.typing import NDArray

from nonsmooth.proofs.robust.balanced_forces import BalancedForces, Quadrangles
from nonsmooth.proofs.robust.intervals import Intervals
from nonsmooth.proofs.robust.nearest import bounded_cells, why_not_nearest
from nonsmooth.proofs.robust.ultimate_bound import root_above, squared_radius
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.tolerances import Tolerance
from nonsmooth.symbolic.unknown_loads import UnknownLoads

Floats: TypeAlias = NDArray[np.float64]

SECTORS = 24  # quadrangles of each ring
RATIO = 0.8  # of the radii of one ring
AT_ONCE = 6  # rings
SMALLEST = 2.0**-22  # of the outermost radius
SHARES = (0.25, 0.5, 0.12, 0.9)  # of the pull inward that the body feels, tried one after the other
PUSHES = (0.6, 0.3, 0.1, 0.03)  # of the friction of all wheels, where what pulls inward is not smooth
STILL = 2.0**-20  # of the fastest wheel
ENOUGH = 0.5  # of the speed inward that is seen: with less, other strengths are tried
RATES = 48  # values of kappa that are tried under rule nearest


@dataclass(frozen=True)
class TouchingRings:
    """Rings that touch, from the largest inward.

    Attributes:
        start: outer radius of the first (length).
        inner: inner radius of each (length).
        rates: kappa on each (length/time).
    """

    start: Fraction
    inner: tuple[Fraction, ...]
    rates: tuple[Fraction, ...]

    @property
    def radius(self) -> Fraction:
        """Of the disc in which every body ends."""
        return self.inner[-1]

    def time_to(self, radius: Fraction, start: Fraction | None = None) -> Fraction:
        """After which every body from within ``start`` is within a radius that is not below :attr:`radius`."""
        outer, total = self.start, Fraction(0)
        most = self.start if start is None else start
        for inner, rate in zip(self.inner, self.rates, strict=True):
            width = min(outer, most) - max(inner, radius)
            total += max(width, Fraction(0)) / rate
            outer = inner
        return total


def rings_about(scene: Scene, box: Tolerance | None, most: float, through: float, least: float) -> TouchingRings | None:
    """Rings about the origin of a centred scene; None where there is none through a radius.

    Args:
        scene: centred; with known loads, where its rule needs loads.
        box: tolerances, under rule ``nearest`` alone.
        most: the largest radius that is looked at.
        through: a radius on the ring at which the search begins, outward and inward.
        least: a smaller disc than this is not looked for.
    """
    if scene.contact.rule == "nearest":
        return None if why_not_nearest(scene) else _of_cells(scene, box or no_tolerance(scene), most)
    if isinstance(scene.contact.loads, UnknownLoads):
        return None
    return _of_forces(scene, most, through, least)


def no_tolerance(scene: Scene) -> Tolerance:
    """The box of width zero, or of what was rounded."""
    zero = scene.field.zero
    return Tolerance(zero, Fraction(0), zero, zero, zero, zero)


# ---- rule nearest --------------------------------------------------------------------------------


def _of_cells(scene: Scene, box: Tolerance, most: float) -> TouchingRings | None:
    """The rates of all cells at once: for each kappa the distance beyond which every body falls that fast."""
    edge = fmpq(*Fraction(most).as_integer_ratio())
    cells = bounded_cells(scene, box, edge)
    fastest = max(abs(float(wheel.speed)) for wheel in scene.wheels)
    limit = Fraction(most)
    reached: list[Fraction] = []
    found: list[Fraction] = []
    least = fmpq(0)
    for k in range(RATES, -1, -1):
        kappa = fmpq(*Fraction(2 * fastest * k / RATES).as_integer_ratio()) if k else least
        radius = root_above(_fraction(squared_radius(cells, kappa)))
        if not k:
            continue
        least = kappa * fmpq(1, 64)
        if radius < limit and (not reached or radius < reached[-1]):
            reached.append(radius)
            found.append(_fraction(kappa))
    last = root_above(_fraction(squared_radius(cells, least)))
    if last < (reached[-1] if reached else limit):
        reached.append(last)
        found.append(_fraction(least))
    return TouchingRings(limit, tuple(reached), tuple(found)) if reached else None


def _fraction(value: fmpq) -> Fraction:
    return Fraction(int(value.p), int(value.q))


# ---- rules with loads ----------------------------------------------------------------------------


def _of_forces(scene: Scene, most: float, through: float, least: float) -> TouchingRings | None:
    """Outward from the ring in the middle, then inward, until one fails."""
    try:
        forces = BalancedForces(scene)
    except ArithmeticError:
        return None
    outward = max(int(np.ceil(np.log(most / through) / -np.log(RATIO))), 1)
    edges: Floats = most * np.power(RATIO, np.arange(outward + 200, dtype=np.float64))
    edges = edges[edges > max(SMALLEST * most, least * RATIO)]
    first = min(outward - 1, len(edges) - 2)
    rates: dict[int, float] = {}
    for begin, step, count in ((first, 1, 1), (first + 1, 1, AT_ONCE), (first - 1, -1, AT_ONCE)):
        k = begin
        while 0 <= k < len(edges) - 1:
            chosen = [j for j in range(k, k + step * count, step) if 0 <= j < len(edges) - 1]
            shown = ring_rates(forces, edges[np.array(chosen) + 1], edges[chosen])
            rates |= dict(zip(chosen, shown, strict=True))
            if min(shown) <= 0 or begin == first:
                break
            k += step * count
        if not rates[first]:
            return None
    return _joined(edges, rates, first)


def _joined(edges: Floats, rates: dict[int, float], first: int) -> TouchingRings | None:
    """The rings about the first one that touch."""
    low = high = first
    if rates.get(first, 0.0) <= 0:
        return None
    while rates.get(low - 1, 0.0) > 0:
        low -= 1
    while rates.get(high + 1, 0.0) > 0:
        high += 1
    kept = range(low, high + 1)
    return TouchingRings(
        Fraction(float(edges[low])),
        tuple(Fraction(float(edges[k + 1])) for k in kept),
        tuple(Fraction(rates[k]) for k in kept),
    )


def ring_rates(forces: BalancedForces, inner: Floats, outer: Floats) -> list[float]:
    """For each ring a kappa with ``c . v <= -kappa |c|`` on it; zero where none is shown."""
    corners = Quadrangles.of_rings(inner, outer, SECTORS).corners
    middles = corners.mean(axis=1)
    free = forces.minimizers(middles, np.zeros((len(middles), 3)))
    seen = -(middles * free[:, :2]).sum(axis=1) / np.hypot(middles[:, 0], middles[:, 1])
    # under rule box a body that rests seems to creep, by the width over which edges are rounded
    least = STILL * forces.fastest if forces.shape.is_box else 0.0
    falls = (seen.reshape(-1, SECTORS) > least).all(axis=1)
    shown = np.zeros(len(corners))
    kept = np.flatnonzero(np.repeat(falls, SECTORS))
    if len(kept):
        shown[kept] = piece_rates(forces, corners[kept], free[kept], seen[kept])
    return np.maximum(shown.reshape(-1, SECTORS).min(axis=1), 0.0).tolist()


def piece_rates(forces: BalancedForces, corners: Floats, free: Floats, seen: Floats) -> Floats:
    """A kappa that pulls of several strengths show on each quadrangle; minus infinity where none does.

    Args:
        forces: of the array.
        corners: (pieces, 4, 2).
        free: about the minimizer in the middle of each.
        seen: about its speed inward; what is shown of it suffices where it is :data:`ENOUGH` of that.
    """
    best = np.full(len(corners), -np.inf)
    for every in _strengths(forces, corners.mean(axis=1)):
        left = np.flatnonzero(best < ENOUGH * seen)
        if not len(left):
            break
        strengths, places = every[left], corners[left].reshape(-1, 2)
        pulls = np.zeros((len(places), 3))
        pulls[:, :2] = np.repeat(strengths, 4)[:, None] * places
        pushed = forces.minimizers(places, pulls, np.repeat(free[left], 4, axis=0)).reshape(-1, 4, 3)
        strength, (x, y) = Intervals.of(strengths[:, None]), (Intervals.of(corners[left, :, k]) for k in range(2))
        shown = forces.powers(corners[left], (strength * x, strength * y, Intervals.of(0.0)), pushed, free[left])
        sizes = np.hypot(corners[left, :, 0], corners[left, :, 1])
        with np.errstate(invalid="ignore"):
            rates = -shown / (strengths[:, None] * sizes) * (1 - 2.0**-40)
        rates = np.where(np.isfinite(rates).all(axis=1), rates.min(axis=1), -np.inf)
        best[left] = np.fmax(best[left], rates)
    return best


def _strengths(forces: BalancedForces, middles: Floats) -> Sequence[Floats]:
    """Values of lambda for each quadrangle."""
    distances = np.hypot(middles[:, 0], middles[:, 1])
    loads = forces.float_loads(middles)
    total = (loads * np.maximum(forces.shape.roll, forces.shape.side)).sum(axis=1)
    inward = forces.pulls_at_rest(middles)
    smooth = [share * inward / distances for share in SHARES]
    rough = [share * total / distances for share in PUSHES]
    return [np.where(a > 0, np.minimum(a, b * 1e3), b) for a, b in zip(smooth, rough, strict=True)]
