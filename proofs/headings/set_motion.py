"""The motion of a body on one set of wheels with its centre of mass at one point, enclosed by balls.

The spatial twist ``xi = (v, omega)`` minimizes ``D = sum_i N_i(c) f_i(r_i, s_i)``, with the slips and support functions
of :mod:`nonsmooth.proofs.boxes.linearization`, so the centre of mass enters through the loads alone.  Where
every loaded wheel slips, ``G(xi, c) = sum_i N_i(c) pull_i(xi) = 0`` determines it.  A wheel that sticks adds two
equations, no slip, and two unknowns, its force in units of the half-axes.  D is convex, so a zero of G with forces
inside the friction sets and a regular Jacobian is the only minimizer, and smooth in c.  Krawczyk's operator
(:mod:`nonsmooth.proofs.enclosures`) proves one zero near what floats find.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

from flint import arb, arb_mat

from nonsmooth.analysis.bodies.set_guesses import SetGuess, SetGuesses
from nonsmooth.analysis.contact_rule import SmoothRule
from nonsmooth.proofs.boxes.linearization import slip_at_rest
from nonsmooth.proofs.enclosures import approximate_inverse, krawczyk, lies_inside, newton, pose_rate_slope
from nonsmooth.symbolic.constraints import added, scaled
from nonsmooth.symbolic.edge_headings import ball_of
from nonsmooth.symbolic.scene import Scene

NEWTON_STEPS = 12  # from a float to the full precision
SINGULAR = "a Jacobian that may be singular"
RADIUS = arb(2) ** -60  # of the box


class UndecidedMotionError(Exception):
    """Balls that do not decide what is asked."""


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
        """``dc'/dc``, (2, 2)."""
        return pose_rate_slope(self.centre, self.omega, self.slope)


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
    balance = _Balance(scene, rule, guess, wheels, centre)
    found = balance.zero_near(arb_mat([[arb(value)] for value in (*guess.twist, *[0.0] * balance.forces)]))
    balance.require_certain(found.entries()[3:])
    _, state, slope = balance(found)
    try:
        moved = state.inv() * slope * arb(-1)
    except ZeroDivisionError:
        raise UndecidedMotionError("a motion that may not be smooth") from None
    return EnclosedMotion(centre, arb_mat(3, 1, found.entries()[:3]), arb_mat(3, 2, moved.entries()[:6]))


class _Balance:
    """G and the slips of the wheels that stick, of elastic loads with total weight 1, as a map of ``(xi, f)``.

    Raises:
        UndecidedMotionError: where the loaded wheels may stand on one line.
    """

    def __init__(self, scene: Scene, rule: SmoothRule, guess: SetGuess, wheels: Sequence[int], centre: arb_mat) -> None:
        """With a guess of which wheels are loaded, and which of these stick."""
        zero, chosen = scene.field.zero, [scene.wheels[k] for k in wheels]
        x, y = centre.entries()
        self._place = arb_mat([[arb(1)], [x], [y]])
        moments = [arb_mat([[arb(1)], *([ball_of(entry)] for entry in wheel.position)]) for wheel in chosen]
        stiffness = arb_mat(3, 3)
        for moment, pressed in zip(moments, guess.loaded, strict=True):
            stiffness += moment * moment.transpose() * arb(int(pressed))
        try:
            inverse = stiffness.inv()
        except ZeroDivisionError:
            raise UndecidedMotionError("loaded wheels on one line") from None
        forms = [inverse * moment for moment in moments]
        self._springs = [
            ((form.transpose() * self._place)[0, 0], p) for form, p in zip(forms, guess.loaded, strict=True)
        ]
        self._slips = []
        for wheel, form, pressed, stuck in zip(chosen, forms, guess.loaded, guess.stuck, strict=True):
            slip = slip_at_rest(wheel, (zero, zero, zero), rule)
            if pressed and (slip.limits.along or slip.limits.across):
                a, b, c = form.entries()
                self._slips.append((replace(slip.map(ball_of), load=(a, b, c)), stuck))
        self.forces = 2 * sum(stuck for _, stuck in self._slips)

    def __call__(self, unknowns: arb_mat) -> tuple[arb_mat, arb_mat, arb_mat]:
        """The values (n, 1) and their slopes by the unknowns (n, n) and by c (n, 2).

        Raises:
            UndecidedMotionError: where a wheel may stick that is not said to.
        """
        entries, size = unknowns.entries(), unknowns.nrows()
        values, state, slope = arb_mat(size, 1), arb_mat(size, size), arb_mat(size, 2)
        row = 3
        for slip, stuck in self._slips:
            now = slip.moved(entries[:3])
            load = (arb_mat([slip.load]) * self._place)[0, 0]
            if stuck:
                grips = scaled(slip.rows[0], slip.limits.along), scaled(slip.rows[1], slip.limits.across)
                pull = added(scaled(grips[0], entries[row]), scaled(grips[1], entries[row + 1]))
                for k, value in enumerate((now.along, now.across)):
                    values[row + k, 0] = value
                    for r in range(3):
                        state[row + k, r], state[r, row + k] = slip.rows[k][r], load * grips[k][r]
                row += 2
            elif now.is_smooth:
                pull = now.pull
                for r, s in product(range(3), repeat=2):
                    state[r, s] += load * now.bend * now.w[r] * now.w[s]
            else:
                raise UndecidedMotionError("a wheel that may stick, or is at the seam of arc and corner")
            for r in range(3):
                values[r, 0] += load * pull[r]
                slope[r, 0], slope[r, 1] = slope[r, 0] + slip.load[1] * pull[r], slope[r, 1] + slip.load[2] * pull[r]
        return values, state, slope

    def zero_near(self, point: arb_mat) -> arb_mat:
        """A box (n, 1) that holds exactly one zero near a start.

        Raises:
            UndecidedMotionError: where none is proved.
        """
        near = newton(lambda at: self(at)[:2], point, NEWTON_STEPS)
        value, state, _ = self(point if near is None else near)
        inverse = approximate_inverse(state)
        if near is None or inverse is None:
            raise UndecidedMotionError(SINGULAR)
        box = arb_mat([[entry + arb(0, RADIUS)] for entry in near.entries()])
        image = krawczyk(near, value, inverse, self(box)[1], box)
        if not lies_inside(image, box):
            raise UndecidedMotionError("a box that Krawczyk's operator does not map into itself")
        return image

    def require_certain(self, forces: Sequence[arb]) -> None:
        """Refuse guesses that are not certain: then loads are affine around, and what sticks goes on sticking.

        Raises:
            UndecidedMotionError: where a loaded wheel may be free, a free one pressed, or one that sticks may slip.
        """
        if not all(spring > 0 if pressed else spring < 0 for spring, pressed in self._springs):
            raise UndecidedMotionError("loads that change their form")
        sets = [slip.limits for slip, stuck in self._slips if stuck]
        pairs = zip(sets, forces[::2], forces[1::2], strict=True)
        if not all(limits.holds_strictly(along, across) for limits, along, across in pairs):
            raise UndecidedMotionError("a wheel that sticks at its limit")
