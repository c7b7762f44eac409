"""Where does a body go that starts near the checked point?"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from fractions import Fraction
from typing import cast

from nonsmooth.proofs.answers.answer import (
    DIGITS,
    WHY_BELOW,
    Answer,
    Position,
    Results,
    at_least,
    at_most,
    half_life,
    has_dynamics,
    is_by_rounding,
)
from nonsmooth.proofs.answers.nearness import Nearness, Turning, homecoming, nearness
from nonsmooth.proofs.clauses.rotation.clause import RotationResult
from nonsmooth.proofs.clauses.translation.at_point import EllipseTranslation
from nonsmooth.proofs.clauses.translation.clause import AnyTranslation, mass_words
from nonsmooth.proofs.findings import Equilibrium, Fact, Quantity, Translation, said
from nonsmooth.proofs.robust.ends import Ends
from nonsmooth.symbolic.mechanics.contact_set import may_turn_off_wheels
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.number_text import Real, float_text, place_text

ONLY_ROUNDING = "which only rounding tells from it"
MOST_TEXT = 20  # characters of a number that is printed exactly
ALL_DIGITS = 17  # which tell any float from all others

OF_TRANSLATION = {
    Translation.ASYMPTOTICALLY_STABLE: Position.COMES_HOME,
    Translation.STABLE: Position.STAYS_NEAR,
    Translation.UNSTABLE: Position.LEAVES,
    Translation.UNDECIDED: Position.UNDECIDED,
}

# Of a place that is not the checked point: where bodies that go away from it end is not asked.
OF_PLACE = {**OF_TRANSLATION, Translation.UNSTABLE: Position.UNSTABLE}


def position_answer(scene: Scene, results: Results, *, may_look: bool = True) -> Answer:
    """From the clauses on the equilibrium and on (x, y); where these do not say it, from where bodies end.

    Args:
        scene: the array.
        results: the clauses' results by name.
        may_look: whether to ask where bodies end; not where what is said contradicts itself.
    """
    verdict, near = _by_clauses(results), None
    if (verdict is Position.COMES_HOME and not _is_beside(results)) or not may_look:
        verdict = Position.UNDECIDED if verdict is Position.LEAVES else verdict
    else:
        near = nearness(scene, results)
        verdict = _to_the_accuracy(verdict, near)
    facts = (*_without_inertia(scene, _facts(scene, results, verdict, near)), *_until_others(scene, results, verdict))
    return Answer("position", verdict, facts)


def _until_others(scene: Scene, results: Results, verdict: Position) -> Iterator[Fact]:
    """How long that holds of a body with an outline, on the wheels of the point, that turns on where it rests."""
    stays = verdict in {Position.COMES_HOME, Position.STAYS_NEAR}
    if stays and may_turn_off_wheels(scene) and cast("RotationResult", results["rotation"]).turns_on:
        yield said("but there it turns all the time, until other wheels may carry it")


def _without_inertia(scene: Scene, facts: Iterable[Fact]) -> tuple[Fact, ...]:
    """The same, with words that say of which body they are, where one with inertia is spoken of beside it."""
    stated = list(facts)
    first = next((k for k, fact in enumerate(stated) if fact.words), None)
    if first is not None and has_dynamics(scene):
        stated[first] = replace(stated[first], words=f"without inertia: {stated[first].words}")
    return tuple(stated)


def _by_clauses(results: Results) -> Position:
    match results["equilibrium"].verdict:
        case Equilibrium.HOLDS:
            return OF_TRANSLATION[_translation(results).verdict]
        case Equilibrium.FAILS:
            return Position.LEAVES
        case _:
            return Position.UNDECIDED


def _is_beside(results: Results) -> bool:
    """Whether the clauses speak of a place of rest that only rounding tells from the point."""
    return getattr(results["equilibrium"], "rounding_distance", None) is not None


def _to_the_accuracy(by_clauses: Position, near: Nearness) -> Position:
    """The verdict with what is shown of the ends: that a body leaves the point itself is not enough for "leaves"."""
    if near.rests_within is not None:
        return Position.COMES_HOME
    if near.comes_near:
        return Position.COMES_NEAR
    if by_clauses is Position.STAYS_NEAR or near.turning is not None:
        return Position.STAYS_NEAR
    return Position.LEAVES if near.leaves else Position.UNDECIDED


def _translation(results: Results) -> AnyTranslation:
    return cast("AnyTranslation", results["translation"])


def _facts(scene: Scene, results: Results, verdict: Position, looked: Nearness | None) -> Iterator[Fact]:
    """How near, how far and how fast; the keys are the same for every verdict."""
    translation, unit = _translation(results), scene.units.after_length
    yield Fact("accuracy", Quantity(_short(scene.accuracy)))
    if looked is not None and looked.rests_within is not None:
        yield from _coming_beside(scene, looked, looked.rests_within, translation.exponential_rate, unit)
        return
    if verdict is Position.COMES_HOME:
        yield from _place(scene, Quantity(Fraction(0)), (Fraction(0), Fraction(0)))
        yield from _homecoming(scene, translation, unit)
        yield said(translation.support_note)
        if isinstance(translation, EllipseTranslation) and not has_dynamics(scene):
            yield said(mass_words(translation.mass, scene.units))
        return
    ends = None if looked is None else looked.ends
    if verdict is Position.COMES_NEAR and ends is not None:
        yield from _coming_near(scene, ends, unit)
        return
    stays = translation.region_radius if verdict is Position.STAYS_NEAR else None
    out_after = None if looked is None else looked.out_after
    yield from _place(scene, Quantity(None), None if ends is None else ends.at)
    yield Fact("after", Quantity(out_after if ends is None else Fraction(at_most(ends.after))))
    within = None if looked is None or looked.turning is None else looked.turning.within
    yield from (Fact("within", Quantity(within)), Fact("seconds_per_distance", Quantity(None)))
    yield from (Fact("swings_out_to", Quantity(None)), Fact("rate", Quantity(None)))
    yield Fact("stays_within", Quantity(stays))
    if stays is not None:
        yield said(f"a body within {at_least(stays)}{unit} of the point never gets farther away")
    elif verdict is Position.LEAVES and looked is not None and looked.leaves:
        yield said(_away(scene, looked, unit))
    else:
        yield said(_plainly(scene, verdict, results, unit, looked))
    yield said(translation.support_note)


def _place(scene: Scene, ends_within: Quantity, offset: tuple[Fraction, Fraction] | None) -> Iterator[Fact]:
    """How near to the point bodies end, and about which place, in the coordinates of the scene."""
    yield Fact("ends_within", ends_within)
    x, y = scene.check.equilibrium
    yield Fact("at", Quantity(None if offset is None else (x + offset[0], y + offset[1])))


def _short(value: Fraction) -> Fraction:
    """A number as it is printed."""
    return value if len(str(value)) <= MOST_TEXT else Fraction(at_least(value))


def _coming_near(scene: Scene, ends: Ends, unit: str) -> Iterator[Fact]:
    """How near, from how far, and how long it takes at most."""
    ends_within, within, after = at_most(ends.ends_within or Fraction(0)), at_least(ends.within), at_most(ends.after)
    yield from _place(scene, Quantity(Fraction(ends_within)), ends.at)
    yield Fact("within", Quantity(Fraction(within)))
    yield Fact("after", Quantity(Fraction(after)))
    kept = "" if scene.body is None else ", while the same wheels carry it"
    start = f"from anywhere within {within}{unit} of it, in at most {after} s{kept}"
    yield said(f"within {ends_within}{unit} of the point, {start}")
    yield _swing(ends, unit)
    if any(ends.at):
        yield said(_where(scene, ends, unit))
    yield said(f"the accuracy is {float_text(float(scene.accuracy), DIGITS)}{unit}")
    yield from (Fact(key, Quantity(None)) for key in ("seconds_per_distance", "rate", "stays_within"))


def _coming_beside(
    scene: Scene, looked: Nearness, rests_within: Fraction, rate: Real | None, unit: str
) -> Iterator[Fact]:
    """To the place of rest that only rounding tells from the point, from close by; and from how far near it."""
    home, beside = looked.home, at_most(rests_within)
    there = Fraction(at_most(rests_within if home is None else home.about))
    yield from _place(scene, Quantity(there), (Fraction(0), Fraction(0)))
    yield from _from_discs(looked, unit, f", to a place of rest within {beside}{unit} of the point, {ONLY_ROUNDING}")
    yield Fact("after", Quantity(None if home is None else Fraction(at_most(home.after))))
    yield Fact("seconds_per_distance", Quantity(None))
    yield _rate(rate)
    yield Fact("stays_within", Quantity(None))


def _from_discs(looked: Nearness, unit: str, goal: str = "") -> Iterator[Fact]:
    """From how far bodies come, how soon they are how near, and how far they get on their way, by enclosures alone."""
    ends, home = looked.ends, looked.home
    start = "close by" if home is None else f"anywhere within {at_least(home.within)}{unit}"
    yield Fact("within", Quantity(None if home is None else Fraction(at_least(home.within))), f"from {start}{goal}")
    if ends is not None and ends.is_near:
        near, within, after = at_most(ends.ends_within or Fraction(0)), at_least(ends.within), at_most(ends.after)
        start = "" if home is not None and home.within == ends.within else f"from anywhere within {within}{unit} "
        yield said(f"{start}it is within {near}{unit} in at most {after} s")
    yield Fact("swings_out_to", Quantity(None)) if home is None else _swing(home, unit)


def _swing(disc: Ends, unit: str) -> Fact:
    """How far bodies from a disc get on their way, where that is farther than its border."""
    farther = disc.swings_out_to > disc.within
    most = at_most(disc.swings_out_to) if farther else at_least(disc.within)
    return Fact("swings_out_to", Quantity(Fraction(most)), f"it swings out to at most {most}{unit}" if farther else "")


def _where(scene: Scene, ends: Ends, unit: str) -> str:
    """The disc in which bodies end: digits tell its centre to a tenth of its radius, which covers their error."""
    place = [x + offset for x, offset in zip(scene.check.equilibrium, ends.at, strict=True)]
    for digits in range(DIGITS, ALL_DIGITS + 1):
        error = sum(abs(x - Fraction(float_text(x, digits))) for x in place)
        if sign(10 * error - ends.about) <= 0:
            break
    return f"it ends within {at_most(ends.about + error)}{unit} of {place_text(place, digits)}"


def _away(scene: Scene, looked: Nearness, unit: str) -> str:
    """Where bodies go that leave."""
    return f"{'under one of the loads ' if looked.is_of_one_load else ''}{_where_to(scene, looked, unit)}"


def _where_to(scene: Scene, looked: Nearness, unit: str) -> str:
    accuracy = f"the accuracy is {float_text(float(scene.accuracy), DIGITS)}{unit}"
    if looked.ends is not None:
        ends = looked.ends
        distance = f"{float_text(ends.distance, DIGITS)}{unit} from the point"
        return f"{_where(scene, ends, unit)}, {distance}, after at most {at_most(ends.after)} s; {accuracy}"
    if looked.out_after is not None:
        return f"it is driven farther away than the accuracy in at most {at_most(looked.out_after)} s; {accuracy}"
    if looked.is_from_point:
        return f"a body that starts at the point goes farther away than the accuracy; {accuracy}"
    near = f"within {at_most(looked.thrown_out_from)}{unit} of it" if looked.thrown_out_from else "as near as one likes"
    return f"some starts {near} go farther away than the accuracy; {accuracy}"


def _plainly(scene: Scene, verdict: Position, results: Results, unit: str, looked: Nearness | None) -> str:
    """The sentence where there is no number to say."""
    if verdict is Position.UNDECIDED and is_by_rounding(results, "equilibrium", "translation"):
        return f"rounding decides{WHY_BELOW}"
    if verdict is Position.STAYS_NEAR:
        turning = None if looked is None else looked.turning
        return "a body that starts close by stays close by" if turning is None else _turning(turning, unit)
    if _by_clauses(results) is Position.LEAVES:
        accuracy = f"{float_text(float(scene.accuracy), DIGITS)}{unit}"
        beside = " to a place of rest that only rounding tells from it" if _is_beside(results) else ""
        gone = f"some starts as near as one likes{beside} go away"
        if results["equilibrium"].verdict is not Equilibrium.HOLDS:
            gone = "the body is driven away from the point itself"
        why = f": {looked.why_not}" if looked is not None and looked.why_not else ""
        open_end = f"whether farther than the accuracy, {accuracy}, is not decided{why}"
        return f"{gone}; {open_end}; simulate --grid 9 samples where bodies end"
    return f"what happens near the point is not decided{WHY_BELOW}"


def _turning(turning: Turning, unit: str) -> str:
    """How a body stays near that turns about a place beside the point."""
    away, farther = f"{at_most(turning.away)}{unit}", f"{at_most(2 * turning.away)}{unit}"
    start = f"a body within {at_least(turning.within)}{unit} of the point"
    return f"{start} gets at most {farther} farther away: it turns about a place within {away} of it"


def _homecoming(scene: Scene, translation: AnyTranslation, unit: str) -> Iterator[Fact]:
    """From how far, how far away the body gets on its way, and how long it takes at most."""
    seconds, within, swing = translation.arrival_per_distance, translation.home_radius, translation.swing_radius
    yield Fact("after", Quantity(None if seconds is None or within is None else seconds * within))
    if within is None or swing is None:
        yield from _from_discs(homecoming(scene), unit)
    else:
        yield Fact("within", Quantity(within), f"from anywhere within {at_least(within)}{unit}")
        swings = f"it swings out to at most {at_most(swing)}{unit}" if swing > within else "it never swings out"
        yield Fact("swings_out_to", Quantity(swing), swings)
    if seconds is None:
        yield Fact("seconds_per_distance", Quantity(None))
    else:
        words = f"it arrives within {at_most(seconds)} s for each 1{unit} of distance"
        words += "" if translation.quadratic is None else " (a bound, often loose)"
        yield Fact("seconds_per_distance", Quantity(seconds), words)
    yield _rate(translation.exponential_rate)
    yield Fact("stays_within", Quantity(translation.region_radius))


def _rate(rate: Real | None) -> Fact:
    """At which bodies come home that are close by."""
    words = "" if rate is None else f"near it the distance halves about every {half_life(rate)} s"
    return Fact("rate", Quantity(rate), words)
