"""Bodies with an outline through the commands: who carries, how far that holds, tipping, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.rule import CONTACT_RULES
from tests.reports.conftest import Invoke
from tests.thorough import few, keep

CARTON = """name = "carton"
[friction]
mu_roll = 1
mu_side = "1/2"
[grid]
rows = 6
columns = 6
[body]
shape = "rectangle"
width = 2.6
height = 1.6
"""
COVER = '[body]\nshape = "disc"\nradius = 9\n'
ALIKE = ("seconds", "contact_set")


@pytest.fixture
def carton(tmp_path: Path) -> str:
    file = tmp_path / "carton.toml"
    file.write_text(CARTON)
    return str(file)


def record(invoke: Invoke, *arguments: str) -> tuple[int, dict[str, Any]]:
    done = invoke(*arguments, "--json")
    return done.status, done.record


@few(2)
@pytest.mark.parametrize("rule", CONTACT_RULES)
@pytest.mark.parametrize("name", keep(1, ["four-wheel", "off-center", "ring-5"]))
def test_a_body_over_all_wheels_changes_no_verdict(name: str, rule: str, invoke: Invoke, tmp_path: Path) -> None:
    source = Path(load_scene.__code__.co_filename).parents[1] / "scenes" / f"{name}.toml"
    file = tmp_path / "covered.toml"
    file.write_text(f"{source.read_text()}\n{COVER}")
    bare, covered = (record(invoke, "check", scene, "--rule", rule) for scene in (name, str(file)))
    places = [found[1]["answers"]["position"] for found in (bare, covered)]
    if places[0]["verdict"] == "leaves":  # where and when is not asked of bodies with an outline
        for found in (bare, covered):
            found[1]["answers"]["position"] = "leaves"
        assert places[1]["verdict"] == "leaves"
    without, within = ({k: v for k, v in found[1].items() if k not in ALIKE} for found in (bare, covered))
    assert (bare[0], without) == (covered[0], within)
    assert covered[1]["contact_set"]["wheels"] == bare[1]["contact_set"]["wheels"]
    assert bare[1]["contact_set"]["margin"] is None
    assert covered[1]["contact_set"]["angle"] is None


def test_the_first_lines_say_who_carries(carton: str, invoke: Invoke, tmp_path: Path) -> None:
    text = " ".join(invoke("check", carton).out.split())
    assert "rectangle 13/5 x 8/5: wheels 15, 16, 21, 22 of 36 carry it" in text
    assert "for certain within 0.2 of here, or 0.1264 rad of this heading" in text
    bare = " ".join(invoke("check", "four-wheel").out.split())
    assert "all wheels carry the body, at every pose: the scene names no [body]" in bare
    file = tmp_path / "heavy.toml"
    table = 'units = { length = "mm" }\ngrid = { rows = 2, columns = 2, pitch = 200 }\n'
    wheels = 'friction = { mu_roll = 1, mu_side = 0.5 }\nfield = { kind = "radial", speed = 100 }\n'
    file.write_text(f"{table}{wheels}body = {{ mass = 2.5, inertia = 52083 }}\n")
    heavy = " ".join(invoke("check", str(file)).out.split())
    assert "all wheels carry the body, at every pose: the scene states no shape of it" in heavy
    path = " ".join(invoke("simulate", str(file), "--from", "1,0,0").out.split())
    assert "mm of its end already at the start" in path


@pytest.mark.parametrize("rule", keep(2, CONTACT_RULES))
def test_the_wheels_that_carry_are_an_array_of_their_own(
    carton: str, rule: str, invoke: Invoke, tmp_path: Path
) -> None:
    """The same verdicts as of a grid of those four wheels alone, in the same square."""
    file = tmp_path / "four.toml"
    file.write_text(CARTON.split("[grid]", maxsplit=1)[0] + "[grid]\nrows = 2\ncolumns = 2\n[check]\nradius = 0.2\n")
    own, four = (record(invoke, "check", scene, "--rule", rule)[1] for scene in (carton, str(file)))
    for clause in ("equilibrium", "translation", "rotation", "theorem4"):
        assert own[clause]["verdict"] == four[clause]["verdict"]
    assert own["answers"]["position"]["verdict"] == four["answers"]["position"]["verdict"]
    assert own["translation"]["worst_rate"] == four["translation"]["worst_rate"]


@pytest.mark.parametrize("rule", CONTACT_RULES)
def test_tipping_is_the_answer_under_every_rule(rule: str, carton: str, invoke: Invoke) -> None:
    status, found = record(invoke, "check", carton, "--at", "2.9,2.9", "--rule", rule)
    assert status == 1
    assert found["answers"]["position"]["verdict"] == "tips"
    assert found["contact_set"]["wheels"] == [36]
    assert found["theorem4"]["verdict"] == "hypotheses not met"


def test_what_tips_says_over_which_edge_and_how_far_and_is_drawn(carton: str, invoke: Invoke, tmp_path: Path) -> None:
    """The carton is 2.6 wide: at (2.7, 0) the columns of wheels at 1.5 and 2.5 carry it, and it is 0.2 beyond these."""
    done = invoke("check", carton, "--at", "2.7,0")
    assert "its centre of mass 0.2 beyond the line through wheels" in " ".join(done.out.replace("\u2502", " ").split())
    picture = tmp_path / "tips.svg"
    drawn = invoke("partition", carton, "--at", "2.7,0", "--show", "array", "-o", str(picture))
    assert (drawn.status, "0.2 beyond" in drawn.out) == (0, True)
    shown = picture.read_text(encoding="utf-8")
    assert "hull of the wheels under it" in shown
    assert "wheel that does not carry it" in shown
    assert invoke("partition", carton, "--at", "2.7,0").status == 2


@pytest.mark.parametrize("flag", [("--certificate", "c.json"), ("--law", "law.py")], ids=("certificate", "law"))
def test_a_body_that_tips_has_no_file_beside_the_answer(
    flag: tuple[str, str], carton: str, invoke: Invoke, tmp_path: Path
) -> None:
    done = invoke("check", carton, "--at", "2.9,2.9", flag[0], str(tmp_path / flag[1]))
    assert done.status == 2
    assert "tips" in done.out
    assert done.err.endswith("received one that tips\n")
    assert not (tmp_path / flag[1]).exists()


def test_tipping_among_many_scenes(carton: str, invoke: Invoke) -> None:
    done = invoke("check", carton, "four-wheel", "--at", "2.9,2.9")
    assert done.status != 0
    assert "tips" in done.out


def test_tipping_in_python(carton: str) -> None:
    array = ns.load(carton)
    assert isinstance(array, ns.Array)
    tipped = array.check(at=(2.9, 2.9))
    assert tipped.position.verdict == "tips"
    assert "wheel 36 alone" in tipped.position.sentence
    assert array.check().contact_set.wheels == (15, 16, 21, 22)


def test_certificates_speak_of_the_wheels_that_carry(carton: str, invoke: Invoke, tmp_path: Path) -> None:
    file = str(tmp_path / "c.json")
    assert invoke("check", carton, "--certificate", file).status == 0
    assert invoke("verify", file, carton).status == 0
    assert invoke("verify", file, carton, "--at", "1/10,0").status == 1


@pytest.mark.parametrize(
    ("side", "mass", "until"),
    keep(1, [(4, "1e-2", "0.01"), (6, "1e-4", "0.05"), (6, "1e-2", "0.01"), (6, "1e-4", "0.02")]),
)
def test_masses_are_compared_where_wheels_leave(
    invoke: Invoke, tmp_path: Path, side: int, mass: str, until: str
) -> None:
    file = tmp_path / "carton.toml"
    file.write_text(CARTON.replace("= 6", f"= {side}"))
    masses = ("--method", "dynamics", "--compare-masses", "--mass", mass, "--until", until)
    status, found = record(invoke, "simulate", str(file), "--from", f"{side / 2 - 1.7},0.15,0", *masses)
    assert status == 0
    assert {own["rule"] for own in found["limits"]} == {"nearest", "box", "roller"}
    beyond = side / 2 - 0.1
    tips = invoke("simulate", str(file), "--from", f"{beyond},{beyond},0", *masses)
    assert (tips.status, tips.out) == (2, "")
    assert tips.err.count("\n") == 1


@few(1)
@pytest.mark.parametrize("options", [("--rule", "nearest"), ("--rule", "box"), ("--method", "dynamics")])
def test_a_path_of_every_kind_through_the_command(
    options: tuple[str, ...], carton: str, invoke: Invoke, tmp_path: Path
) -> None:
    run = ("simulate", carton, *options, "--from", "1.3,0.15,0", "--until", "0.25")
    status, found = record(invoke, *run)
    assert status == 0
    kinds = [event["kind"] for event in found["events"]]
    assert kinds.count("leave") == 2
    for name in ("path.svg", "path.html", "path.csv"):
        assert invoke(*run, "-o", str(tmp_path / name)).status == 0
    tips = invoke("simulate", carton, *options, "--from", "2.9,2.9,0")
    assert (tips.status, tips.out) == (2, "")
    assert tips.err.endswith("where the body stands on its wheels, received one where it tips over wheel 36\n")


def test_a_path_through_the_command_and_python(carton: str, invoke: Invoke) -> None:
    status, found = record(invoke, "simulate", carton, "--rule", "ellipse", "--from", "0.5,0.15,0", "--until", "0.5")
    assert status == 0
    assert {event["kind"] for event in found["events"]} <= {"enter", "leave", "slide"}
    array = ns.load(carton)
    assert isinstance(array, ns.Array)
    path = array.with_(rule="ellipse").simulate((0.5, 0.15, 0), until=0.5)
    assert np.allclose(found["end"]["state"], path.trajectory.end.state, rtol=0, atol=1e-12)


def test_reports_name_the_wheels_that_carry(carton: str, invoke: Invoke) -> None:
    done = invoke("derive", carton, "--only", "answers,verdict")
    assert done.status == 0
    assert "wheels 15, 16, 21, 22 of 36 carry it" in " ".join(done.out.split())


@pytest.mark.parametrize("rule", keep(1, ["nearest", "ellipse"]))
def test_auto_finds_a_point_where_the_body_stands(carton: str, rule: str, invoke: Invoke) -> None:
    status, found = record(invoke, "check", carton, "--at", "auto", "--rule", rule)
    assert status in {0, 1}
    assert found["equilibrium"]["verdict"] == "holds"
