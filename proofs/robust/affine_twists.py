"""The twist all over a small polygon, enclosed to first order: an affine function of the place, and a small rest.

Where D bends in every direction its gradient G in the twist has one zero ``xi(c)``.  With a twist ``xi_0`` near it at
the middle m of a polygon, loads that are affine in c, and Y about the inverse of the Hessian of D ::

    xi(c) = xi_0 - Y G(xi_0, m) - Y dG/dc(xi_0) (c - m) + (1 - Y B)(xi(c) - xi_0),

where B is a mean of the (generalized) Hessians of ``D(., c)`` between ``xi_0`` and ``xi(c)``: G is Lipschitz, also
where arcs and corners of friction sets meet, as long as no wheel may stick.  The middle two terms are known to
rounding.  Where the right side maps a box X of twists into its own inside, for every c of the polygon and every B of
the box, it holds exactly one zero of G for each c (Krawczyk), and so, D being convex, the only minimizer of D; the last
term then is of second order in the size of the polygon.

A bound of V' by it misses the truth by that much, while one by forces that balance a pull misses it by first order.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.proofs.boxes.balanced_forces import TINY, BalancedForces
from nonsmooth.proofs.boxes.intervals import Intervals
from nonsmooth.proofs.robust.level_sets import RingPieces
from nonsmooth.symbolic.mechanics.friction_set import Box

Floats: TypeAlias = NDArray[np.float64]

GROWTH = 1.25  # of the first box of twists, over what changes to first order
SHRINKINGS = 2  # of that box, to its image
MOST_HALVINGS = 10  # of a quadrangle
HELD = 2.0**-16  # of the fastest rim: a slip so slow is taken for none
MOST_PIECES = 2**16  # that are left after some of them
AT_ONCE = 2**20  # numbers of one array, about


def refined_rates(forces: BalancedForces, pieces: RingPieces) -> list[float]:
    """For each ring a kappa with ``V' <= -kappa`` on it, by quadrangles halved until twists are enclosed; else zero."""
    rates, owners = np.full(len(pieces.corners), np.inf), np.arange(len(pieces.corners))
    left, free = pieces, forces.minimizers(pieces.middles)
    for _ in range(MOST_HALVINGS + 1):
        shown = affine_rates(forces, left, free)
        hopeless = ~(_seen(forces, left, free) > 0) | _sticks(forces, free)
        lost = np.unique(owners[(shown <= 0) & hopeless])
        rates[lost] = 0.0
        np.minimum.at(rates, owners[shown > 0], shown[shown > 0])
        again = np.flatnonzero((shown <= 0) & ~np.isin(owners, lost))
        if len(lost):  # its ring is not shown: nothing is said of the others that are not through
            rates[owners[again]] = 0.0
            break
        if not len(again):
            break
        left, is_exact = left.at(again).halves
        free = forces.minimizers(left.middles)
        owners = np.tile(owners[again], 2)
        if not is_exact.all() or len(owners) > MOST_PIECES:
            rates[owners] = 0.0
            break
    else:
        rates[owners] = 0.0
    return rates.reshape(-1, pieces.per_ring).min(axis=1).tolist()


def _seen(forces: BalancedForces, pieces: RingPieces, free: Floats) -> Floats:
    """About ``-V'`` in the middle of each quadrangle, times its size."""
    slopes, places = pieces.middle_slopes, pieces.middles
    moments = slopes[:, 1] * places[:, 0] - slopes[:, 0] * places[:, 1]
    return np.asarray(-(slopes * free[:, :2]).sum(axis=1) - moments * free[:, 2] / forces.length)


def _sticks(forces: BalancedForces, free: Floats) -> NDArray[np.bool_]:
    """Whether a wheel seems not to slip, or its rim not to while its rollers turn: there D has an edge."""
    along, across = (np.abs(slip) < HELD * forces.fastest for slip in forces.slips(free))
    return np.asarray((along & (across | (forces.sets.cut < 1))).any(axis=1))


def affine_rates(forces: BalancedForces, pieces: RingPieces, free: Floats) -> Floats:
    """A kappa with ``V' <= -kappa`` on each quadrangle, (pieces,); minus infinity where no twist is enclosed.

    Args:
        forces: of the array.
        pieces: the quadrangles.
        free: about the minimizer in the middle of each, (pieces, 3).
    """
    if isinstance(forces.sets, Box):  # D does not bend
        return np.full(len(pieces.corners), -np.inf)
    count = max(AT_ONCE // (16 * len(forces.sets.along)), 1)
    parts = [np.arange(k, min(k + count, len(free))) for k in range(0, len(free), count)]
    with np.errstate(all="ignore"):  # what is not a number encloses nothing
        return np.concatenate([_rates(forces, pieces.at(part), free[part]) for part in parts])


def _rates(forces: BalancedForces, pieces: RingPieces, free: Floats) -> Floats:
    found = _affine_twists(forces, pieces, free)
    if found is None:
        return np.full(len(pieces.corners), -np.inf)
    middle, by_place, rest, is_enclosed = found
    away = [Intervals.of(pieces.corners[:, :, k]) - Intervals.of(pieces.middles[:, None, k]) for k in range(2)]
    covector = (*pieces.slopes, pieces.moments * Intervals.of(1 / forces.length).widened)
    rises, bends = Intervals.of(0.0), Intervals.of(0.0)
    for k, along in enumerate(covector):
        affine = middle[:, None, k] + by_place[:, None, k, 0] * away[0] + by_place[:, None, k, 1] * away[1]
        rises = rises + along * (affine + rest[:, None, k])
        # the mean of products of two affine functions is that of the means, but for a quarter of both ranges
        bends = bends + _range(along) * _range(affine) * Intervals.of(0.25)
    rates = (-(rises + bends[:, None]).high / pieces.sizes).min(axis=1) * (1 - 2.0**-40)
    return np.where(is_enclosed & (rates > 0) & np.isfinite(rates), rates, -np.inf)


def _range(values: Intervals) -> Intervals:
    """An upper bound of the range over the corners of each piece, (pieces,)."""
    return Intervals.of(values.high.max(axis=1)) - Intervals.of(values.low.min(axis=1))


def _affine_twists(
    forces: BalancedForces, pieces: RingPieces, free: Floats
) -> tuple[Intervals, Intervals, Intervals, NDArray[np.bool_]] | None:
    """``xi_0``, ``-Y dG/dc``, the rest, by pieces (n, 3), (n, 3, 2), (n, 3), and where they enclose; None nowhere."""
    places = pieces.middles
    slopes = forces.hessians(places, free)
    inverse = np.full_like(slopes, np.nan)
    regular = np.abs(np.linalg.det(slopes)) > 0
    inverse[regular] = np.linalg.inv(slopes[regular])
    start = Intervals.of(free)
    slips = _slips(forces, start)
    forms, (one, by_x, by_y) = forces.forms, forces.forms
    pull = _pull(forces, slips)
    loads = one + by_x * Intervals.of(places[:, :1]) + by_y * Intervals.of(places[:, 1:])
    off = -_times(inverse, _weighed(loads, pull))
    columns = [-_times(inverse, _weighed(form, pull)) for form in forms[1:]]
    by_place = Intervals(*(np.stack([getattr(column, end) for column in columns], axis=-1) for end in ("low", "high")))
    reach = [np.abs(pieces.corners[:, :, k] - places[:, None, k]).max(axis=1) * (1 + 2.0**-40) for k in range(2)]
    sides = [Intervals(-size, size)[:, None] for size in reach]
    change = off + by_place[:, :, 0] * sides[0] + by_place[:, :, 1] * sides[1]
    size = GROWTH * np.maximum(np.abs(change.low), np.abs(change.high)) + TINY
    size = size + 2.0**-8 * size.max(axis=1, keepdims=True)
    over = one + by_x * (Intervals.of(places[:, :1]) + sides[0]) + by_y * (Intervals.of(places[:, 1:]) + sides[1])
    is_enclosed: NDArray[np.bool_] = np.asarray((over.low >= 0).all(axis=1))
    box, rest = Intervals(-size, size), off
    for shrinking in range(SHRINKINGS):
        left = _contraction(forces, inverse, _slips(forces, start + box), over)
        rest = off + (left * box[:, None, :]).sum(axis=2)
        image = rest + by_place[:, :, 0] * sides[0] + by_place[:, :, 1] * sides[1]
        if not shrinking:
            is_enclosed &= ((image.low > box.low) & (image.high < box.high)).all(axis=1)
            if not is_enclosed.any():
                return None
        # B belongs to the way from xi_0 to xi(c): the box holds both ends
        low, high = np.maximum(image.low, box.low), np.minimum(image.high, box.high)
        box = Intervals(np.minimum(low, 0.0), np.maximum(high, 0.0))
    return start, by_place, rest, is_enclosed


def _slips(forces: BalancedForces, twists: Intervals) -> tuple[Intervals, Intervals]:
    """(n, wheels) each, of twists (n, 3)."""
    r, s = (
        row[0] * twists[:, 0:1] + row[1] * twists[:, 1:2] + row[2] * twists[:, 2:3] - speed
        for row, speed in zip(forces.rows, forces.speeds, strict=True)
    )
    return r, s


def _pull(forces: BalancedForces, slips: tuple[Intervals, Intervals]) -> list[Intervals]:
    """The gradient of D by the twist, per unit of load of each wheel; three of (n, wheels)."""
    f, g = forces.enclosed_sets.gradient(*slips)
    return [f * a + g * b for a, b in zip(*forces.rows, strict=True)]


def _weighed(loads: Intervals, parts: list[Intervals]) -> Intervals:
    """The sums over all wheels, (n, parts)."""
    sums = [(loads * part).sum(axis=1) for part in parts]
    return Intervals(*(np.stack([getattr(each, end) for each in sums], axis=-1) for end in ("low", "high")))


def _contraction(
    forces: BalancedForces, inverse: Floats, slips: tuple[Intervals, Intervals], loads: Intervals
) -> Intervals:
    """``1 - Y B`` for all Hessians B of D over some slips and loads, (n, 3, 3)."""
    r, s = slips
    bend, w = loads * forces.enclosed_sets.bend(r, s), [s * a - r * b for a, b in zip(*forces.rows, strict=True)]
    entries = _weighed(bend, [w[i] * w[j] if i != j else w[i].square for i in range(3) for j in range(3)])
    hessian = Intervals(entries.low.reshape(-1, 3, 3), entries.high.reshape(-1, 3, 3))
    columns = [-_times(inverse, hessian[:, :, j]) for j in range(3)]
    product = Intervals(*(np.stack([getattr(each, end) for each in columns], axis=-1) for end in ("low", "high")))
    return product + Intervals.of(np.eye(3))


def _times(matrices: Floats, vectors: Intervals) -> Intervals:
    """The products of matrices (n, 3, 3) and vectors (n, 3)."""
    return (Intervals.of(matrices) * vectors[:, None, :]).sum(axis=2)
