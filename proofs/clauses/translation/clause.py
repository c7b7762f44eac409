"""Clause 2 of Theorem 4 as the check asks it, and what it says."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from typing import TYPE_CHECKING, TypeAlias

from nonsmooth.proofs.clauses.at_point.every_load import witness_load
from nonsmooth.proofs.clauses.at_point.mass import MassLimit
from nonsmooth.proofs.clauses.clause import CheckedArray, Clause, witness_record
from nonsmooth.proofs.clauses.translation.at_point import (
    EllipseTranslation,
    EveryLoadTranslation,
    decide_for_every_load,
    decide_translation_at,
)
from nonsmooth.proofs.clauses.translation.on_cells import LYAPUNOV, TranslationResult, decide_translation
from nonsmooth.proofs.clauses.workspace import LEMMA, Workspace
from nonsmooth.proofs.findings import Fact, Quantity, Theorem4, Translation, number_fact, said
from nonsmooth.symbolic.mechanics.units import Units
from nonsmooth.symbolic.numbers.number_text import float_text

if TYPE_CHECKING:
    from nonsmooth.analysis.minimizers.sampling import SampledDerivative


# ---- bodies with mass: up to which mass, or which speeds, the verdict on (x, y) holds ------------


GRAVITY = Fraction(981, 100)  # m/s^2


def mass_fact(limit: MassLimit | None, units: Units) -> Fact:
    """The masses per weight, 1/g, between which stability under full dynamics is lost; in words where it is lost."""
    if limit is None:
        return Fact("mass")
    record = {
        "stable_to": Quantity(limit.stable_to),
        "unstable_at": None if limit.unstable_at is None else Quantity(limit.unstable_at),
        "squared_radius": Quantity(limit.squared_radius),
        "speed_factor": speed_factor(limit, units),
    }
    if limit.unstable_at is None:
        words = "with mass too, linearized: whatever the mass, up to 1/g = {}"
        return Fact("mass", record, words, (float_text(limit.stable_to),))
    words = "with mass, linearized: stable up to 1/g = {}, unstable at {} (inertia of a disc as large as the array)"
    return Fact("mass", record, words, (float_text(limit.stable_to), float_text(limit.unstable_at)))


def speed_factor(limit: MassLimit, units: Units) -> float | None:
    """By how much all speeds may grow, at the earth's gravity, until the mass counts; None without a unit of length.

    With speeds s times as large the mass counts ``s^2``-fold.
    """
    metres = units.metres
    return None if metres is None else math.sqrt(limit.stable_to * GRAVITY / metres)


def mass_words(limit: MassLimit | None, units: Units) -> str:
    """For an answer: empty where the mass does not matter or nothing is known."""
    if limit is None or limit.unstable_at is None:
        return ""
    factor = speed_factor(limit, units)
    if factor is None:
        return f"so does a body with mass up to 1/g = {float_text(limit.stable_to)}, and not one a little heavier"
    if factor < 1:
        return f"but with mass and g = 9.81 m/s^2 only at speeds below {factor:.3g} of these"
    return f"with mass and g = 9.81 m/s^2 too, up to {factor:.3g} times these speeds"


# ---- the clause ----------------------------------------------------------------------------------


AnyTranslation: TypeAlias = TranslationResult | EllipseTranslation | EveryLoadTranslation

SAMPLES = 2_000  # points at which V* is evaluated without cells, where no lemma covers the square
MOST_SLIPS = 500_000  # of all wheels at all these points: beyond 250 wheels there are fewer, as nothing rests on them


class TranslationClause(Clause[AnyTranslation]):
    """Strong stability of (x, y): of every Filippov solution."""

    name = "translation"

    def decide(self, work: Workspace) -> AnyTranslation:
        """By ``|c|^2``, the fan of cones or a quadratic function on cells; by linearization without."""
        if work.leaves_loads_open:
            return decide_for_every_load(work.every_load, work.lemma)
        if work.partition is not None:
            return decide_translation(work.partition, work.lemma)
        samples = min(SAMPLES, MOST_SLIPS // len(work.scene.wheels)) if work.sample else 0
        if work.point.rest is not None:  # the lemma is about the point itself
            return decide_translation_at(work.point, None, samples=samples)
        if work.lemma is not None and work.prune:
            work.skip("samples of V*", SAMPLES, f"{LEMMA}: no solver is needed")
        return decide_translation_at(work.point, work.lemma, samples=samples, always=not work.prune)

    def undecided(self, result: AnyTranslation, reason: str) -> AnyTranslation:
        """Neither stable nor unstable; V* stands as it was evaluated."""
        if isinstance(result, TranslationResult):
            verdict = Translation.UNDECIDED
            return TranslationResult(
                verdict, result.derivatives, result.worst, None, None, reason, support=result.support
            )
        if isinstance(result, EveryLoadTranslation):
            return EveryLoadTranslation(result.point.undecided(reason), Translation.UNDECIDED, reason)
        return EllipseTranslation(result.point.undecided(reason), None, result.sampled)

    def settles(self, result: AnyTranslation) -> tuple[Theorem4, str] | None:
        """A body that is thrown out refutes the theorem."""
        if result.verdict is Translation.UNSTABLE:
            return Theorem4.FAILS, f"translation is unstable: {result.reason}"
        return None

    def is_open(self, result: AnyTranslation) -> bool:
        """Without stability of (x, y) nothing is proved."""
        return result.verdict is Translation.UNDECIDED

    def facts(self, result: AnyTranslation, check: CheckedArray) -> Iterator[Fact]:
        """V with its largest rate, where it was sampled, the region and the witness."""
        yield Fact("lyapunov", LYAPUNOV)
        if result.sampled is None:
            yield number_fact("worst_rate", result.worst_rate, "max V*/|c| = {} on the square", explained=True)
        yield from _sampled(result.sampled)
        yield from _quadratic(result)
        radius = result.region_radius
        region = None if radius is None else {"shape": "disc", "radius": Quantity(radius)}
        yield Fact("region", region, "" if radius is None else "region: disc of radius {}", (radius,), explained=True)
        yield from _support(result)
        yield mass_fact(result.mass if isinstance(result, EllipseTranslation) else None, check.scene.units)
        yield Fact("witness", witness_record(result.witness, "value"))
        if isinstance(result, EveryLoadTranslation):
            yield witness_load(result.load)


def _sampled(sampled: SampledDerivative | None) -> Iterator[Fact]:
    """What is said of V* where it is not known exactly."""
    if sampled is None:
        yield from (Fact("samples"), Fact("not_certified"))
        return
    rate = sampled.largest_relative
    words = f"largest V*/|c| at {sampled.samples} sampled points of the square: {{}}"
    shown = () if rate is None else (float_text(rate),)
    yield Fact("worst_rate", Quantity(rate), words if shown else "", shown, explained=True)
    yield Fact("samples", sampled.samples)
    missing = sampled.not_certified
    words = f"largest V*/|c| over the square not certified: {missing}" if missing else ""
    yield Fact("not_certified", missing or None, words, explained=True)


def _quadratic(result: AnyTranslation) -> Iterator[Fact]:
    """The Lyapunov function ``c^T P c`` that serves where ``|c|^2`` does not."""
    quadratic = result.quadratic
    if quadratic is None:
        yield Fact("quadratic")
        return
    decay = float(quadratic.decay)
    record = {"lyapunov": str(quadratic), "decay": decay, "level": Quantity(quadratic.level)}
    yield Fact("quadratic", record, f"V = {quadratic} decreases: V* <= -{float_text(decay, 4)} |c|")
    yield said("region: V < {}", quadratic.level)


def _support(result: AnyTranslation) -> Iterator[Fact]:
    """The support polygon, where the square leaves it."""
    if not isinstance(result, TranslationResult) or result.support is None:
        yield Fact("support")
        return
    distance = Quantity(result.support.distance) if result.support.stands else None
    record = {"distance": distance, "note": result.support_note}
    yield Fact("support", record, result.support_note, explained=True)
