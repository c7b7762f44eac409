"""Certificates of plain systems, and where the numbers beside a V hold."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs import checker
from nonsmooth.proofs.checker.cells import read_system
from nonsmooth.proofs.checker.files import EARLIER, check_file
from nonsmooth.proofs.kernel.cells import stated_cells, surfaces_of
from nonsmooth.proofs.kernel.search import NotShownError, Search
from nonsmooth.proofs.kernel.subject import NoCertificateError, about
from nonsmooth.proofs.system_certificates import certificate_of, left_out
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.domain import SublevelRegion
from nonsmooth.symbolic.files.scene_file import load_system
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from tests import built_in
from tests.oracles.floats import velocity
from tests.oracles.mutants import Record
from tests.plain import built, refused
from tests.proofs.forged import with_reach
from tests.proofs.switched_oracle import random_relay
from tests.proofs.test_known_systems import NAMES, linear, random_matrix
from tests.thorough import but, few, keep, thorough

# ---- Certificates of plain systems in two states and more: what a V decides is accepted, and nothing else is stated.

BENDS = "4*Abs(x) + 4*Abs(y) + z**2"
SYSTEMS: dict[str, tuple[list[Any], dict[str, Any]]] = {
    "slides": (["-sgn(x)", "-sgn(y)", "-z"], {"lyapunov": BENDS}),
    "whole space": (["-x", "-y", "-z + Abs(x)"], {"lyapunov": "Abs(x) + Abs(y) + Abs(z)/2"}),
    "curved surface": (["-x", "-y", "-z + Abs(x*y - z)/2"], {}),
    "several planes": (["-x + relu(y - 1/8)/4", "-y", "-z + relu(y - 1/4)/4"], {}),
    "centre": (["y", "-x", "-z"], {}),
    "switched": ([["y - x", "z - y", "-x - y - z"], ["y - x", "z - y", "-x - y - 2*z"]], {}),
    "grows": (["sgn(x) + y", "-sgn(y)", "-z"], {}),
}
RELAYS = ns.System(["x", "y"], ["-sign(x) + y/4", "-sign(y) - x/4"], radius="1/2")


def certified(system: ns.System) -> Record:
    return certificate_of(decide_system(system.system))


def claims(record: Record, kind: str) -> list[Any]:
    """What a certificate states of one kind."""
    return [claim[kind] for claim in record["statement"]["claims"] if kind in claim]


@cache
def decided(name: str) -> StabilityResult:
    rhs, check = SYSTEMS[name]
    return decide_system(built(rhs, **check))


@cache
def text_of(name: str) -> str:
    return json.dumps(certificate_of(decided(name)))


def record_of(name: str) -> Record:
    record: Record = json.loads(text_of(name))
    return record


# ---- what is true --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", keep(2, ["relay-oscillator-damped", "flower", "relay-chain"]))
def test_built_in_systems_are_accepted_without_the_program(name: str, tmp_path: Path) -> None:
    file = tmp_path / "c.json"
    file.write_text(json.dumps(certificate_of(built_in.decided(name))), encoding="utf-8")
    line = [sys.executable, "-I", "-S", str(Path(checker.__file__).parent), str(file)]
    done = subprocess.run(line, capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stdout.splitlines()[0]) == (0, "valid")
    assert "asymptotically stable" in done.stdout


@few(3)
@pytest.mark.parametrize("name", but(["whole space", "slides"], SYSTEMS))
def test_verdicts_in_three_states_are_certified(name: str) -> None:
    record = record_of(name)
    assert refused(record) == ""
    assert claims(record, "stability") == [str(decided(name).verdict)]


@pytest.mark.usefixtures("without_reach")
@pytest.mark.parametrize("seed", range(12))
def test_random_relays_that_a_v_decides_are_certified(seed: int, load: Any) -> None:
    result = decide_system(load(*random_relay(seed).rhs))
    if result.function is not None:
        assert claims(certificate_of(result), "stability") == [str(result.verdict)]


@pytest.mark.parametrize("seed", range(6))
def test_random_linear_systems_that_a_v_decides_are_certified(seed: int) -> None:
    rng = np.random.default_rng(500 + seed)
    count = int(rng.integers(3, 7))
    result = decide_system(built([linear(row) for row in random_matrix(rng, count)], states=NAMES))
    if result.function is not None or result.deciding.entry is not None:
        assert claims(certificate_of(result), "stability") == [str(result.verdict)]


def test_region_and_rate_are_stated_and_no_larger_ones() -> None:
    record = certified(RELAYS)
    ((region, whole), (rate,)) = claims(record, "attracts"), claims(record, "rate")
    assert whole == "everywhere"
    assert (region["below"], rate["kind"], rate["kappa"]) == ("1/4", "exponential", "4")
    for kind, key, value in (("attracts", "below", "257/1024"), ("rate", "kappa", "33/8"), ("rate", "kind", "finite")):
        changed = json.loads(json.dumps(record))
        next(c for c in changed["statement"]["claims"] if kind in c)[kind][key] = value  # the region stands first
        assert "evidence of the claim" in refused(changed)
    larger = json.loads(json.dumps(record))
    larger["evidence"][0]["hypotheses"]["level"] = "257/1024"
    assert "border" in refused(larger)


def test_arbitrary_switching_and_growth() -> None:
    switched = ns.System(["x", "v"], [["v", "-2*x - v"], ["v", "-5/2*x - v"]])
    assert claims(certified(switched), "stability") == ["asymptotically stable"]
    assert claims(certified(ns.System(["x", "y"], ["x + y", "y - x"])), "stability") == ["unstable"]


def test_a_region_beyond_the_square_of_v_is_stated_where_v_may_stand_still_on_its_border() -> None:
    """V = x^2 + y^2 stands still at (0, -1/2), on the border of the largest region V < 1/4."""
    record = certified(ns.System(["x", "y"], ["-x", "-y - 2*y**2"], radius="1/2"))
    regions = {(claim["within"], claim["below"]) for claim in claims(record, "attracts")}
    assert regions == {("1/32", "1/1024"), ("1/2", "1/4"), ("1/2", "1/8")}
    (near, far) = claims(record, "rate")
    assert (near["within"], near["kappa"], far["below"], far["kappa"]) == ("1/32", "15/8", "1/8", "9/16")
    assert left_out(record) == []
    (gain,) = claims(record, "gain")
    assert (gain["within"], gain["kappa"], gain["gamma"]) == ("1/32", "15/8", "3/32")


# ---- what is left out, refused, rejected ---------------------------------------------------------


def test_a_claim_that_is_not_shown_is_left_out_and_named() -> None:
    """Of a rate four times too large nothing is written but that it is missing; verdict and level stand."""
    result = decide_system(RELAYS.system)
    rate = result.reach.rate
    assert rate is not None
    record = certificate_of(with_reach(result, rate=replace(rate, kappa=rate.kappa * 4)))
    assert (len(claims(record, "attracts")), claims(record, "rate")) == (2, [])
    (line, *_) = left_out(record)
    assert line.startswith("V' <= -16 V on abs(x), abs(y) <= 1/2")
    assert "no proof was found of rate cell" in line


@pytest.mark.parametrize(("force", "why"), [("sign(y)/4", "every point of the ray"), ("0", "solutions near the")])
def test_that_a_stable_point_does_not_attract_is_left_out_and_named(force: str, why: str) -> None:
    (line,) = left_out(certified(ns.System(["x", "y"], ["y", f"-x - {force}"])))
    assert line.startswith(f"the equilibrium does not attract: {why}")


@pytest.mark.usefixtures("without_reach")
def test_irrational_numbers_stand_for_themselves_in_the_plane() -> None:
    record = certificate_of(decide_system(load_system("eq-4")))
    assert claims(record, "stability") == ["asymptotically stable"]
    assert len(record["statement"]["subject"]["rhs"]) == 1
    beside = certificate_of(decide_system(load_system("eq-4", at="sqrt(2)/2,0")))
    assert claims(beside, "equilibrium") == [False]
    assert beside["statement"]["subject"]["at"] == [[["1/2", 0]], "0"]


@pytest.mark.parametrize(
    ("written", "plain"),
    [
        (["-sin(pi/6)*x"], ["-1/2*x"]),
        (["-sqrt(4)*x"], ["-2*x"]),
        (["-x*sin(pi/6) + y", "-y - sign(y)*sqrt(4)"], ["-x*(1/2) + y", "-y - sign(y)*2"]),
    ],
)
def test_functions_of_numbers_that_are_rational_are_that_number(written: list[str], plain: list[str]) -> None:
    """The checker reads no function of numbers; the same system in plain numbers has the same certificate."""
    states = ["x", "y"][: len(plain)]
    (one, other) = (ns.System(states, rhs, name="one").check().certificate() for rhs in (written, plain))
    assert one["statement"]["claims"] == other["statement"]["claims"]
    assert one == other


@pytest.mark.usefixtures("without_reach")
@pytest.mark.parametrize(
    "rhs", keep(2, [["-1e300*x + y", "-1e-300*y"], ["-x - 1e400*y", "-y"], ["-x + 1e200*y", "-y"]])
)
def test_numbers_beyond_floats_may_have_no_certificate(rhs: list[str]) -> None:
    result = decide_system(built(rhs))
    assert str(result.verdict) == "asymptotically stable"
    with pytest.raises(NoCertificateError, match="the checker does not show it"):
        certificate_of(result)


@pytest.mark.usefixtures("without_reach")
def test_lines_that_floats_do_not_tell_apart_are_told_apart() -> None:
    result = decide_system(built(["x*sign(1.00000000000000000001*x + y) - x*sign(x + y) - x", "-y"]))
    assert {"stability": "asymptotically stable"} in certificate_of(result)["statement"]["claims"]


@pytest.mark.usefixtures("without_reach")
def test_irrational_numbers_lie_between_rational_ones_in_space() -> None:
    record = certified(ns.System(["x", "y", "z"], ["-sqrt(2)*x + y", "-y - sqrt(3)*z", "sqrt(3)*y - z"]))
    assert claims(record, "stability") == ["asymptotically stable"]
    assert len(record["statement"]["subject"]["rhs"]) == 8


@pytest.mark.parametrize("name", but(["slides"], ["slides", "several planes", "grows"]))
def test_every_condition_must_be_shown(name: str) -> None:
    """A certificate without one of its proofs, with an empty one, or with one more is rejected."""
    record = record_of(name)
    entry, *others = record["evidence"]
    for k, key in list(enumerate(entry["proofs"]))[:: 3 if name == "slides" else 1]:
        without = {condition: proof for condition, proof in entry["proofs"].items() if condition != key}
        proofs = without if k % 2 else {**entry["proofs"], key: {}}
        assert key in refused({**record, "evidence": [{**entry, "proofs": proofs}, *others]})
    more = {**entry["proofs"], "cell +++ field 9": {"squares": []}}
    assert "proofs of claims that are asked" in refused({**record, "evidence": [{**entry, "proofs": more}, *others]})


@pytest.mark.parametrize("field", [["-x - sign(x**3*(x - 1/4)**2)", "-y"], ["y", "-x - y - sign(y*(x + y - 1/4)**4)"]])
def test_a_switching_expression_that_keeps_its_sign_where_it_is_zero_has_a_surface_there(field: list[str]) -> None:
    record = certified(ns.System(["x", "y"], field, radius="1/2"))
    assert not refused(record)
    surfaces = record["evidence"][0]["hypotheses"]["cells"]["surfaces"]
    assert any("1/4" in surface or "- 1" in surface for surface in surfaces)


@thorough  # the audit of the same faces: test_audits, many_states/test_attacks.py
@pytest.mark.parametrize(("more", "face"), keep(1, [("", "00+"), (" + Abs(x + y) + Abs(x - y)", "00+00")]))
def test_faces_on_which_v_bends_are_asked(more: str, face: str) -> None:
    """Some planes share the z axis, along which solutions slide outward; V falls everywhere else."""
    system = built(["-3*sgn(x)", "-3*sgn(y)", "sgn(z)"])
    text = f"Abs(x) + Abs(y){more} + Abs(z)"
    cells = stated_cells(system, system.check.radius, surfaces_of(system, parse_piecewise(text, system.states)))
    told = {"cells": cells.record, "function": text, "verdict": "asymptotically stable"}
    hypotheses = {**told, "second": None, "everywhere": False, "level": None, "below": False, "rate": None}
    search = Search()
    with pytest.raises(NotShownError, match="no proof was found of face "):
        search.entry(read_system(about(system)), "lyapunov", hypotheses)
    assert all(name.startswith(("V ", "cell ", "empty ", "face ")) for name in search.found)
    assert f"face {face}" not in search.found


@pytest.mark.parametrize("schema", EARLIER)
def test_earlier_versions_are_refused_with_the_line_that_writes_them_anew(schema: str, tmp_path: Path) -> None:
    file = tmp_path / "old.json"
    file.write_text(json.dumps({"schema": schema, "states": ["x"]}), encoding="utf-8")
    status, line = check_file(str(file))
    assert status == 2
    assert f"nonsmooth check {EARLIER[schema]} --certificate {file}" in line
    assert "\n" not in line


# ---- Every number beside a V names where it holds: there it is compared with solutions by small steps and with
# samples.
#
# The oracle shares nothing with the proofs: formulas are evaluated in floats, solutions are polygons with small
# steps, and what is compared are the numbers of the JSON record alone, on the domain that stands beside each.

STEP = 1 / 512
STARTS = 60
DIRECTIONS = 16  # of disturbances


def smooth(seed: int, count: int) -> list[str]:
    """A contraction with a shear, and random terms of degree two and three that are felt near the border."""
    rng = np.random.default_rng(seed)
    names = ["x", "y", "z"][:count]
    quadratic = [f"{a}*{b}" for a in names for b in names]
    rhs = []
    for k, name in enumerate(names):
        other = names[(k + 1) % count]
        terms = [f"-{name}", f"({rng.integers(-4, 5)}/8)*{other}"]
        terms += [f"({rng.integers(-8, 9)}/2)*{rng.choice(quadratic)}", f"({rng.integers(-8, 9)}/4)*{name}**3"]
        rhs.append(" + ".join(terms))
    return rhs


def relay(seed: int, count: int) -> list[str]:
    """Relays that push back, with random linear terms."""
    rng = np.random.default_rng(seed)
    names = ["x", "y", "z"][:count]
    others = names[1:] + names[:1]
    pairs = zip(names, others, strict=True)
    return [f"-{rng.integers(1, 4)}*sign({name}) + ({rng.integers(-4, 5)}/4)*{other}" for name, other in pairs]


FAMILIES = {"smooth": smooth, "relay": relay}


def values(text: str, states: np.ndarray) -> np.ndarray:
    """A formula at the columns of an array of states."""
    return velocity([text], states)[0]


def lyapunov_record(rhs: list[str]) -> dict[str, Any]:
    record = ns.System(["x", "y", "z"][: len(rhs)], rhs, radius="1/2").check().to_dict()["lyapunov"]
    return dict(record)


def starts_below(record: dict[str, Any], within: dict[str, Any], count: int) -> np.ndarray:
    """Random points of the square at which V is below the level that is named; as columns."""
    rng = np.random.default_rng(0)
    radius = within["radius"]
    points = rng.uniform(-radius, radius, (count, 200_000)) * rng.uniform(0, 1, 200_000)
    inside = values(record["V"], points) < within["level"]
    return points[:, inside][:, :STARTS]


def requires_rate(rhs: list[str], record: dict[str, Any], kind: str, kappa: float, within: dict[str, Any]) -> None:
    """V falls at the rate along polygons from everywhere in the domain, which they never leave."""
    states = starts_below(record, within, len(rhs))
    assert states.shape[1] == STARTS
    first = values(record["V"], states)
    slack = 4 * STEP * np.abs(velocity(rhs, states)).max()  # of a polygon across a surface
    for step in range(1, 3 * 512):
        states = states + STEP * velocity(rhs, states)
        t = step * STEP
        now = values(record["V"], states)
        bound = first * np.exp(-kappa * t) if kind == "exponential" else np.maximum(first - kappa * t, 0)
        smallest = slack if "sign" in "".join(rhs) else 2 * STEP * first
        assert np.all(now <= bound + smallest)
        assert np.all(np.abs(states) <= within["radius"] + slack)


def requires_inequality(rhs: list[str], record: dict[str, Any], kappa: float, within: dict[str, Any]) -> None:
    """``V' <= -kappa V`` at random points of the domain, the slope of V by central differences."""
    states = starts_below(record, within, len(rhs))
    small = 1e-6
    along = velocity(rhs, states)
    rise = (values(record["V"], states + small * along) - values(record["V"], states - small * along)) / (2 * small)
    assert np.all(rise <= -kappa * values(record["V"], states) + 1e-6)


def requires_gain(rhs: list[str], record: dict[str, Any], gain: dict[str, Any]) -> None:
    """Disturbances that do their worst keep to ``V' <= -kappa V + gamma abs(d)`` in the level set that is named."""
    states = starts_below(record, gain["within"], len(rhs))
    kappa, kind, level = record["rate"]["kappa"], record["rate"]["kind"], gain["within"]["level"]
    delta = 0.9 * gain["largest"]
    angles = np.linspace(0, 2 * np.pi, DIRECTIONS, endpoint=False)
    pushes = delta * np.array([np.cos(angles), np.sin(angles)])[:, :, None]
    first = values(record["V"], states)
    slack = 8 * STEP * gain["gamma"] * (np.abs(velocity(rhs, states)).max() + delta)
    for step in range(1, 2 * 512):
        moved = (states + STEP * velocity(rhs, states))[:, None] + STEP * pushes
        worst = values(record["V"], moved.reshape(2, -1)).reshape(DIRECTIONS, -1).argmax(axis=0)
        states = moved[:, worst, np.arange(states.shape[1])]
        t = step * STEP
        falls = np.exp(-kappa * t)
        bound = first * falls + gain["gamma"] * delta / kappa * (1 - falls)
        if kind == "finite":
            bound = np.maximum(first - (kappa - gain["gamma"] * delta) * t, 0)
        assert np.all(values(record["V"], states) <= bound + slack)
    assert values(record["V"], states).max() < level + slack


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", [2, 1, *range(3, 21)])
def test_planar_numbers_hold_where_they_say(family: str, seed: int) -> None:
    rhs = FAMILIES[family](seed, 2)
    record = lyapunov_record(rhs)
    rate, gain, region = record["rate"], record["gain"], record["region"]
    if region is not None:
        states = starts_below(record, {"radius": region["within"], "level": region["level"]}, 2)
        for _ in range(20 * 512):
            states = states + STEP * velocity(rhs, states)
        assert np.all(np.abs(states) < 0.02)
    if rate is None:
        return
    requires_rate(rhs, record, rate["kind"], rate["kappa"], rate["within"])
    assert rate["within"]["text"] in rate["text"]
    if rate["region"] is not None:
        requires_rate(rhs, record, "exponential", rate["region"]["kappa"], rate["region"]["within"])
        requires_inequality(rhs, record, rate["region"]["kappa"], rate["region"]["within"])
    if gain is not None:
        requires_gain(rhs, record, gain)
        assert gain["within"]["text"] in gain["text"]


@pytest.mark.parametrize("family", keep(1, FAMILIES))
@pytest.mark.parametrize("seed", range(4))
def test_numbers_in_three_states_hold_where_they_say(family: str, seed: int) -> None:
    rhs = FAMILIES[family](seed, 3)
    record = lyapunov_record(rhs)
    rate = record["rate"]
    if rate is not None and rate["within"]["level"] is not None:
        requires_rate(rhs, record, rate["kind"], rate["kappa"], rate["within"])
        assert rate["within"]["text"] in rate["text"]


def test_a_rate_beside_a_larger_region_names_its_own_square() -> None:
    """``y' = -y - 2 y^2`` rests at ``y = -1/2``: no rate holds all over the region, the near one far less."""
    record = lyapunov_record(["-x", "-y - 2*y**2"])
    region, rate, gain = record["region"], record["rate"], record["gain"]
    assert (region["level"], region["within"]) == (1 / 4, 1 / 2)
    assert rate["within"]["radius"] == gain["within"]["radius"] == 1 / 32
    assert rate["within"]["level"] == gain["within"]["level"] == 1 / 1024
    y = -np.sqrt(rate["region"]["within"]["level"])
    assert 2 * y * (-y - 2 * y * y) <= -rate["region"]["kappa"] * y * y
    assert 2 * y * (-y - 2 * y * y) > -rate["kappa"] * y * y  # so a rate that names no domain misleads


def test_a_forged_rate_on_a_region_is_rejected() -> None:
    result = ns.System(["x", "y"], ["-x", "-y - 2*y**2"], radius="1/2").check().evidence
    reach = result.reach
    assert reach.region_rate is not None
    assert reach.region is not None
    assert result.check()
    faster = replace(reach.region_rate, kappa=reach.region_rate.kappa * 2)
    farther = replace(reach.region_rate, level=reach.region.level * 2)
    for forged in (faster, farther):
        assert not with_reach(result, region_rate=forged).check()
    assert isinstance(reach.near, SublevelRegion)
    assert not with_reach(result, near=replace(reach.near, level=reach.region.level)).check()
