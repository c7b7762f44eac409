"""Scenes exported in the frame of the world run in the physics engine as written, and end where their comments say."""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import mujoco
import numpy as np
import pytest

from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.reports.engine.mjcf import WorldExport, export_world
from nonsmooth.symbolic.files.body_table import rectangle
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.body import Body, Disc
from nonsmooth.symbolic.mechanics.scene import Contact, Friction, Scene
from tests.conftest import Arrays, WheelData
from tests.reports.conftest import Invoke
from tests.thorough import keep

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


def error(exported: WorldExport) -> float:
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
    assert error(export_world(scene, place)) < CLOSE


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
    assert error(export_world(replace(scene, contact=Contact("ellipse")))) < LIFTED


@pytest.mark.parametrize("shape", keep(1, ["rectangle", "disc"]))
def test_a_body_with_an_outline(shape: str) -> None:
    """Turned, and beside its centre of mass; the engine finds its wheels itself."""
    scene = even(load_scene("carton-on-6x6"))
    field = scene.field
    outline = rectangle(field(Fraction(6, 5)), field(1)) if shape == "rectangle" else Disc(field(Fraction(5, 4)))
    heading = field(Fraction(4, 5)), field(Fraction(3, 5))
    body = Body(outline, (field(Fraction(1, 10)), field(Fraction(-1, 20))), heading)
    start = field(Fraction(4, 5)), field(Fraction(-3, 5))
    assert error(export_world(replace(scene, body=body), start)) < LIFTED


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
