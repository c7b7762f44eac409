"""Bodies that are carried away from a place of rest under a rule without cells, farther than a distance.

Over a disc about an enclosed place of rest (:mod:`nonsmooth.proofs.boxes.enclosed_rest`)
``c' = A(c) (c - c_0)``, A in the hull of its values there; Krawczyk's operator encloses the twist all over the disc.

Let V be linear on sectors (:mod:`nonsmooth.proofs.robust.level_sets`), and rise along every motion where it is
positive: in the disc by A, at the two rays of each sector, and on rings around it, up to a polygon that holds the disc
of radius a.  Then each body that starts where V is positive, as near as one likes, leaves that polygon (Chetaev).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise, product

import numpy as np
from flint import arb, arb_mat, ctx

from nonsmooth.proofs.boxes.balanced_forces import TINY, BalancedForces
from nonsmooth.proofs.boxes.enclosed_rest import (
    PRECISION,
    EnclosedRest,
    enclosed_motion,
    enclosed_rest,
    unknowns_at_rest,
)
from nonsmooth.proofs.boxes.enclosures import UNIT
from nonsmooth.proofs.boxes.intervals import Intervals
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.robust.level_sets import (
    VERTICES,
    RingPieces,
    SectorFunction,
    lyapunov_matrix,
    short_levels,
    short_vertices,
)
from nonsmooth.proofs.robust.touching_rings import RATIO, falls_about, finer_rate, ring_rates
from nonsmooth.symbolic.mechanics.friction_set import Box
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.coefficients import rational_ball
from nonsmooth.symbolic.numbers.enclosures import rational_above, rational_below
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Mask, even_angles, max_norms

# ---- the twist all over a small polygon ----------------------------------------------------------
#
# Enclosed to first order: an affine function of the place, and a small rest.
#
# Where D bends in every direction its gradient G in the twist has one zero ``xi(c)``.  With a twist ``xi_0`` near it at
# the middle m of a polygon, loads that are affine in c, and Y about the inverse of the Hessian of D ::
#
#     xi(c) = xi_0 - Y G(xi_0, m) - Y dG/dc(xi_0) (c - m) + (1 - Y B)(xi(c) - xi_0),
#
# where B is a mean of the (generalized) Hessians of ``D(., c)`` between ``xi_0`` and ``xi(c)``: G is Lipschitz, also
# where arcs and corners of friction sets meet, as long as no wheel may stick.  The middle two terms are known to
# rounding.  Where the right side maps a box X of twists into its own inside, for every c of the polygon and every B of
# the box, it holds exactly one zero of G for each c (Krawczyk), and so, D being convex, the only minimizer of D; the
# last term then is of second order in the size of the polygon.
#
# A bound of V' by it misses the truth by that much, while one by forces that balance a pull misses it by first order.


GROWTH = 1.25  # of the first box of twists, over what changes to first order
SHRINKINGS = 2  # of that box, to its image
MOST_HALVINGS = 10  # of a quadrangle
HELD = 2.0**-16  # of the fastest rim: a slip so slow is taken for none
MOST_PIECES = 2**16  # that are left after some of them
AT_ONCE = 2**20  # numbers of one array, about


def refined_rates(forces: BalancedForces, pieces: RingPieces) -> list[float]:
    """For each ring a kappa with ``V' <= -kappa`` on it, by quadrangles halved until twists are enclosed; else zero."""
    rates, owners = np.full(len(pieces.corners), np.inf), np.arange(len(pieces.corners))
    quadrangles, free = pieces, forces.minimizers(pieces.middles)
    for _ in range(MOST_HALVINGS + 1):
        kappas = affine_rates(forces, quadrangles, free)
        hopeless = ~(falls_about(forces, quadrangles, free) > 0) | _sticks(forces, free)
        lost = np.unique(owners[(kappas <= 0) & hopeless])
        rates[lost] = 0.0
        np.minimum.at(rates, owners[kappas > 0], kappas[kappas > 0])
        again = np.flatnonzero((kappas <= 0) & ~np.isin(owners, lost))
        if len(lost):  # its ring is not shown: nothing is said of the others that are not through
            rates[owners[again]] = 0.0
            break
        if not len(again):
            break
        quadrangles, is_exact = quadrangles.at(again).halves
        free = forces.minimizers(quadrangles.middles)
        owners = np.tile(owners[again], 2)
        if not is_exact.all() or len(owners) > MOST_PIECES:
            rates[owners] = 0.0
            break
    else:
        rates[owners] = 0.0
    return rates.reshape(-1, pieces.per_ring).min(axis=1).tolist()


def _sticks(forces: BalancedForces, free: Floats) -> Mask:
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
    twists = _affine_twists(forces, pieces, free)
    if twists is None:
        return np.full(len(pieces.corners), -np.inf)
    middle, by_place, rest, is_enclosed = twists
    away = [Intervals.of(pieces.corners[:, :, k]) - Intervals.of(pieces.middles[:, None, k]) for k in range(2)]
    rises, bends = Intervals.of(0.0), Intervals.of(0.0)
    for k, along in enumerate(forces.covector(*pieces.slopes, pieces.moments)):
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
) -> tuple[Intervals, Intervals, Intervals, Mask] | None:
    """``xi_0``, ``-Y dG/dc``, the rest, by pieces (n, 3), (n, 3, 2), (n, 3), and where they enclose; None nowhere."""
    places = pieces.middles
    slopes = forces.hessians(places, free)
    inverse = np.full_like(slopes, np.nan)
    regular = np.abs(np.linalg.det(slopes)) > 0
    inverse[regular] = np.linalg.inv(slopes[regular])
    start = Intervals.of(free)
    slips = _slips(forces, start)
    one, by_x, by_y = forces.forms
    pull = _pull(forces, slips)
    loads = one + by_x * Intervals.of(places[:, :1]) + by_y * Intervals.of(places[:, 1:])
    off = -_times(inverse, _weighed(loads, pull))
    by_place = Intervals.stacked([-_times(inverse, _weighed(form, pull)) for form in (by_x, by_y)])
    reach = [max_norms(pieces.corners[:, :, k] - places[:, None, k]) * (1 + 2.0**-40) for k in range(2)]
    sides = [Intervals(-size, size)[:, None] for size in reach]
    change = off + by_place[:, :, 0] * sides[0] + by_place[:, :, 1] * sides[1]
    size = GROWTH * np.maximum(np.abs(change.low), np.abs(change.high)) + TINY
    size = size + 2.0**-8 * size.max(axis=1, keepdims=True)
    over = one + by_x * (Intervals.of(places[:, :1]) + sides[0]) + by_y * (Intervals.of(places[:, 1:]) + sides[1])
    is_enclosed: Mask = np.asarray((over.low >= 0).all(axis=1))
    box, rest = Intervals(-size, size), off
    for shrinking in range(SHRINKINGS):
        contraction = _contraction(forces, inverse, _slips(forces, start + box), over)
        rest = off + (contraction * box[:, None, :]).sum(axis=2)
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
    return Intervals.stacked([(loads * part).sum(axis=1) for part in parts])


def _contraction(
    forces: BalancedForces, inverse: Floats, slips: tuple[Intervals, Intervals], loads: Intervals
) -> Intervals:
    """``1 - Y B`` for all Hessians B of D over some slips and loads, (n, 3, 3)."""
    r, s = slips
    bend, w = loads * forces.enclosed_sets.bend(r, s), [s * a - r * b for a, b in zip(*forces.rows, strict=True)]
    entries = _weighed(bend, [w[i] * w[j] if i != j else w[i].square for i in range(3) for j in range(3)])
    hessian = Intervals(entries.low.reshape(-1, 3, 3), entries.high.reshape(-1, 3, 3))
    product = Intervals.stacked([-_times(inverse, hessian[:, :, j]) for j in range(3)])
    return product + Intervals.of(np.eye(3))


def _times(matrices: Floats, vectors: Intervals) -> Intervals:
    """The products of matrices (n, 3, 3) and vectors (n, 3)."""
    return (Intervals.of(matrices) * vectors[:, None, :]).sum(axis=2)


# ---- places of rest ------------------------------------------------------------------------------


PARTS = 6  # of each side of the square in which the field is differentiated
CONE, CONE_PARTS = 16, 16  # the same for cones, of which few of them are asked: of at most so many sectors
DISCS = tuple(Fraction(1, 8**k) for k in range(1, 6))  # of the accuracy: where the field is taken for nearly linear
WIDTHS = (1.0, 0.5, 0.25)  # b of the cones that are tried
MOST_VERTICES = 512  # of a polygon on which slow spirals rise
SLACK = 0.5  # of the rate outward: what bends of such a polygon may cost
SHORT = 16  # bits of levels: quadrangles between them can be halved some times without rounding
NO_FARTHER = Fraction(1, 2**24)  # of the accuracy: where starts beside an enclosed place of rest are


def is_carried_away(scene: Scene, accuracy: Fraction, beside: Fraction) -> bool:
    """Whether some bodies from as near the point of a centred scene as one likes are carried farther than a distance.

    Args:
        scene: centred, with a place of rest at or beside its point.
        accuracy: the distance.
        beside: how far the place of rest may be from the point; zero where it is the point.  Else bodies are meant that
            start farther away than rounding reaches, but within :data:`NO_FARTHER` of the distance.
    """
    rest = enclosed_rest(scene)
    if rest is None or rest.stability is not Translation.UNSTABLE:
        return False
    forces = BalancedForces(scene)
    for shape in _rising(np.array([float(entry) for entry in rest.slope.entries()]).reshape(2, 2)):
        level = _level_close_by(rest, shape, accuracy, beside)
        if level is not None and _rises_around(forces, shape, level, accuracy):
            return True
    return False


def _rising(slope: Floats) -> Iterator[SectorFunction]:
    """Functions that rise along ``c' = A c`` where they are positive, for an unstable A.

    Where both roots are on the right, on polygons in ellipses; a turn at the rate w costs ``w tan(pi/n)`` of the rate
    outward on a polygon with n vertices, so that slow spirals have more of them.  With coordinates along the modes
    ``x - b |y|`` does, b > 0, where the root of x is the larger one; it is positive in a cone about that mode.
    """
    roots, modes = np.linalg.eig(slope)
    matrix = lyapunov_matrix(-slope)
    if matrix is not None:
        count = VERTICES
        while count < MOST_VERTICES and np.tan(np.pi / count) * abs(roots.imag).max() > SLACK * roots.real.min():
            count *= 2
        yield SectorFunction.of_ellipse(matrix, count)
    if not np.isreal(roots).all():
        return
    first, second = (modes[:, k].real for k in (int(roots.argmax()), int(roots.argmin())))
    if first[0] * second[1] < first[1] * second[0]:
        second = -second
    angles = even_angles(VERTICES)
    x, y = np.cos(angles), np.sin(angles)
    if abs(first[0] * second[1] - first[1] * second[0]) > 2.0**-10:
        vertices = short_vertices(x[:, None] * first + y[:, None] * second)
        for width in WIDTHS:
            for side in (1, -1):
                yield SectorFunction(vertices, short_vertices(side * x - width * np.abs(y)))


def _level_close_by(rest: EnclosedRest, shape: SectorFunction, accuracy: Fraction, beside: Fraction) -> float | None:
    """The level of a polygon in which V rises; None where none is shown."""
    start = NO_FARTHER * accuracy / Fraction(shape.outside)
    with ctx.workprec(PRECISION):
        for share in DISCS:
            level = float(short_levels(np.array([share * float(accuracy)]), SHORT)[0])
            if _rises_close_by(rest, shape, level, beside, start):
                return level
    return None


def _rises_close_by(rest: EnclosedRest, shape: SectorFunction, level: float, beside: Fraction, start: Fraction) -> bool:
    """Whether V rises in the polygon of a level; beside a place of rest but for the polygon of the level ``start``."""
    slopes = _slopes_over(rest, shape, level * shape.outside, beside)
    off, close = (rational_ball(entry) for entry in (beside, start))
    # at the level s of the polygon V' >= rate s - size off
    return slopes is not None and all(rate * close > size * off for rate, size in _rates_at_rays(shape, slopes))


def _rates_at_rays(shape: SectorFunction, slopes: Sequence[arb_mat]) -> Iterator[tuple[arb, arb]]:
    """At both rays w of each sector ``g . A w``, and a bound of ``g . A d`` for d with entries up to one."""
    for sector, slope in zip(shape.sectors.tolist(), slopes, strict=True):
        a, b, c, d = slope.entries()
        g, h = (arb(float(part.low[sector])).union(arb(float(part.high[sector]))) for part in shape.slopes)
        for x, y in shape.rays(sector).tolist():
            yield g * (a * x + b * y) + h * (c * x + d * y), abs(g * a + h * c) + abs(g * b + h * d)


def _slopes_over(rest: EnclosedRest, shape: SectorFunction, reach: float, beside: Fraction) -> list[arb_mat] | None:
    """For each sector the hull of A over what it has of the square about the origin with a half-width.

    The square is cut into parts; a sector, and the ways from a place of rest beside the origin to its points, lie in
    those that are not beyond one of its two rays by more than ``beside``.

    Args:
        rest: a place of rest in the square.
        shape: with the sectors.
        reach: half-width of the square.
        beside: how far the place of rest may be from the origin.
    """
    near, count = unknowns_at_rest(rest.zero).mid(), PARTS if len(shape.sectors) > CONE else CONE_PARTS
    half, margin = reach / count, reach * 2.0**-20 + float(beside) * 2
    motions: dict[tuple[float, float], tuple[arb_mat, arb_mat] | None] = {}
    middles = [half * (2 * k + 1 - count) for k in range(count)]
    hulls = []
    for sector in shape.sectors.tolist():
        hull: list[arb] = []
        for place in product(middles, middles):
            if _is_beyond(shape.rays(sector), place, half, margin):
                continue
            if place not in motions:
                part = [arb(entry) + arb(half * (1 + 2.0**-40)) * UNIT for entry in place]
                motions[place] = enclosed_motion(rest.balance, near, part)
            motion = motions[place]
            if motion is None:
                return None
            hull = list(map(arb.union, hull, motion[1].entries())) if hull else motion[1].entries()
        hulls.append(arb_mat(2, 2, hull))
    return hulls


def _is_beyond(rays: Floats, place: tuple[float, float], half: float, margin: float) -> bool:
    """Whether a square about a place is farther than a margin beyond one of the two rays of a sector."""
    (ax, ay), (bx, by) = (ray / np.hypot(*ray) for ray in rays)
    x, y = place
    inside_first = ax * y - ay * x + half * (abs(ax) + abs(ay))
    inside_second = by * x - bx * y + half * (abs(bx) + abs(by))
    return bool(min(inside_first, inside_second) < -margin)


def _rises_around(forces: BalancedForces, shape: SectorFunction, level: float, accuracy: Fraction) -> bool:
    """Whether V rises on rings from a level outward, until a polygon holds the disc of the accuracy."""
    most = float(accuracy) / shape.inside * (1 + 2.0**-20)
    count = max(int(np.ceil(np.log(most / level) / -np.log(RATIO))), 1)
    levels = short_levels(most * (1 + 2.0**-10) * (level / most) ** (np.arange(count + 1) / count), SHORT)
    levels[-1] = level
    for outer, inner in pairwise(levels):
        pieces = shape.pieces(np.array([inner]), np.array([outer])).turned
        if ring_rates(forces, pieces)[0] > 0 or refined_rates(forces, pieces)[0] > 0:
            continue
        if finer_rate(forces, shape, inner, outer, turned=True) <= 0:
            return False
    return True


# ---- coming to it --------------------------------------------------------------------------------


@dataclass(frozen=True)
class AttractingDisc:
    """A disc about the point of a centred scene from which every body comes to an enclosed place of rest.

    V falls at least like ``exp(-rate t)`` about the place of rest; its level 1 holds the disc of radius ``inside``
    about it, and lies in that of radius ``outside``.

    Attributes:
        radius: about the point (length).
        beside: how far the place of rest is from the point at most (length).
        rate: 1/time.
        inside, outside: see above.
    """

    radius: Fraction
    beside: Fraction
    rate: Fraction
    inside: Fraction
    outside: Fraction

    @property
    def swing(self) -> Fraction:
        """A distance from the point that no body from the disc exceeds: of the level that holds the disc."""
        return (self.radius + self.beside) * self.outside / self.inside + self.beside

    def time_to(self, near: Fraction, start: Fraction) -> Fraction:
        """After which bodies from within ``start`` of the point are within ``near`` of it; both beyond ``beside``."""
        share = (start + self.beside) * self.outside / (self.inside * (near - self.beside))
        with ctx.workprec(PRECISION):
            logarithm = rational_above((rational_ball(share)).log())
        return max(logarithm, Fraction(0)) / self.rate


def attracting_disc(rest: EnclosedRest, radii: Sequence[Fraction]) -> AttractingDisc | None:
    """The first of some discs that is shown to be one; None where none is.

    With ``c' = A(c) (c - c_0)``, A in a hull over a square about the point, and V linear on sectors about ``c_0``,
    ``g . A w < 0`` at both rays w of each sector: so V falls in the polygon of a level inside the square.

    Args:
        rest: the place of rest of a centred scene, which attracts.
        radii: of discs about the point that are tried.
    """
    middle = np.array([float(entry) for entry in rest.slope.entries()]).reshape(2, 2)
    matrix = lyapunov_matrix(middle)
    if matrix is None:
        return None
    shape = SectorFunction.of_ellipse(matrix)
    inside, outside, beside = Fraction(shape.inside), Fraction(shape.outside), rest.distance
    with ctx.workprec(PRECISION):
        for radius in radii:
            level = (radius + beside) / inside
            reach = level * outside + beside
            slopes = _slopes_over(rest, shape, float(reach) * (1 + 2.0**-40), beside)
            if slopes is None:
                continue
            rate = min(rational_below(-rate) for rate, _ in _rates_at_rays(shape, slopes))
            if rate > 0:
                return AttractingDisc(radius, beside, rate, inside, outside)
    return None
