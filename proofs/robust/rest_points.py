"""A place of rest near a point under a rule without cells, enclosed, and bodies that are carried away from it.

With ``G(xi, c)`` the gradient of D in the twist, a body that rests at c, and may turn there, has the twist
``xi = omega (c_y, -c_x, 1)``; Krawczyk's operator encloses the zero ``(c, omega)`` of G and shows that it is the only
one nearby.  Where D bends in every direction the twist is smooth in c, and ``c' = A(c) (c - c_0)``, A in the hull of ::

    V + omega J + (J c) w,    (V; w) = -(dG/dxi)^-1 dG/dc,

over a disc about the place of rest, on which Krawczyk's operator encloses the twist too.

Let V be linear on sectors (:mod:`nonsmooth.proofs.robust.level_sets`), and rise along every motion where it is
positive: in the disc by A, at the two rays of each sector, and on rings around it, up to a polygon that holds the disc
of radius a.  Then each body that starts where V is positive, as near as one likes, leaves that polygon (Chetaev).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise, product
from typing import TypeAlias

import numpy as np
from flint import arb, arb_mat, ctx
from numpy.typing import NDArray

from nonsmooth.analysis.contact_rule import SmoothRule, rule_of, smooth_rule_of
from nonsmooth.proofs.clauses.at_point.linearization import slip_at_rest
from nonsmooth.proofs.enclosures import UNIT, krawczyk, lies_inside, linear_stability, pose_rate_slope
from nonsmooth.proofs.headings.set_motion import UndecidedMotionError
from nonsmooth.proofs.robust.balanced_forces import BalancedForces
from nonsmooth.proofs.robust.level_sets import VERTICES, SectorFunction, short_levels, short_vertices
from nonsmooth.proofs.robust.load_box import LoadBox, load_box
from nonsmooth.proofs.robust.touching_rings import RATIO, finer_rate, ring_rates
from nonsmooth.proofs.robust.ultimate_bound import root_above
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.edge_headings import ball_of
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.unknown_loads import UnknownLoads

Floats: TypeAlias = NDArray[np.float64]

PRECISION = 128  # bits
NEWTON_STEPS = 6
INFLATIONS = 10
GROWTH = 1.25  # of the image of a box, which is the next one
LEAST = 2.0**-100  # of its half-widths, beside one
PARTS = 6  # of each side of the square in which the field is differentiated
DISCS = tuple(8.0**-k for k in range(1, 6))  # of the accuracy: where the field is taken for nearly linear
WIDTHS = (1.0, 0.5)  # b of the cones that are tried
NO_FARTHER = Fraction(1, 2**24)  # of the accuracy: where starts beside an enclosed place of rest are


@dataclass(frozen=True)
class EnclosedRest:
    """A place of rest, the only one in a box about it; by a member of what was rounded.

    Attributes:
        place: from the origin of the scene (length).
        spin: omega there (1/time).
        slope: A there, (2, 2).
    """

    place: tuple[arb, arb]
    spin: arb
    slope: arb_mat

    @property
    def distance(self) -> Fraction:
        """An upper bound of its distance from the origin."""
        x, y = self.place
        return root_above(-rational_below(-(x * x + y * y)))

    @property
    def stability(self) -> Translation:
        """By the trace and the determinant of A."""
        return linear_stability([list(row) for row in self.slope.tolist()])


class _Gradient:
    """G with its derivatives, in balls."""

    def __init__(self, scene: Scene, loads: LoadBox) -> None:
        rule, zero = smooth_rule_of(scene), scene.field.zero
        self._slips = [slip_at_rest(wheel, (zero, zero, zero), rule).map(ball_of) for wheel in scene.wheels]
        self._loads = loads

    def at(self, twist: arb_mat, place: Sequence[arb]) -> tuple[arb_mat, arb_mat, arb_mat]:
        """G (3, 1), by the twist (3, 3) and by the place (3, 2).

        Raises:
            UndecidedMotionError: where a wheel may stick, or lift off.
        """
        value, bend, slope = arb_mat(3, 1), arb_mat(3, 3), arb_mat(3, 2)
        loads = self._loads.at(place)
        if not all(load > 0 for load in loads):
            raise UndecidedMotionError("a wheel that may lift off")
        for slip, load, (_, by_x, by_y) in zip(self._slips, loads, self._loads.forms, strict=True):
            now = slip.moved(twist.entries())
            if not now.is_smooth:
                raise UndecidedMotionError("a wheel that may stick, or is at the seam of arc and corner")
            pull, w = (arb_mat([[entry] for entry in triple]) for triple in (now.pull, now.w))
            value += pull * load
            bend += w * w.transpose() * (load * now.bend)
            slope += pull * arb_mat([[by_x, by_y]])
        return value, bend, slope


def enclosed_rest(scene: Scene) -> EnclosedRest | None:
    """The place of rest at or beside the point of a centred scene; None where none is enclosed."""
    gradient = _gradient_of(scene)
    if gradient is None:
        return None
    with ctx.workprec(PRECISION):
        try:
            forces = BalancedForces(scene)
            spin = forces.minimizers(np.zeros((1, 2)), np.zeros((1, 3)))[0, 2] / forces.length
            return _krawczyk(gradient, arb_mat([[arb(0)], [arb(0)], [arb(float(spin))]]))
        except (ArithmeticError, UndecidedMotionError, ValueError):
            return None


def _gradient_of(scene: Scene) -> _Gradient | None:
    if not isinstance(rule_of(scene), SmoothRule) or isinstance(scene.contact.loads, UnknownLoads):
        return None
    with ctx.workprec(PRECISION):
        loads = load_box(scene, arb(0))
        return None if loads is None else _Gradient(scene, loads)


def _resting(z: arb_mat) -> tuple[arb_mat, arb_mat]:
    """The twist of a body that turns on the spot, and its derivative by ``z = (c_x, c_y, omega)``."""
    x, y, omega = z.entries()
    twist = arb_mat([[omega * y], [-omega * x], [omega]])
    return twist, arb_mat([[arb(0), omega, y], [-omega, arb(0), -x], [arb(0), arb(0), arb(1)]])


def _equations(gradient: _Gradient, z: arb_mat) -> tuple[arb_mat, arb_mat, arb_mat, arb_mat]:
    """G for a body that rests, its derivative by z, and what A is made of."""
    twist, by_z = _resting(z)
    value, bend, slope = gradient.at(twist, z.entries()[:2])
    through = bend * by_z
    for k in range(3):
        for j in range(2):
            through[k, j] = through[k, j] + slope[k, j]
    return value, through, bend, slope


def _krawczyk(gradient: _Gradient, z: arb_mat) -> EnclosedRest | None:
    """From a guess in floats."""
    for _ in range(NEWTON_STEPS):
        value, slope, _, _ = _equations(gradient, z)
        z = (z - slope.mid().solve(value.mid())).mid()
    value, slope, _, _ = _equations(gradient, z)
    about = _contracted(value, slope, lambda box: _equations(gradient, z + box)[1])
    if about is None:
        return None
    box, image = about
    _, _, bend, by_place = _equations(gradient, z + box)
    x, y, omega = (z + image).entries()
    return EnclosedRest((x, y), omega, _linear(bend, by_place, (x, y), omega))


def _contracted(
    value: arb_mat, slope: arb_mat, slope_over: Callable[[arb_mat], arb_mat]
) -> tuple[arb_mat, arb_mat] | None:
    """A box about an approximate zero that Krawczyk's operator takes into its interior, and where; about zero.

    Args:
        value: of the map at that point, (3, 1).
        slope: about its Jacobian there, (3, 3).
        slope_over: its Jacobian over a box.
    """
    inverse, centre = slope.mid().inv().mid(), arb_mat(3, 1)
    image = inverse * value * arb(-1)
    for _ in range(INFLATIONS):
        box = arb_mat([[(GROWTH * abs(entry).upper() + LEAST) * UNIT] for entry in image.entries()])
        image = krawczyk(centre, value, inverse, slope_over(box), box)
        if lies_inside(image, box):
            return box, image
    return None


def _linear(bend: arb_mat, by_place: arb_mat, place: Sequence[arb], omega: arb) -> arb_mat:
    """A, from the derivatives of G."""
    return pose_rate_slope(arb_mat([[entry] for entry in place]), omega, bend.solve(by_place * arb(-1)))


# ---- carried away --------------------------------------------------------------------------------


def is_carried_away(scene: Scene, accuracy: Fraction, beside: Fraction) -> bool:
    """Whether some bodies from as near the point of a centred scene as one likes are carried farther than a distance.

    Args:
        scene: centred, with a place of rest at or beside its point.
        accuracy: the distance.
        beside: how far the place of rest may be from the point; zero where it is the point.  Else bodies are meant that
            start farther away than rounding reaches, but within :data:`NO_FARTHER` of the distance.
    """
    rest, gradient = enclosed_rest(scene), _gradient_of(scene)
    if rest is None or gradient is None or rest.stability is not Translation.UNSTABLE:
        return False
    middle = np.array([float(entry) for entry in rest.slope.entries()]).reshape(2, 2)
    with ctx.workprec(PRECISION):
        for shape in _rising(middle):
            start = NO_FARTHER * accuracy / Fraction(shape.outside)
            for share in DISCS:
                level = float(short_levels(np.array([share * float(accuracy)]))[0])
                if _rises_close_by(gradient, rest, shape, level, beside, start):
                    if _rises_around(scene, shape, level, accuracy):
                        return True
                    break
    return False


def _rising(slope: Floats) -> Iterator[SectorFunction]:
    """Functions that rise along ``c' = A c`` where they are positive, for an unstable A.

    With coordinates along the modes ``x - b |y|`` does, b > 0, where the root of x is the larger one; it is positive in
    a cone about that mode.
    """
    roots, modes = np.linalg.eig(slope)
    if (roots.real > 0).all():
        from scipy.linalg import solve_continuous_lyapunov

        yield SectorFunction.of_ellipse(solve_continuous_lyapunov(-slope.T, -np.eye(2)))
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


def _rises_close_by(
    gradient: _Gradient, rest: EnclosedRest, shape: SectorFunction, level: float, beside: Fraction, start: Fraction
) -> bool:
    """Whether V rises in the polygon of a level; beside a place of rest but for the polygon of the level ``start``."""
    reach = arb(level * shape.outside)
    slope = _slope_over(gradient, rest, reach)
    if slope is None:
        return False
    a, b, c, d = slope.entries()
    off, close = (arb(entry.numerator) / entry.denominator for entry in (beside, start))
    rates, sizes = [], []
    for sector in shape.sectors.tolist():
        g, h = (arb(float(part.low[sector])).union(arb(float(part.high[sector]))) for part in shape.slopes)
        for x, y in shape.vertices[[sector, (sector + 1) % len(shape.vertices)]].tolist():
            rates.append(g * (a * x + b * y) + h * (c * x + d * y))
            sizes.append(abs(g * a + h * c) + abs(g * b + h * d))
    # at the level s of the polygon V' >= rate s - size off
    return all(rate * close > size * off for rate, size in zip(rates, sizes, strict=True))


def _slope_over(gradient: _Gradient, rest: EnclosedRest, reach: arb) -> arb_mat | None:
    """The hull of A over the square about the origin with that half-width, part by part, for a place of rest in it."""
    (x, y), omega = rest.place, rest.spin
    twist, half, found = arb_mat([[omega * y], [-omega * x], [omega]]).mid(), reach / PARTS, None
    middles = [half * (2 * k + 1 - PARTS) for k in range(PARTS)]
    try:
        for place in product(middles, middles):
            part = _slope_over_part(gradient, twist, place, half)
            if part is None:
                return None
            pairs = part.entries() if found is None else map(arb.union, found, part.entries())
            found = list(pairs)
    except (UndecidedMotionError, ZeroDivisionError):
        return None
    return None if found is None else arb_mat(2, 2, found)


def _slope_over_part(gradient: _Gradient, near: arb_mat, middle: tuple[arb, arb], half: arb) -> arb_mat | None:
    """The same over a square about another point; Krawczyk's operator encloses the twist all over it."""
    start = near
    for _ in range(NEWTON_STEPS):
        value, bend, _ = gradient.at(start, middle)
        start = (start - bend.mid().solve(value.mid())).mid()
    place = [entry + half * UNIT for entry in middle]
    value, _, _ = gradient.at(start, place)
    about = _contracted(value, bend, lambda box: gradient.at(start + box, place)[1])
    if about is None:
        return None
    twist = start + about[0]
    _, bend, by_place = gradient.at(twist, place)
    return _linear(bend, by_place, place, twist[2, 0])


def _rises_around(scene: Scene, shape: SectorFunction, level: float, accuracy: Fraction) -> bool:
    """Whether V rises on rings from a level outward, until a polygon holds the disc of the accuracy."""
    try:
        forces = BalancedForces(scene)
    except ArithmeticError:
        return False
    most = float(accuracy) / shape.inside * (1 + 2.0**-20)
    count = max(int(np.ceil(np.log(most / level) / -np.log(RATIO))), 1)
    levels = short_levels(most * (1 + 2.0**-20) * (level / most) ** (np.arange(count + 1) / count))
    levels[-1] = level
    for outer, inner in pairwise(levels):
        pieces = shape.pieces(np.array([inner]), np.array([outer])).turned
        if ring_rates(forces, pieces)[0] <= 0 and finer_rate(forces, shape, inner, outer, turned=True) <= 0:
            return False
    return True
