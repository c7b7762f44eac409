"""Sentences of the program with their formulas set as formulas."""

from __future__ import annotations

import pytest

from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.reports.output.document import Math
from nonsmooth.reports.output.prose import with_formulas
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.thorough import few, keep


def plain(text: str) -> str:
    return "".join(part.plain if isinstance(part, Math) else str(part) for part in with_formulas(text))


@pytest.mark.parametrize(
    ("text", "latex"),
    [
        ("V* < 0 at every nonzero vertex", [r"\dot V^* < 0"]),
        ("at any rate in [-sqrt(2)/2, 3*sqrt(5)/7]", [r"-\tfrac{\sqrt{2}}{2}", r"\tfrac{3\sqrt{5}}{7}"]),
        ("by at most -3/8 |c_0|", [r"-\tfrac{3}{8}", r"\lvert c_0 \rvert"]),
        ("theta is stable", [r"\theta"]),
        ("a cell on the paper's page 3 of 12", []),
        ("V = 25*x**2/38 + y**2/2 and 2/3", [r"\tfrac{2}{3}"]),  # a square over 38, not a power of 2/38
        ("the file a/b and a date 2001/1988x", []),
    ],
)
def test_formulas_are_found(text: str, latex: list[str]) -> None:
    assert [part.latex for part in with_formulas(text) if isinstance(part, Math)] == latex


@few(8)
@pytest.mark.parametrize("rule", ["nearest", "box", "ellipse"])
@pytest.mark.parametrize("name", keep(6, builtin_scenes()))
def test_no_word_is_lost(name: str, rule: str) -> None:
    check = check_theorem4(load_scene(name, rule=rule))
    for reason in (check.reason, *(found.reason for _, found in check.clauses)):
        assert plain(reason) == reason
