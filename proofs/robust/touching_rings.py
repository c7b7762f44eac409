"""Rings about a point on which every body comes nearer, from where they begin to where they end, and how long it takes.

V is the distance, or a function whose level sets are polygons (:mod:`nonsmooth.proofs.robust.level_sets`).  On each
ring ``inner <= V <= outer`` let ``V' <= -kappa`` for every velocity that is possible there;
with exact kinematics too.  So bodies that start in the largest level set come to the smallest one, in the time that is
the sum of (outer - inner)/kappa, and do not leave it.

One rate for all rings would make that time many times too long: near a place of rest bodies are slow.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from fractions import Fraction
from functools import cache

import numpy as np
from flint import fmpq

from nonsmooth.proofs.boxes.balanced_forces import BalancedForces
from nonsmooth.proofs.boxes.intervals import TINY, Intervals
from nonsmooth.proofs.robust.level_sets import Distance, LevelFunction, RingPieces, short_levels
from nonsmooth.proofs.robust.rings import TouchingRings, root_above, squared_radius
from nonsmooth.symbolic.mechanics.friction_set import Box
from nonsmooth.symbolic.mechanics.scene import Scene, Tolerance
from nonsmooth.symbolic.messages.under_way import tell
from nonsmooth.symbolic.numbers.coefficients import as_fraction
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Mask, cross, finite_rows, norms, row_products

RATIO = 0.8  # of the levels of one ring
AT_ONCE = 6  # rings
FIRST_PIECES = (32, 128, 512)  # of many, looked at before others: where one fails, the others need no look
FINER = (2, 4)  # parts of each side of a ring that is not shown in one
FINEST = (8, 16)  # the same beside an edge of the field, over which a body's twist turns round
SMALLEST = 2.0**-22  # of the outermost radius
SHARES = (0.25, 0.5, 0.12, 0.9)  # of the pull inward that the body feels, tried one after the other
PUSHES = (0.6, 0.3, 0.1, 0.03)  # of the friction of all wheels, where what pulls inward is not smooth
SLOW = 2.0**-24  # of the fastest wheel: speeds that are not looked at, where floats do not tell a circle from a spiral
ENOUGH = 0.5  # of the speed inward that is seen: with less, other strengths are tried
RATES = 48  # values of kappa that are tried under rule nearest


def rings_about(
    scene: Scene,
    most: float,
    through: float,
    least: float,
    shape: LevelFunction | None = None,
    finer: Sequence[int] = FINER,
    useful: Fraction | None = None,
) -> TouchingRings | None:
    """Rings about the origin of a centred scene; None where there is none through a radius.

    Args:
        scene: centred; with known loads, where its rule needs loads.
        most: the largest disc of starts that is looked for.
        through: a disc of starts that is needed; the search begins at its border, outward and inward.
        least: a smaller disc of ends than this is not looked for.
        shape: V, where the rule has loads; the distance where none is given.
        finer: into how many parts each side of a ring is divided that is not shown in one.
        useful: where bodies only end in a larger disc than this, starts farther out are not looked for.
    """
    if scene.contact.rule == "nearest":
        from nonsmooth.proofs.robust.nearest import why_not_nearest

        return None if why_not_nearest(scene) else _of_cells(scene, most)
    return _of_forces(scene, most, through, least, shape or Distance(), finer, useful)


def no_tolerance(scene: Scene) -> Tolerance:
    """The box of width zero, or of what was rounded."""
    zero = scene.field.zero
    return Tolerance(zero, Fraction(0), zero, zero, zero, zero)


# ---- rule nearest --------------------------------------------------------------------------------


def _of_cells(scene: Scene, most: float) -> TouchingRings | None:
    """The rates of all cells at once: for each kappa the distance beyond which every body falls that fast.

    It grows with kappa; so the largest kappa that does within the limit is found by bisection.
    """
    from nonsmooth.proofs.robust.nearest import bounded_cells

    edge = fmpq(*Fraction(most).as_integer_ratio())
    cells = bounded_cells(scene, no_tolerance(scene), edge)
    fastest = scene.fastest
    limit = Fraction(most)
    kappas = [fmpq(*Fraction(2 * fastest * k / RATES).as_integer_ratio()) for k in range(1, RATES + 1)]
    kappas = [kappas[0] * fmpq(1, 64), *kappas]

    @cache
    def radius(k: int) -> Fraction:
        return root_above(as_fraction(squared_radius(cells, kappas[k])))

    within = bisect_left(range(len(kappas)), True, key=lambda k: radius(k) >= limit)
    rings: list[int] = []
    for k in reversed(range(within)):
        if not rings or radius(k) < radius(rings[-1]):
            rings.append(k)
    return (
        TouchingRings(limit, tuple(map(radius, rings)), tuple(as_fraction(kappas[k]) for k in rings)) if rings else None
    )


# ---- rules with loads ----------------------------------------------------------------------------


def _of_forces(
    scene: Scene,
    most: float,
    through: float,
    least: float,
    shape: LevelFunction,
    finer: Sequence[int],
    useful: Fraction | None,
) -> TouchingRings | None:
    """From the ring in the middle inward, then outward if bodies come far enough inward, until one fails."""
    forces = BalancedForces.of(scene)
    if forces is None:
        return None
    outward = max(int(np.ceil(np.log(most / through) / -np.log(RATIO))), 1)
    edges = short_levels(most / shape.inside * np.power(RATIO, np.arange(outward + 200, dtype=np.float64)))
    edges = edges[edges > max(SMALLEST * most / shape.inside, least / shape.outside * RATIO)]
    first = min(outward - 1, len(edges) - 2)
    rates: dict[int, float] = {}
    for begin, step, count in ((first, 1, 1), (first + 1, 1, AT_ONCE), (first - 1, -1, AT_ONCE)):
        k = begin
        inward = _joined(shape, edges, rates, first) if step < 0 else None
        if inward is not None and useful is not None and inward.radius > useful:
            return inward
        while 0 <= k < len(edges) - 1:
            chosen = [j for j in range(k, k + step * count, step) if 0 <= j < len(edges) - 1]
            kappas = ring_rates(forces, shape.pieces(edges[np.array(chosen) + 1], edges[chosen]))
            failed = next((j for j, rate in enumerate(kappas) if rate <= 0), None)
            if failed is not None:
                inner, outer = edges[chosen[failed] + 1], edges[chosen[failed]]
                kappas = [*kappas[:failed], finer_rate(forces, shape, inner, outer, finer)]
            rates |= dict(zip(chosen, kappas, strict=False))
            if kappas[-1] <= 0 or begin == first:
                break
            k += step * len(kappas)
        if rates[first] <= 0:
            return None
    return _joined(shape, edges, rates, first)


def finer_rate(
    forces: BalancedForces,
    shape: LevelFunction,
    inner: float,
    outer: float,
    finer: Sequence[int] = FINER,
    *,
    turned: bool = False,
) -> float:
    """The same for one ring of smaller and smaller pieces, of V or of -V; zero where none is shown."""
    for parts in finer:
        levels = short_levels(np.geomspace(outer, inner, parts + 1))
        levels[[0, -1]] = outer, inner
        pieces = shape.pieces(levels[1:], levels[:-1], parts)
        rate = least_rate(forces, pieces.turned if turned else pieces)
        if rate > 0 or rate == -np.inf:
            return max(rate, 0.0)
    return 0.0


def _joined(shape: LevelFunction, edges: Floats, rates: dict[int, float], first: int) -> TouchingRings | None:
    """The rings about the first one that touch."""
    low = high = first
    if rates.get(first, 0.0) <= 0:
        return None
    while rates.get(low - 1, 0.0) > 0:
        low -= 1
    while rates.get(high + 1, 0.0) > 0:
        high += 1
    indices = range(low, high + 1)
    return TouchingRings(
        Fraction(float(edges[low])),
        tuple(Fraction(float(edges[k + 1])) for k in indices),
        tuple(Fraction(rates[k]) for k in indices),
        Fraction(shape.inside),
        Fraction(shape.outside),
    )


def ring_rates(forces: BalancedForces, pieces: RingPieces) -> list[float]:
    """For each ring a kappa with ``V' <= -kappa`` on it; zero where none is shown, minus infinity where V rises.

    Args:
        forces: of the array.
        pieces: of the rings.
    """
    free, estimates, falls = _falls_seen(forces, pieces)
    nearer = falls.reshape(-1, pieces.per_ring).all(axis=1)
    kappas = np.full(len(pieces.corners), -np.inf)
    indices = np.flatnonzero(np.repeat(nearer, pieces.per_ring))
    if len(indices):
        kappas[indices] = np.maximum(piece_rates(forces, pieces.at(indices), free[indices], estimates[indices]), 0.0)
    return kappas.reshape(-1, pieces.per_ring).min(axis=1).tolist()


def least_rate(forces: BalancedForces, pieces: RingPieces) -> float:
    """The same on all of them, with pulls of more strengths; pieces on which V falls slowly are looked at first."""
    free, estimates, falls = _falls_seen(forces, pieces)
    if not falls.all():
        return -np.inf
    rate = np.inf
    for chosen in np.split(np.argsort(estimates), FIRST_PIECES):
        if len(chosen):
            kappas = piece_rates(forces, pieces.at(chosen), free[chosen], estimates[chosen], more=True)
            rate = min(rate, float(kappas.min()))
            if rate <= 0:
                return 0.0
    return rate


def falls_about(forces: BalancedForces, pieces: RingPieces, free: Floats) -> Floats:
    """About ``-V'`` in the middle of each quadrangle, times its size, from the minimizers there."""
    slopes, places = pieces.middle_slopes, pieces.middles
    moments = cross(places, slopes)
    return -row_products(slopes, free[:, :2]) - moments * free[:, 2] / forces.length


def _falls_seen(forces: BalancedForces, pieces: RingPieces) -> tuple[Floats, Floats, Mask]:
    """In the middle of each quadrangle the minimizer, ``-V'`` in floats, and whether that is positive."""
    free = forces.minimizers(pieces.middles)
    slopes, falls = pieces.middle_slopes, falls_about(forces, pieces, free)
    sizes = pieces.sizes.mean(axis=1)
    return free, falls / sizes, falls / sizes > SLOW * forces.fastest * norms(slopes) / sizes


def piece_rates(
    forces: BalancedForces, pieces: RingPieces, free: Floats, estimates: Floats, *, more: bool = False
) -> Floats:
    """A kappa that pulls of several strengths show on each quadrangle; minus infinity where none does.

    Args:
        forces: of the array.
        pieces: the quadrangles.
        free: about the minimizer in the middle of each.
        estimates: of ``-V'`` there; what is shown of it suffices where it is :data:`ENOUGH` of that.
        more: whether pulls are tried too that slow the body by shares of that.
    """
    best = np.full(len(pieces.corners), -np.inf)
    strengths = _strengths(forces, pieces)
    if more and not isinstance(forces.sets, Box):
        strengths += _slowing(forces, pieces, free, estimates)
    for every in strengths:
        indices = np.flatnonzero(best < ENOUGH * estimates)
        if not len(indices):
            break
        tell(f"{len(indices)} pieces left")
        chosen, some = every[indices], pieces.at(indices)
        strength = Intervals.of(chosen[:, None])
        pulls = forces.covector(strength * some.slopes[0], strength * some.slopes[1], strength * some.moments)
        middle = np.stack([pull.middle for pull in pulls], axis=-1).reshape(-1, 3)
        against = forces.against(some.corners.reshape(-1, 2), middle)
        powers = forces.powers(some.corners, pulls, against.forces, free[indices])
        with np.errstate(invalid="ignore"):
            rates = -powers / (chosen[:, None] * some.sizes) * (1 - 2.0**-40)
        rates = np.where(finite_rows(rates), rates.min(axis=1), -np.inf)
        best[indices] = np.fmax(best[indices], rates)
    return best


def _strengths(forces: BalancedForces, pieces: RingPieces) -> list[Floats]:
    """Values of lambda for each quadrangle."""
    slopes = pieces.middle_slopes
    sizes, total = norms(slopes), _friction(forces, pieces)
    against = forces.pulls_at_rest(pieces.middles, slopes)
    smooth = [share * against / sizes for share in SHARES]
    rough = [share * total / sizes for share in PUSHES]
    return [np.where(a > 0, np.minimum(a, b * 1e3), b) for a, b in zip(smooth, rough, strict=True)]


def _slowing(forces: BalancedForces, pieces: RingPieces, free: Floats, estimates: Floats) -> list[Floats]:
    """Those that slow the body by shares of ``-V'``, where the friction of a body at rest does not tell its motion."""
    slopes = pieces.middle_slopes
    most = _friction(forces, pieces) / norms(slopes)
    yields = forces.compliance(pieces.middles, slopes, free)
    strength = np.minimum(estimates * pieces.sizes.mean(axis=1) / np.maximum(yields, TINY), most)
    return [share * strength for share in SHARES]


def _friction(forces: BalancedForces, pieces: RingPieces) -> Floats:
    """The largest friction of all wheels together, in the middle of each quadrangle."""
    loads = forces.float_loads(pieces.middles)
    return row_products(loads, forces.largest_friction)
