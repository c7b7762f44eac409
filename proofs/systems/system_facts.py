"""What the verdict on a plain system says, and that on somebody's V: one list of facts for each.

Rows of the terminal and keys of JSON are the same facts (:mod:`nonsmooth.proofs.facts`).
"""

from __future__ import annotations

from collections.abc import Iterator

from nonsmooth.proofs.facts import Fact, Quantity, row_fact, text_fact, unsaid
from nonsmooth.proofs.inequalities.strata import Refutation
from nonsmooth.proofs.systems.decay_rate import DecayKind
from nonsmooth.proofs.systems.derivatives import LyapunovResult, Supremum
from nonsmooth.proofs.systems.domain import Domain
from nonsmooth.proofs.systems.lyapunov_audit import AuditResult
from nonsmooth.proofs.systems.stability_result import stability_facts
from nonsmooth.proofs.systems.sublevel_region import SublevelRegion
from nonsmooth.proofs.systems.system_stability import SystemResult
from nonsmooth.proofs.systems.written_potential import PotentialPiece, potential_pieces
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.number_text import place_text
from nonsmooth.symbolic.scene_error import one_line
from nonsmooth.symbolic.signed_roots import SignedRoots
from nonsmooth.symbolic.switched_system import SwitchedSystem

DERIVATIVES = {
    "naive": "naive",
    "shevitz_paden": "Shevitz-Paden",
    "bacciotti_ceragioli": "Bacciotti-Ceragioli",
}


def system_facts(result: SystemResult) -> Iterator[Fact]:
    """Stability of a plain system; points are measured from the equilibrium."""
    proving, check, states = result.proving, result.scene.check, result.scene.states
    holds = text_fact("verdict", str(result.equilibrium), "equilibrium")
    yield Fact("equilibrium", (holds, Fact("at", Quantity(check.equilibrium))))
    yield from displacement_facts(result.scene)
    if result.scene.written or result.scene.others:
        yield row_fact("field", rewriting_words(result.scene))
    if proving is not result.lyapunov:
        reason = f"{result.lyapunov.reason} (on {result.reported_domain.text(states)})"
        yield row_fact(f"tried: V = {one_line(check.lyapunov.text)}", reason)
    if proving is not None and result.domain is not None:  # before what is said of this V on this domain
        yield row_fact("with", f"V = {proving_text(result)}")
        yield row_fact("on", result.domain.text(states))
    yield Fact("lyapunov", tuple(_potential(result)))
    yield Fact("translation", tuple(stability_facts(result, everywhere=result.everywhere)))
    if result.scene.by_roots is not None:
        yield _roots(result, result.scene.by_roots.roots)
    if result.region is not None:
        yield row_fact("region", region_words(result.region, states))
    if result.rate is not None:
        yield row_fact("rate", rate_words(result))
    if result.region_rate is not None:
        yield row_fact("rate farther out", region_rate_words(result))
    if result.gain is not None:
        yield row_fact("disturbed", gain_words(result))


def displacement_facts(scene: SwitchedSystem) -> Iterator[Fact]:
    """Where V, domains and regions are measured from, unless that is the origin."""
    point = scene.check.equilibrium
    if any(point):
        place = ", ".join("{}" for _ in point)
        words = f"the checked point ({place}): in V and in domains the states stand for their distances from it"
        yield row_fact("measured from", words, *point)


def _roots(result: SystemResult, roots: SignedRoots) -> Fact:
    """Which states are seen by signed roots, in which time, and whether solutions arrive in finite time."""
    record = {
        "states": list(roots.states),
        "coordinates": list(roots.meanings),
        "time_scale": roots.time_scale,
        "finite_time": result.finite_time or None,
    }
    said = "solutions near the equilibrium arrive in finite time" if result.finite_time else "not known to be finite"
    stable = result.verdict is Translation.ASYMPTOTICALLY_STABLE
    return Fact("roots", record, said, row="arrival") if stable else Fact("roots", record)


def rewriting_words(system: SwitchedSystem) -> str:
    """What was done to the stated formulas, and between which right-hand sides it may switch, in words."""
    said = []
    if system.by_roots is not None:
        roots = system.by_roots.roots
        said.append(f"with {' and '.join(roots.meanings)}, in a time that passes {roots.time_scale} times slower")
    if system.scale is not None:
        said.append(f"multiplied by {one_line(system.scale.text)}, which is positive on the square: other speeds")
    enclosed = ["sin and cos of states lie between polynomials"] if system.waves else []
    enclosed += ["irrational numbers lie between rational ones"] if system.encloses_numbers else []
    if enclosed:
        said.append(f"{' and '.join(enclosed)}: between {len(system.members)} right-hand sides")
    elif system.others:
        said.append(f"any of {len(system.members)} right-hand sides, or a mixture of them, at any time")
    return f"{'; '.join(said)}."


def _potential(result: SystemResult) -> Iterator[Fact]:
    """The V that proves the verdict, with the scene's V under ``tried`` where that is another; else the scene's V."""
    proving, given = result.proving, result.scene.check.lyapunov.text
    if proving is None:
        yield Fact("V", given)
        yield Fact("pieces")
        yield _domain(result.reported_domain, result.scene.states)
        yield from _conditions(result.lyapunov)
    else:
        yield Fact("V", proving_text(result))
        yield Fact("pieces", [_piece(piece) for piece in proving_pieces(result)] or None)
        yield _domain(result.domain or result.reported_domain, result.scene.states)
        yield from _conditions(proving)
    yield Fact("proves", proving is not None)
    yield Fact("region", None if result.region is None else _region_record(result.region, result.scene.states))
    yield Fact("rate", _rate_record(result))
    yield Fact("gain", _gain_record(result))
    if proving is None or proving is result.lyapunov:
        yield Fact("tried")
        return
    own = (
        Fact("V", given),
        Fact("pieces"),
        _domain(result.reported_domain, result.scene.states),
        *_conditions(result.lyapunov),
    )
    yield Fact("tried", unsaid(own))


def reached_words(region: SublevelRegion, states: tuple[str, ...]) -> str:
    """What is certified of a sublevel set of V."""
    return f"every start with {region} within {Domain(region.radius).text(states)} reaches the equilibrium"


def region_words(region: SublevelRegion, states: tuple[str, ...]) -> str:
    """The same, and what refutes a larger one."""
    reached = reached_words(region, states)
    if region.point is None:
        return f"{reached}; V < {region.refuted} is not decided"
    where = place_text(region.point, 5)
    on_border = max(abs(x) for x in region.point) == region.radius
    why = "leaves the square" if on_border else "holds a point at which V does not fall"
    return f"{reached}; V < {region.refuted} {why}, {where}"


def _region_record(region: SublevelRegion, states: tuple[str, ...]) -> dict[str, object]:
    return {
        "level": Quantity(region.level),
        "within": Quantity(region.radius),
        "refuted": Quantity(region.refuted),
        "point": Quantity(region.point),
        "text": region_words(region, states),
    }


def rate_words(result: SystemResult) -> str:
    """How fast V falls on its domain, and what that says of the starts whose solutions stay there."""
    rate, domain, near = result.rate, result.domain, result.near
    if rate is None or domain is None:
        raise TypeError("required a result with a rate")
    where = f"{rate} on {domain.text(result.scene.states)}"
    if near is None:
        return f"{where}, as long as a solution stays there"
    return f"{where}: {rate.decay.on_starts(rate.kappa, f'every start with V < {near.level} there')}"


def region_rate_words(result: SystemResult) -> str:
    """How fast V falls on a region that reaches beyond its domain."""
    rate, region = result.region_rate, result.region
    if rate is None or region is None:
        raise TypeError("required a result with a rate on its region")
    inside = Domain(region.radius).text(result.scene.states)
    starts = DecayKind.EXPONENTIAL.on_starts(rate.kappa, "every start there")
    return f"{rate} where V < {rate.level} within {inside}: {starts}"


def gain_words(result: SystemResult) -> str:
    """What a disturbance does to V on its domain, and to the starts whose solutions stay there."""
    gain, domain = result.gain, result.domain
    if gain is None or domain is None:
        raise TypeError("required a result with a gain")
    return "; ".join(filter(None, (f"{gain} on {domain.text(result.scene.states)}", gain.on_starts)))


def _rate_record(result: SystemResult) -> dict[str, object] | None:
    """The rate on the domain of V, and under ``region`` that on a larger region."""
    if result.rate is None:
        return None
    return {
        "kind": result.rate.decay.name.lower(),
        "kappa": Quantity(result.rate.kappa),
        "text": rate_words(result),
        "within": _within(result),
        "region": _region_rate_record(result),
    }


def _region_rate_record(result: SystemResult) -> dict[str, object] | None:
    rate, region = result.region_rate, result.region
    if rate is None or region is None:
        return None
    text = f"V < {rate.level} within {Domain(region.radius).text(result.scene.states)}"
    within = {"radius": Quantity(region.radius), "level": Quantity(rate.level), "text": text}
    return {"kappa": Quantity(rate.kappa), "text": region_rate_words(result), "within": within}


def _gain_record(result: SystemResult) -> dict[str, object] | None:
    gain = result.gain
    if gain is None:
        return None
    return {
        "gamma": Quantity(gain.gamma),
        "largest": Quantity(gain.largest),
        "ultimate": Quantity(gain.ultimate),
        "text": gain_words(result),
        "within": _within(result),
    }


def _within(result: SystemResult) -> dict[str, object]:
    """Where a rate and a gain hold: the square of V; solutions from V below the level stay in it."""
    domain = result.domain or result.reported_domain
    level = None if result.near is None else result.near.level
    return {"radius": Quantity(domain.radius), "level": Quantity(level), "text": domain.text(result.scene.states)}


def proving_pieces(result: SystemResult) -> tuple[PotentialPiece, ...]:
    """The V that was searched on cones, piece by piece; empty for one with a formula."""
    proving, searched = result.proving, result.searched
    return (
        ()
        if proving is None or searched is None or searched.formula
        else potential_pieces(proving.cells, result.scene.states)
    )


def proving_text(result: SystemResult) -> str:
    """V in the displacement from the equilibrium: a formula, or the pieces of one that was searched on cones."""
    if result.searched is not None and result.searched.formula is not None:
        return result.searched.formula.text
    return (
        "; ".join(map(str, proving_pieces(result))) if result.searched else one_line(result.scene.check.lyapunov.text)
    )


def _piece(piece: PotentialPiece) -> dict[str, object]:
    cone = None if piece.start is None else {"from": Quantity(piece.start), "to": Quantity(piece.end)}
    return {"V": str(piece.potential), "cone": cone}


def _domain(domain: Domain, states: tuple[str, ...]) -> Fact:
    kind = "plane" if domain.radius is None else "square"
    return Fact("domain", {"kind": kind, "radius": Quantity(domain.radius), "text": domain.text(states)})


def _conditions(result: LyapunovResult) -> Iterator[Fact]:
    """The ladder of derivatives, and what follows."""
    yield from _derivatives(result)
    yield Fact("verdict", result.verdict.name.lower())
    yield Fact("reason", result.reason)
    yield from unsaid([_witness(result.witness)])


def audit_facts(result: AuditResult) -> Iterator[Fact]:
    """Whether somebody's V is a Lyapunov function."""
    yield Fact("V", result.lyapunov, str(result.verdict), row=f"V = {one_line(result.lyapunov)}")
    yield Fact("domain") if result.result is None else text_fact("domain", result.domain_text, "on")
    if isinstance(result.scene, SwitchedSystem) and (result.scene.written or result.scene.others):
        yield row_fact("field", rewriting_words(result.scene))  # of which the derivatives speak
    if result.result is not None:
        yield from _derivatives(result.result)
    yield Fact("verdict", str(result.verdict))
    yield text_fact("reason", result.reason, "because")
    if result.proves is not None:
        yield row_fact("shows", f"the equilibrium is {result.proves}")
    yield _witness(result.witness)
    yield Fact("proves", None if result.proves is None else str(result.proves))


def _derivatives(result: LyapunovResult) -> Iterator[Fact]:
    for key, name in DERIVATIVES.items():
        yield _supremum(key, f"sup of V', {name}", result.supremum(key))


def _supremum(key: str, row: str, found: Supremum) -> Fact:
    sign, value = str(found.trend), found.value
    record = {"sign": sign, "value": Quantity(value), "point": Quantity(found.point)}
    words, shown = ("{}", (sign,)) if value is None else ("{} ({})", (sign, value))
    return Fact(key, record, words, shown, row=row)


def _witness(witness: Refutation | None) -> Fact:
    """Where V fails."""
    if witness is None:
        return Fact("witness")
    record = {"point": Quantity(witness.point), "value": Quantity(witness.value), "meaning": witness.meaning}
    place = ", ".join("{}" for _ in witness.point)
    words, value = f"{{}} at ({place})", () if witness.value is None else (witness.value,)
    words += " (value {})" * len(value)
    return Fact("witness", record, words, (witness.meaning, *witness.point, *value), row="witness")
