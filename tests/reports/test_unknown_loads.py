"""What commands say of scenes whose loads are unknown: verdicts, or one line that names the key."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.reports.conftest import Invoke
from tests.thorough import few, keep, thorough

TEXT = '[friction]\nmu_roll = 1\nmu_side = "1/2"\n[ring]\ncount = 5\n[contact]\nrule = "{}"\nloads = {}\n'


@pytest.fixture(params=['"any"', '{kind = "elastic", height = 0.1}'])
def loads(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def scene(tmp_path: Path, rule: str, loads: str) -> str:
    path = tmp_path / "ring.toml"
    path.write_text(TEXT.format(rule, loads), encoding="utf-8")
    return str(path)


@few(1)
@pytest.mark.parametrize("rule", ["ellipse", "box", "roller", "nearest"])
def test_json_says_which_loads_are_meant(tmp_path: Path, invoke: Invoke, loads: str, rule: str) -> None:
    done = invoke("check", scene(tmp_path, rule, loads), "--json", "--require", "position")
    assert done.status in {0, 1}
    record = done.record
    assert record["equilibrium"]["loads"].startswith("any" if "any" in loads else "elastic")
    assert record["equilibrium"]["verdict"] == "holds"


def test_motions_that_are_possible_are_listed(tmp_path: Path, invoke: Invoke) -> None:
    path = tmp_path / "ring.toml"
    path.write_text(TEXT.replace("count = 5", "count = 3").format("box", '"any"'), encoding="utf-8")
    assert "16 motions under every load, rule box; 1 possible at the point" in invoke("partition", str(path)).out
    record = invoke("partition", str(path), "--json").record
    assert set(record) == {"schema", "scene", "rule", "at", "exact", "motions", "notes"}
    (rest,) = [motion for motion in record["motions"] if motion["at_point"]]
    assert rest["twist"] == [0, 0, 0]
    assert rest["rows"] == ["S1", "S2", "S3"]
    assert len(rest["polygon"]) == 6
    assert invoke("partition", str(path), "-o", "ring.svg").status == 2


@pytest.mark.parametrize(("rows", "columns"), keep(1, [(2, 3), (3, 4)]))
def test_json_holds_the_load_that_refutes(tmp_path: Path, invoke: Invoke, rows: int, columns: int) -> None:
    path = tmp_path / "grid.toml"
    grid = f"[grid]\nrows = {rows}\ncolumns = {columns}"
    text = TEXT.replace("[ring]\ncount = 5", grid).format("ellipse", '"any"')
    path.write_text(text, encoding="utf-8")
    done = invoke("check", str(path), "--json")
    assert done.status == 1
    load = done.record["equilibrium"]["load"]
    assert len(load) == rows * columns
    assert sum(load) == pytest.approx(1)


@thorough  # the small one: test_json_holds_the_load_that_refutes
@pytest.mark.parametrize("rule", ["ellipse", "box"])
def test_reports_show_the_load_that_refutes_and_say_what_is_about_one_load(
    tmp_path: Path, invoke: Invoke, rule: str
) -> None:
    path = tmp_path / "grid.toml"
    text = TEXT.replace("[ring]\ncount = 5", "[grid]\nrows = 3\ncolumns = 4").format(rule, '"any"')
    path.write_text(text, encoding="utf-8")
    report = invoke("derive", str(path)).out
    assert re.search(r"under the load \(0\.\d+ on wheel \d+, ", report)
    left_out = report[report.index("What was left out") :]
    for section in ("cells", "derivative", "trajectories", "feedback"):
        assert f"Section {section}: the loads are not known, and this is about one load." in left_out
    assert invoke("derive", str(path), "-o", "grid.html").status == 0
