"""A new clause is one class, a new number one fact: terminal, JSON, report and conclusion take them from there."""

from __future__ import annotations

import inspect
import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from nonsmooth.proofs import clause_registry
from nonsmooth.proofs.clauses.clause import CheckedArray
from nonsmooth.proofs.clauses.rotation.clause import RotationClause, RotationResult
from nonsmooth.proofs.findings import Fact, number_fact
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.rehearsals.mirror import MirrorClause
from tests.reports.conftest import Invoke
from tests.thorough import few, keep

MANY_PARTS = "--without precision,trajectories,rules"

THREE = """
[friction]
mu_roll = 1
mu_side = "1/2"

[ring]
count = 3
"""


@pytest.fixture
def mirror(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clause_registry, "CLAUSES", (*clause_registry.CLAUSES, MirrorClause()))


@few(1)
@pytest.mark.usefixtures("mirror")
@pytest.mark.parametrize(
    ("rule", "parts"),
    keep(2, [(rule, parts) for parts in ("--only theorem", MANY_PARTS) for rule in ("nearest", "ellipse", "box")]),
)
def test_a_new_clause_is_shown_everywhere(invoke: Invoke, tmp_path: Path, rule: str, parts: str) -> None:
    assert len(inspect.getsource(MirrorClause).splitlines()) <= 60
    shown = " ".join(invoke("check", "four-wheel", "--rule", rule, "--evidence").out.replace("│", " ").split())
    assert "mirror symmetric 0 wheels have no counterpart across the point the farthest wheel has |p|^2 = 2" in shown
    record = json.loads(invoke("check", "four-wheel", "--rule", rule, "--json").out)["mirror"]
    assert record == {
        "verdict": "symmetric", "reason": "0 wheels have no counterpart across the point",
        "farthest": 2.0, "exact": {"farthest": "2"},
    }  # fmt: skip
    options = ("--rule", rule, *parts.split())
    report = invoke("derive", "four-wheel", *options).out
    assert "Clause 5, mirror: symmetric" in report
    assert "the farthest wheel has |p|^2 = $2$" in report.replace("\\", "")
    assert invoke("derive", "four-wheel", *options, "-o", "a.html").status == 0


@pytest.mark.usefixtures("mirror")
def test_a_new_clause_takes_part_in_the_conclusion(invoke: Invoke, tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text(THREE, encoding="utf-8")
    refused = invoke("check", "my.toml", "--json")
    assert refused.status == 1
    record = json.loads(refused.out)
    assert record["theorem4"] == {"verdict": "fails", "reason": "3 wheels have no counterpart across the point"}
    assert "mirror" in record["seconds"]
    result = check_theorem4(load_scene(tmp_path / "my.toml"))
    assert result.check()


class WidthOfDrift(RotationClause):
    """The rotation clause with one more number."""

    def facts(self, result: RotationResult, check: CheckedArray) -> Iterator[Fact]:
        """The facts as they are, and the width."""
        yield from super().facts(result, check)
        if result.drift is not None:
            low, high = result.drift.interval
            yield number_fact("width", high - low, "the drift is {} wide")


def test_a_new_number_is_one_fact(invoke: Invoke, monkeypatch: pytest.MonkeyPatch) -> None:
    clauses = tuple(WidthOfDrift() if clause.name == "rotation" else clause for clause in clause_registry.CLAUSES)
    monkeypatch.setattr(clause_registry, "CLAUSES", clauses)
    assert "the drift is sqrt(2) wide" in invoke("check", "four-wheel", "--evidence").out
    record = json.loads(invoke("check", "four-wheel", "--json").out)["rotation"]
    assert record["width"] == pytest.approx(2**0.5)
    assert record["exact"]["width"] == "sqrt(2)"
    assert r"the drift is $\sqrt{2}$ wide" in invoke("derive", "four-wheel", "--only", "theorem").out
