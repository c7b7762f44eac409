"""``nonsmooth check`` for many scenes: one line each, all records, the worst exit status."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.reports.conftest import Invoke
from tests.thorough import few

TIPPING = """
[check]
radius = 5
[contact]
rule = "box"
[friction]
mu_roll = 1
mu_side = "1/2"
[ring]
count = 3
radius = 1
"""


@few(1)
@pytest.mark.parametrize(
    ("scenes", "worst"),
    [
        (["four-wheel", "ring-3"], 0),
        (["four-wheel", "eq-4", "flower"], 0),
        (["four-wheel", "outward", "eq-3"], 1),
        (["four-wheel", "off-center"], 1),
    ],
)
def test_every_scene_has_its_line_and_the_worst_status_counts(invoke: Invoke, scenes: list[str], worst: int) -> None:
    single = [invoke("check", scene)[0] for scene in scenes]
    status, out, err = invoke("check", *scenes)
    assert (status, err) == (worst, "")
    assert status == max(single)
    lines = [line.split("│")[1].strip() for line in out.splitlines() if line.startswith("│")]
    assert [name for name in lines[1:] if name] == scenes


def test_records_are_those_of_the_single_checks(invoke: Invoke) -> None:
    scenes = ["four-wheel", "eq-4", "differential-drive"]
    status, out, _ = invoke("check", *scenes, "--json")
    found = json.loads(out)
    assert (status, found["schema"]) == (1, "nonsmooth-checks/1")
    for record, scene in zip(found["checks"], scenes, strict=True):
        alone = json.loads(invoke("check", scene, "--json")[1])
        alone.pop("seconds", None)
        record.pop("seconds", None)
        assert record == alone


@pytest.mark.usefixtures("without_paths", "without_other_rules")
def test_every_rule_of_every_scene(invoke: Invoke) -> None:
    status, out, _ = invoke("check", "four-wheel-side", "ring-3", "--rule", "all", "--json")
    records = json.loads(out)["checks"]
    found = [(record["scene"], record["rule"]) for record in records]
    assert found == [
        (scene, rule) for scene in ("four-wheel-side", "ring-3") for rule in ("nearest", "box", "ellipse", "roller")
    ]
    assert status in (1, 3)


@pytest.mark.usefixtures("without_paths", "without_other_rules")
def test_a_refused_scene_stops_no_other(invoke: Invoke, tmp_path: Path) -> None:
    tipping = tmp_path / "tipping.toml"
    tipping.write_text(TIPPING, encoding="utf-8")
    alone = invoke("check", str(tipping))
    status, out, err = invoke("check", "outward", str(tipping), "four-wheel", "--json")
    records = json.loads(out)["checks"]
    assert (status, err) == (2, "")
    assert [record.get("theorem4", {}).get("verdict") for record in records] == ["fails", None, "holds"]
    assert records[1]["refused"] in alone[2]
    assert "support polygon" in records[1]["refused"]
    assert "refused" in invoke("check", "outward", str(tipping))[1]
