"""Exported scenes run in the physics engine, and meet what their comments predict."""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import mujoco
import numpy as np
import pytest

from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.reports.engine.mjcf import CONFORMS, Motion, WorldExport, export_scene, export_world
from nonsmooth.symbolic.files.body_table import rectangle
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.vehicle_file import load_vehicle
from nonsmooth.symbolic.mechanics.body import Body, Disc
from nonsmooth.symbolic.mechanics.scene import Contact, Friction, Scene
from tests.conftest import Arrays, WheelData
from tests.engine_export import engine_twist, error, predicted_twist
from tests.reports.conftest import Invoke
from tests.thorough import keep

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


def test_what_the_file_holds_otherwise_is_said(invoke: Invoke, tmp_path: Path) -> None:
    """Rule, place, wheels, and all else that the scene states and the engine is not told."""
    rest = (
        'rule = "box"\n[drive]\nspeed_limit = 2\n[tolerance]\nposition = 0.01\n[feedback]\ndelay = 0.1\n'
        '[units]\nlength = "mm"\n[body]\nshape = "rectangle"\nwidth = 1.2\nheight = 4\n[check]\nradius = 0.01\n'
    )
    text = RING.replace("mu_side = 0.5", "mu_side = 0.000001")
    (tmp_path / "all.toml").write_text(text + rest, encoding="utf-8")
    done = invoke("export", "all.toml", "--from", "0,0.01")
    for words in (
        "rule ellipse, which the engine follows, in place of the scene's box",
        "centre of mass in the scene: (0, 0.01)",
        "left out: wheels 1, 4, which do not carry the body at this place",
        "left out: the outline of the body",
        "left out: speed limits",
        "left out: tolerances",
        "left out: errors of a feedback loop",
        "friction below 1e-05 is written as that",
        " mm in the scene",
    ):
        assert words in done.out
    written = invoke("export", "all.toml", "-o", "all.xml").out
    assert "4 of 6 wheels" in written
    assert "(the checked point is (0, 0)), rule ellipse in place of box" in written


def test_a_plain_export_names_no_difference(invoke: Invoke, tmp_path: Path) -> None:
    (tmp_path / "plain.toml").write_text(RING + 'rule = "ellipse"\n', encoding="utf-8")
    out = invoke("export", "plain.toml", "--from", "0,0").out
    assert not any(words in out for words in ("left out", "in place of", "is written as", "the checked point"))


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
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
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


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("four-wheel",), 'required "ellipse", the friction of the engine (or --rule ellipse)'),
        (("ring-5", "--rule", "ellipse"), "required friction axes along or across that of wheel 1"),
        (("ring-3", "--rule", "oval"), "'oval' is not one of"),
        (("roller-bed", "--rule", "roller"), 'required "ellipse"'),
    ],
)
def test_what_the_engine_has_no_means_for_is_refused(invoke: Invoke, arguments: tuple[str, ...], said: str) -> None:
    done = invoke("export", *arguments, "--frame", "world")
    assert done.status == 2
    assert said in " ".join(done.err.split())


def test_the_command_writes_the_file(invoke: Invoke, tmp_path: Path) -> None:
    done = invoke("export", "four-wheel", "--frame", "world", "--rule", "ellipse", "--from", "0.2,0.1", "-o", "w.xml")
    assert done.status == 0
    assert "4 wheels and a free body, predicted to end at" in done.out
    assert " in the file, after " in done.out
    text = (tmp_path / "w.xml").read_text(encoding="utf-8")
    for words in ("the table stands", "MuJoCo 3.11 or later", "start of the centre of mass in the scene: (0.2, 0.1)"):
        assert words in text
    mujoco.MjModel.from_xml_string(text)
