"""What the verdict on a plain system says, and that on somebody's V: one list of facts for each.

Rows of the terminal and keys of JSON are the same facts (:mod:`nonsmooth.proofs.findings`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from nonsmooth.proofs.findings import Fact, Quantity, Translation, function_facts, row_fact, text_fact, unsaid
from nonsmooth.proofs.kernel.quotients import quotient_text, signed_roots_of
from nonsmooth.proofs.systems.derivatives import Supremum
from nonsmooth.proofs.systems.domain import (
    DecayKind,
    DecayRate,
    DisturbanceGain,
    Domain,
    RegionRate,
    ReshapedRegion,
    SublevelRegion,
    cube_text,
    disturbance_letter,
)
from nonsmooth.proofs.systems.findings import DERIVATIVES, DecidedSystem, ExaminedFunction, Method, Reach
from nonsmooth.symbolic.formulas.enclosed_functions import kinds_text
from nonsmooth.symbolic.formulas.signed_roots import SignedRoots
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.messages.scene_kind import SceneKind
from nonsmooth.symbolic.numbers.number_text import percent_text, place_text
from nonsmooth.symbolic.systems.switched_system import PLANE, SwitchedSystem

if TYPE_CHECKING:
    from nonsmooth.proofs.kernel.arrival import Arrival
    from nonsmooth.proofs.system_audit import AuditResult
    from nonsmooth.proofs.systems.basin import CertifiedBasin
    from nonsmooth.symbolic.mechanics.scene import Scene
    from nonsmooth.symbolic.numbers.plane_arrays import Floats


def system_facts(result: DecidedSystem) -> Iterator[Fact]:
    """Stability of a plain system; points are measured from the equilibrium."""
    function, given, scene = result.function, result.given, result.scene
    check, states = scene.check, scene.states
    holds = text_fact("verdict", str(result.equilibrium), "equilibrium")
    yield Fact("equilibrium", (holds, Fact("at", Quantity(check.equilibrium))))
    if len(states) > 1 or result.reach.rate is not None:  # in one state a V is looked at for a rate alone
        yield from displacement_facts(scene)
    rewritten = rewriting_words(scene, in_time_of_states=result.is_in_time_of_states)
    if rewritten:
        yield row_fact("field", rewritten)
    if given is not None and given is not function and (given.suprema or not check.is_default):
        reason = f"{given.reason} (on {given.domain.text(states)})"
        yield row_fact(f"tried: V = {one_line(check.lyapunov.text)}", reason)
    if check.quotient is not None and (function is not None or not result.deciding.entry):
        top, bottom = (one_line(part.text) for part in check.quotient)
        yield row_fact(f"tried: V = ({top})/({bottom})", "it was not shown to be positive and to fall")
    if function is not None:  # before what is said of this V on this domain
        yield from function_facts(function.text, function.domain.text(states))
    yield Fact("lyapunov", tuple(_potential(result)) or None)
    yield Fact("translation", tuple(_stability(result)))
    yield from result.deciding.facts
    yield from _proved_by(result)
    if scene.by_roots is not None and len(states) > 1:  # in one state no time of arrival is looked for
        yield _roots(result, scene.by_roots.roots)
    reach = result.reach
    if reach.global_entry is not None:
        yield row_fact("from everywhere", global_words(reach.global_entry, scene.stated_states))
    if reach.approach is not None:
        words = approach_words(reach.approach, states)
        yield Fact("approach", _approach_record(reach.approach, words), words, row="approaches")
    if reach.homogeneous is not None:
        homogeneity = reach.homogeneous
        record = {"weights": Quantity(homogeneity.weights), "degree": Quantity(homogeneity.degree)}
        yield Fact("homogeneous", record, str(homogeneity), row="homogeneous")
    if reach.arrival is not None:
        words = arrival_words(reach.arrival, scene.stated_states)
        yield Fact("arrival_time", _arrival_record(reach.arrival), words, row="time of arrival")
    if reach.region is not None:
        yield row_fact("region", region_words(reach.region, states))
    if reach.reshaped is not None:
        words = reshaped_words(reach.reshaped, states)
        yield Fact("reshaped", _reshaped_record(reach.reshaped, words), words, row="reshaped V")
    if reach.basin is not None:
        words = basin_words(reach.basin, states)
        yield Fact("basin", basin_record(reach.basin, words), words, row="triangles")
    if reach.rate is not None and len(states) == 1:
        yield Fact("rate", _rate_record(reach, states), rate_words(reach, states), row="rate")
    elif reach.rate is not None:
        yield row_fact("rate", rate_words(reach, states))
    if reach.region_rate is not None:
        yield row_fact("rate farther out", region_rate_words(reach.region_rate, states))
    if reach.gain is not None and len(states) == 1:
        yield Fact("gain", _gain_record(reach, states), gain_words(reach.gain, states), row="disturbed")
    elif reach.gain is not None:
        yield row_fact("disturbed", gain_words(reach.gain, states))


def _stability(result: DecidedSystem) -> Iterator[Fact]:
    """The verdict, what decided, whether it is about all starts, and why."""
    yield text_fact("verdict", str(result.verdict), "stability")
    yield Fact("method", str(result.method))
    yield Fact("everywhere", result.reach.everywhere)
    method = "" if result.method is Method.NONE else f" ({result.method})"
    yield Fact("reason", result.reason, f"{result.reason}{method}", row="because")


def displacement_facts(scene: SwitchedSystem) -> Iterator[Fact]:
    """Where V, domains and regions are measured from, unless that is the origin."""
    point = scene.check.equilibrium
    if any(point):
        place = ", ".join("{}" for _ in point)
        words = f"the checked point ({place}): in V and in domains the states stand for their distances from it"
        yield row_fact("measured from", words, *point)


def _roots(result: DecidedSystem, roots: SignedRoots) -> Fact:
    """Which states are seen by signed roots, in which time, and whether solutions arrive in finite time."""
    in_time = result.reach.in_finite_time
    record = {
        "states": list(roots.states),
        "coordinates": list(roots.meanings),
        "time_scale": "1" if result.is_in_time_of_states else roots.time_scale,
        "finite_time": in_time or None,
    }
    said = "solutions near the equilibrium arrive in finite time" if in_time else "not known to be finite"
    stable = result.verdict is Translation.ASYMPTOTICALLY_STABLE
    return Fact("roots", record, said, row="arrival") if stable else Fact("roots", record)


def _arrival_record(arrival: Arrival) -> dict[str, object]:
    numbers = {"factor": Quantity(arrival.factor), "size": Quantity(arrival.size)}
    return {**numbers, "orders": list(arrival.orders), "power": arrival.power}


def arrival_words(arrival: Arrival, states: Sequence[str]) -> str:
    """After which time every solution is at the point, by the states from which it starts."""
    start = states[0] if len(states) == 1 else f"({', '.join(states)})"
    return f"every solution from {start} is at the equilibrium after at most {arrival.words(states)}"


def rewriting_words(system: SwitchedSystem, *, in_time_of_states: bool = False) -> str:
    """What was done to the stated formulas, and between which right-hand sides it may switch, in words.

    Args:
        system: which may be in roots of its states.
        in_time_of_states: whether velocities are those of the states all the same, for a V about roots of its own.
    """
    said = []
    if system.by_roots is not None and not in_time_of_states:
        roots = system.by_roots.roots
        said.append(f"with {' and '.join(roots.meanings)}, in a time that passes {roots.time_scale} times slower")
    rewriting, scale = system.rewriting, system.rewriting.scale
    if scale is not None:
        where = "on the square but at the point" if system.vanishing else "on the square"
        said.append(f"multiplied by {rewriting.stated_text(scale)}, which is positive {where}: other speeds")
    enclosed = []
    if rewriting.waves:
        kinds = kinds_text(rewriting.waves)
        enclosed.append(f"{kinds} of states {'lie' if ' and ' in kinds else 'lies'} between polynomials")
    enclosed += list(rewriting.encloses)
    if system.intervals:
        takes = (
            "takes any value of its interval" if len(system.intervals) == 1 else "take any values of their intervals"
        )
        enclosed.append(f"{' and '.join(system.intervals)} {takes} at any time")
    if enclosed:
        said.append(f"{' and '.join(enclosed)}: between {len(system.members)} right-hand sides")
    if system.others and system.overlaps:
        said.append("where [[region]] tables overlap any of them acts, or a mixture, at any time")
    elif system.others and not enclosed:
        said.append(f"any of {len(system.members)} right-hand sides, or a mixture of them, at any time")
    return f"{'; '.join(said)}." if said else ""


def _proved_by(result: DecidedSystem) -> Iterator[Fact]:
    """The V of a theorem whose evidence decides, as its formula, and where its claims hold; rows say it in words."""
    entry, rows = result.deciding.entry, {fact.row: fact.words for fact in result.deciding.facts}
    if entry is None or result.function is not None or entry["theorem"] not in ("lyapunov", "instability"):
        return
    if isinstance(entry["hypotheses"]["function"], str):
        yield Fact("proved_by", {"V": quotient_text(entry["hypotheses"]), "on": rows.get("on")})


def _potential(result: DecidedSystem) -> Iterator[Fact]:
    """The V that proves the verdict, with the scene's V under ``tried`` where that is another; else the scene's V."""
    function, given, reach, states = result.function, result.given, result.reach, result.scene.states
    if len(states) == 1:
        return
    shown = function or given
    if shown is None:
        yield Fact("V", result.scene.check.lyapunov.text)
        yield from map(Fact, ("pieces", "domain", "verdict", "reason", "witness"))
    else:
        yield from _conditions(shown, states)
    yield Fact("proves", function is not None)
    yield Fact("region", None if reach.region is None else _region_record(reach.region, states))
    yield Fact("rate", _rate_record(reach, states))
    yield Fact("gain", _gain_record(reach, states))
    other = None if function is None or given is function else given
    yield Fact("tried", None if other is None else unsaid(_conditions(other, states)))


def _conditions(function: ExaminedFunction, states: Sequence[str]) -> Iterator[Fact]:
    """V, its domain, the ladder of derivatives, and what follows."""
    yield Fact("V", function.text)
    yield Fact("pieces")
    domain = function.domain
    record = {"kind": domain.kind(states), "radius": Quantity(domain.radius), "text": domain.text(states)}
    yield Fact("domain", record)
    yield from _derivatives(function)
    yield Fact("verdict", function.decrease.name.lower())
    yield Fact("reason", function.reason)
    yield from unsaid([_witness(function.witness)])


def reached_words(region: SublevelRegion, states: Sequence[str]) -> str:
    """What is certified of a sublevel set of V."""
    return f"every start with {region} within {cube_text(region.radius, states)} reaches the equilibrium"


def global_words(entry: Mapping[str, Any], states: Sequence[str]) -> str:
    """Which V shows that every start reaches the point."""
    hypotheses = entry["hypotheses"]
    function, bounded = f"V = {quotient_text(hypotheses)}", "where its level sets are bounded"
    roots = signed_roots_of(hypotheses, states)
    if roots is not None:
        bounded = f"{bounded}, with {' and '.join(roots.meanings)}"
    if hypotheses["second"] is None:
        return f"{function} falls in the whole space too, {bounded}"
    return f"{function} does not increase in the whole space, {bounded}, and no other solution stays where V' = 0"


def approach_words(entry: Mapping[str, Any], states: Sequence[str]) -> str:
    """Which solutions are certified to approach the set of equilibria, and by which V."""
    hypotheses = entry["hypotheses"]
    within, function = hypotheses["cells"]["within"], f"V = {one_line(hypotheses['function'])}"
    where = "near it" if within is None else cube_text(Fraction(within), states)
    return (
        f"{_approaching(hypotheses, where)} approaches the set of equilibria: where {function} is kept, nothing moves"
    )


def _approaching(hypotheses: Mapping[str, Any], cube: str) -> str:
    if hypotheses["proper"] is not None:
        return "every solution"
    if hypotheses["level"] is not None:
        return f"every start with V < {hypotheses['level']} within {cube}"
    return "every solution from near the equilibrium"


def _approach_record(entry: Mapping[str, Any], words: str) -> dict[str, object]:
    hypotheses = entry["hypotheses"]
    record = {"V": one_line(hypotheses["function"]), "everywhere": hypotheses["proper"] is not None}
    return {**record, "level": hypotheses["level"], "within": hypotheses["cells"]["within"], "text": words}


def region_words(region: SublevelRegion, states: Sequence[str]) -> str:
    """The same, and what refutes a larger one."""
    reached = reached_words(region, states)
    if region.refuted is None:
        return reached
    if region.point is None:
        return f"{reached}; V < {region.refuted} is not decided"
    where = place_text(region.point, 5)
    on_border = max(abs(x) for x in region.point) == region.radius
    cube = "square" if len(states) == len(PLANE) else "cube"
    why = f"leaves the {cube}" if on_border else "holds a point at which V does not fall"
    return f"{reached}; V < {region.refuted} {why}, {where}"


def _region_record(region: SublevelRegion, states: Sequence[str]) -> dict[str, object]:
    record: dict[str, object] = {"level": Quantity(region.level), "within": Quantity(region.radius)}
    if region.refuted is not None:
        record |= {"refuted": Quantity(region.refuted), "point": Quantity(region.point)}
    return record | {"text": region_words(region, states)}


def reshaped_words(reshaped: ReshapedRegion, states: Sequence[str]) -> str:
    """What is certified of a sublevel set of another V."""
    where, function = cube_text(reshaped.region.radius, states), one_line(reshaped.formula.text)
    return f"every start with {function} < {reshaped.region.level} within {where} reaches the equilibrium"


def _reshaped_record(reshaped: ReshapedRegion, words: str) -> dict[str, object]:
    level, within = Quantity(reshaped.region.level), Quantity(reshaped.region.radius)
    return {"V": one_line(reshaped.formula.text), "level": level, "within": within, "text": words}


def basin_words(basin: CertifiedBasin, states: Sequence[str]) -> str:
    """What is certified by triangles, and how much that is of what is sampled."""
    certified, coming = basin.sampled
    share = percent_text(basin.share)
    mesh = f"every start in {len(basin.simplices)} {basin.kind} about the region reaches the equilibrium"
    within = ", ".join(f"{low:.3g} <= {s} <= {high:.3g}" for s, (low, high) in zip(states, basin.window, strict=True))
    said = [
        mesh,
        f"the region and they hold {share} of the starts sampled within {within} that do ({certified} of {coming})",
    ]
    if basin.filled is not None and basin.outside is not None:
        sides, filled = len(basin.outside["corners"]), percent_text(basin.filled)
        said.append(f"no start outside of a polygon of {sides} sides does, of whose area the region fills {filled}")
    traps, saddles = (
        " and ".join(place_text(place, 3) for place, _ in rings) for rings in (basin.traps, basin.saddles)
    )
    if traps:
        said.append(f"no start inside of a polygon about {traps} does")
    if saddles:
        beside = "lines beside the saddles" if len(basin.saddles) > 1 else "a line beside the saddle"
        said.append(f"no start beyond {beside} {saddles} does")
    certified, possible, starts = basin.square
    if possible < starts and (traps or saddles):
        low, high = (percent_text(count / starts) for count in (certified, possible))
        said.append(f"so {low} to {high} of the sampled starts do")
    return "; ".join(said)


def basin_record(basin: CertifiedBasin, words: str) -> dict[str, object]:
    """The corners with the values of W, in the displacement from the point, and the triangles by their corners."""
    from nonsmooth.proofs.systems.outer_ring import ring_of

    certified, coming = basin.sampled
    return {
        "vertices": basin.corners[:, :-1].tolist(),
        "values": basin.corners[:, -1].astype(int).tolist(),
        "simplices": basin.simplices.tolist(),
        "share": {"sampled": basin.share, "certified_starts": certified, "starts": coming},
        "unit": basin.mesh["unit"],
        "outside": outside_record(basin),
        **({"traps": [ring_of(ring).tolist() for _, ring in basin.traps]} if basin.traps else {}),
        **({"saddles": [_line_record(*line) for line in basin.saddles]} if basin.saddles else {}),
        "text": words,
    }


def _line_record(saddle: Floats, hypotheses: dict[str, Any]) -> dict[str, object]:
    """A line over which all velocities lead to the right: its corners, and where its half-lines go from both ends."""
    from nonsmooth.proofs.checker.outside import place_of
    from nonsmooth.proofs.systems.outer_ring import ring_of

    ends = [list(place_of(end)) for end in hypotheses["ends"]]
    return {"at": saddle.tolist(), "corners": ring_of(hypotheses).tolist(), "ends": ends}


def outside_record(basin: CertifiedBasin) -> dict[str, object] | None:
    """The polygon outside of which no start reaches the point, and how much of its area the region fills."""
    if basin.outside is None:
        return None
    from nonsmooth.proofs.systems.outer_ring import ring_of

    return {"polygon": ring_of(basin.outside).tolist(), "filled": basin.filled}


def rate_words(reach: Reach, states: Sequence[str]) -> str:
    """How fast V falls on its domain, and what that says of the starts whose solutions stay there."""
    rate, near = reach.rate, reach.near
    if rate is None:
        raise TypeError("required a rate")
    where = f"{_potential_words(rate, states)}{rate} on {rate.domain.text(states)}"
    if rate.domain.radius is None:
        return f"{where}: {rate.decay.on_starts(rate.kappa, 'every start')}"
    if len(states) == 1:
        return f"{where}: {rate.decay.on_starts(rate.kappa, 'every start there')}"
    if near is None:
        return f"{where}, as long as a solution stays there"
    return f"{where}: {rate.decay.on_starts(rate.kappa, f'every start with V < {near.level} there')}"


def region_rate_words(rate: RegionRate, states: Sequence[str]) -> str:
    """How fast V falls on a region that reaches beyond its domain."""
    starts = DecayKind.EXPONENTIAL.on_starts(rate.kappa, "every start there")
    return f"{rate} where {_below_words(rate, states)}: {starts}"


def _below_words(rate: RegionRate, states: Sequence[str]) -> str:
    """Where the rate on a region holds."""
    return f"V < {rate.level} within {cube_text(rate.radius, states)}"


def gain_words(gain: DisturbanceGain, states: Sequence[str]) -> str:
    """What a disturbance does to V on its domain, and to the starts whose solutions stay there."""
    letter = disturbance_letter(states)
    where = f"{_potential_words(gain.rate, states)}{gain.inequality(letter)} on {gain.domain.text(states)}"
    return "; ".join(filter(None, (where, gain.on_starts(letter))))


def _potential_words(rate: DecayRate, states: Sequence[str]) -> str:
    """What V is, in one state, where nothing else names it."""
    return f"V = {rate.function}: ".replace("Abs", "abs") if rate.function else ""


def _rate_record(reach: Reach, states: Sequence[str]) -> dict[str, object] | None:
    """The rate on the domain of V, and in two states under ``region`` that on a larger region."""
    rate = reach.rate
    if rate is None:
        return None
    record: dict[str, object] = {
        "kind": rate.decay.name.lower(),
        "kappa": Quantity(rate.kappa),
        "text": rate_words(reach, states),
        "within": _within(rate.domain, None if reach.near is None else reach.near.level, states),
    }
    farther = None if reach.region_rate is None else _region_rate_record(reach.region_rate, states)
    return record | ({"region": farther} if len(states) == len(PLANE) else {})


def _region_rate_record(rate: RegionRate, states: Sequence[str]) -> dict[str, object]:
    within = {"radius": Quantity(rate.radius), "level": Quantity(rate.level), "text": _below_words(rate, states)}
    return {"kappa": Quantity(rate.kappa), "text": region_rate_words(rate, states), "within": within}


def _gain_record(reach: Reach, states: Sequence[str]) -> dict[str, object] | None:
    gain = reach.gain
    if gain is None:
        return None
    return {
        "gamma": Quantity(gain.gamma),
        "largest": Quantity(gain.largest),
        "ultimate": Quantity(gain.ultimate),
        "text": gain_words(gain, states),
        "within": _within(gain.domain, gain.level, states),
    }


def _within(domain: Domain, level: Fraction | None, states: Sequence[str]) -> dict[str, object]:
    """Where a rate or a gain holds: the cube of V; solutions from V below the level stay in it."""
    return {"radius": Quantity(domain.radius), "level": Quantity(level), "text": domain.text(states)}


def audit_facts(result: AuditResult) -> Iterator[Fact]:
    """Whether somebody's V is a Lyapunov function."""
    scene, function = result.scene, result.function
    yield Fact("V", result.lyapunov, str(result.verdict), row=f"V = {one_line(result.lyapunov)}")
    said = (Fact("verdict", str(result.verdict)), text_fact("reason", result.reason, "because"))
    yield from said
    if result.proves is not None:
        yield row_fact("shows", f"the equilibrium is {result.proves}")
    yield _witness(result.witness)
    yield from _looked_at(scene, function)
    yield Fact("proves", None if result.proves is None else str(result.proves))


def _looked_at(scene: Scene | SwitchedSystem, function: ExaminedFunction | None) -> Iterator[Fact]:
    """Where V is looked at, and its derivatives."""
    states = scene.states if scene.kind is SceneKind.SYSTEM else PLANE
    yield Fact("domain") if function is None else text_fact("domain", function.domain.text(states), "on")
    if scene.kind is SceneKind.SYSTEM and (scene.rewriting.written or scene.others):
        yield row_fact("field", rewriting_words(scene))  # of which the derivatives speak
    yield from () if function is None else _derivatives(function)


def _derivatives(function: ExaminedFunction) -> Iterator[Fact]:
    for key, supremum in function.suprema.items():
        yield _supremum(key, f"sup of V', {DERIVATIVES[key]}", supremum)


def _supremum(key: str, row: str, supremum: Supremum) -> Fact:
    sign, value = str(supremum.supremum_sign), supremum.value
    record = {"sign": sign, "value": Quantity(value), "point": Quantity(supremum.point)}
    words, shown = ("{}", (sign,)) if value is None else ("{} ({})", (sign, value))
    return Fact(key, record, words, shown, row=row)


def _witness(witness: Any) -> Fact:
    """Where V fails."""
    if witness is None:
        return Fact("witness")
    record = {"point": Quantity(witness.point), "value": Quantity(witness.value), "meaning": witness.meaning}
    place = ", ".join("{}" for _ in witness.point)
    words, value = f"{{}} at ({place})", () if witness.value is None else (witness.value,)
    words += " (value {})" * len(value)
    return Fact("witness", record, words, (witness.meaning, *witness.point, *value), row="witness")
