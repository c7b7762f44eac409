"""Exported scenes run in the physics engine, and meet what their comments predict."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from nonsmooth.reports.engine.mjcf import CONFORMS, Motion, export_scene
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.vehicle_file import load_vehicle
from tests.engine_export import engine_twist, error, predicted_twist
from tests.reports.conftest import Invoke

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
