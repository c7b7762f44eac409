"""The answers to a check, their registry, and what is said beside them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, cast

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.proofs import clause_registry
from nonsmooth.proofs.answers.answer import (
    DIGITS,
    Answer,
    Position,
    Question,
    Results,
    angle_at_most,
    at_least,
    at_most,
    half_life,
    require_dynamics,
    require_tolerances,
)
from nonsmooth.proofs.answers.heading import heading_answer, headings_of_rest
from nonsmooth.proofs.answers.pose import pose_answer
from nonsmooth.proofs.answers.position import position_answer
from nonsmooth.proofs.clauses.workspace import Workspace
from nonsmooth.proofs.findings import Certainty, Fact, Quantity
from nonsmooth.proofs.theorem4 import Theorem4Result
from nonsmooth.symbolic.mechanics.rule import CONTACT_RULES
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.springs import under_rule
from nonsmooth.symbolic.messages.under_way import part_of, tell
from nonsmooth.symbolic.numbers.number_text import float_text
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, work_limit

if TYPE_CHECKING:
    from nonsmooth.proofs.answers.destinations import Destinations, RestPoint
    from nonsmooth.proofs.answers.heading import HeadingsOfRest
    from nonsmooth.proofs.clauses.feedback.clause import AnyFeedback
    from nonsmooth.proofs.robust.decide import Robust
    from nonsmooth.proofs.robust.feedback import RobustLoop


# ---- what the other contact rules answer about position and heading, in a few words each ---------
#
# A check is about one contact rule.  Which of them fits a machine is often not known, so the first clauses are decided
# under the others too, where that is little work.


FEW_UNITS = 150_000  # of exact arithmetic: a fifth of a second or so
FEW_WHEELS = 1_000  # beyond them loads and support polygons alone, which are not counted in units, take longer
TAKES_LONG = "not asked: it takes a while"


class OtherRule(NamedTuple):
    """What one contact rule says, or why it says nothing.

    Attributes:
        name: of the rule.
        answers: position and heading; empty where there are none.
        why_not: why there are none.
        equilibrium: whether the point is an equilibrium; None where there is no answer.
    """

    name: str
    answers: tuple[Answer, ...]
    why_not: str = ""
    equilibrium: str | None = None


def other_rules(scene: Scene) -> tuple[OtherRule, ...]:
    """Position and heading under every contact rule but the scene's own."""
    names, others = [name for name in CONTACT_RULES if name != scene.contact.rule], []
    for k, name in enumerate(names):
        with part_of(k, len(names), "other rules"):
            others.append(_under(scene, name))
    return tuple(others)


def _under(scene: Scene, name: str) -> OtherRule:
    if len(scene.wheels) > FEW_WHEELS:
        return OtherRule(name, (), TAKES_LONG)
    other = under_rule(scene, name)
    try:
        with work_limit(scene.field, FEW_UNITS):
            results = clause_registry.decide_clauses(Workspace(other, sample=False), left_out="feedback")
    except RefusalError as error:
        return OtherRule(name, (), str(error))
    except WorkLimitError:
        return OtherRule(name, (), TAKES_LONG)
    answers = (position_answer(other, results), heading_answer(other, results))
    return OtherRule(name, answers, equilibrium=str(results["equilibrium"].verdict))


# ---- the registry --------------------------------------------------------------------------------


# In the order in which they are said; to ask another question, write its function and a line here.
QUESTIONS: dict[str, Question] = {"position": position_answer, "heading": heading_answer, "pose": pose_answer}
THEOREM, INERTIA = "theorem4", "inertia"


@dataclass(frozen=True)
class Answers:
    """What a builder asked, answered.

    Attributes:
        answers: one to every question, in order.
        destinations: where bodies from all over the square end, where they do not all come home.
        others: what the other contact rules say.
        robust: what holds for every array within the tolerances; None for a scene that states none.
        headings: at which headings a body with an outline rests; None where its heading does not matter.
        rest_points: the places of rest among which the checked point was chosen, the best first; None where it was
            not chosen.
        inertia: what a body with inertia does; None where the scene does not say what gravity is, and under rules that
            do not say which forces act.
    """

    answers: tuple[Answer, ...]
    destinations: Destinations | None
    others: tuple[OtherRule, ...]
    robust: Answer | None = None
    headings: HeadingsOfRest | None = None
    rest_points: tuple[RestPoint, ...] | None = None
    inertia: Answer | None = None

    @property
    def rows(self) -> tuple[Answer, ...]:
        """All that is a verdict with a sentence, in the order in which it is said."""
        first, *others = self.answers
        beside = [answer for answer in (self.inertia,) if answer is not None]
        return (first, *beside, *others, *([] if self.robust is None else [self.robust]))


def answers_of(check: Theorem4Result) -> tuple[Answer, ...]:
    """The answer to every question, from the clauses of the check; only the pose may need a decision beyond them."""
    clauses = {name for contradiction in check.contradictions for name in contradiction.clauses}
    may_look = clauses.isdisjoint({"equilibrium", "translation"})
    position = position_answer(check.scene, check.results, may_look=may_look)
    others = (question(check.scene, check.results) for name, question in QUESTIONS.items() if name != position.name)
    return position, *others


def full_answers(
    check: Theorem4Result,
    *,
    ask_others: bool = True,
    around: bool = False,
    rest_points: tuple[RestPoint, ...] | None = None,
) -> Answers:
    """The answers with what they leave open: where bodies go otherwise, and what the other rules say.

    Args:
        check: the verdicts.
        ask_others: say what the other rules say.
        around: look for headings of rest around the checked point too.
        rest_points: the places of rest among which the checked point was chosen, where it was.
    """
    tell("where bodies near the point end")
    answers = answers_of(check)
    position = answers[0].verdict
    goes_elsewhere = position is not Position.COMES_HOME or bool(check.other_equilibria)
    tell("where bodies go that start in the square")
    destinations = _destinations_of(check) if goes_elsewhere else None
    others = other_rules(check.scene) if ask_others else ()
    tell("headings of rest")
    headings = _headings_of(check, around=around)
    tell("tolerances")
    robust = robust_answer(check.scene, check.results)
    tell("a body with inertia")
    return Answers(answers, destinations, others, robust, headings, rest_points, _inertia_of(check))


def _inertia_of(check: Theorem4Result) -> Answer | None:
    if check.scene.inertia is None:
        return None
    from nonsmooth.proofs.answers.inertia import inertia_answer  # full dynamics: only a scene with units loads them

    return inertia_answer(check.scene)


def _headings_of(check: Theorem4Result, *, around: bool) -> HeadingsOfRest | None:
    if check.scene.body is None:
        return None
    return headings_of_rest(check.scene, around=around)


def _destinations_of(check: Theorem4Result) -> Destinations | None:
    if check.partition is not None and check.equilibria is None:  # places where bodies may end are not known
        return None
    from nonsmooth.proofs.answers.destinations import destinations_of  # paths: only a check that needs them loads them

    return destinations_of(check)


def exit_status(check: Theorem4Result, required: Sequence[str], answered: Answers | None = None) -> int:
    """0 where every required answer is the one a builder hopes for, 1 where one is not, else 3 for undecided.

    3 where anything that is said contradicts something else, whatever is required.

    Args:
        check: the verdicts.
        required: names of questions, :data:`THEOREM`, :data:`INERTIA` or :data:`TOLERANCES`.
        answered: the answers, where they are known already.

    Raises:
        SceneError: where tolerances are required of a scene that states none, and inertia of one that does not say what
            gravity is or which forces act.
    """
    by_name = {answer.name: answer.exit_status for answer in answers_of(check)}
    by_name[THEOREM] = check.verdict.exit_status
    if TOLERANCES in required:
        require_tolerances(check.scene)
        robust = robust_answer(check.scene, check.results) if answered is None else answered.robust
        by_name[TOLERANCES] = 3 if robust is None else robust.exit_status
    if INERTIA in required:
        require_dynamics(check.scene, "--require inertia")
        answer = _inertia_of(check) if answered is None else answered.inertia
        by_name[INERTIA] = 3 if answer is None else _inertia_status(answer)
    if check.contradictions:
        return 3
    statuses = {by_name[name] for name in required}
    return next((status for status in (1, 3) if status in statuses), 0)


def _inertia_status(answer: Answer) -> int:
    """0 where the body is stable close to its place of rest (proved) and settles from all starts (simulated).

    1 too where one of these starts ends on a limit cycle or is thrown off, 3 where one is still moving.
    """
    if answer.exit_status or answer.numbers.get("settles_after") is not None:
        return answer.exit_status
    ends = {str(one["what"]) for one in answer.numbers.get("from", ())}
    return 1 if ends & {"limit cycle", "thrown off"} else 3


# ---- the answer for every array within tolerances ------------------------------------------------
#
# Does it hold for every array within the tolerances?


TOLERANCES = "tolerances"
KEYS = ("radius", "from", "within", "turning", "equilibrium", "drift", "at_rest_within")
WORDS = {
    "position": "the positions of the wheels",
    "heading": "the headings of the wheels",
    "speed": "the speeds",
    "mu_roll": "mu_roll",
    "mu_side": "mu_side",
    "centre_of_mass": "the centre of mass",
}


def robust_answer(scene: Scene, results: Results) -> Answer | None:
    """The answer for every array within the scene's tolerances; None for a scene that states none."""
    if scene.tolerances is None:
        return None
    from nonsmooth.proofs.robust.decide import decide_robust  # only a scene that states tolerances needs it
    from nonsmooth.proofs.robust.feedback import decide_robust_loop

    robust, loop = decide_robust(scene), decide_robust_loop(scene, cast("AnyFeedback", results["feedback"]).holding)
    if robust is None:
        return None
    return Answer(TOLERANCES, robust.verdict, (*robust_facts(scene, robust), _loop_fact(loop)))


def _loop_fact(loop: RobustLoop | None) -> Fact:
    """How fast feedback holds the pose of every array."""
    if loop is None:
        return Fact("pose_rate", None)
    if loop.rate is None:
        return Fact("pose_rate", None, f"of feedback nothing is said: {loop.reason}")
    time = half_life(loop.rate)
    words = f"feedback holds the pose of every array, with gain k its error halves at least every {time}/k s"
    return Fact("pose_rate", Quantity(loop.rate), words)


def robust_facts(scene: Scene, robust: Robust) -> Iterator[Fact]:
    """The keys are the same for every verdict."""
    unit = scene.units.after_length
    if robust.verdict is Certainty.UNDECIDED:
        yield Fact(words=robust.reason)
    numbers = (
        robust.radius,
        robust.start,
        robust.within,
        robust.turning,
        robust.equilibrium,
        robust.drift,
        robust.rests,
    )
    words = dict.fromkeys(KEYS, "") | _words_of_ends(scene, robust, unit) | _words_of_equilibria(scene, robust, unit)
    if robust.rests:
        words["at_rest_within"] = (
            f"for every array within them, a body within {at_least(robust.rests)}{unit} of the point stays where it is"
        )
    for key, value in zip(KEYS, numbers, strict=True):
        yield Fact(key, Quantity(value), words[key])
    yield Fact("factor", Quantity(robust.factor), _factor_words(robust))
    yield Fact("binding", robust.binding, "" if robust.binding is None else _binding_words(robust.binding))


def _words_of_ends(scene: Scene, robust: Robust, unit: str) -> dict[str, str]:
    """Where every body ends."""
    if robust.start is None or robust.radius is None or robust.within is None:
        return {}
    near = f"the body ends within {at_most(robust.radius)}{unit} of the point"
    if robust.radius > scene.accuracy:
        near += f", farther than the accuracy, {float_text(float(scene.accuracy), DIGITS)}{unit}"
    words = {
        "radius": f"for every array within them, {near}",
        "from": f"from anywhere within {at_least(robust.start)}{unit}",
        "within": f"after at most {at_most(robust.within)} s",
    }
    if robust.turning is not None:
        words["turning"] = f"on the way it turns by at most {angle_at_most(robust.turning, scene.units)}"
    return words


def _words_of_equilibria(scene: Scene, robust: Robust, unit: str) -> dict[str, str]:
    """One equilibrium of every array."""
    if robust.equilibrium is None or robust.drift is None:
        return {}
    # a body with an outline that turns comes to lie on other wheels
    turned = scene.body is not None and not scene.body.is_round and robust.drift != 0
    kept = ", while they are turned so little that the same wheels carry them" if turned else ""
    near = f"every array within them has one equilibrium within {at_most(robust.equilibrium)}{unit} of the point"
    attracts = f"it attracts, exponentially, bodies that start close to it{kept}"
    return {
        "equilibrium": f"{near}; {attracts}",
        "drift": f"there a body turns at no more than {angle_at_most(robust.drift, scene.units)}/s",
    }


def _binding_words(name: str) -> str:
    """By what the certificate is bound, which need not be what moves ends most."""
    what = f"the tolerance of {WORDS[name]} binds: without it that certified multiple grows most"
    return f"{what} (which one moves ends most, simulate --tables samples)"


def _factor_words(robust: Robust) -> str:
    """How much larger the tolerances may be."""
    if robust.factor is None:
        return ""
    if not robust.factor:
        return "no multiple of the tolerances above a thousandth is certified"
    return f"such a bound is certified up to {at_least(robust.factor)} times the tolerances"
