"""Wheels of one array may have different friction sets: rubber beside rollers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.cells.contact_rule import rule_of, smooth_rule_of
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.reports.sections.contact import losses_of
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.vehicle_file import load_vehicle
from nonsmooth.symbolic.mechanics.friction_set import float_sets
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.reports.conftest import Invoke
from tests.thorough import keep

cp: Any = import_module("cvxpy")  # its atoms have no stubs
PLACES = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
ROLLERS_AND_RUBBER = ["roller", None, "roller", None]
CLOSE = 2e-5  # of the fastest wheel: Clarabel's twist at its tightest tolerances


def array(contacts: Sequence[str | None], rule: str = "ellipse") -> ns.Array:
    """Four inward wheels; those of the list name a contact rule."""
    wheels = [ns.Wheel(place, heading="inward", contact=own) for place, own in zip(PLACES, contacts, strict=True)]
    return ns.Array(wheels, mu_roll=1, mu_side="1/2", rule=rule)


def scene_file(folder: Path, contacts: Sequence[str | None], rule: str = "ellipse") -> str:
    file = folder / "mixed.toml"
    head = f'friction = {{ mu_roll = 1, mu_side = "1/2" }}\ncontact = {{ rule = "{rule}" }}\n'
    wheels = "".join(
        f'[[wheel]]\nposition = [{x}, {y}]\nheading = "inward"\n' + (f'contact = "{own}"\n' if own else "")
        for (x, y), own in zip(PLACES, contacts, strict=True)
    )
    file.write_text(head + wheels, encoding="utf-8")
    return str(file)


# ---- the definition ------------------------------------------------------------------------------


def least_loads(places: Floats, centre: Floats) -> Floats:
    """Elastic loads by their definition: ``min |N|^2`` with balance, ``N >= 0``."""
    forces = cp.Variable(len(places), nonneg=True)
    balance = [cp.sum(forces) == 1, places.T @ forces == centre]
    cp.Problem(cp.Minimize(cp.sum_squares(forces)), balance).solve(solver="CLARABEL", tol_gap_abs=1e-13)
    return np.asarray(forces.value)


def least_dissipation(wheels: Sequence[dict[str, Any]], loads: Floats) -> Floats:
    """The twist of the least ``sum N_i h_i``, each h_i by the words of the wheel's rule, as a cone program."""
    twist, terms = cp.Variable(3), []
    for wheel, load in zip(wheels, loads, strict=True):
        (x, y), (a, b), u = wheel["place"], wheel["rim"], wheel["speed"]
        vx, vy = twist[0] - twist[2] * y, twist[1] + twist[2] * x
        along, across, (roll, side) = a * vx + b * vy - u, a * vy - b * vx, wheel["friction"]
        if wheel["contact"] == "ellipse":
            terms.append(load * cp.norm(cp.hstack([roll * along, side * across])))
        else:  # a roller turns with the speed t against its bearing
            t = cp.Variable()
            terms.append(load * (roll * cp.norm(cp.hstack([along, across - t])) + side * cp.abs(t)))
    tight = {"tol_gap_abs": 1e-13, "tol_gap_rel": 1e-13, "tol_feas": 1e-13}
    cp.Problem(cp.Minimize(cp.sum(cp.hstack(terms)))).solve(solver="CLARABEL", **tight)
    return np.asarray(twist.value)


def random_wheels(rng: np.random.Generator) -> list[dict[str, Any]]:
    """Four to eight wheels, at least one of each rule."""
    count = int(rng.integers(4, 9))
    contacts = ["ellipse", "roller", *rng.choice(["ellipse", "roller"], count - 2)]
    angles = rng.uniform(0, 2 * np.pi, count)
    return [
        {
            "place": rng.uniform(-1, 1, 2).round(3),
            "rim": np.array([np.cos(angle), np.sin(angle)]).round(4),
            "speed": round(float(rng.uniform(0.2, 1)), 3),
            "friction": (1.0, round(float(rng.uniform(0.05, 0.9)), 3)),
            "contact": contact,
        }
        for angle, contact in zip(angles, contacts, strict=True)
    ]


@pytest.mark.parametrize("seed", keep(4, range(100)))
@pytest.mark.filterwarnings("ignore:Solution may be inaccurate:UserWarning")  # Clarabel ends a digit short, and says so
def test_the_motion_is_the_least_dissipation_of_the_words(seed: int) -> None:
    rng = np.random.default_rng(seed)
    wheels = random_wheels(rng)
    places = np.array([wheel["place"] for wheel in wheels])
    centre = rng.dirichlet(np.full(len(places), 3.0)) @ places
    made = ns.Array(
        [
            ns.Wheel(
                tuple(map(str, wheel["place"])), heading=tuple(map(str, wheel["rim"])), speed=str(wheel["speed"]),
                mu_roll=str(wheel["friction"][0]), mu_side=str(wheel["friction"][1]), contact=wheel["contact"],
            )
            for wheel in wheels
        ]
    )  # fmt: skip
    for wheel in wheels:  # headings have length one only to four digits
        wheel["rim"] = wheel["rim"] / np.hypot(*wheel["rim"])
    minima = minima_under(smooth_rule_of(made.scene), made.scene, centre[None])
    assert minima.check()[0]
    if minima.faces:  # at the twists of the words any of the face is right
        return
    expected = least_dissipation(wheels, least_loads(places, centre))
    fastest = max(wheel["speed"] for wheel in wheels)
    assert np.abs(minima.twists[0] - expected).max() <= CLOSE * fastest


def test_each_wheel_has_the_set_of_its_rule() -> None:
    scene = array(ROLLERS_AND_RUBBER).scene
    rule = smooth_rule_of(scene)
    found = [rule.friction_set(wheel.friction) for wheel in scene.wheels]
    assert [(str(one.along), str(one.across), str(one.cut)) for one in found] == [
        ("1", "1", "1/2"),
        ("1", "1/2", "1"),
    ] * 2


# ---- which rule a wheel has ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("contacts", "rule", "of_scene"),
    [
        (ROLLERS_AND_RUBBER, "ellipse", "mixed"),
        (ROLLERS_AND_RUBBER, "roller", "roller"),
        (["roller"] * 4, "nearest", "roller"),
        (["box", None, None, None], "box", "box"),
        (["ellipse", "ellipse", "roller", "ellipse"], "nearest", "mixed"),
    ],
)
def test_a_wheel_that_names_none_has_the_rule_of_the_scene(
    contacts: list[str | None], rule: str, of_scene: str
) -> None:
    scene = array(contacts, rule).scene
    assert rule_of(scene).name == of_scene
    assert [scene.rule_of_wheel(wheel) for wheel in scene.wheels] == [own or rule for own in contacts]


def test_one_rule_for_all_is_the_plain_scene() -> None:
    scene = array(["roller"] * 4, "nearest").scene
    assert scene.contact.rule == "roller"
    assert {wheel.friction.rule for wheel in scene.wheels} == {""}


def test_a_table_of_wheels_has_a_column_for_it(tmp_path: Path) -> None:
    (tmp_path / "wheels.csv").write_text("x,y,contact\n1,1,roller\n-1,1,\n-1,-1, roller\n1,-1,\n", encoding="utf-8")
    (tmp_path / "scene.toml").write_text(
        'wheels = { file = "wheels.csv" }\nfriction = { mu_roll = 1, mu_side = "1/2" }\n'
        'field = { kind = "radial", speed = 1 }\ncontact = { rule = "ellipse" }\n',
        encoding="utf-8",
    )
    scene = load_scene(tmp_path / "scene.toml")
    assert [scene.rule_of_wheel(wheel) for wheel in scene.wheels] == ["roller", "ellipse"] * 2


# ---- commands ------------------------------------------------------------------------------------


def test_wheels_that_name_the_rule_of_all_others_are_no_news(invoke: Invoke, tmp_path: Path) -> None:
    record = invoke("check", scene_file(tmp_path, ["ellipse", None, None, None]), "--json").record
    assert record["rule"] == "ellipse"
    assert not record["notes"]


def test_all_rules_are_those_of_all_wheels_and_the_array_as_it_is(invoke: Invoke, tmp_path: Path) -> None:
    checks = invoke("check", scene_file(tmp_path, ROLLERS_AND_RUBBER), "--rule", "all", "--json").record["checks"]
    assert [record["rule"] for record in checks] == ["nearest", "box", "ellipse", "roller", "mixed"]
    assert [bool(record["notes"]) for record in checks] == [False] * 4 + [True]
    plain = invoke("check", scene_file(tmp_path, [None] * 4), "--rule", "roller", "--json").record
    for changing in ("seconds", "scene"):
        plain.pop(changing), checks[3].pop(changing)
    assert checks[3]["translation"] == plain["translation"]
    assert checks[3]["feedback"] == plain["feedback"]


def test_verdicts_carry_evidence() -> None:
    result = check_theorem4(array(ROLLERS_AND_RUBBER).scene)
    assert result.check()
    uniform = replace(result, scene=result.scene.under("ellipse"))
    assert not uniform.check()


@pytest.mark.parametrize("name", ["four-wheel", "ring-5"])
def test_every_wheel_by_name_is_the_rule(name: str) -> None:
    """An array whose wheels are told apart by name alone, under a rule that mixes only in words."""
    plain = load_scene(name, rule="ellipse")
    (twist,) = minima_under(smooth_rule_of(plain), plain, np.array([[0.05, 0.02]])).twists
    mixed = with_labels(plain, "ellipse")
    (other,) = minima_under(smooth_rule_of(mixed), mixed, np.array([[0.05, 0.02]])).twists
    np.testing.assert_array_equal(twist, other)


def with_labels(scene: Scene, rule: str) -> Scene:
    """The same array under rule mixed, whose wheels all name one rule."""
    wheels = tuple(replace(wheel, friction=replace(wheel.friction, rule=rule)) for wheel in scene.wheels)
    return replace(scene, wheels=wheels, contact=replace(scene.contact, rule="mixed"))


def least_sum(along: float, across: float, r: float, s: float) -> float:
    """Over many parts t of the slip across."""
    t = np.linspace(-abs(s), abs(s), 20_001)
    return float((along * np.hypot(r, s - t) + across * np.abs(t)).min())


LOSSES: dict[str, Callable[[float, float, float, float], float]] = {
    "sqrt(mu_R^2 r_i^2 + mu_S^2 s_i^2)": lambda along, across, r, s: np.hypot(along * r, across * s),
    "mu_R sqrt(r_i^2 + s_i^2)": lambda along, across, r, s: along * np.hypot(r, s),
    "min_t (mu_R |(r_i, s_i - t)| + mu_S |t|)": least_sum,
}


@pytest.mark.parametrize("rule", ["ellipse", "roller"])
@pytest.mark.parametrize("side", ["1/20", "7/10", "3/5", "4/5", "0"])
def test_reports_print_the_dissipation_that_is_minimized(rule: str, side: str) -> None:
    wheels = [ns.Wheel(place, heading="inward") for place in PLACES]
    scene = ns.Array(wheels, mu_roll="7/10", mu_side=side, rule=rule).scene
    friction = scene.wheels[0].friction
    limits = smooth_rule_of(scene).friction_set(friction)
    along, across = float(friction.roll), float(friction.side)
    written = LOSSES[losses_of(limits, friction).text]
    for r, s in np.random.default_rng(5).normal(size=(20, 2)):
        (held,) = float_sets([limits]).support(np.array([r]), np.array([s]))
        assert held == pytest.approx(written(along, across, r, s), rel=1e-4)


def test_a_vehicle_may_have_both(tmp_path: Path) -> None:
    """Two driven wheels of rubber and two omniwheels: in place it turns without slip of the rubber along its axle."""
    wheels = [(0.5, 0.2, "roller"), (0.5, -0.2, "roller"), (0, 0.2, None), (0, -0.2, None)]
    tables = "".join(
        f'[[wheel]]\nposition = ["{x}", "{y}"]\n' + (f'contact = "{own}"\n' if own else "") for x, y, own in wheels
    )
    head = 'friction = { mu_roll = 1, mu_side = "1/10" }\n[vehicle]\ntrack = "2/5"\n'
    (tmp_path / "a.toml").write_text(head + tables, encoding="utf-8")
    vehicle = load_vehicle(tmp_path / "a.toml")
    assert vehicle.scene.contact.rule == "mixed"
