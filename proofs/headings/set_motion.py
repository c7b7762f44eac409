"""The motion of a body on one set of wheels with its centre of mass at one point, enclosed by balls.

Krawczyk's operator proves one zero of a smooth map E in a box.  With an approximate zero m, an approximate inverse Y of
the Jacobian there and the Jacobian J(X) over a box X about m, ``K = m - Y E(m) + (I - Y J(X)) (X - m)``.  If K lies in
the interior of X, E has exactly one zero in X, it lies in K, and every matrix in J(X) is regular (Krawczyk 1969;
Neumaier 1990, theorem 5.1.8).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from flint import arb, arb_mat

from nonsmooth.analysis.bodies.set_guesses import SetGuesses
from nonsmooth.analysis.contact_rule import SmoothRule
from nonsmooth.proofs.headings.ball_motion import BallMotion, UndecidedMotionError
from nonsmooth.symbolic.scene import Scene

Map: TypeAlias = Callable[[arb_mat], tuple[arb_mat, arb_mat]]  # a point (n, 1) to the value (n, 1) and Jacobian (n, n)

NEWTON_STEPS = 12  # from a float to the full precision
RADIUS_BITS = 60  # the box has the radius 2^-60


@dataclass(frozen=True)
class EnclosedMotion:
    """The only minimizer of D.

    Attributes:
        centre: ``c``, (2, 1).
        twist: encloses the spatial twist, (3, 1).
        slope: encloses its slope in c, (3, 2).
    """

    centre: arb_mat
    twist: arb_mat
    slope: arb_mat

    @property
    def velocity(self) -> tuple[arb, arb]:
        """Of the centre of mass: ``v + omega J c``."""
        (vx, vy, omega), (x, y) = self.twist.entries(), self.centre.entries()
        return vx - omega * y, vy + omega * x

    @property
    def omega(self) -> arb:
        """The rotation rate."""
        return self.twist[2, 0]

    @property
    def linearized(self) -> arb_mat:
        """``dc'/dc = Dv + J c Domega + omega J``, (2, 2)."""
        x, y = self.centre.entries()
        moved = arb_mat([[arb(1), arb(0), -y], [arb(0), arb(1), x]])
        return moved * self.slope + arb_mat([[arb(0), -self.omega], [self.omega, arb(0)]])


def set_motion(
    scene: Scene, rule: SmoothRule, guesses: SetGuesses, wheels: Sequence[int], centre: arb_mat
) -> EnclosedMotion:
    """The motion on some wheels of a scene, by their places in its list.

    Raises:
        UndecidedMotionError: where it is not proved, or not smooth in c.
    """
    x, y = (float(entry.mid()) for entry in centre.entries())
    guess = guesses.of(wheels, (x, y))
    if guess is None:
        raise UndecidedMotionError("no motion found, or a body that tips")
    motion = BallMotion([scene.wheels[k] for k in wheels], guess.loaded, guess.stuck, rule)
    found = _zero_near(_Equations(motion, centre), [*guess.twist, *[0.0] * motion.forces])
    entries = found.entries()
    twist, forces = arb_mat(3, 1, entries[:3]), arb_mat(len(entries) - 3, 1, entries[3:])
    motion.require_certain(centre, forces)
    try:
        slope = motion.pull(twist, forces, centre).twist_slope()
    except ZeroDivisionError:
        raise UndecidedMotionError("a motion that may not be smooth") from None
    return EnclosedMotion(centre, twist, slope)


class _Equations:
    """G and the slips of the wheels that stick, as a map of ``(xi, f)`` alone."""

    def __init__(self, motion: BallMotion, centre: arb_mat) -> None:
        self._motion, self._centre = motion, centre

    def __call__(self, unknowns: arb_mat) -> tuple[arb_mat, arb_mat]:
        entries = unknowns.entries()
        twist, forces = arb_mat(3, 1, entries[:3]), arb_mat(len(entries) - 3, 1, entries[3:])
        found = self._motion.pull(twist, forces, self._centre)
        return found.values, found.state


def _zero_near(equations: Map, start: list[float]) -> arb_mat:
    """A box (n, 1) that holds exactly one zero near a start.

    Raises:
        UndecidedMotionError: where none is proved.
    """
    point = arb_mat([[arb(value)] for value in start])
    try:
        for _ in range(NEWTON_STEPS):
            value, slope = equations(point)
            point = (point - slope.mid().inv().mid() * value).mid()
        around = arb(0, arb(2) ** -RADIUS_BITS)
        box = arb_mat([[entry + around] for entry in point.entries()])
        return _contracted(equations, box)
    except ZeroDivisionError:
        raise UndecidedMotionError("a Jacobian that may be singular") from None


def _contracted(equations: Map, box: arb_mat) -> arb_mat:
    """Krawczyk's operator on a box, where it maps it into its interior.

    Raises:
        UndecidedMotionError: where it does not.
    """
    size = box.nrows()
    middle = box.mid()
    value, slope = equations(middle)
    inverse = slope.mid().inv().mid()
    spread = equations(box)[1]
    identity = arb_mat(size, size, [arb(int(k // size == k % size)) for k in range(size * size)])
    image = middle - inverse * value + (identity - inverse * spread) * (box - middle)
    inside = all(outer.contains_interior(inner) for outer, inner in zip(box.entries(), image.entries(), strict=True))
    if not inside:
        raise UndecidedMotionError("a box that Krawczyk's operator does not map into itself")
    return image
