"""``check --continuum``: the continuous idealization beside the verdicts, and where there is none."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from nonsmooth.reports.derivations.derivation import REPORT_FORMATS, derive_report, render_report
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.rule import CONTACT_RULES
from tests.reports.conftest import Invoke
from tests.reports.derived import derived
from tests.thorough import keep

HEADING = 1e-12


def test_verdicts_do_not_depend_on_it(invoke: Invoke) -> None:
    done = [invoke("check", "four-wheel", "--json", *option) for option in (("--continuum",), ())]
    with_it, without = (outcome.record for outcome in done)
    assert without["continuum"] is None
    for record in (with_it, without):
        del record["continuum"], record["seconds"]
    assert (done[0].status, with_it) == (done[1].status, without)


def test_every_rule_has_its_row(invoke: Invoke) -> None:
    asked = ("check", "four-wheel", "--rule", "all", "--continuum")
    record, out = invoke(*asked, "--json").record, invoke(*asked).out
    assert [check["continuum"]["array"]["rule"] for check in record["checks"]] == list(CONTACT_RULES)
    assert out.count("continuous idealization") == 1
    assert [out.count(f"the array, rule {rule}") for rule in CONTACT_RULES] == [1, 1, 1, 1]
    assert "not in the verdict" in out


def test_an_object_of_the_scene(tmp_path: Path, invoke: Invoke) -> None:
    file = tmp_path / "my.toml"
    wheels = '[friction]\nmu_roll = 1\nmu_side = "1/2"\n[grid]\nrows = 2\ncolumns = 2\n'
    law = '[field]\nkind = "elliptic"\na = 2\nb = 1\nspeed = "magnitude"\n'
    file.write_text(f'{wheels}{law}[body]\nshape = "polygon"\nvertices = [[0, 0], [30, 0], [0, 10]]\n')
    record = invoke("check", str(file), "--continuum", "--json").record
    (triangle,) = record["continuum"]["objects"]
    assert record["continuum"]["given"] is True
    assert triangle["exact"]["vertices"][0] == ["-10", "-10/3"]
    axis = math.atan2(-2 * 9 / 72, 27 / 36 - 3 / 36) / 2  # of the long principal axis; the weaker pull is along y
    stable = next(heading["theta"] for heading in triangle["headings"] if heading["stable"])
    assert stable == pytest.approx(math.pi / 2 - axis, abs=HEADING)


@pytest.mark.usefixtures("without_paths", "without_other_rules")
@pytest.mark.parametrize("extent", keep(1, ["short", "all"]))
def test_the_derivation_has_a_section(extent: str) -> None:
    """That it is in a report of all sections, tests/reports/test_derivation.py shows for another scene."""
    short = ("verdict", "continuum")
    report = derived("elliptic") if extent == "all" else derive_report(load_scene("elliptic"), parts=short)
    for suffix in REPORT_FORMATS:
        text = render_report(report, suffix)
        assert "The continuous idealization" in text
        assert "turns to certain headings" in text


@pytest.mark.usefixtures("without_paths", "without_other_rules")
def test_no_section_without_a_field(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text(
        '[friction]\nmu_roll = 1\nmu_side = "1/2"\n[grid]\nrows = 2\ncolumns = 2\n[field]\nkind = "squeeze"\n'
    )
    titles = [
        section.title for section in derive_report(load_scene(file), parts=("continuum", "left-out")).document.sections
    ]
    assert "The continuous idealization" not in titles
    assert "What was left out, and why" in titles
