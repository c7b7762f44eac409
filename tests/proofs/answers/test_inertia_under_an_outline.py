"""With inertia, of a body with an outline that turns where it rests: which wheels carry it there, and how long."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from nonsmooth.proofs.answers.inertia import inertia_answer, near_rest, settled_from
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_set import standing
from nonsmooth.symbolic.mechanics.scene import Scene

ROWS = [(99, 1, 60), (201, 0, 118), (100, 99, 2), (200, 101, 179), (101, 200, -62), (199, 199, -117)]
OTHERS = [(0, 0, 33), (300, 0, 146), (0, 200, -33), (300, 200, -147)]
WIDTH, HEIGHT = 230, 340
SCENE = f"""
units = {{ length = "mm", speed = "m/s" }}
friction = {{ mu_roll = 0.7, mu_side = 0.6 }}
contact = {{ rule = "ellipse" }}
body = {{ shape = "rectangle", width = {WIDTH}, height = {HEIGHT} }}
check = {{ equilibrium = [150, 100], radius = 50 }}
wheels = {{ file = "wheels.csv" }}
"""


@pytest.fixture
def table(tmp_path: Path) -> Scene:
    lines = "".join(f"{x},{y},{heading},0.25\n" for x, y, heading in ROWS + OTHERS)
    (tmp_path / "wheels.csv").write_text(f"x,y,heading,speed\n{lines}", encoding="utf-8")
    (tmp_path / "table.toml").write_text(SCENE, encoding="utf-8")
    return load_scene(tmp_path / "table.toml")


def test_the_same_wheels_carry_it_for_the_time_that_is_said(table: Scene) -> None:
    """The wheels under the outline at all poses of that time, by their places; without the outline it is stable."""
    near = near_rest(standing(table))
    said = re.search(r"up to ([\d.]+) deg/s, and after ([\d.]+) deg, ([\d.]+) s at least", near.why_not)
    assert said is not None
    assert "on the wheels that carry it here its centre of mass comes to rest, close to its place" in near.why_not
    assert "but its heading does not: there it turns all the time" in near.why_not
    rate, turn, time = map(float, said.groups())
    assert rate == pytest.approx(math.degrees(abs(near.spin)), rel=1e-3)
    assert rate * time == pytest.approx(turn, rel=1e-2)
    assert near.place is not None
    centre = complex(150 + near.place[0], 100 + near.place[1])
    wheels = np.array([complex(x, y) for x, y, _ in ROWS + OTHERS])
    for t in np.linspace(0, time, 40):
        seen = (wheels - centre) * np.exp(-1j * near.spin * t)
        inside = (abs(seen.real) < WIDTH / 2) & (abs(seen.imag) < HEIGHT / 2)
        assert inside.tolist() == [True] * len(ROWS) + [False] * len(OTHERS)
    alone = near_rest(replace(standing(table), body=None, idle=()))
    assert str(alone.verdict) == "stable"
    assert near.eigenvalues


def test_times_from_half_of_the_stated_radius_stand_beside_those_from_the_checked_one(table: Scene) -> None:
    """From where no other wheel carries it, and from farther out, each as a path from there tells it."""
    scene = standing(table)
    assert scene.check.wider is not None
    assert float(scene.check.wider) == 50
    found = inertia_answer(scene)
    assert found is not None
    near = float(scene.check.radius) / 2
    assert f"from 4 starts {near:.4g} mm away: within" in found.sentence
    assert "from 4 starts 25 mm away, half of the 50 mm that are stated, so also over other wheels: " in found.sentence
    stated = found.numbers["from_stated"]
    assert len(stated["from"]) + stated["tip"] == 4
    for row in stated["from"]:
        x, y, _ = row["start"]
        assert math.hypot(x - 150, y - 100) == pytest.approx(25)
    alone = settled_from(scene, tuple(stated["from"][0]["start"]))
    assert alone is not None
    assert alone.settles_after == pytest.approx(stated["from"][0]["settles_after"], rel=0.02)
