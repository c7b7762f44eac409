"""``nonsmooth verify``: what it prints, and whether a certificate is about a scene."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.array_certificates import subject
from tests.reports.conftest import Invoke
from tests.thorough import few


@pytest.mark.usefixtures("without_paths", "without_other_rules")
@few(2)
@pytest.mark.parametrize(
    ("name", "options"),
    [("four-wheel", []), ("ring-5", []), ("spiral-30", ["--rule", "box"]), ("rectangle", ["--radius", "1/3"])],
)
def test_a_certificate_is_about_its_scene(invoke: Invoke, name: str, options: list[str]) -> None:
    invoke("check", name, "--certificate", "c.json", *options)
    status, text, _ = invoke("verify", "c.json", name, *options)
    assert status == 0
    assert text.splitlines()[-1] == f"about {name}: the same wheels, rule, point and square"


@pytest.mark.usefixtures("without_paths", "without_other_rules")
@few(3)
@pytest.mark.parametrize(
    ("arguments", "difference"),
    [
        (["four-wheel-side"], "friction of wheel 1"),
        (["four-wheel", "--rule", "box"], "rule"),
        (["four-wheel", "--radius", "1/3"], "radius"),
        (["four-wheel", "--at", "0,1/9"], "at"),
        (["ring-8", "--radius", "1/2"], "number of wheels (4 instead of 8)"),
        (["outward"], "direction of wheel 1"),
    ],
)
def test_a_certificate_of_another_scene_is_rejected(invoke: Invoke, arguments: list[str], difference: str) -> None:
    invoke("check", "four-wheel", "--certificate", "c.json")
    status, text, _ = invoke("verify", "c.json", *arguments)
    assert status == 1
    required = f"rejected: required a certificate about {arguments[0]}, received another {difference}"
    assert text.splitlines()[0] == required


Change = Callable[[dict[str, Any]], object]


@pytest.mark.usefixtures("without_paths", "without_other_rules")
@pytest.mark.parametrize(
    "change",
    [
        lambda c: subject(c)["field"].reverse(),  # the generators of ring-5 under other names
        lambda c: subject(c)["wheels"][0].update(speed=[["1/2"], ["1/2"]]),
        lambda c: subject(c)["field"][0].update(above="0"),
    ],
    ids=["nothing to rename", "a sum", "another bound"],
)
def test_numbers_are_compared_and_not_their_text(invoke: Invoke, change: Change) -> None:
    invoke("check", "four-wheel", "--certificate", "c.json")
    certificate = json.loads(Path("c.json").read_text(encoding="utf-8"))
    change(certificate)
    Path("c.json").write_text(json.dumps(certificate), encoding="utf-8")
    assert invoke("verify", "c.json", "four-wheel").status == 0


def test_a_certificate_without_any_claim_is_rejected(invoke: Invoke) -> None:
    invoke("check", "four-wheel", "--certificate", "c.json")
    certificate = json.loads(Path("c.json").read_text(encoding="utf-8"))
    certificate["statement"]["claims"] = []
    Path("c.json").write_text(json.dumps(certificate), encoding="utf-8")
    assert invoke("verify", "c.json")[:2] == (1, "rejected: required a claim\n")


@pytest.mark.usefixtures("without_paths", "without_other_rules")
@pytest.mark.parametrize("option", [["--rule", "box"], ["--radius", "1"], ["--at", "0,0"]])
def test_options_of_a_scene_need_a_scene(invoke: Invoke, option: list[str]) -> None:
    invoke("check", "four-wheel", "--certificate", "c.json")
    status, out, err = invoke("verify", "c.json", *option)
    assert (status, out) == (2, "")
    assert err == f"nonsmooth: {option[0]}: required a scene to compare the certificate with, received none\n"


def test_what_a_check_prints_and_its_certificate_leaves_out_is_said_by_both(invoke: Invoke, tmp_path: Path) -> None:
    """Arrival in finite time and all of the plane have no words there: the writer and the reader of the file say so."""
    scene = tmp_path / "roots.toml"
    twisting = '"-3*sgn(x)*sqrt(Abs(x)) + y", "-2*sgn(x)"'
    scene.write_text(f'[system]\nstates = ["x", "y"]\nrhs = [{twisting}]\n', encoding="utf-8")
    status, _, err = invoke("check", str(scene), "--certificate", "c.json")
    lines = err.splitlines()
    assert status == 0
    assert lines
    assert all(line.startswith("c.json: left out: ") for line in lines)
    assert "arrive in finite time" in lines[-1]
    status, out, _ = invoke("verify", "c.json", str(scene))
    said = [line for line in out.splitlines() if line.startswith("left out, not shown here: ")]
    assert status == 0
    assert [line.partition(": ")[2] for line in said] == [line.partition("left out: ")[2] for line in lines]


@pytest.mark.parametrize("notes", [None, [], {"left out": "x"}, {"left out": {"a": 1}}, {"left out": [["\x1b[2J\n"]]}])
def test_notes_that_nobody_wrote_do_no_harm(invoke: Invoke, tmp_path: Path, notes: Any) -> None:
    scene = tmp_path / "far.toml"
    scene.write_text('[system]\nstates = ["x", "y"]\nrhs = ["-x", "-y"]\n', encoding="utf-8")
    invoke("check", str(scene), "--certificate", "c.json")
    record = json.loads(Path("c.json").read_text(encoding="utf-8"))
    Path("c.json").write_text(json.dumps({**record, "notes": notes}), encoding="utf-8")
    status, out, _ = invoke("verify", "c.json")
    assert (status, out.splitlines()[0]) == (0, "valid")
    assert "\x1b" not in out
