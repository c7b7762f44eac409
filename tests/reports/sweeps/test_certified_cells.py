"""Cells of a sweep that are certified as a whole, against arrays drawn from them; what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nonsmooth.symbolic.files.scene_file import load_scene
from tests.proofs.robust.test_nearest_bounds import drawn, velocities
from tests.reports.conftest import Invoke
from tests.thorough import few

SCENE = """
friction = {{ mu_roll = 1, mu_side = {mu_side} }}
check = {{ radius = "1/20" }}
wheel = [
  {{ position = [{x}, "1/10"], heading = {heading}, speed = {speed} }},
  {{ position = ["-1/10", "1/10"], heading = 315, speed = "1/10" }},
  {{ position = ["-1/10", "-1/10"], heading = 45, speed = "1/10" }},
  {{ position = ["1/10", "-1/10"], heading = 135, speed = "1/10" }},
]
"""
TOLERANCE = '[tolerance]\nposition = "1/1000"\nheading = "1 deg"\nspeed = "1/50"\nmu_side = "1/20"\n'
DEFAULTS = {"mu_side": 0.5, "x": 0.1, "heading": 225, "speed": 0.1}
PATHS = {
    "mu_side": "friction.mu_side",
    "x": "wheel.1.position.x",
    "heading": "wheel.1.heading",
    "speed": "wheel.1.speed",
}


def written(folder: Path, **values: float) -> Path:
    file = folder / "table.toml"
    file.write_text(SCENE.format(**{**DEFAULTS, **values}) + TOLERANCE, encoding="utf-8")
    return file


@few(1)
@pytest.mark.parametrize(
    ("first", "second"),
    [(("x", "0.1:0.11:2"), ("mu_side", "0.3:0.5:2")), (("heading", "221:229:3"), ("speed", "0.09:0.11:3"))],
    ids=["position and friction", "heading and speed"],
)
def test_no_array_of_a_certified_cell_breaks_it(
    invoke: Invoke, tmp_path: Path, first: tuple[str, str], second: tuple[str, str]
) -> None:
    """Scenes at corners and inside of the cell, and arrays within the tolerances of each, outside the cell's disc."""
    file, names = written(tmp_path), (first[0], second[0])
    vary = [f"{PATHS[name]}={values}" for name, values in (first, second)]
    record = invoke(
        "sweep", str(file), "--vary", vary[0], "--vary", vary[1], "--certify", "--workers", "1", "--json"
    ).record
    certified = [cell for cell in record["cells"] if cell["verdict"] == "certified"]
    assert len(record["cells"]) == (int(first[1][-1]) - 1) * (int(second[1][-1]) - 1)
    assert certified
    rng = np.random.default_rng(5)
    for cell in certified[:2]:
        for _ in range(6):
            shares = rng.choice([0.0, 1.0, 0.5], 2)
            ends = [cell["between"][PATHS[name]] for name in names]
            chosen = {name: low + s * (high - low) for name, (low, high), s in zip(names, ends, shares, strict=True)}
            scene = load_scene(written(tmp_path, **chosen), rule="nearest")
            sizes = rng.uniform(cell["ends_within"], cell["starts_within"], 400)
            angles = rng.uniform(0, 2 * np.pi, 400)
            points = sizes[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
            moved = velocities(drawn(scene, 400, int(rng.integers(1000))), points)
            assert ((points * moved).sum(axis=1) < 0).all()


def test_a_cell_across_a_border_is_left_white(invoke: Invoke, tmp_path: Path) -> None:
    """Where mu_side may exceed mu_roll the answer changes: a cell beside the border is certified, one across is not."""
    cells = cells_of(invoke, written(tmp_path), f"{PATHS['mu_side']}=0.5,0.8,1.2,1.4")
    assert [cell["verdict"] for cell in cells] == ["certified", "undecided", "undecided"]
    assert cells[1]["ends_within"] is None
    assert cells[1]["why"]


def cells_of(invoke: Invoke, file: Path, *vary: str) -> list[dict[str, Any]]:
    options = [part for text in vary for part in ("--vary", text)]
    found: list[dict[str, Any]] = invoke("sweep", str(file), *options, "--certify", "--workers", "1", "--json").record[
        "cells"
    ]
    return found


@few(1)
@pytest.mark.parametrize(
    ("vary", "stated", "larger"),
    [
        ("mu_side=0.4,0.6", 'mu_side = "1/20', " + 1/5*1048577/1048576 + 1/20*1/5*1048577/1048576"),
        ("x=0.098,0.102", 'position = "1/1000', " + 1/500*1048577/1048576"),
    ],
)
def test_a_cell_is_its_middle_with_larger_tolerances(
    invoke: Invoke, tmp_path: Path, vary: str, stated: str, larger: str
) -> None:
    """The bound is the one of a check of that scene."""
    name, values = vary.split("=")
    (cell,) = cells_of(invoke, written(tmp_path), f"{PATHS[name]}={values}")
    middle = tmp_path / "middle.toml"
    middle.write_text((SCENE.format(**DEFAULTS) + TOLERANCE).replace(stated, stated + larger), encoding="utf-8")
    robust = invoke("check", str(middle), "--json").record["robust"]
    assert robust["radius"] == pytest.approx(cell["ends_within"], rel=1e-12)
    assert robust["from"] == pytest.approx(cell["starts_within"], rel=1e-12)


def test_the_picture_leaves_white_what_is_not_certified(invoke: Invoke, tmp_path: Path) -> None:
    vary = ("--vary", f"{PATHS['mu_side']}=0.5,0.8,1.2", "--vary", f"{PATHS['x']}=0.098,0.102")
    outcome = invoke("sweep", str(written(tmp_path)), *vary, "--certify", "--workers", "1", "-o", "cells.svg")
    assert outcome.status == 0
    assert "1 of 2 cells of the grid are certified as a whole" in outcome.out
    assert "#009e73" in (tmp_path / "cells.svg").read_text(encoding="utf-8").lower()


def test_results_of_cells_are_kept(invoke: Invoke, tmp_path: Path) -> None:
    vary = ("--vary", f"{PATHS['mu_side']}=0.5,0.8", "--certify", "--workers", "1", "--store", "runs.sqlite", "--json")
    first, again = (invoke("sweep", str(written(tmp_path)), *vary).record for _ in range(2))
    assert first == again
