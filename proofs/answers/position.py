"""Where does a body go that starts near the checked point?"""

from __future__ import annotations

from collections.abc import Iterator
from typing import cast

from nonsmooth.proofs.answers.answer import Answer, Position, Results, is_by_rounding
from nonsmooth.proofs.answers.bounds import at_least, at_most, half_life
from nonsmooth.proofs.answers.units import of_length
from nonsmooth.proofs.clauses.translation.at_point import EllipseTranslation
from nonsmooth.proofs.clauses.translation.clause import AnyTranslation
from nonsmooth.proofs.clauses.translation.mass_facts import mass_words
from nonsmooth.proofs.facts import Fact, Quantity, said
from nonsmooth.proofs.verdicts import Equilibrium, Translation
from nonsmooth.symbolic.scene import Scene

OF_TRANSLATION = {
    Translation.ASYMPTOTICALLY_STABLE: Position.COMES_HOME,
    Translation.STABLE: Position.STAYS_NEAR,
    Translation.UNSTABLE: Position.LEAVES,
    Translation.UNDECIDED: Position.UNDECIDED,
}


def position_answer(scene: Scene, results: Results) -> Answer:
    """From the clauses on the equilibrium and on (x, y)."""
    return Answer("position", _verdict(results), tuple(_facts(scene, results)))


def _verdict(results: Results) -> Position:
    match results["equilibrium"].verdict:
        case Equilibrium.HOLDS:
            return OF_TRANSLATION[_translation(results).verdict]
        case Equilibrium.FAILS:
            return Position.LEAVES
        case _:
            return Position.UNDECIDED


def _translation(results: Results) -> AnyTranslation:
    return cast("AnyTranslation", results["translation"])


def _facts(scene: Scene, results: Results) -> Iterator[Fact]:
    """How far and how fast; the keys are the same for every verdict."""
    verdict, found, unit = _verdict(results), _translation(results), of_length(scene)
    rests = results["equilibrium"].verdict is Equilibrium.HOLDS
    if verdict is Position.COMES_HOME:
        yield from _homecoming(found, unit)
        yield said(found.support_note)
        if isinstance(found, EllipseTranslation):
            yield said(mass_words(found.mass, scene.units))
        return
    stays = found.region_radius if verdict is Position.STAYS_NEAR else None
    yield from (Fact("within", Quantity(None)), Fact("seconds_per_distance", Quantity(None)))
    yield from (Fact("swings_out_to", Quantity(None)), Fact("rate", Quantity(None)))
    yield Fact("stays_within", Quantity(stays))
    if stays is not None:
        yield said(f"a body within {at_least(stays)}{unit} of the point never gets farther away")
    else:
        yield said(_plainly(verdict, results, rests=rests))
    yield said(found.support_note)


def _plainly(verdict: Position, results: Results, *, rests: bool) -> str:
    """The sentence where there is no number to say."""
    if verdict is Position.UNDECIDED and is_by_rounding(results, "equilibrium", "translation"):
        return "rounding decides; why: below"
    if verdict is Position.LEAVES:
        return "some starts as near as one likes go away" if rests else "the body is driven away from the point itself"
    if verdict is Position.STAYS_NEAR:
        return "a body that starts close by stays close by"
    return "what happens near the point is not decided; why: below"


def _disc(found: AnyTranslation, unit: str) -> Iterator[Fact]:
    """From how far, and how far away the body gets on its way at most."""
    within, swing = found.home_radius, found.swing_radius
    if within is None or swing is None:
        yield Fact("within", Quantity(None), "from close by")
        yield Fact("swings_out_to", Quantity(None))
        return
    yield Fact("within", Quantity(within), f"from anywhere within {at_least(within)}{unit}")
    swings = f"it swings out to at most {at_most(swing)}{unit}" if swing > within else "it never swings out"
    yield Fact("swings_out_to", Quantity(swing), swings)


def _homecoming(found: AnyTranslation, unit: str) -> Iterator[Fact]:
    """From how far, and how long it takes at most."""
    seconds, rate = found.arrival_per_distance, found.exponential_rate
    yield from _disc(found, unit)
    if seconds is None:
        yield Fact("seconds_per_distance", Quantity(None))
    else:
        words = f"it arrives within {at_most(seconds)} s for each 1{unit} of distance"
        words += "" if found.quadratic is None else " (a bound, often loose)"
        yield Fact("seconds_per_distance", Quantity(seconds), words)
    if rate is None:
        yield Fact("rate", Quantity(None))
    else:
        yield Fact("rate", Quantity(rate), f"near it the distance halves about every {half_life(rate)} s")
    yield Fact("stays_within", Quantity(found.region_radius))
