"""The commands ``verify``, ``stress``, ``vehicle`` and ``export``; what is exported runs in the physics engine."""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest
from matplotlib.quiver import Quiver

import nonsmooth as ns
from nonsmooth.analysis.measurements.harness import Case, ResultRow, Rows, judged, refused
from nonsmooth.proofs import measurements
from nonsmooth.proofs.checker.files import check_file
from nonsmooth.proofs.findings import Contradiction
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import INTERRUPTED, run
from nonsmooth.reports.simulations.mjcf import CONFORMS, Motion, WorldExport, export_scene, export_world
from nonsmooth.symbolic.files.scene_document import rectangle
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.vehicle_file import load_vehicle
from nonsmooth.symbolic.mechanics.body import Body, Disc
from nonsmooth.symbolic.mechanics.scene import Contact, Friction, Scene
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.array_certificates import subject
from tests.conftest import Arrays, WheelData
from tests.engine_export import engine_twist, error, predicted_twist
from tests.four_wheel import CORNERS
from tests.reports.conftest import Invoke
from tests.thorough import keep

# ---- ``nonsmooth verify``: what it prints, and whether a certificate is about a scene ------------


@pytest.fixture(scope="module")
def of_four_wheel(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The certificate that a check of the built-in array writes."""
    file = tmp_path_factory.mktemp("certificate") / "c.json"
    assert run(app, ["check", "four-wheel", "--certificate", str(file)]) == 0
    return file.read_bytes()


@pytest.fixture
def certified(of_four_wheel: bytes, invoke: Invoke) -> None:
    """The same as ``c.json`` in the folder where commands run."""
    Path("c.json").write_bytes(of_four_wheel)


Change = Callable[[dict[str, Any]], object]


@pytest.mark.usefixtures("certified")
@pytest.mark.parametrize(
    "change",
    [
        lambda c: subject(c)["field"].reverse(),  # the generators of ring-5 under other names
        lambda c: subject(c)["wheels"][0].update(speed=[["1/2"], ["1/2"]]),
        lambda c: subject(c)["field"][0].update(above="0"),
    ],
    ids=["nothing to rename", "a sum", "another bound"],
)
def test_numbers_are_compared_and_not_their_text(invoke: Invoke, change: Change) -> None:
    certificate = json.loads(Path("c.json").read_text(encoding="utf-8"))
    change(certificate)
    Path("c.json").write_text(json.dumps(certificate), encoding="utf-8")
    assert invoke("verify", "c.json", "four-wheel").status == 0


@pytest.mark.parametrize("notes", [None, [], {"left out": "x"}, {"left out": {"a": 1}}, {"left out": [["\x1b[2J\n"]]}])
def test_notes_that_nobody_wrote_do_no_harm(invoke: Invoke, tmp_path: Path, notes: Any) -> None:
    scene = tmp_path / "far.toml"
    scene.write_text('[system]\nstates = ["x", "y"]\nrhs = ["-x", "-y"]\n', encoding="utf-8")
    invoke("check", str(scene), "--certificate", "c.json")
    record = json.loads(Path("c.json").read_text(encoding="utf-8"))
    Path("c.json").write_text(json.dumps({**record, "notes": notes}), encoding="utf-8")
    status, out, _ = invoke("verify", "c.json")
    assert (status, out.splitlines()[0]) == (0, "valid")
    assert "\x1b" not in out


# ---- ``certificate()`` of a result is what ``--certificate`` writes; where there is none, one line says why.

OPEN = ["-x - sign(x + sqrt(2)*y)", "-y + z/9", "-z + x/9"]  # a system of which nothing is decided, and that soon
AGAINST = Contradiction("a path and the check", ("one end", "another"), ("equilibrium",))


@pytest.mark.parametrize("name", ["four-wheel", "relay-oscillator-damped"])
def test_it_is_what_the_command_writes_and_the_checker_accepts(invoke: Invoke, name: str, tmp_path: Path) -> None:
    assert invoke("check", name, "--certificate", "c.json").status == 0
    scene: Any = ns.load(name)
    certificate = scene.check().certificate()
    assert certificate == json.loads(Path("c.json").read_text(encoding="utf-8"))
    again = tmp_path / "again.json"
    again.write_text(json.dumps(certificate), encoding="utf-8")
    status, said = check_file(str(again))
    assert (status, said.splitlines()[0].split(":")[0]) == (0, "valid")


def test_what_has_none_is_refused_in_a_line() -> None:
    array = ns.load("four-wheel")
    assert isinstance(array, ns.Array)
    refusals = {
        "the stand-alone checker follows cells, and this rule has none": array.check(rule="ellipse"),
        "required a check of one scene, received RulesResult": array.check(rule="all"),
        "required a check of one scene, received SettleMapResult": array.map(3),
        "needs a verdict": ns.System(["x", "y", "z"], OPEN).check(),
        "required a check that does not contradict itself, received one": replace(array.check(), elsewhere=(AGAINST,)),
    }
    for words, result in refusals.items():
        with pytest.raises(NoCertificateError) as refused:
            result.certificate()
        assert words in str(refused.value)
        assert "\n" not in str(refused.value)


# ---- ``nonsmooth stress`` through the command line: formats, exit statuses, an interrupt, progress.

GOOD = judged("spirals", "loss 1e-3", "1e5 switches", 1e-13, 1e-12, condition=1e3, why="rounding")
SILENT = refused("loads", "1e-3 outside", "the body tips there", expected=True)
BAD = judged("spirals", "loss 1e-5", "1e7 switches [b]", 1e-3, 1e-12, why="rounding")


def with_rows(monkeypatch: pytest.MonkeyPatch, *rows: ResultRow, interrupt: bool = False) -> None:
    def case(scene: object) -> Rows:
        yield from rows
        if interrupt:
            raise KeyboardInterrupt

    monkeypatch.setattr(measurements, "CASES", (Case("family", array=case),))


@pytest.mark.parametrize(("rows", "expected"), [((GOOD, SILENT), 0), ((GOOD, BAD), 1)])
def test_the_status_says_whether_all_is_ok(
    rows: tuple[ResultRow, ...], expected: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with_rows(monkeypatch, *rows)
    assert run(app, ["stress", "four-wheel"]) == expected
    text = " ".join(capsys.readouterr().out.split())
    assert ("four-wheel: 2 rows, all ok" in text) == (not expected)
    assert ("not ok: spirals, loss 1e-5: 1e7 switches [b]; error <= 1e-12: rounding" in text) == bool(expected)


def test_files(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with_rows(monkeypatch, GOOD, SILENT, BAD)
    for suffix in ("json", "csv", "svg"):
        target = tmp_path / f"stress.{suffix}"
        assert run(app, ["stress", "four-wheel", "-o", str(target)]) == 1
        assert capsys.readouterr().out == f"{target}: four-wheel: 3 rows, 1 not ok\n"
        assert target.stat().st_size > 0
    with (tmp_path / "stress.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["ok"] for row in rows] == ["True", "True", "False"]
    assert (rows[1]["error"], float(rows[0]["error"])) == ("", 1e-13)
    assert json.loads((tmp_path / "stress.json").read_text())["rows"][1]["error"] is None


def test_an_interrupt_keeps_what_is_finished(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with_rows(monkeypatch, GOOD, SILENT, interrupt=True)
    assert run(app, ["stress", "four-wheel", "--json", "-o", str(tmp_path / "some.json")]) == INTERRUPTED
    record = json.loads(capsys.readouterr().out)
    assert [row["case"] for row in record["rows"]] == ["spirals", "loads"]
    assert record["complete"] is record["ok"] is False
    assert json.loads((tmp_path / "some.json").read_text()) == record
    assert run(app, ["stress", "four-wheel"]) == INTERRUPTED
    assert "interrupted, later cases are missing" in " ".join(capsys.readouterr().out.split())


def test_a_number_that_is_none_is_null(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    with_rows(monkeypatch, judged("spirals", "loss 1e-3", "1e5 switches", math.nan, 1.0, why="rounding"))
    assert run(app, ["stress", "four-wheel", "--json"]) == 1
    (row,) = json.loads(capsys.readouterr().out)["rows"]
    assert (row["error"], row["ok"]) == (None, False)


# ---- ``nonsmooth vehicle``: records, files, refusals, and the same in Python ---------------------


@pytest.mark.parametrize("name", ["mecanum-base", "husky-a200"])
def test_arrows_of_slips_and_forces_stay_inside_the_picture(name: str) -> None:
    (picture, *_) = ns.Vehicle.load(name).motion().figure().axes
    for arrows in (child for child in picture.collections if isinstance(child, Quiver)):
        tips = arrows.get_offsets() + np.column_stack([arrows.U, arrows.V])
        assert (np.abs(tips) < picture.get_xlim()[1]).all()


def test_a_vehicle_made_in_python() -> None:
    corners = [(0.25, 0.25), (-0.25, 0.25), (-0.25, -0.25), (0.25, -0.25)]
    headings = [(-1, 1), (-1, -1), (1, -1), (1, 1)]
    wheels = [ns.Wheel(place, heading=heading, speed=1) for place, heading in zip(corners, headings, strict=True)]
    found = ns.Vehicle(wheels).motion()
    assert found.to_dict()["exact"]["twist"] == ["0", "0", "2*sqrt(2)"]
    with pytest.raises(ns.SceneError, match=r"vehicle: vehicle\.track: required a track beside wheel_base"):
        ns.Vehicle(wheel_base=1)


# ---- Exported scenes run in the physics engine, and meet what their comments predict -------------

RING = "[friction]\nmu_roll = 1\nmu_side = 0.5\n[ring]\ncount = 6\n[contact]\n"
SHARP = 5e-4  # relative, of twists: a quarter of what conforms; 42 contacts at low loads come to 4e-4, others to 4e-5


@pytest.mark.parametrize(
    "arguments",
    [
        ("four-wheel",),
        ("ring-6",),
        ("carton-on-6x6",),
        ("four-wheel", "--from", "0.3,-0.1"),
        ("spiral-30",),
        ("mecanum-4",),
        ("husky-a200",),
        ("tracked-base",),
    ],
    ids=" ".join,
)
def test_the_engine_meets_the_prediction(invoke: Invoke, tmp_path: Path, arguments: tuple[str, ...]) -> None:
    done = invoke("export", *arguments, "-o", "scene.xml")
    assert done.status == 0
    assert "predicted" in done.out
    assert error((tmp_path / "scene.xml").read_text(encoding="utf-8")) < SHARP < CONFORMS


def test_an_effective_track_in_the_engine() -> None:
    """The formula of four equal wheels, by an engine that knows nothing of it."""
    vehicle = load_vehicle("husky-a200")
    exported = export_scene(vehicle.scene, vehicle.centre_of_mass)
    assert exported.motion is Motion.SPIN
    omega = engine_twist(exported.text())[2] / exported.pace / exported.scale
    assert 2 / (omega * 0.555) == pytest.approx(1 + (0.512 / 0.555) ** 2, rel=SHARP)


def test_a_body_that_should_rest_creeps_less_than_the_bound(invoke: Invoke) -> None:
    text = invoke("export", "four-wheel", "--from", "0,0").out
    assert "predicted motion: rest" in text
    bound = float(text.split("creep bound: ")[1].split()[0])
    assert np.abs(predicted_twist(text)).max() < 1e-3 * bound
    assert np.abs(engine_twist(text)).max() < bound


@pytest.mark.parametrize("frame", ["body", "world"])
def test_exported_files_are_well_formed(frame: str, invoke: Invoke, tmp_path: Path) -> None:
    """Comments held two hyphens side by side, which the engine reads and strict parsers of XML refuse."""
    scene = tmp_path / "named.toml"
    places = "".join(f'[[wheel]]\nname = "M--{k}"\nposition = {list(place)}\n' for k, place in enumerate(CORNERS))
    body = '[body]\nshape = "rectangle"\nwidth = 3\nheight = 3\n[check]\nradius = "1/4"\n'
    far = '[[wheel]]\nname = "far--off"\nposition = [3, 0]\n'
    text = f"name = 'four--wheels'\n[friction]\nmu_roll = 1\nmu_side = 1\n{places}{far}{body}"
    scene.write_text(text, encoding="utf-8")
    exported = invoke("export", str(scene), "--rule", "ellipse", "--frame", frame).out
    assert ElementTree.fromstring(exported).tag == "mujoco"


def test_units_of_the_scene_do_not_matter(invoke: Invoke, tmp_path: Path) -> None:
    text = (
        "[friction]\nmu_roll = 1\nmu_side = 0.3\n[ring]\ncount = 5\nradius = 250\n"
        '[field]\nkind = "spiral"\nangle = 20\nspeed = 40\n'
    )
    (tmp_path / "large.toml").write_text(text, encoding="utf-8")
    assert error(invoke("export", "large.toml", "--from", "60,30").out) < SHARP


def test_the_comment_is_safe_for_any_name(invoke: Invoke, tmp_path: Path) -> None:
    name = 'name = "a --> b <&> --"\n'
    text = "[friction]\nmu_roll = 1\nmu_side = 1\n[ring]\ncount = 3\n"
    (tmp_path / "odd.toml").write_text(name + text, encoding="utf-8")
    assert error(invoke("export", "odd.toml").out) < SHARP


def test_the_mass_and_the_inertia_are_those_of_the_scene(invoke: Invoke, tmp_path: Path) -> None:
    """In kg and in lengths of the file."""
    units = 'units = { length = "m" }\nbody = { mass = 2.5, inertia = 10 }\n'
    (tmp_path / "plain.toml").write_text(units + RING + 'rule = "ellipse"\n', encoding="utf-8")
    out = invoke("export", "plain.toml", "--from", "0,0").out
    (scale,) = map(float, re.findall(r"1 in this file is (\S+) m", out))
    ((mass, turning),) = re.findall(r'mass="(\S+)" diaginertia="(\S+) ', out)
    assert float(mass) == 2.5
    assert float(turning) * scale**2 == pytest.approx(10, rel=1e-6)
    assert "mass 2.5 kg, as stated; inertia 4 m^2 per mass" in out


def test_a_place_is_exact_and_stated() -> None:
    scene = load_scene("carton-on-6x6")
    exported = export_scene(scene)
    assert exported.place == (0.1, 0.05)
    assert len(exported.scene.wheels) == 4
    assert exported.motion is Motion.SLIDE


# ---- Scenes exported in the frame of the world run in the physics engine as written, and end where their comments
# say.

CLOSE = 0.01  # of the way, where motions hardly react to loads
# Slip lifts the engine's springs by half a per cent of the weight, and the plate sinks and tilts: 4 % of the way.
LIFTED = 0.05


def engine_path(text: str) -> tuple[Floats, Floats, Floats]:
    """The pose of the free joint at the start and at the end, and the end that the comment predicts."""
    number = r"([-+0-9.e]+)"
    said = re.search(rf"predicted end \(x, y, theta\) after {number} s: {number} {number} {number}\n", text)
    assert said is not None
    seconds, *end = (float(value) for value in said.groups())
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    start = pose(data)
    mujoco.mj_step(model, data, nstep=round(seconds / model.opt.timestep))
    return start, pose(data), np.array(end)


def pose(data: mujoco.MjData) -> Floats:
    place = data.qpos
    return np.array([place[0], place[1], 2 * np.arctan2(place[6], place[3])])


def path_error(exported: WorldExport) -> float:
    """Of the predicted end, over the way."""
    start, end, predicted = engine_path(exported.text())
    assert np.abs(predicted - start).max() > 0.05
    return float(np.abs(end - predicted).max() / np.abs(predicted - start).max())


def even(scene: Scene, roll: str = "1", side: str = "1") -> Scene:
    """With one friction for all wheels, under the rule of the engine."""
    friction = Friction(scene.field(Fraction(roll)), scene.field(Fraction(side)))
    wheels = tuple(replace(wheel, friction=friction) for wheel in scene.wheels)
    return replace(scene, wheels=wheels, contact=Contact("ellipse"))


@pytest.mark.parametrize(
    ("name", "at"),
    keep(1, [("four-wheel", ("3/10", "-1/10")), ("four-wheel", None), ("ring-3", None), ("ring-5", None)]),
)
def test_the_engine_ends_where_it_is_predicted(name: str, at: tuple[str, str] | None) -> None:
    scene = load_scene(name)
    scene = scene.under("ellipse") if name == "four-wheel" else even(scene)
    place = None if at is None else (scene.field(Fraction(at[0])), scene.field(Fraction(at[1])))
    assert path_error(export_world(scene, place)) < CLOSE


@pytest.mark.parametrize("turn", keep(1, ["1/2", "-3/2"]))
def test_friction_axes_at_right_angles_anywhere(arrays: Arrays, turn: str) -> None:
    """Rims along two directions that are not the world's: the file is turned, and the friction differs by four."""
    c, s = arrays.circle_point(Fraction(turn))
    along, across = (c, s), (-s, c)
    places = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    rims = [along, across, along, across]
    speeds = [Fraction(-1), Fraction(1, 2), Fraction(3, 4), Fraction(-1, 3)]
    wheels = [
        WheelData((Fraction(x), Fraction(y)), rim, u) for (x, y), rim, u in zip(places, rims, speeds, strict=True)
    ]
    scene = arrays.scene(wheels, (1, Fraction(1, 4)))
    assert path_error(export_world(replace(scene, contact=Contact("ellipse")))) < LIFTED


@pytest.mark.parametrize("shape", keep(1, ["rectangle", "disc"]))
def test_a_body_with_an_outline(shape: str) -> None:
    """Turned, and beside its centre of mass; the engine finds its wheels itself."""
    scene = even(load_scene("carton-on-6x6"))
    field = scene.field
    outline = rectangle(field(Fraction(6, 5)), field(1)) if shape == "rectangle" else Disc(field(Fraction(5, 4)))
    heading = field(Fraction(4, 5)), field(Fraction(3, 5))
    body = Body(outline, (field(Fraction(1, 10)), field(Fraction(-1, 20))), heading)
    start = field(Fraction(4, 5)), field(Fraction(-3, 5))
    assert path_error(export_world(replace(scene, body=body), start)) < LIFTED
