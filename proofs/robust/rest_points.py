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
from typing import TypeAlias

import numpy as np
from flint import arb, arb_mat, ctx
from numpy.typing import NDArray

from nonsmooth.proofs.boxes.balanced_forces import BalancedForces
from nonsmooth.proofs.boxes.enclosed_rest import (
    NEWTON_STEPS,
    PRECISION,
    Balance,
    EnclosedRest,
    enclosed_rest,
    isolated_zero,
    slope_of_pose_rate,
    unknowns_at_rest,
)
from nonsmooth.proofs.boxes.enclosures import UNIT, newton
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.robust.affine_twists import refined_rates
from nonsmooth.proofs.robust.level_sets import VERTICES, SectorFunction, lyapunov_matrix, short_levels, short_vertices
from nonsmooth.proofs.robust.touching_rings import RATIO, finer_rate, ring_rates
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.enclosures import rational_below

Floats: TypeAlias = NDArray[np.float64]

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
    angles = 2 * np.pi * np.arange(VERTICES) / VERTICES
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
    off, close = (arb(entry.numerator) / entry.denominator for entry in (beside, start))
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
    known: dict[tuple[float, float], arb_mat | None] = {}
    middles = [half * (2 * k + 1 - count) for k in range(count)]
    hulls = []
    for sector in shape.sectors.tolist():
        hull: list[arb] = []
        for place in product(middles, middles):
            if _is_beyond(shape.rays(sector), place, half, margin):
                continue
            if place not in known:
                known[place] = _slope_over_part(rest.balance, near, place, half * (1 + 2.0**-40))
            part = known[place]
            if part is None:
                return None
            hull = list(map(arb.union, hull, part.entries())) if hull else part.entries()
        hulls.append(arb_mat(2, 2, hull))
    return hulls


def _is_beyond(rays: Floats, place: tuple[float, float], half: float, margin: float) -> bool:
    """Whether a square about a place is farther than a margin beyond one of the two rays of a sector."""
    (ax, ay), (bx, by) = (ray / np.hypot(*ray) for ray in rays)
    x, y = place
    inside_first = ax * y - ay * x + half * (abs(ax) + abs(ay))
    inside_second = by * x - bx * y + half * (abs(bx) + abs(by))
    return bool(min(inside_first, inside_second) < -margin)


def _slope_over_part(balance: Balance, near: arb_mat, middle: tuple[float, float], half: float) -> arb_mat | None:
    """The hull of A over a square about a point; Krawczyk's operator encloses twist and forces all over it."""
    centre = arb(middle[0]), arb(middle[1])
    place = [entry + arb(half) * UNIT for entry in centre]

    def equations(unknowns: arb_mat, there: Sequence[arb]) -> tuple[arb_mat, arb_mat] | None:
        found = balance.at(unknowns, there)
        return None if found is None else found[:2]

    start = newton(lambda unknowns: equations(unknowns, centre), near, NEWTON_STEPS)
    unknowns = None if start is None else isolated_zero(lambda unknowns: equations(unknowns, place), start)
    found = None if unknowns is None else balance.at(unknowns, place)
    if unknowns is None or found is None:
        return None
    _, bend, by_place = found
    return slope_of_pose_rate(bend, by_place, place, unknowns[2, 0])


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
            logarithm = -rational_below(-(arb(share.numerator) / share.denominator).log())
        return max(logarithm, Fraction(0)) / self.rate


def attracting_disc(scene: Scene, rest: EnclosedRest, radii: Sequence[Fraction]) -> AttractingDisc | None:
    """The first of some discs that is shown to be one; None where none is.

    With ``c' = A(c) (c - c_0)``, A in a hull over a square about the point, and V linear on sectors about ``c_0``,
    ``g . A w < 0`` at both rays w of each sector: so V falls in the polygon of a level inside the square.

    Args:
        scene: centred.
        rest: its place of rest, which attracts.
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
