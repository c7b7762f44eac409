"""What the verdict on a system in three states and more says, and that on somebody's V: lists of facts."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from nonsmooth.proofs.facts import Fact, Quantity, row_fact, text_fact, unsaid
from nonsmooth.proofs.many_states.audit import ManyStateAudit
from nonsmooth.proofs.many_states.decision import ManyStateResult
from nonsmooth.proofs.many_states.examination import FailurePoint
from nonsmooth.proofs.many_states.examined_lyapunov import ExaminedLyapunov
from nonsmooth.proofs.many_states.sublevel import SublevelSet
from nonsmooth.proofs.systems.stability_result import stability_facts
from nonsmooth.proofs.systems.system_facts import displacement_facts, rewriting_words
from nonsmooth.proofs.verdicts import Equilibrium, Translation
from nonsmooth.symbolic.number_text import brief_text
from nonsmooth.symbolic.scene_error import one_line


def many_state_facts(result: ManyStateResult) -> Iterator[Fact]:
    """Stability in three states and more; points are measured from the checked one."""
    check, evidence, proving = result.scene.check, result.evidence, result.proving
    stays = result.verdict in (Translation.STABLE, Translation.ASYMPTOTICALLY_STABLE)  # then 0 is in F
    equilibrium = Equilibrium.HOLDS if stays else evidence.equilibrium
    yield Fact(
        "equilibrium",
        (text_fact("verdict", str(equilibrium), "equilibrium"), Fact("at", Quantity(check.equilibrium))),
    )
    yield from displacement_facts(result.scene)
    if result.scene.written or result.scene.others:
        yield row_fact("field", rewriting_words(result.scene))
    named = evidence.named
    if named is not None and named is not proving and not check.is_default:
        reason = f"{named.examination.reason} (on {domain_words(named)})"
        yield row_fact(f"tried: V = {one_line(check.lyapunov.text)}", reason)
    yield Fact("lyapunov", tuple(_potential(result)))
    yield Fact("translation", tuple(stability_facts(result, everywhere=result.everywhere)))
    if proving is not None:
        yield row_fact("with", f"V = {one_line(proving.formula.text)}")
        yield row_fact("on", domain_words(proving))
    elif evidence.growth is not None:
        growth = evidence.growth
        yield row_fact("with", f"V = {one_line(growth.formula.text)}")
        direction = ", ".join(map(str, growth.direction))
        yield row_fact("on", f"{_cube(result.scene.states, growth.radius)}; V < 0 in the direction ({direction})")
    if result.region is not None:
        yield row_fact("region", region_words(result.region, result.scene.states))
    if result.rate is not None:
        yield row_fact("rate", rate_words(result))


def domain_words(function: ExaminedLyapunov) -> str:
    """Where the conditions on a V are looked at."""
    if function.examination.is_homogeneous:
        return "the whole space"
    return _cube(function.examination.cells.states, function.radius)


def region_words(region: SublevelSet, states: tuple[str, ...]) -> str:
    """What is certified of a sublevel set of V."""
    inside = _cube(states, region.radius)
    return f"every start with V < {region.level} within {inside} reaches the equilibrium"


def _cube(states: tuple[str, ...], radius: object) -> str:
    bounded = ", ".join(f"abs({name})" for name in states)
    return f"{bounded} <= {radius if isinstance(radius, Fraction) else brief_text(radius)}"  # type: ignore[arg-type]


def _potential(result: ManyStateResult) -> Iterator[Fact]:
    """The V that shows stability, with the scene's V under ``tried`` where that is another; else the scene's V."""
    proving, named = result.proving, result.evidence.named
    shown = proving or named
    if shown is None:
        yield Fact("V", result.scene.check.lyapunov.text)
        yield from unsaid((Fact("pieces"), Fact("domain"), Fact("verdict"), Fact("reason"), Fact("witness")))
    else:
        yield from _conditions(shown)
    yield Fact("proves", proving is not None)
    yield Fact("region", None if result.region is None else _region_record(result.region, result.scene.states))
    yield Fact("rate", _rate_record(result))
    own = named if proving is not None and named is not proving else None
    yield Fact("tried", None if own is None else unsaid(_conditions(own)))


def _conditions(function: ExaminedLyapunov) -> Iterator[Fact]:
    whole = function.examination.is_homogeneous
    radius = None if whole else function.radius
    yield Fact("V", function.formula.text)
    yield Fact("pieces")
    domain = {"kind": "space" if whole else "cube", "radius": Quantity(radius), "text": domain_words(function)}
    yield Fact("domain", domain)
    yield Fact("verdict", function.examination.verdict.name.lower())
    yield Fact("reason", function.examination.reason)
    yield from unsaid([_witness(function.examination.failure)])


def _region_record(region: SublevelSet, states: tuple[str, ...]) -> dict[str, object]:
    return {
        "level": Quantity(region.level),
        "within": Quantity(region.radius),
        "text": region_words(region, states),
    }


def rate_words(result: ManyStateResult) -> str:
    """How fast V falls where that is proved, and what that says of the starts whose solutions stay there."""
    rate = result.rate
    if rate is None:
        raise TypeError("required a result with a rate")
    if result.rate_radius is None:
        return f"{rate} on the whole space: {rate.decay.on_starts(rate.kappa, 'every start')}"
    where = f"{rate} on {_cube(result.scene.states, result.rate_radius)}"
    if result.region is None:
        return f"{where}, as long as a solution stays there"
    return f"{where}: {rate.decay.on_starts(rate.kappa, f'every start with V < {result.region.level} there')}"


def _rate_record(result: ManyStateResult) -> dict[str, object] | None:
    rate, radius = result.rate, result.rate_radius
    if rate is None:
        return None
    within = {
        "radius": Quantity(radius),
        "level": Quantity(None if result.region is None else result.region.level),
        "text": "the whole space" if radius is None else _cube(result.scene.states, radius),
    }
    kind = rate.decay.name.lower()
    return {"kind": kind, "kappa": Quantity(rate.kappa), "text": rate_words(result), "within": within}


def _witness(failure: FailurePoint | None) -> Fact:
    """Where V fails."""
    if failure is None:
        return Fact("witness")
    record = {"point": Quantity(failure.point), "value": Quantity(failure.value), "meaning": failure.meaning}
    place = ", ".join(map(str, failure.point))
    value = "" if failure.value is None else f" (value {failure.value})"
    return Fact("witness", record, f"{failure.meaning} at ({place}){value}", row="witness")


def many_state_audit_facts(result: ManyStateAudit) -> Iterator[Fact]:
    """Whether somebody's V is a Lyapunov function."""
    yield Fact("V", result.lyapunov, str(result.verdict), row=f"V = {one_line(result.lyapunov)}")
    yield Fact("verdict", str(result.verdict))
    yield text_fact("reason", result.reason, "because")
    yield Fact("domain") if result.function is None else text_fact("domain", domain_words(result.function), "on")
    if result.scene.written or result.scene.others:
        yield row_fact("field", rewriting_words(result.scene))
    if result.proves is not None:
        yield row_fact("shows", f"the equilibrium is {result.proves}")
    yield _witness(result.witness)
    yield Fact("proves", None if result.proves is None else str(result.proves))
