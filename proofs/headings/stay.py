"""What a body does on one set of wheels with its centre of mass at one point: rests, turns on the spot, or moves.

Decided by the exact clauses of a check, of these wheels alone.  Where they leave it open under a rule without cells,
balls enclose the motion.  They may show that the centre of mass moves.  That it stays they cannot show, but a symmetry
can: where a half turn about the point takes every wheel to one that does the same, the only minimizer of D is turned
into itself, so the centre of mass has no velocity, and the body turns at the enclosed rate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING, cast

from flint import arb, arb_mat

from nonsmooth.analysis.cells.contact_rule import SmoothRule, rule_of
from nonsmooth.analysis.cells.filippov import filippov_twists
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.proofs import clause_registry
from nonsmooth.proofs.boxes.enclosures import (
    approximate_inverse,
    krawczyk,
    lies_inside,
    linear_stability,
    newton,
    pose_rate_slope,
)
from nonsmooth.proofs.boxes.linearization import slip_at_rest
from nonsmooth.proofs.clauses.equilibrium.clause import EllipseEquilibrium
from nonsmooth.proofs.clauses.rotation.clause import RotationResult
from nonsmooth.proofs.clauses.translation.clause import AnyTranslation
from nonsmooth.proofs.clauses.workspace import Workspace
from nonsmooth.proofs.findings.verdicts import Equilibrium, Rotation, Translation
from nonsmooth.symbolic.mechanics.constraints import Twist, added, scaled
from nonsmooth.symbolic.mechanics.contact_set import TipsError, on_wheels, whole
from nonsmooth.symbolic.mechanics.edge_headings import ball_of
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import Vector, cross
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, work_limit

if TYPE_CHECKING:
    from nonsmooth.analysis.bodies.set_motion import SetGuess, SetGuesses

NEEDED = ("equilibrium", "translation", "rotation")
UNITS = 400_000  # of exact arithmetic for one set of wheels: half a second or so


class Stays(StrEnum):
    """Whether the centre of mass stays."""

    RESTS = "rests"
    TURNS = "turns on the spot"
    MOVES = "moves"
    TIPS = "tips"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Stay:
    """What a set of wheels does.

    Attributes:
        kind: see :class:`Stays`.
        translation: whether the place attracts, while the same wheels carry.
        rotation: what the heading does there.
        turning: sign of the rotation rate of a body that turns on the spot one way; else 0.
        reason: why something is not decided; empty where all is.
        twists: their hull holds all motions at the point, measured from it; empty where they are not known exactly.
    """

    kind: Stays
    translation: Translation = Translation.UNDECIDED
    rotation: Rotation = Rotation.UNDECIDED
    turning: int = 0
    reason: str = field(default="", compare=False)
    twists: tuple[Twist, ...] = field(default=(), compare=False, repr=False)

    @property
    def is_equilibrium(self) -> bool:
        """Whether the centre of mass stays."""
        return self.kind in (Stays.RESTS, Stays.TURNS)


class StaysAt:
    """What sets of wheels do at one point; to be used at one working precision."""

    def __init__(self, scene: Scene) -> None:
        """At the checked point of a scene."""
        self.scene = whole(scene)
        rule = rule_of(scene)
        known = scene.contact.loads is None
        self.rule = rule if isinstance(rule, SmoothRule) and known else None
        self._guesses: SetGuesses | None = None
        self._motions: dict[tuple[int, ...], EnclosedMotion | str] = {}
        self._stays: dict[tuple[int, ...], Stay] = {}

    def on(self, numbers: Sequence[int]) -> Stay:
        """What the wheels with some numbers do."""
        key = tuple(numbers)
        if key not in self._stays:
            stay = self._exactly(key)
            self._stays[key] = self._by_balls(key, stay) if stay.kind is Stays.UNDECIDED else stay
        return self._stays[key]

    def rates(self, numbers: Sequence[int]) -> list[arb_mat] | None:
        """Rows ``(c', omega)``, (1, 3), whose hull holds all motions on the wheels with some numbers.

        None where they are not known, or the body tips.
        """
        stay = self.on(numbers)
        if stay.twists:
            return [arb_mat([[ball_of(entry) for entry in (*twist.velocity, twist.omega)]]) for twist in stay.twists]
        motion = "a body that tips" if stay.kind is Stays.TIPS else self.motion(numbers)
        return None if isinstance(motion, str) else [arb_mat([[*motion.velocity, motion.omega]])]

    def motion(self, numbers: Sequence[int]) -> EnclosedMotion | str:
        """The enclosed motion on the wheels with some numbers; why none is proved.

        It is looked for under a rule without cells and with elastic loads.
        """
        if self.rule is None:
            return "a rule with cells, or loads of one set of wheels"
        if self._guesses is None:
            from nonsmooth.analysis.bodies.set_motion import SetGuesses  # floats: only where exact clauses leave open

            self._guesses = SetGuesses(self.scene, self.rule)
        key = tuple(numbers)
        if key not in self._motions:
            places = [k for k, wheel in enumerate(self.scene.wheels) if wheel.index in key]
            centre = arb_mat([[ball_of(entry)] for entry in self.scene.check.equilibrium])
            try:
                self._motions[key] = set_motion(self.scene, self.rule, self._guesses, places, centre)
            except UndecidedMotionError as error:
                self._motions[key] = str(error)
        return self._motions[key]

    def _exactly(self, numbers: Sequence[int]) -> Stay:
        """By the clauses of a check; left open for loads of other wheels, refused cells, and too much arithmetic."""
        try:
            with work_limit(self.scene.field, UNITS):
                work = Workspace(on_wheels(self.scene, numbers), sample=False)
                for clause in clause_registry.CLAUSES:
                    if clause.name in NEEDED:
                        work.earlier[clause.name] = clause.decide(work)
        except TipsError:
            return Stay(Stays.TIPS)
        except (RefusalError, WorkLimitError, SceneError) as error:
            return Stay(Stays.UNDECIDED, reason=str(error))
        return _stay_of(work)

    def _by_balls(self, numbers: Sequence[int], stay: Stay) -> Stay:
        motion = self.motion(numbers)
        if isinstance(motion, str):
            return stay if stay.reason else Stay(Stays.UNDECIDED, reason=motion)
        if any(not entry.contains(0) for entry in motion.velocity):
            return Stay(Stays.MOVES)
        wheels = [wheel for wheel in self.scene.wheels if wheel.index in numbers]
        if motion.omega.contains(0) or not is_half_turned(wheels, self.scene.check.equilibrium):
            return stay
        turning = 1 if motion.omega > 0 else -1
        return Stay(Stays.TURNS, linear_stability(motion.linearized.tolist()), Rotation.UNSTABLE, turning)


def _stay_of(work: Workspace) -> Stay:
    equilibrium, rotation = work.earlier["equilibrium"], cast("RotationResult", work.earlier["rotation"])
    twists: tuple[Twist, ...] = ()
    rates: tuple[Number, Number] | None = None
    if isinstance(equilibrium, EllipseEquilibrium):
        twist = equilibrium.point.twist
        twists = () if twist is None else (twist,)
        rates = None if twist is None else (twist.omega, twist.omega)
    elif work.partition is not None:
        zero = work.partition.scene.field.zero
        twists = filippov_twists(work.partition, (zero, zero))
        rates = None if rotation.drift is None else rotation.drift.interval
    if equilibrium.verdict is Equilibrium.FAILS:
        return Stay(Stays.MOVES, twists=twists)
    if equilibrium.verdict is Equilibrium.HOLDS and rotation.spin is not None:
        return _enclosed_stay(cast("AnyTranslation", work.earlier["translation"]).verdict, rotation, rotation.spin)
    if equilibrium.verdict is not Equilibrium.HOLDS or rates is None:
        return Stay(Stays.UNDECIDED, reason=equilibrium.reason if rates is None else rotation.reason, twists=twists)
    translation = cast("AnyTranslation", work.earlier["translation"]).verdict
    low, high = (rate.sign() for rate in rates)
    turning = high if low == high else 0
    return Stay(Stays.RESTS if low <= 0 <= high else Stays.TURNS, translation, rotation.verdict, turning, twists=twists)


def _enclosed_stay(translation: Translation, rotation: RotationResult, spin: tuple[Fraction, Fraction]) -> Stay:
    """At a place of rest that is the point within rounding."""
    low, high = spin
    if low <= 0 <= high:
        return Stay(Stays.UNDECIDED, reason=rotation.reason)
    return Stay(Stays.TURNS, translation, rotation.verdict, 1 if low > 0 else -1)


def is_half_turned(wheels: Sequence[Wheel], point: Vector) -> bool:
    """Whether a half turn about a point takes every wheel to one of the same speed, rim, axis and friction, exactly."""
    x, y = point
    return all(any(_does_the_same(one, other, (x + x, y + y)) for other in wheels) for one in wheels)


def _does_the_same(one: Wheel, other: Wheel, twice: Vector) -> bool:
    """Whether a half turn about half of ``twice`` takes one wheel to another."""
    (x, y), (a, b) = one.position, other.position
    if x + a != twice[0] or y + b != twice[1] or one.friction != other.friction:
        return False
    surfaces = [(wheel.unit_direction, wheel.speed) for wheel in (one, other)]
    (d, u), (e, w) = surfaces
    opposite = not any(p * u + q * w for p, q in zip(d, e, strict=True))
    return opposite and not cross(one.grip, other.grip)


# ---- motions on a set of wheels ------------------------------------------------------------------
#
# The spatial twist ``xi = (v, omega)`` minimizes ``D = sum_i N_i(c) f_i(r_i, s_i)``, with the slips and support
# functions of :mod:`nonsmooth.proofs.boxes.linearization`, so the centre of mass enters through the loads alone.  Where
# every loaded wheel slips, ``G(xi, c) = sum_i N_i(c) pull_i(xi) = 0`` determines it.  A wheel that sticks adds two
# equations, no slip, and two unknowns, its force in units of the half-axes.  D is convex, so a zero of G with forces
# inside the friction sets and a regular Jacobian is the only minimizer, and smooth in c.  Krawczyk's operator
# (:mod:`nonsmooth.proofs.boxes.enclosures`) proves one zero near what floats find.


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
