"""The motion of a body on one set of wheels with its centre of mass at one point, enclosed by balls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb, arb_mat

from nonsmooth.analysis.bodies.set_guesses import SetGuesses
from nonsmooth.analysis.contact_rule import SmoothRule
from nonsmooth.proofs.headings.ball_motion import BallMotion, Pull, UndecidedMotionError, add
from nonsmooth.proofs.headings.krawczyk import zero_near
from nonsmooth.symbolic.scene import Scene


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
        UnprovedError: where it is not proved, or not smooth in c.
    """
    x, y = (float(entry.mid()) for entry in centre.entries())
    guess = guesses.of(wheels, (x, y))
    if guess is None:
        raise UndecidedMotionError("no motion found, or a body that tips")
    motion = BallMotion([scene.wheels[k] for k in wheels], guess.loaded, guess.stuck, rule)
    found = zero_near(_Equations(motion, centre), [*guess.twist, *[0.0] * motion.forces])
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
        found: Pull = self._motion.pull(twist, forces, self._centre)
        jacobian = arb_mat(len(entries), len(entries))
        add(jacobian, 0, 0, found.state)
        return found.values, jacobian
