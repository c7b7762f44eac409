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
from typing import TYPE_CHECKING, cast

import numpy as np
from flint import arb, arb_mat

from nonsmooth.analysis.cells.contact_rule import SmoothRule, rule_of, smooth_rule_of
from nonsmooth.analysis.cells.filippov import filippov_twists
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.proofs import clause_registry
from nonsmooth.proofs.boxes.balanced_forces import LoadBox, load_box
from nonsmooth.proofs.boxes.enclosed_rest import Balance, enclosed_motion
from nonsmooth.proofs.boxes.enclosures import linear_stability
from nonsmooth.proofs.clauses.equilibrium.clause import EllipseEquilibrium
from nonsmooth.proofs.clauses.rotation.clause import RotationResult
from nonsmooth.proofs.clauses.translation.clause import AnyTranslation
from nonsmooth.proofs.clauses.workspace import Workspace
from nonsmooth.proofs.findings import Equilibrium, Rotation, Translation
from nonsmooth.symbolic.mechanics.contact_set import TipsError, on_wheels, whole
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.mechanics.edge_headings import ball_of
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import Vector, cross
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, work_limit

if TYPE_CHECKING:
    from nonsmooth.analysis.bodies.set_motion import SetGuesses

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


class BodyAtPoint:
    """What sets of wheels do at one point; to be used at one working precision."""

    def __init__(self, scene: Scene) -> None:
        """At the checked point of a scene."""
        self.scene = whole(scene)
        rule = rule_of(scene)
        known = scene.contact.loads is None
        self.rule = rule if isinstance(rule, SmoothRule) and known else None
        self._guesses: SetGuesses | None = None
        self._motions: dict[tuple[int, ...], EnclosedMotion | None] = {}
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
        motion = None if stay.kind is Stays.TIPS else self.motion(numbers)
        return None if motion is None else [arb_mat([[*motion.velocity, motion.omega]])]

    def motion(self, numbers: Sequence[int]) -> EnclosedMotion | None:
        """The enclosed motion on the wheels with some numbers; None where none is proved.

        It is looked for under a rule without cells and with elastic loads.
        """
        if self.rule is None:
            return None
        if self._guesses is None:
            from nonsmooth.analysis.bodies.set_motion import SetGuesses  # floats: only where exact clauses leave open

            self._guesses = SetGuesses(self.scene, self.rule)
        key = tuple(numbers)
        if key not in self._motions:
            places = [k for k, wheel in enumerate(self.scene.wheels) if wheel.index in key]
            x, y = map(ball_of, self.scene.check.equilibrium)
            self._motions[key] = set_motion(self.scene, self._guesses, places, (x, y))
        return self._motions[key]

    def _exactly(self, numbers: Sequence[int]) -> Stay:
        """By the clauses of a check; left open for loads of other wheels, refused cells, and too much arithmetic."""
        try:
            with work_limit(self.scene.field, UNITS):
                work = Workspace(on_wheels(self.scene, numbers), sample=False)
                clause_registry.decide_clauses(work, left_out="feedback")
        except TipsError:
            return Stay(Stays.TIPS)
        except (RefusalError, WorkLimitError, SceneError) as error:
            return Stay(Stays.UNDECIDED, reason=str(error))
        return _stay_of(work)

    def _by_balls(self, numbers: Sequence[int], stay: Stay) -> Stay:
        motion = self.motion(numbers)
        if motion is None:
            return stay
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
        twists = filippov_twists(work.partition)
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
# functions of :mod:`nonsmooth.proofs.boxes.linearization`, so the centre of mass enters through the loads alone.  The
# equations of wheels that slip, and of those that stick, are those of a place of rest
# (:class:`nonsmooth.proofs.boxes.enclosed_rest.Balance`), with the twist for their unknown in place of c.


@dataclass(frozen=True)
class EnclosedMotion:
    """The only minimizer of D.

    Attributes:
        centre: ``c``.
        twist: encloses the spatial twist.
        linearized: ``dc'/dc``, (2, 2).
    """

    centre: tuple[arb, arb]
    twist: tuple[arb, arb, arb]
    linearized: arb_mat

    @property
    def velocity(self) -> tuple[arb, arb]:
        """Of the centre of mass: ``v + omega J c``."""
        (vx, vy, omega), (x, y) = self.twist, self.centre
        return vx - omega * y, vy + omega * x

    @property
    def omega(self) -> arb:
        """The rotation rate."""
        return self.twist[2]


def set_motion(
    scene: Scene, guesses: SetGuesses, wheels: Sequence[int], centre: tuple[arb, arb]
) -> EnclosedMotion | None:
    """The motion on some wheels of a scene, by their places in its list; None where it is not proved to be one.

    So it is where a loaded wheel may be free or a free one pressed, and where it is not smooth in c.
    """
    guess = guesses.of(wheels, (float(centre[0].mid()), float(centre[1].mid())))
    chosen = tuple(scene.wheels[k] for k in wheels)
    on_these = replace(scene, wheels=chosen)
    springs = None if guess is None else load_box(on_these, arb(0), np.flatnonzero(guess.loaded).tolist())
    if guess is None or springs is None:
        return None
    pushes = zip(springs.at(centre), guess.loaded, strict=True)
    if not all(push > 0 if pressed else push < 0 for push, pressed in pushes):
        return None  # loads may change their form
    sets = [smooth_rule_of(scene).friction_set(wheel.friction) for wheel in chosen]
    rubbing = [
        k for k, friction_set in enumerate(sets) if guess.loaded[k] and (friction_set.along or friction_set.across)
    ]
    part = replace(scene, wheels=tuple(chosen[k] for k in rubbing))
    held = {n: 2 for n, k in enumerate(rubbing) if guess.stuck[k]}
    balance = Balance(part, LoadBox(tuple(springs.forms[k] for k in rubbing)), held)
    start = [*guess.twist, *[0.0] * (balance.size - 3)]
    enclosed = enclosed_motion(balance, arb_mat([[arb(value)] for value in start]), centre)
    if enclosed is None:
        return None
    vx, vy, omega = enclosed[0].entries()[:3]
    return EnclosedMotion(centre, (vx, vy, omega), enclosed[1])
