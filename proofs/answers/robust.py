"""Does it hold for every array within the tolerances?"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, cast

from nonsmooth.proofs.answers.answer import Answer, Results, angle_at_most, at_least, at_most, half_life
from nonsmooth.proofs.findings import Certainty, Fact, Quantity
from nonsmooth.symbolic.mechanics.scene import Scene

if TYPE_CHECKING:
    from nonsmooth.proofs.clauses.feedback.clause import AnyFeedback
    from nonsmooth.proofs.robust.decide import Robust
    from nonsmooth.proofs.robust.feedback import RobustLoop

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

    found, loop = decide_robust(scene), decide_robust_loop(scene, cast("AnyFeedback", results["feedback"]).holding)
    if found is None:
        return None
    return Answer(TOLERANCES, found.verdict, (*robust_facts(scene, found), _loop_fact(loop)))


def _loop_fact(loop: RobustLoop | None) -> Fact:
    """How fast feedback holds the pose of every array."""
    if loop is None:
        return Fact("pose_rate", None)
    if loop.rate is None:
        return Fact("pose_rate", None, f"of feedback nothing is said: {loop.reason}")
    time = half_life(loop.rate)
    words = f"feedback holds the pose of every array, with gain k its error halves at least every {time}/k s"
    return Fact("pose_rate", Quantity(loop.rate), words)


def robust_facts(scene: Scene, found: Robust) -> Iterator[Fact]:
    """The keys are the same for every verdict."""
    unit = scene.units.after_length
    if found.verdict is Certainty.UNDECIDED:
        yield Fact(words=found.reason)
    numbers = (
        found.radius,
        found.start,
        found.within,
        found.turning,
        found.equilibrium,
        found.drift,
        found.rests,
    )
    words = dict.fromkeys(KEYS, "") | _words_of_ends(scene, found, unit) | _words_of_equilibria(scene, found, unit)
    if found.rests:
        words["at_rest_within"] = (
            f"for every array within them, a body within {at_least(found.rests)}{unit} of the point stays where it is"
        )
    for key, value in zip(KEYS, numbers, strict=True):
        yield Fact(key, Quantity(value), words[key])
    yield Fact("factor", Quantity(found.factor), _factor_words(found))
    yield Fact("binding", found.binding, "" if found.binding is None else _binding_words(found.binding))


def _words_of_ends(scene: Scene, found: Robust, unit: str) -> dict[str, str]:
    """Where every body ends."""
    if found.start is None or found.radius is None or found.within is None:
        return {}
    words = {
        "radius": f"for every array within them, the body ends within {at_most(found.radius)}{unit} of the point",
        "from": f"from anywhere within {at_least(found.start)}{unit}",
        "within": f"after at most {at_most(found.within)} s",
    }
    if found.turning is not None:
        words["turning"] = f"on the way it turns by at most {angle_at_most(found.turning, scene.units)}"
    return words


def _words_of_equilibria(scene: Scene, found: Robust, unit: str) -> dict[str, str]:
    """One equilibrium of every array."""
    if found.equilibrium is None or found.drift is None:
        return {}
    # a body with an outline that turns comes to lie on other wheels
    turned = scene.body is not None and not scene.body.is_round and found.drift != 0
    kept = ", while they are turned so little that the same wheels carry them" if turned else ""
    near = f"every array within them has one equilibrium within {at_most(found.equilibrium)}{unit} of the point"
    attracts = f"it attracts, exponentially, bodies that start close to it{kept}"
    return {
        "equilibrium": f"{near}; {attracts}",
        "drift": f"there a body turns at no more than {angle_at_most(found.drift, scene.units)}/s",
    }


def _binding_words(name: str) -> str:
    """By what the certificate is bound, which need not be what moves ends most."""
    what = f"the tolerance of {WORDS[name]} binds: without it that certified multiple grows most"
    return f"{what} (which one moves ends most, simulate --tables samples)"


def _factor_words(found: Robust) -> str:
    """How much larger the tolerances may be."""
    if found.factor is None:
        return ""
    if not found.factor:
        return "no multiple of the tolerances above a thousandth is certified"
    return f"such a bound is certified up to {at_least(found.factor)} times the tolerances"
