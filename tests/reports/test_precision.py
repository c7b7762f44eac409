"""The command ``precision``: its JSON contract, CSV and figure, refusals, and what an interrupt leaves."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from rich.text import Text

from nonsmooth.analysis.measurements.harness import (
    Assessment,
    Clock,
    LeftOut,
    Limits,
    Order,
    ResultRow,
    Study,
    StudyPlan,
    Trial,
    measure,
)
from nonsmooth.proofs import measurements
from nonsmooth.proofs.measurements import STUDIES
from nonsmooth.reports.checks.measurements import Precision, rows_table
from nonsmooth.reports.output.console import INTERRUPTED
from nonsmooth.reports.output.progress import silent
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.precision_page import page_text
from tests.reports.conftest import Invoke
from tests.thorough import few

ROW_KEYS = [
    "study", "method", "parameter", "setting", "error", "seconds", "outcome", "reference", "note", "details", "work",
]  # fmt: skip
ROOT = Path(__file__).resolve().parents[2]
SETTINGS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
LIMIT = 0.05  # seconds


def endless(clock: Clock) -> float:
    while True:
        clock.check()


def gives_up(clock: Clock) -> float:
    raise RuntimeError("no convergence")


def interrupted(clock: Clock) -> float:
    raise KeyboardInterrupt


def study(works: dict[str, Callable[[float], Callable[[Clock], float]]], name: str = "test") -> Study:
    """Methods whose error is what their work returns."""
    trials = tuple(Trial(method, make(s), Assessment, "width", s) for method, make in works.items() for s in SETTINGS)
    orders = dict.fromkeys(works, Order(1.0, "by construction"))
    return Study(name, f"{name}: a title", "error [length]", lambda scene: StudyPlan("what is known", trials, orders))


def proportional(setting: float) -> Callable[[Clock], float]:
    return lambda clock: 3 * setting


def measured(*studies: Study) -> Precision:
    return Precision(measure(load_scene("four-wheel"), studies, Limits(1, LIMIT), silent))


# ---- contract ------------------------------------------------------------------------------------


def test_json_of_a_study(invoke: Invoke) -> None:
    status, out, _ = invoke("precision", "ring-3", "--study", "derivation", "--runs", "1", "--json")
    record = json.loads(out)
    assert status == 0
    assert (record["schema"], record["scene"], record["complete"]) == ("nonsmooth-precision/1", "ring-3", True)
    assert [entry["study"] for entry in record["studies"]] == ["derivation"]
    assert all(list(row) == ROW_KEYS for row in record["rows"])
    assert {row["method"] for row in record["rows"]} >= {"number field, cofactors", "SymPy, LUsolve and simplify"}
    assert all(row["reference"].startswith("exact twists") for row in record["rows"])
    done = [row for row in record["rows"] if row["outcome"] == "done"]
    assert all(row["seconds"] > 0 and row["error"] >= 0 for row in done)
    (slope,) = record["slopes"]
    assert (slope["method"], slope["expected"]) == ("balls", 1)


def test_csv_and_json_files_hold_the_same_rows(invoke: Invoke, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measurements, "STUDIES", (study({"exact": proportional}),))
    assert all(invoke("precision", "four-wheel", "-o", f"rows.{kind}").status == 0 for kind in ("csv", "json"))
    with Path("rows.csv").open(encoding="utf-8", newline="") as file:
        table = list(csv.DictReader(file))
    rows = json.loads(Path("rows.json").read_text(encoding="utf-8"))["rows"]
    assert list(table[0]) == ROW_KEYS
    assert [(r["method"], float(r["setting"]), float(r["error"])) for r in table] == [
        (r["method"], r["setting"], r["error"]) for r in rows
    ]


def test_every_study_names_its_quantity_with_a_unit() -> None:
    assert len({one.name for one in STUDIES}) == len(STUDIES) >= 4
    assert all("[" in one.quantity or one.name == "pruning" for one in STUDIES)


def test_a_table_shows_errors_times_and_slopes(invoke: Invoke) -> None:
    status, out, _ = invoke("precision", "ring-3", "--study", "derivation", "--runs", "1")
    assert status == 0
    for words in ("twist error [length/time, rad/time]", "NumPy, floats", "balls: slope"):
        assert words in out


# ---- interrupts and what is left out -------------------------------------------------------------


def test_rows_under_one_heading_stand_together() -> None:
    """Cases that take turns at every parameter had a heading at every row."""
    rows = [ResultRow(name, parameter) for parameter in "12" for name in ("box", "ellipse")]
    shown = rows_table(("of", "end"), rows, lambda row: row.name, lambda row: (Text(row.parameter or ""), Text("done")))
    assert [str(cell) for cell in shown.columns[1].cells] == ["box", "done", "done", "ellipse", "done", "done"]


def test_an_interrupt_keeps_the_finished_rows(invoke: Invoke, monkeypatch: pytest.MonkeyPatch) -> None:
    broken = study({"exact": proportional, "broken": lambda s: interrupted if s < 1e-2 else proportional(s)}, "second")
    monkeypatch.setattr(measurements, "STUDIES", (study({"exact": proportional}, "first"), broken, study({}, "never")))
    status, out, _ = invoke("precision", "four-wheel", "--json", "-o", "rows.csv")
    record = json.loads(out)
    assert status == INTERRUPTED
    assert record["complete"] is False
    assert [entry["study"] for entry in record["studies"]] == ["first", "second"]
    assert [row["method"] for row in record["rows"]] == ["exact"] * 10 + ["broken"] * 2
    assert len(Path("rows.csv").read_text(encoding="utf-8").splitlines()) == 1 + 12


def test_an_interrupt_while_building_keeps_earlier_studies() -> None:
    def build(scene: Scene) -> StudyPlan:
        raise KeyboardInterrupt

    found = measured(study({"exact": proportional}, "first"), Study("second", "second", "error [1]", build))
    assert not found.run.complete
    assert [one.of.name for one in found.run.measured] == ["first"]


def test_a_study_that_is_left_out_says_why() -> None:
    def build(scene: Scene) -> StudyPlan:
        raise LeftOut("there is no reference")

    found = measured(Study("absent", "absent", "error [1]", build), study({"exact": proportional}))
    absent, present = found.facts()["studies"]
    assert (absent["left_out"], absent["reference"]) == ("there is no reference", None)
    assert present["left_out"] is None
    assert found.run.complete


def test_scenes_of_rule_ellipse_leave_out_what_has_no_cells() -> None:
    scene = load_scene("four-wheel", rule="ellipse")
    for one in STUDIES[:2]:
        with pytest.raises(LeftOut, match="nearest"):
            one.build(scene)
    assert all(one.build(scene).trials for one in STUDIES[2:5])


# ---- figure --------------------------------------------------------------------------------------


def drawn(view: Precision) -> Figure:
    return view.figure()


@cache
def figure() -> Figure:
    works: dict[str, Any] = {
        "converges": proportional,
        "exact": lambda s: lambda clock: 0.0,
        "slow": lambda s: endless if s < 1e-2 else proportional(s),
        "fails": lambda s: gives_up,
    }
    return drawn(measured(study(works), study({"other": proportional}, "other")))


def test_axes_have_names_units_and_logarithms() -> None:
    panels = figure().axes
    assert [panel.get_title(loc="left") for panel in panels] == ["test: a title", "other: a title"]
    for panel in panels:
        assert (panel.get_xscale(), panel.get_yscale()) == ("log", "log")
        assert (panel.get_xlabel(), panel.get_ylabel()) == ("error [length]", "processor time [s]")
        legend = panel.get_legend()
        assert legend is not None
        assert [text.get_text() for text in legend.get_texts()] == (
            ["converges", "exact", "slow", "fails"] if panel is panels[0] else ["other"]
        )


def points(line: Line2D) -> list[tuple[float, float]]:
    """Points of a line."""
    return [(float(x), float(y)) for x, y in np.asarray(line.get_xydata())]


def test_failures_stand_open_at_the_time_limit() -> None:
    panel = figure().axes[0]
    opened = [line for line in panel.lines if line.get_fillstyle() == "none"]
    assert len(opened) == 2  # slow and fails
    for line in opened:
        ((x, y),) = points(line)
        assert math.isfinite(x)
        assert y == LIMIT


def test_zero_errors_are_stars_at_the_floor() -> None:
    panel = figure().axes[0]
    (stars,) = (points(line) for line in panel.lines if line.get_marker() == "*")
    (line,) = (points(line) for line in panel.lines if line.get_label() == "converges")
    assert len(stars) == len(SETTINGS)
    assert max(x for x, _ in stars) < min(x for x, _ in line)


def test_legends_and_panels_do_not_overlap() -> None:
    drawn = figure()
    FigureCanvasAgg(drawn).draw()
    boxes = [panel.get_window_extent() for panel in drawn.axes]
    boxes += [legend.get_window_extent() for panel in drawn.axes if (legend := panel.get_legend()) is not None]
    boxes += [legend.get_window_extent() for legend in drawn.legends]
    for k, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[:k])


@few(1)
@pytest.mark.parametrize("suffix", [".svg", ".png", ".pdf"])
def test_figures_are_written(invoke: Invoke, suffix: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measurements, "STUDIES", (study({"exact": proportional}),))
    assert invoke("precision", "four-wheel", "-o", f"precision{suffix}")[0] == 0
    starts = {".svg": b"<?xml", ".png": b"\x89PNG", ".pdf": b"%PDF"}
    assert Path(f"precision{suffix}").read_bytes().startswith(starts[suffix])


def test_nothing_to_draw_is_said() -> None:
    assert [text.get_text() for text in drawn(measured()).texts][1:] == ["no rows with a setting to draw"]


def test_the_page_keeps_its_text_and_measures_the_rest_anew() -> None:
    shown = measured(study({"exact": proportional})).run
    old = (ROOT / "docs" / "precision.md").read_text(encoding="utf-8")
    new = page_text(old, shown, [])
    assert "### Test: a title\n\nError: error [length]. Yardstick: what is known.\n\n| method | setting |" in new
    assert [line for line in new.splitlines() if line.startswith("## ")] == [
        line for line in old.splitlines() if line.startswith("## ")
    ]
    assert page_text(new, shown, []) == new
