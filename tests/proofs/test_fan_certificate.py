"""Certificates by the velocities at the equilibrium: known fans, forgeries, mutants, and random fans."""

from __future__ import annotations

import json
import math
import random
import subprocess
import sys
from collections.abc import Callable, Iterator
from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import Any, TypeAlias

import pytest

import nonsmooth as ns
from nonsmooth.proofs import system_checker
from nonsmooth.proofs.system_checker import FAN_SCHEMA, FanCertificate, RejectedError, check_certificate
from nonsmooth.proofs.system_decision import certificate_of
from nonsmooth.proofs.systems.fan_certificate import fan_statement
from nonsmooth.proofs.systems.system_certificate import NoCertificateError, build_system_certificate
from nonsmooth.proofs.systems.system_stability import system_check
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.files.system_file import load_system
from tests.proofs import mutants
from tests.proofs.mutants import Record, is_one_line
from tests.proofs.switched_oracle import Affine, Judge, Switched, spread
from tests.proofs.test_system_checker import in_floats
from tests.thorough import thorough

Velocity: TypeAlias = Callable[[float, float], tuple[float, float]]

ATTRACTS, STABLE, UNSTABLE = "asymptotically stable", "stable", "unstable"


def claim(rhs: list[str], verdict: str, motions: list[tuple[str, str]] | None = None, **more: Any) -> Record:
    """A certificate written by hand; motions as pairs of texts such as ``("1 0", "-1 0")``: ray and velocity."""
    listed = [{"ray": ray.split(), "velocity": velocity.split()} for ray, velocity in motions or []]
    own = {"schema": FAN_SCHEMA, "states": ["x", "y"], "rhs": [rhs], "at": ["0", "0"], "verdict": verdict}
    return {**own, "motions": listed, "gain": None, "notes": {}, **more}


def test_where_no_v_is_certified_velocities_are(tmp_path: Path) -> None:
    """A curve cuts the cells of V, which the checker does not take; the velocities show the verdict too."""
    scene = '[system]\nstates = ["x", "y"]\nrhs = ["-sign(x + y**2)", "-sign(y) + x"]\n'
    (tmp_path / "my.toml").write_text(scene, encoding="utf-8")
    result = system_check(load_system(tmp_path / "my.toml"))
    with pytest.raises(NoCertificateError, match="products of lines"):
        build_system_certificate(result)
    record = certificate_of(result)
    assert (record["schema"], record["verdict"]) == (FAN_SCHEMA, str(result.verdict))
    (tmp_path / "my.toml").write_text(
        scene.replace("-sign(x + y**2)", "y").replace("-sign(y) + x", "-2*sign(x + y - x**2)")
    )
    with pytest.raises(NoCertificateError, match="products of lines"):
        certificate_of(system_check(load_system(tmp_path / "my.toml")))


# ---- what is true --------------------------------------------------------------------------------

HOME = [("1 0", "-1 0"), ("-1 0", "1 0"), ("0 1", "0 -1"), ("0 -1", "0 1")]
DIAGONALS = [("1 1", "-1 -1"), ("-1 1", "1 -1"), ("-1 -1", "1 1"), ("1 -1", "-1 1")]
TURN = ["sign(y)", "-sign(x) - sign(y)/2"]

TRUE = {
    "turns outward": claim(["sign(y)", "-sign(x) + sign(y)/2"], UNSTABLE, gain="9"),
    "turns inward": claim(TURN, ATTRACTS, gain="1/9"),
    "turns inward, which is stable": claim(TURN, STABLE, gain="1/9"),
    "turns inward, higher terms": claim(["sign(y) + 5*x**2", "-sign(x) - sign(y)/2 + 9*x"], ATTRACTS, gain="1/9"),
    "turns inward, curved": claim(["sign(y - x**2)", "-sign(x) - sign(y - x**2)/2"], ATTRACTS, gain="1/9"),
    "turns inward, elsewhere": claim(
        ["sign(y - 1/2)", "-sign(x + 3) - sign(y - 1/2)/2 + sat(x, -1, 1) + 1"], ATTRACTS, gain="1/9", at=["-3", "1/2"]
    ),
    "closed orbits": claim(["sign(y)", "-sign(x)"], STABLE, gain="1"),
    "slides home": claim(["-sign(x)", "-sign(y)"], ATTRACTS, HOME + DIAGONALS),
    "slides home, scaled rays": claim(["-sign(x)", "-sign(y)"], ATTRACTS, [("7 0", "-1 0"), *HOME[1:], *DIAGONALS]),
    "slides home beside kinks": claim(["-sign(x) + Abs(x + y)", "-sign(y) - relu(x)"], ATTRACTS, HOME + DIAGONALS),
    "slides away": claim(["sign(x)", "-3*sign(y)"], UNSTABLE, [("1 0", "1 0")]),
    "slides away where it repels": claim(["3*sign(x) - 1", "1"], UNSTABLE, [("0 1", "0 1")]),
    "runs away": claim(["1", "x"], UNSTABLE, [("1 0", "1 0")]),
    "runs away between curves": claim(["sign(x) + x*y", "1 + 0*sign(y - x**2)"], UNSTABLE, [("1 1", "1 1")]),
    "equilibria on a line": claim(
        ["0", "-sign(y)"], STABLE, [("0 1", "0 -1"), ("0 -1", "0 1"), ("1 0", "0 0"), ("-1 0", "0 0")]
    ),
    "slides home where it repels": claim(
        ["sign(x)*(3*sign(y + Abs(x)) - 1)/2", "-1 - 2*sign(y + Abs(x))"], ATTRACTS, [("0 1", "0 -3"), ("0 -1", "0 1")]
    ),
    "slides away slowly": claim(["-sign(x) + y", "y - x + sign(x)*y**2"], UNSTABLE, [("0 1", "0 0")]),
    "slides away slowly where it repels": claim(["3*sign(x)", "sign(x) + y**3 - x"], UNSTABLE, [("0 1", "0 0")]),
    "one outward velocity is enough": claim(["sign(x) + 1", "y"], UNSTABLE, [("1 0", "2 0")]),
}  # fmt: skip


@pytest.mark.parametrize("name", TRUE)
def test_true_claims_are_accepted(name: str) -> None:
    assert check_certificate(TRUE[name]) == ""


@pytest.mark.parametrize("name", TRUE)
def test_the_same_motions_and_gains_show_no_other_verdict(name: str) -> None:
    record, weaker = TRUE[name], {"turns inward": {STABLE}, "turns inward, which is stable": {ATTRACTS}}
    for exact in ("turns inward, elsewhere", "slides home", "slides home, scaled rays", "slides home where it repels"):
        weaker[exact] = {STABLE}
    for verdict in {ATTRACTS, STABLE, UNSTABLE} - {record["verdict"]} - weaker.get(name, set()):
        assert is_one_line(check_certificate({**record, "verdict": verdict}))


def certified(rhs: list[str]) -> Record:
    """The program's certificate."""
    return certificate_of(system_check(ns.System(["x", "y"], rhs, radius="1/4").system))


@pytest.mark.parametrize("name", ["relay-oscillator", "escaping-slide", "line-of-equilibria"])
def test_built_in_systems_are_accepted_without_the_program(name: str, tmp_path: Path) -> None:
    file = tmp_path / "c.json"
    record = certificate_of(system_check(load_system(name)))
    assert record["schema"] == FAN_SCHEMA
    file.write_text(json.dumps(record), encoding="utf-8")
    line = [sys.executable, "-I", "-S", str(Path(system_checker.__file__)), str(file)]
    done = subprocess.run(line, capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stdout.splitlines()[0]) == (0, "valid")


@pytest.mark.parametrize("name", ["turns outward", "turns inward, curved", "slides away", "runs away"])
def test_the_program_states_the_same(name: str) -> None:
    record = certified(TRUE[name]["rhs"][0])
    assert (record["verdict"], record["gain"]) == (TRUE[name]["verdict"], TRUE[name]["gain"])
    assert check_certificate(record) == ""


@pytest.mark.parametrize(
    ("rhs", "why"),
    [
        (["sqrt(2)*sign(y)", "-sign(x) + sign(y)/2"], "rational"),
        (["sign(y - sqrt(2)*x)", "-sign(x) + sign(y - sqrt(2)*x)/2"], "rational"),
        (["x", "y"], "do not all vanish"),
        (["y", "-sign(x) + sign(y)/4"], "all cross their switching lines"),
    ],
)
def test_other_verdicts_have_none(rhs: list[str], why: str) -> None:
    with pytest.raises(NoCertificateError, match=why) as refused:
        certified(rhs)
    assert is_one_line(str(refused.value))


# ---- what is false -------------------------------------------------------------------------------

THIN = "(1 + sign(y))*(1 - sign(y - x**2))/4"  # 1 between y = 0 and y = x^2, where solutions run along the x axis
FALSE = {
    "turns outward": (claim(["sign(y)", "-sign(x) + sign(y)/2"], ATTRACTS, gain="9"), "below one"),
    "turns outward, gain inverted": (claim(["sign(y)", "-sign(x) + sign(y)/2"], ATTRACTS, gain="1/9"), "gain"),
    "turns inward": (claim(TURN, UNSTABLE, gain="1/9"), "above one"),
    "another gain": (claim(TURN, ATTRACTS, gain="1/8"), "the gain"),
    "no gain": (claim(TURN, ATTRACTS), "radial velocity"),
    "closed orbits": (claim(["sign(y)", "-sign(x)"], ATTRACTS, gain="1"), "below one"),
    "closed orbits, unstable": (claim(["sign(y)", "-sign(x)"], UNSTABLE, gain="1"), "above one"),
    "open orbits": (claim(["sign(y) + x*Abs(x)", "-sign(x)"], STABLE, gain="1"), "constant fields"),
    "orbits between curves": (claim(["sign(y - x**2)", "-sign(x)"], STABLE, gain="1"), "straight"),
    "a gain beside radial velocities": (claim(["-sign(x)", "-sign(y)"], ATTRACTS, gain="1/9"), "all radial"),
    "equilibria on a line": ({**TRUE["equilibria on a line"], "verdict": ATTRACTS}, "lead inward"),
    "one motion left out": (claim(["sign(x)", "-3*sign(y)"], ATTRACTS, HOME[2:]), "all radial"),
    "an outward motion": (
        claim(["-sign(x)*(1 - 2*sign(y))", "-1 - sign(y)*3"], ATTRACTS, [("0 1", "0 -4"), ("0 -1", "0 2")]), "radial"
    ),
    "equilibria, unstable": ({**TRUE["equilibria on a line"], "verdict": UNSTABLE,
                              "motions": [{"ray": ["1", "0"], "velocity": ["0", "0"]}]}, "leads outward"),
    "slides home slowly": (claim(["-sign(x)", "-y**3"], UNSTABLE, [("0 1", "0 0")]), "leads outward"),
    "slides home slowly where it repels": (claim(["sign(x)", "-y"], UNSTABLE, [("0 1", "0 0")]), "leads outward"),
    "slides away slowly on one ray": (claim(["-sign(x)", "y**2"], UNSTABLE, [("0 -1", "0 0")]), "leads outward"),
    "slides on a curve": (claim(["-sign(x - y**2)", "y"], UNSTABLE, [("0 1", "0 0")]), "leads outward"),
    "a slow slide that attracts": (claim(["-sign(x)", "-y"], ATTRACTS, [("0 1", "0 0"), ("0 -1", "0 0"), *HOME[:2]]),
                                   "lead inward"),
    "inward, unstable": (claim(["-sign(x)", "-sign(y)"], UNSTABLE, [("1 0", "-1 0")]), "leads outward"),
    "another velocity": (claim(["sign(x)", "-3*sign(y)"], UNSTABLE, [("1 0", "3 0")]), "leads outward"),
    "another ray": (claim(["sign(x)", "-3*sign(y)"], UNSTABLE, [("0 1", "1 0")]), "leads outward"),
    "no evidence": (claim(["sign(x)", "-3*sign(y)"], UNSTABLE), "one motion"),
    "no motion on that side": (claim(["sign(x)", "1"], UNSTABLE, [("0 -1", "0 1")]), "leads outward"),
    "a velocity along a line": (claim(["y", "-sign(x) - sign(y)/2"], ATTRACTS, gain="1/9"), "along a ray"),
    "no velocity in a quadrant": (claim(["-relu(sign(x))", "-sign(y)"], ATTRACTS, HOME), "along a ray"),
    "no jump": (claim(["-x", "-y"], ATTRACTS, HOME), "jumps at the point"),
    "a thin cell": (claim([f"-sign(x)*(1 - {THIN}) + {THIN}", f"-sign(y)*(1 - {THIN})"], ATTRACTS, HOME + DIAGONALS),
                    "one switching curve"),
    "a cusp": (claim(["-sign(x)", "-sign(y) - sign(y**2 - x**3)/2"], ATTRACTS, HOME + DIAGONALS), "products"),
    "roots in lines": (claim(["-sign(x)", "-sign(y) - sign(x**2 - 2*y**2)/4"], ATTRACTS, HOME), "rationals"),
    "square roots of states": (claim(["-sign(x) + sqrt(Abs(y))", "-sign(y)"], ATTRACTS, HOME), "rational"),
    "fractions of states": (claim(["-sign(x)/(1 + x)", "-sign(y)"], ATTRACTS, HOME), "division"),
    "elsewhere": (claim(["-sign(x)", "-sign(y)"], ATTRACTS, HOME + DIAGONALS, at=["1", "0"]), "all radial"),
    "two right-hand sides": (
        {**claim(["-sign(x)", "-sign(y)"], ATTRACTS, HOME + DIAGONALS), "rhs": [["-sign(x)", "-sign(y)"]] * 2},
        "one right-hand side",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FALSE)
def test_false_claims_are_rejected(name: str) -> None:
    record, why = FALSE[name]
    refused = check_certificate(record)
    assert is_one_line(refused)
    assert why in refused


GOOD = TRUE["slides away"]
MALFORMED: list[Any] = [
    {**GOOD, "more": 1}, {key: value for key, value in GOOD.items() if key != "gain"}, {**GOOD, "schema": [FAN_SCHEMA]},
    {**GOOD, "gain": 1}, {**GOOD, "motions": None}, {**GOOD, "motions": [{"ray": ["0", "0"], "velocity": ["1", "0"]}]},
    {**GOOD, "motions": [{"ray": ["1", "0"]}]}, {**GOOD, "motions": GOOD["motions"] * 2}, {**GOOD, "at": ["0"]},
    {**GOOD, "motions": [{"ray": ["1", "0"], "velocity": ["1"]}]}, {**GOOD, "states": ["x", "x"]},
    {**GOOD, "states": ["x"]}, {**GOOD, "rhs": [["sign(x)"]]}, {**GOOD, "rhs": [["sign(x)", "z"]]},
    {**GOOD, "rhs": []}, {**GOOD, "rhs": [["sign(x)", "__import__('os')"]]}, {**GOOD, "verdict": "holds"},
    {**GOOD, "rhs": [["sign(x)", "+".join(f"sign(x + {k}*y)" for k in range(1, 30))]]},
]  # fmt: skip


@pytest.mark.parametrize("data", MALFORMED, ids=range(len(MALFORMED)))
def test_malformed_data_are_rejected_in_one_line(data: Any) -> None:
    assert is_one_line(check_certificate(data))


# ---- oracles -------------------------------------------------------------------------------------


def random_fan(seed: int, *, drift: bool = True) -> Switched:
    """One to three lines, relays that push to them and along them, products of relays, perhaps a linear part."""
    source = random.Random(seed)
    lines: list[tuple[int, int]] = []
    count = source.randint(1, 3)
    while len(lines) < count:
        a, b = source.randint(-3, 3), source.randint(-3, 3)
        if (a or b) and all(a * d - b * c for c, d in lines):
            lines.append((a, b))
    push, along, rest = source.randint(-1, 3), source.choice((-3, 0, 0, 3)), source.randint(0, 4)
    terms: list[tuple[tuple[int, ...], Affine]] = []
    for chosen in product((False, True), repeat=count):
        taken = tuple(k for k in range(count) if chosen[k])
        if len(taken) < 3:
            velocity = [Fraction(source.randint(-rest, rest), 2) for _ in range(2)]
            if len(taken) == 1:
                a, b = lines[taken[0]]
                velocity = [velocity[0] - push * a - along * b, velocity[1] - push * b + along * a]
            c, d, e, f = (Fraction(source.randint(-2, 2) if drift and len(taken) < 2 else 0) for _ in range(4))
            terms.append((taken, Affine(((c, d), (e, f)), (velocity[0], velocity[1]))))
    return Switched(tuple(lines), tuple(terms))


def accepted_verdicts(rhs: tuple[str, str]) -> set[str]:
    """The verdicts that the checker accepts with the motions and the gain that it finds itself."""
    found = set()
    certificate = FanCertificate(claim(list(rhs), STABLE))
    motions = certificate.fan.motions()
    outward = [motion for motion in motions if motion.speed > 0]
    for verdict, listed in ((ATTRACTS, motions), (STABLE, motions), (UNSTABLE, outward[:1])):
        certificate.verdict, certificate.motions, certificate.gain = verdict, listed, None
        try:
            if not motions:
                certificate.gain = certificate.fan.gain()
            certificate.check()
        except (RejectedError, ZeroDivisionError):
            continue
        found.add(verdict)
    return found


def compare_with_formulas(count: int, first: int) -> list[str]:
    """The verdicts on random fans that both the checker and the formulas in floats decide, all of them alike."""
    decided = []
    for seed in range(first, first + count):
        system = random_fan(seed)
        accepted, known = accepted_verdicts(system.rhs) - {STABLE}, Judge(system).verdict()
        assert len(accepted) < 2, (seed, system.rhs)
        if known is not None and accepted:
            assert accepted == {known}, (seed, system.rhs)
            decided.append(known)
    return decided


def compare_with_paths(count: int, first: int) -> int:
    """How many random fans are said to attract; all polygons with small steps come near the point."""
    attracted = 0
    for seed in range(first, first + count):
        system = random_fan(seed, drift=False)
        if ATTRACTS in accepted_verdicts(system.rhs):
            attracted += 1
            ends = (spread(system, steps=steps)[1] for steps in (4000, 64000))  # some turns shrink slowly
            assert any(end < 0.5 for end in ends), (seed, system.rhs)
    return attracted


@pytest.mark.parametrize("seed", [5, 9, 20, 34, 47, 48, 50, 56])
def test_the_program_finds_the_motions_and_gains_of_the_checker(seed: int) -> None:
    rhs = random_fan(seed, drift=False).rhs
    fan = FanCertificate(claim(list(rhs), STABLE)).fan
    fan.require_strict()
    record = fan_statement(ns.System(["x", "y"], list(rhs)).system, Translation.STABLE)
    own = FanCertificate(record)
    assert set(own.motions) == set(fan.motions())
    assert own.gain == (None if own.motions else fan.gain())


def test_random_fans_against_formulas() -> None:
    decided = compare_with_formulas(20, 0)
    assert min(decided.count(ATTRACTS), decided.count(UNSTABLE)) > 2


def test_random_fans_against_paths() -> None:
    assert compare_with_paths(1, 10) > 0


@thorough  # the small one: test_random_fans_against_formulas
def test_many_random_fans_against_formulas_and_paths() -> None:
    decided = compare_with_formulas(1000, 1000)
    assert min(decided.count(ATTRACTS), decided.count(UNSTABLE)) > 200
    assert compare_with_paths(60, 1000) > 10


# ---- mutations -----------------------------------------------------------------------------------

STEP = 4e-3  # of a polygon, over the distance from the point
START = 1e-7
TURN_STEPS = 40_000


def mutated(record: Record, source: random.Random) -> Record:
    """One digit, sign or operator of one text changed, or the verdict."""
    if not source.randrange(8):
        return {**record, "verdict": source.choice((ATTRACTS, STABLE, UNSTABLE))}
    keys = source.choice((("rhs",), ("motions", "gain"), ("rhs", "at", "motions", "gain")))
    return mutants.mutant(record, keys, "xy", source)


def velocity_of(record: Record) -> Velocity:
    """The literal field, in the displacement from the point."""
    first, second = (in_floats(text) for text in record["rhs"][0])
    x, y = (float(Fraction(text)) for text in record["at"])
    return lambda u, v: (first(x + u, y + v), second(x + u, y + v))


def polygon(field: Velocity, angle: float) -> Iterator[tuple[float, float]]:
    """Angle turned through and distance over the first one, along a polygon whose steps chatter along lines."""
    x, y, turned = START * math.cos(angle), START * math.sin(angle), 0.0
    for _ in range(TURN_STEPS):
        f, g = field(x, y)
        size, speed = math.hypot(x, y), math.hypot(f, g)
        if not speed:
            return
        step = STEP * size / speed
        turned += math.atan2(step * (x * g - y * f), size * size + step * (x * f + y * g))
        x, y = x + step * f, y + step * g
        yield turned, math.hypot(x, y) / START


def assert_gain(field: Velocity, gain: float, angle: float) -> None:
    """The distance after a full turn of a polygon is what the gain says."""
    for turned, distance in polygon(field, angle):
        if abs(turned) >= 2 * math.pi:
            assert abs(math.log(distance / gain)) < 0.15 + 0.05 * abs(math.log(gain))
            return
    raise AssertionError("no full turn")


def assert_held(field: Velocity, ray: tuple[float, float], velocity: tuple[float, float]) -> None:
    """A multiple of the ray is a mixture of the literal fields on its sides."""
    angle = math.atan2(ray[1], ray[0])
    sides = [field(1e-8 * math.cos(angle + turn), 1e-8 * math.sin(angle + turn)) for turn in (-1e-4, 1e-4)]
    (a, b), (c, d) = sides
    size = max(math.hypot(a - c, b - d), 1e-12)
    share = ((velocity[0] - a) * (c - a) + (velocity[1] - b) * (d - b)) / size**2
    share = min(1.0, max(0.0, share))
    off = math.hypot(a + share * (c - a) - velocity[0], b + share * (d - b) - velocity[1])
    assert off < 1e-4 * (1 + math.hypot(*velocity))
    assert abs(ray[0] * velocity[1] - ray[1] * velocity[0]) < 1e-9


def slide_nearby(field: Velocity, ray: tuple[float, float]) -> float:
    """The radial part of the mixture of the literal fields on both sides of a ray, a little way from the point."""
    x, y = (1e-4 * part / math.hypot(*ray) for part in ray)
    f, g = (field(x - side * 1e-7 * y, y + side * 1e-7 * x) for side in (-1, 1))
    n, m = (x * own[1] - y * own[0] for own in (f, g))
    return (m * (x * f[0] + y * f[1]) - n * (x * g[0] + y * g[1])) / (m - n)


def assert_true(record: Record, source: random.Random) -> None:
    """The motions by the literal fields beside their rays, gains and arrival along polygons."""
    field, angle = velocity_of(record), source.uniform(0, 6.28)
    speeds = []
    for motion in record["motions"]:
        ray, velocity = (tuple(float(Fraction(text)) for text in motion[key]) for key in ("ray", "velocity"))
        assert_held(field, ray, velocity)  # type: ignore[arg-type]
        speeds.append(ray[0] * velocity[0] + ray[1] * velocity[1])
    if record["gain"] is not None:
        gain = float(Fraction(record["gain"]))
        assert_gain(field, gain, angle)
        assert {ATTRACTS: gain < 1, STABLE: gain <= 1, UNSTABLE: gain > 1}[record["verdict"]], record
    elif record["verdict"] == UNSTABLE:
        assert max(speeds) > 0 or slide_nearby(field, ray) > 0, record  # type: ignore[arg-type]
    else:
        distances = [1.0, *(distance for _, distance in polygon(field, angle))]
        assert min(distances) < 0.1 or (record["verdict"] == STABLE and distances[-1] < 30), record


def attack(count: int, seed: int) -> int:
    """How many of many mutants are accepted; each is put to the test."""
    names = ["turns outward", "turns inward, higher terms", "turns inward, elsewhere", "closed orbits", "slides home"]
    names += ["slides away slowly"]
    names += ["slides home beside kinks", "slides away", "runs away between curves", "slides home where it repels"]
    return mutants.attack([TRUE[name] for name in names], mutated, check_certificate, assert_true, count, seed)


@thorough  # the small one: test_false_claims_are_rejected
def test_mutants_are_rejected_or_still_true() -> None:
    accepted = attack(400, 1)
    assert 0 < accepted < 400
