"""Questions of a builder, their closed sets of answers, and what an answer holds.

An answer says in plain words what the clauses of a check show with their evidence; it decides nothing itself.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeAlias, cast

from flint import arb

from nonsmooth.analysis.cells.contact_rule import has_cells
from nonsmooth.proofs.findings import Certainty, Fact, Quantity, Rotation
from nonsmooth.symbolic.mechanics.contact_set import contact_set
from nonsmooth.symbolic.mechanics.contact_states import free_text, free_twists
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.units import Units
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.numbers.enclosures import rational_above, rational_below
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import lower_text, numbers_text, upper_text
from nonsmooth.symbolic.numbers.rounded import BY_ROUNDING

if TYPE_CHECKING:
    from nonsmooth.proofs.clauses.feedback.clause import AnyFeedback
    from nonsmooth.proofs.clauses.workspace import ClauseResult
    from nonsmooth.proofs.theorem4 import Theorem4Result

UNDECIDED = "undecided"
WHY_BELOW = "; why: below"  # at the end of an answer beside which the clauses stand


class Position(StrEnum):
    """Where a body goes that starts near the checked point."""

    COMES_HOME = "comes home"
    COMES_NEAR = "comes near"  # within the accuracy of the point, from at least twice as far
    STAYS_NEAR = "stays near"
    LEAVES = "leaves"
    UNSTABLE = "unstable"  # of another place: some bodies go away from it, nobody asked how far
    TIPS = "tips"  # it does not lie on the wheels at the checked pose
    UNDECIDED = "undecided"


class Heading(StrEnum):
    """What its heading does."""

    KEEPS = "keeps"
    DRIFTS = "drifts"
    UNDECIDED = "undecided"


class Pose(StrEnum):
    """Whether a feedback law can hold position and heading together."""

    CAN_BE_HELD = "can be held"
    CANNOT_BE_HELD = "cannot be held"
    UNDECIDED = "undecided"


class Inertia(StrEnum):
    """What a body with inertia does near its place of rest, by the linearized full dynamics."""

    STABLE = "stable"
    UNSTABLE = "unstable"  # which does not say that it leaves
    UNDECIDED = "undecided"


GOOD = frozenset(
    {Inertia.STABLE, Position.COMES_HOME, Position.COMES_NEAR, Heading.KEEPS, Pose.CAN_BE_HELD, Certainty.CERTIFIED}
)


@dataclass(frozen=True, repr=False)
class Answer:
    """The answer to one question.

    Attributes:
        name: the question's name: its key in JSON, and in ``--require``.
        verdict: the answer, one of a closed set.
        told: the facts, which may be found out as they are told.
    """

    name: str
    verdict: Position | Heading | Pose | Certainty | Inertia
    told: Iterable[Fact]

    @cached_property
    def facts(self) -> tuple[Fact, ...]:
        """How far, how fast, on what conditions: numbers with their words."""
        return tuple(self.told)

    @property
    def sentence(self) -> str:
        """The words of all facts."""
        return "; ".join(fact.words for fact in self.facts if fact.words)

    @property
    def numbers(self) -> dict[str, Any]:
        """What the facts say under their keys: exact numbers, texts and lists; None where there is none."""
        values = {fact.key: fact.value for fact in self.facts if fact.key}
        return {key: value.value if isinstance(value, Quantity) else value for key, value in values.items()}

    def __getitem__(self, key: str) -> Any:
        """One of the numbers: ``answer["within"]``.

        Raises:
            KeyError: for a key that the answer has not.
        """
        return self.numbers[key]

    def __repr__(self) -> str:
        return f"{self.verdict}: {self.sentence}"

    @property
    def tone(self) -> str:
        """``good``, ``fair``, ``bad`` or ``open``: how the answer looks in color."""
        if self.verdict in (Position.STAYS_NEAR, Heading.DRIFTS):
            return "fair"
        return {0: "good", 1: "bad", 3: "open"}[self.exit_status]

    @property
    def exit_status(self) -> int:
        """0 where the answer is the one a builder hopes for, 3 where it is undecided, else 1."""
        if self.verdict == UNDECIDED:
            return 3
        return 0 if self.verdict in GOOD else 1


Results: TypeAlias = "Mapping[str, ClauseResult]"
Question: TypeAlias = Callable[[Scene, Results], Answer]


def reason_below(answer: Answer, results: Results) -> str:
    """What an answer refers to that says that its reason stands below; empty for another one."""
    if WHY_BELOW not in answer.sentence:
        return ""
    if answer.name == "pose":
        return cast("AnyFeedback", results["feedback"]).holding.reason
    return results["translation" if answer.name == "position" else "rotation"].reason


def is_by_rounding(results: Results, *names: str) -> bool:
    """Whether rounding would decide one of these clauses."""
    return any(BY_ROUNDING in results[name].reason for name in names)


def has_dynamics(scene: Scene) -> bool:
    """Whether answers are asked of a body with inertia: its gravity is known, and its rule says which forces act."""
    return scene.inertia is not None and not has_cells(scene)


def require_tolerances(scene: Scene) -> None:
    """Refuse to ask what holds within tolerances of a scene that states none.

    Raises:
        SceneError: of such a scene.
    """
    if scene.tolerances is None:
        raise SceneError(scene.origin, "tolerance", "a table of tolerances to require them", StatedFact("none"))


def require_dynamics(scene: Scene, key: str) -> None:
    """Refuse to ask of a body with inertia.

    Args:
        scene: the array.
        key: what asks for it, for the message.

    Raises:
        SceneError: where the scene does not say what gravity is or which forces act.
    """
    if not has_dynamics(scene):
        expected = "[units] and rule ellipse, roller or mixed, under which bodies with inertia are followed"
        lacks = f"rule {scene.contact.rule}" if scene.inertia is not None else "no [units]"
        raise SceneError(scene.origin, key, expected, StatedFact(lacks))


# ---- numbers of an answer as a reader of a data sheet wants them ---------------------------------
#
# Four digits, rounded to the safe side.


DIGITS = 4
LN_2 = Fraction(693_147_180_560, 10**12)  # just above the natural logarithm of 2

Positive: TypeAlias = Number | Lazy | Fraction | arb


def at_least(value: Positive) -> str:
    """A decimal that is not above the number."""
    return lower_text(_comparable(value), DIGITS)


def at_most(value: Positive) -> str:
    """A decimal that is not below the number."""
    return upper_text(_comparable(value, rational_above), DIGITS)


def half_life(rate: Positive) -> str:
    """``ln 2/rate``: the time in which ``exp(-rate t)`` halves, rounded up."""
    return at_most(LN_2 / _comparable(rate))


def _comparable(value: Positive, end: Callable[[arb], Fraction] = rational_below) -> Number | Lazy | Fraction:
    """A number, or an end of a ball."""
    return end(value) if isinstance(value, arb) else value


# ---- units ---------------------------------------------------------------------------------------

HALF_TURN = 180, Fraction(355, 113), Fraction(3_141_592_653, 10**9)  # degrees; just above pi, just below


def angle_at_least(value: Positive, units: Units) -> str:
    """An angle (radian) or a rate of one in the unit of the scene, not above it: ``5.13 deg``."""
    degrees, above, _ = HALF_TURN
    shown = _comparable(value) * (degrees / above) if units.in_degrees else value
    return f"{at_least(shown)} {units.angle}"


def angle_at_most(value: Positive, units: Units) -> str:
    """An angle (radian) or a rate of one in the unit of the scene, not below it."""
    degrees, _, below = HALF_TURN
    shown = _comparable(value, rational_above) * (degrees / below) if units.in_degrees else value
    return f"{at_most(shown)} {units.angle}"


# ---- which wheels carry the body -----------------------------------------------------------------
#
# Which wheels carry the body, and how far the answers hold: only while no wheel enters or leaves.


ALL_CARRY = "all wheels carry the body, at every pose: the scene names no [body]"
WITHOUT_SHAPE = "all wheels carry the body, at every pose: the scene states no shape of it"


def contact_facts(check: Theorem4Result) -> tuple[Fact, ...]:
    """The contact set of a check under its keys, and the twists that its rows leave ``free``, about the point."""
    free = free_twists(check.scene.recentred())
    words = f"free: {free_text(free)}, so D is the same all along" if free else ""
    return *_facts(check), Fact("free", Quantity(free), words)


def how_far(scene: Scene, place: str = "here", heading: str = "this heading") -> str:
    """How far a body with an outline may move and turn for certain on the same wheels; empty without one."""
    contacts = contact_set(scene)
    if contacts.margin is None:
        return ""
    words = f"within {at_least(contacts.margin)}{scene.units.after_length} of {place}"
    if contacts.angle is None:
        return words
    return f"{words}, or {angle_at_least(contacts.angle, scene.units)} of {heading} (of both: shares that add up to 1)"


def _facts(check: Theorem4Result) -> Iterator[Fact]:
    scene = check.scene
    contacts, unit = contact_set(scene), scene.units.after_length
    if scene.body is None or contacts.margin is None:
        names_body = scene.inertia is not None and scene.inertia.is_stated
        yield Fact("wheels", list(contacts.wheels), WITHOUT_SHAPE if names_body else ALL_CARRY)
        yield from (Fact(key, Quantity(None)) for key in ("margin", "angle", "keeps_wheels_within"))
        return
    count = len(scene.wheels) + len(scene.idle)
    words = f"{scene.body.words}: wheels {numbers_text(contacts.wheels)} of {count} carry it"
    if not scene.idle:
        words = f"{scene.body.words}: all {count} wheels carry it"
    yield Fact("wheels", list(contacts.wheels), words)
    words = f"the answers hold while no wheel enters or leaves: for certain {how_far(scene)}"
    yield Fact("margin", Quantity(contacts.margin), words)
    yield Fact("angle", Quantity(contacts.angle))
    turn = check.rotation.rotation_per_distance if check.rotation.verdict is Rotation.NEUTRAL else None
    keeps = None if turn is None else contacts.start_that_keeps(turn)
    said = "" if keeps is None else f"from within {at_least(keeps)}{unit} it keeps its wheels all the way home"
    yield Fact("keeps_wheels_within", Quantity(keeps), said)
