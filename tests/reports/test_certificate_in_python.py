"""``certificate()`` of a result is what ``--certificate`` writes; where there is none, one line says why."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import nonsmooth as ns
from nonsmooth.proofs.checker.files import check_file
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.proofs.theorem4_result import Contradiction
from tests.reports.conftest import Invoke

OPEN = ["-x - sign(x + sqrt(2)*y)", "-y + z/9", "-z + x/9"]  # a system of which nothing is decided, and that soon
AGAINST = Contradiction("a path and the check", ("one end", "another"), ("equilibrium",))


@pytest.mark.parametrize("name", ["four-wheel", "relay-oscillator-damped"])
def test_it_is_what_the_command_writes_and_the_checker_accepts(invoke: Invoke, name: str, tmp_path: Path) -> None:
    assert invoke("check", name, "--certificate", "c.json").status == 0
    scene: Any = ns.load(name)
    certificate = scene.check().certificate()
    assert certificate == json.loads(Path("c.json").read_text(encoding="utf-8"))
    again = tmp_path / "again.json"
    again.write_text(json.dumps(certificate), encoding="utf-8")
    status, said = check_file(str(again))
    assert (status, said.splitlines()[0].split(":")[0]) == (0, "valid")


def test_what_has_none_is_refused_in_a_line() -> None:
    array = ns.load("four-wheel")
    assert isinstance(array, ns.Array)
    refusals = {
        "the stand-alone checker follows cells, and this rule has none": array.check(rule="ellipse"),
        "required a check of one scene, received RulesResult": array.check(rule="all"),
        "required a check of one scene, received SettleMapResult": array.map(3),
        "needs a verdict": ns.System(["x", "y", "z"], OPEN).check(),
        "required a check that does not contradict itself, received one": replace(array.check(), elsewhere=(AGAINST,)),
    }
    for words, result in refusals.items():
        with pytest.raises(NoCertificateError) as refused:
            result.certificate()
        assert words in str(refused.value)
        assert "\n" not in str(refused.value)


def test_the_command_shows_the_answers_without_one(invoke: Invoke, tmp_path: Path) -> None:
    (tmp_path / "open.toml").write_text(
        f'name = "open"\n[system]\nstates = ["x", "y", "z"]\nrhs = {json.dumps(OPEN)}\n', encoding="utf-8"
    )
    done = invoke("check", "open.toml", "--certificate", "c.json")
    assert (done.status, done.err) == (2, "nonsmooth: open.toml: a certificate needs a verdict, received undecided\n")
    assert "│ stability │ undecided │" in done.out
    assert not Path("c.json").exists()
