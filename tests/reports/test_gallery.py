"""The gallery in the documents is what the program writes today: the same words, and numbers up to rounding."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import pytest

from nonsmooth.reports.checks.subject import Invocation
from tests.gallery import PAGE, SHOWN, gallery_files, gallery_page, gallery_report
from tests.reports.derived import derived, page
from tests.thorough import keep

DOCS = Path(__file__).resolve().parents[2] / "docs"
STALE = "the gallery is stale: run make gallery"
NUMBER = re.compile(r"(\d+(?:\.\d+)?(?:e[+-]?\d+)?)")
IDENTITY = re.compile(r'(?<=id=")[^"]*|(?<=#)[\w-]+|Python [\d.]+')  # hashes of coordinates; the interpreter's version
# An error such as 1.4e-16 is what one processor's arithmetic left over: another leaves another. So it is with the
# digits of a condition number such as 3.9e14, the inverse of what is left over.
LEFT_OVER = re.compile(
    r"<mn>[\d.]+</mn><mo>[^<]*</mo><msup><mn>10</mn><mrow>(?:<mo>[^<]*</mo>)?<mn>1[3-9]</mn></mrow></msup>"
)
# Another machine rounds otherwise in the last digit shown, and an integrator may take a step more or less.
RELATIVE, ABSOLUTE = 0.01, 0.02
MANY_STEPS = 20  # counts from here on may be of steps


def differences(old: str, new: str) -> list[tuple[str, str]]:
    """Pieces that differ by more than rounding."""
    first, second = (NUMBER.split(LEFT_OVER.sub("rounding", IDENTITY.sub("", text))) for text in (old, new))
    if len(first) != len(second):
        return [("other words", "")]
    pairs = zip(first, second, strict=True)
    return [(a, b) for a, b in pairs if a != b and not (NUMBER.fullmatch(a) and NUMBER.fullmatch(b) and close(a, b))]


def close(first: str, second: str) -> bool:
    if first.isdigit() and second.isdigit() and min(int(first), int(second)) >= MANY_STEPS:
        return abs(int(first) - int(second)) <= max(1, RELATIVE * int(first))
    return math.isclose(float(first), float(second), rel_tol=RELATIVE, abs_tol=ABSOLUTE)


@pytest.mark.parametrize("name", keep(1, SHOWN))
def test_the_gallery_is_fresh(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.gallery.render_report", lambda report, suffix: page(name))
    for path, content in gallery_files(name, derived(name)):
        shown = DOCS.joinpath(path).read_text(encoding="utf-8")
        assert differences(shown, content.decode()) == [], STALE
    overview = DOCS.joinpath(PAGE).read_text(encoding="utf-8")
    assert gallery_page({name: derived(name)}).split("\n## ")[1].strip() in overview, STALE


def test_the_reports_are_those_of_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    """As ``derived`` makes them: of the scene under its name, with all sections."""
    asked: list[tuple[Any, ...]] = []
    monkeypatch.setattr("tests.gallery.derive_report", lambda *given: asked.append(given))
    for name in SHOWN:
        gallery_report(name)
    assert [(scene.name, *rest) for scene, *rest in asked] == [(name, Invocation(name)) for name in SHOWN]


def test_the_page_shows_what_the_gallery_holds() -> None:
    page = DOCS.joinpath(PAGE).read_text(encoding="utf-8")
    assert re.findall(r"^## (.+)$", page, re.M) == list(SHOWN)
    assert {path.stem for path in (DOCS / "gallery").iterdir()} == set(SHOWN)


def power(mantissa: str, exponent: int) -> str:
    """``1.4 * 10^-16`` as the reports write it."""
    raised = f"<msup><mn>10</mn><mrow><mo>&#x02212;</mo><mn>{exponent}</mn></mrow></msup>"
    return f"<mn>{mantissa}</mn><mo>&#x022C5;</mo>{raised}"


@pytest.mark.parametrize(
    ("old", "new", "same"),
    [
        ("V = 1.414, 7 cells", "V = 1.415, 7 cells", True),
        ("V = 1.414, 7 cells", "V = 1.5, 7 cells", False),
        ("V = 1.414, 7 cells", "V = 1.414, 8 cells", False),
        ("holds", "fails", False),
        ("1 2", "1 2 3", False),
        ('<g id="p1a">', '<g id="p2b">', True),
        (power("1.4", 16), power("4.6", 17), True),
        (power("1.4", 9), power("4.6", 9), False),
    ],
)
def test_what_counts_as_stale(old: str, new: str, same: bool) -> None:
    assert (differences(old, new) == []) is same
