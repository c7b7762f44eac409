"""``simulate --tables``: places of rest against bodies that are followed to their ends by small steps."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from matplotlib.patches import Circle

from nonsmooth.analysis.bodies.sampled_tables import SampledTables, drawn_model, find_rest, nominal_model, sample_tables
from nonsmooth.analysis.fields.plane_arrays import turned
from nonsmooth.proofs.robust.decide import decided_statement
from nonsmooth.reports.simulations.sampled_tables import SampledTablesResult, draw_tables
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.oracles.measured_tables import MeasuredTable, SmallSteps
from tests.reports.conftest import Invoke
from tests.thorough import few

TABLE = """
name = "table"
units = { length = "mm", speed = "m/s" }
friction = { mu_roll = 0.8, mu_side = 0.6 }
contact = { rule = "RULE" }
grid = { rows = 2, columns = 3, pitch = 100 }
field = { kind = "radial", speed = 0.1 }
tolerance = { position = 1, heading = "1 deg", mu_roll = "15/100", mu_side = "15/100" }
"""
OF_TWO = (("heading", np.nan), ("mu_roll", 1.0))  # tolerances: of the first no end is found


@pytest.fixture
def table(tmp_path: Path) -> Path:
    file = tmp_path / "table.toml"
    file.write_text(TABLE.replace("RULE", "ellipse"), encoding="utf-8")
    return file


def scene_of(file: Path) -> Scene:
    return load_scene(str(file))


@few(1)
@pytest.mark.parametrize("rule", ["ellipse", "roller"])
def test_small_steps_end_where_the_sample_says(tmp_path: Path, rule: str) -> None:
    """Bodies on the same drawn tables, followed by the words of the rule alone, come to their places of rest."""
    nominal = MeasuredTable.random(2, rule, off=4.0)
    allowed = 'tolerance = { position = 1, heading = "1 deg", speed = 0.01, mu_roll = 0.15, mu_side = 0.15 }\n'
    (tmp_path / "table.toml").write_text(f"check = {{ radius = 40 }}\n{allowed}{nominal.toml}", encoding="utf-8")
    scene = scene_of(tmp_path / "table.toml")
    assert scene.tolerances is not None
    found, generator = sample_tables(scene, 4, 7), np.random.default_rng(7)
    for place in found.places:
        model = drawn_model(scene, scene.tolerances, generator)
        headings = np.degrees(np.arctan2(model.rims[:, 1], model.rims[:, 0]))
        rows = tuple(zip(*model.positions.T, headings, model.speeds, strict=True))
        roll, side = model.friction.reshape(-1, 2).T
        end, _ = SmallSteps(MeasuredTable(rows, roll, side * model.cuts, rule)).end(np.array([8.0, -6.0]), 8.0, 0.05)
        assert end == pytest.approx(place, abs=0.01)


def test_wheels_beside_the_body_carry_nothing(tmp_path: Path) -> None:
    """Two wheels that a body with an outline does not cover move no end, whatever their tolerances."""
    body = 'body = { shape = "rectangle", width = 230, height = 130, mass = 1 }\n'
    text = TABLE.replace("RULE", "ellipse").replace("columns = 3", "columns = 2")
    beside = text.replace("columns = 2", "columns = 4") + body
    found = []
    for name, table_text in (("four", text), ("eight", beside)):
        (tmp_path / f"{name}.toml").write_text(table_text.replace("grid =", "check = { radius = 10 }\ngrid ="))
        found.append(sample_tables(scene_of(tmp_path / f"{name}.toml"), 3, 5))
    assert found[1].places == pytest.approx(found[0].places, abs=1e-9)


def test_draws_stay_within_their_tolerances(table: Path) -> None:
    scene = scene_of(table)
    assert scene.tolerances is not None
    drawn, generator = nominal_model(scene), np.random.default_rng(1)
    models = [drawn_model(scene, scene.tolerances, generator) for _ in range(50)]
    positions = np.abs([model.positions - drawn.positions for model in models])
    across = turned(drawn.rims)
    turns = np.abs([(across * model.rims).sum(axis=1) for model in models])
    shares = np.abs([model.friction / drawn.friction - 1 for model in models])
    for values, bound in ((positions, 1.0), (turns, np.sin(np.pi / 180)), (shares, 0.15)):
        assert 0.9 * bound < values.max() <= bound * (1 + 1e-12)
    assert all((model.speeds == pytest.approx(drawn.speeds)) for model in models)
    slips = [model.slips(np.zeros(3))[:, 1] for model in models]  # the surface moves along the rim, wherever it points
    assert np.abs(slips).max() < 1e-9


def test_the_sample_lies_within_what_is_certified(table: Path) -> None:
    scene = scene_of(table)
    assert scene.tolerances is not None
    small = replace(scene, tolerances=scene.tolerances.times(Fraction(1, 8)))
    proved = decided_statement(small)
    radius = proved.equilibrium or proved.radius
    assert radius is not None
    assert sample_tables(small, 40, 3).within(1.0) <= float(radius)


def test_the_number_says_which_share_ends_within_it() -> None:
    places = np.array([[float(k), 0.0] for k in range(1, 20)] + [[np.nan, np.nan]])
    found = SampledTables(("heading",), places, np.zeros(2), np.zeros(2))
    assert (found.missing, found.within(0.95), found.within(0.5)) == (1, 19.0, 10.0)
    assert found.within(1.0) == np.inf


def test_a_table_that_carries_bodies_away_has_no_place_of_rest(table: Path) -> None:
    table.write_text(table.read_text().replace('"radial", speed', '"expression", x = "x", y = "y", speed'))
    model = nominal_model(scene_of(table))
    assert find_rest(model, np.array([0.1, 0.1]), 100.0) is None


def test_the_command_says_what_binds(table: Path, invoke: Invoke) -> None:
    command = ("simulate", str(table), "--tables", "5", "--seed", "3")
    record = invoke(*command, "--json").record
    assert (record["status"], record["tables"], record["certified"]) == ("sampled", 5, None)
    alone = {part["drawn"][0]: part["moved"] for part in record["parts"] if len(part["drawn"]) == 1}
    assert max(alone, key=lambda name: alone[name]) == record["binding"]
    shown = " ".join(invoke(*command).out.split())
    assert f"95 % of 5 tables end within {record['within']:.3g} mm (sampled, seed 3)" in shown
    assert "certified: not asked for (--certified)" in shown
    assert "(sampled ends; what binds the certified bound, and may be another, check says)" in shown
    near = sum(math.hypot(x, y) <= record["accuracy"] for x, y in record["rows"])  # of the checked point (0, 0)
    assert record["near"] == near
    assert f"{near} of 5 within the accuracy, {record['accuracy']:.3g} mm" in shown
    assert invoke(*command, "--json").record == record


def test_nothing_binds_where_ends_are_not_found(table: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """``not known: mm``, and the first of the tolerances whose ends are not known was said to bind."""
    lost, kept = (SampledTables((name,), np.full((4, 2), x), np.zeros(2), np.zeros(2)) for name, x in OF_TWO)
    found = SampledTablesResult(scene_of(table), 1, lost, (), (kept, lost), None)
    assert found.facts()["binding"] is None
    assert found.summary().startswith("of 4 of 4 tables no place of rest that attracts was found (sampled, seed 1); 0")
    found.to_terminal()
    shown = capsys.readouterr().out
    assert "which tolerance binds is not known" in shown
    assert "not known: mm" not in shown


def test_what_is_not_drawn_is_refused(table: Path, invoke: Invoke) -> None:
    assert "states no tolerances" in invoke("simulate", "four-wheel", "--tables", "5").err
    table.write_text(TABLE.replace("RULE", "nearest"))
    assert "under rules with friction sets" in invoke("simulate", str(table), "--tables", "5").err
    assert "--seed: required --tables" in invoke("simulate", "four-wheel", "--from", "0,0,0", "--seed", "3").err


def test_the_picture_draws_the_accuracy_and_its_legend_below(table: Path) -> None:
    found = draw_tables(scene_of(table), SimulateOptions(tables=4))
    figure = found.figure()
    assert [len(figure.legends), figure.axes[0].get_legend()] == [1, None]
    radii = [circle.get_radius() for circle in figure.axes[0].patches if isinstance(circle, Circle)]
    assert radii == [found.all.within(0.95), found.accuracy]
