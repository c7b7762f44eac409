"""Statements that are false, for which the checker must ask something that cannot be shown.

Each was accepted once: with surfaces that have a factor in common, patterns of signs that have no point, functions that
jump, or inequalities that hold near the point only, the claims that were asked were too few.
"""

from __future__ import annotations

from typing import Any

import pytest

from nonsmooth.proofs.checker.cells import read_system
from nonsmooth.proofs.checker.positivity import Claim, Proofs
from nonsmooth.proofs.checker.statements import THEOREMS, VERSION, refusal
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.kernel.search import NotShownError, Search

Cells = dict[str, Any]


class Believed(Proofs):
    """Proofs that show whatever is asked, and keep it: what a forger would have to show."""

    def __init__(self) -> None:
        super().__init__({})
        self.asked: dict[str, Claim] = {}

    def show(self, claim: Claim) -> None:
        self.asked[claim.name] = claim
        self.note_form(claim)


def subject(*rhs: str) -> dict[str, Any]:
    states = ["x", "y", "z"][: len(rhs)]
    return {"states": states, "rhs": [list(rhs)], "at": ["0"] * len(rhs)}


def attracts(cells: Cells, function: Any, **more: Any) -> dict[str, Any]:
    told = {"second": None, "everywhere": False, "level": None, "below": False, "rate": None, **more}
    return {"cells": cells, "function": function, "verdict": "asymptotically stable", **told}


def asked(rhs: tuple[str, ...], hypotheses: dict[str, Any]) -> Believed:
    proofs = Believed()
    THEOREMS["lyapunov"](read_system(subject(*rhs)), hypotheses, proofs)
    return proofs


def test_surfaces_with_a_common_factor_hide_no_sliding() -> None:
    """On the line x = 0 solutions slide with y' = y, though V = Abs(x) + y^2 falls on either side of it."""
    cells = {"within": "1/2", "surfaces": ["x*(1 + y**2)", "x"], "empty": []}
    with pytest.raises(NotShownError, match="common factor"):
        Search().entry(read_system(subject("-sign(x*(1 + y**2))", "y")), "lyapunov", attracts(cells, "Abs(x) + y**2"))


def test_patterns_without_a_point_hide_no_equilibrium() -> None:
    """(0, 1/2) rests: it holds both (-1, 2) and (1, -2) in F, in cells right and left of it, where V has two slopes.

    The pattern "right of x = 0, but left of both other lines" has no point, so what is claimed there says nothing.
    """
    upper, lower = "x + y - 1/2", "x - y + 1/2"
    right = f"(1 + sign({upper}))*(1 + sign({lower}))/4"
    left = f"(1 - sign({upper}))*(1 - sign({lower}))/4"
    rhs = (f"{left} - {right} - x*(1 - {left} - {right})", f"2*{right} - 2*{left} - y*(1 - {left} - {right})")
    cells = {"within": "1", "surfaces": ["x", upper, lower], "empty": []}
    proofs = asked(rhs, attracts(cells, "20*x**2 + y**2 + 4*x*y + 2*Abs(x)*y", level="1/2"))
    face = proofs.asked["face 0.."]
    assert len(face.inequalities) == 8


def test_functions_that_jump_are_refused() -> None:
    """Solutions turn around the point and leave; V falls in every quadrant, and jumps up between two of them.

    Both quadrants differ in the signs of x and x y, and no pattern between them has a point.
    """
    square = "(x**2 + y**2)"
    odd = f"(x**2 - y**2)*({square} - x*y) + %s*{square}**2"
    even = f"(y**2 - x**2)*({square} + x*y) + %s*{square}**2"
    function = [["+.+", odd % 4], ["-.+", even % 10], ["-.-", odd % 8], ["+.-", even % 6]]
    cells = {"within": "1", "surfaces": ["x", "x*y", "y"], "empty": ["+-+", "-++", "---"]}
    with pytest.raises(RejectedError, match="common factor"):
        asked(("-y + x/100", "x + y/100"), attracts(cells, function))


def test_forms_along_sliding_too() -> None:
    """Beyond Abs(y) = 2 solutions slide away along x = 0: V' is a form on every cell, the fields are not."""
    bent = "(y**2 - 2)/4"
    rhs = (f"(1 - sign(x))/2 - (1 + sign(x))/2*(1 + {bent})", f"(1 + sign(x))/2*({bent})*sign(y)")
    cells = {"within": "1", "surfaces": ["x", "y"], "empty": []}
    hypotheses = attracts(cells, "Abs(x) + Abs(y)")
    assert Search().entry(read_system(subject(*rhs)), "lyapunov", hypotheses)[1]
    with pytest.raises(NotShownError, match="forms"):
        Search().entry(read_system(subject(*rhs)), "lyapunov", {**hypotheses, "everywhere": True})


def test_more_curves_than_states_meet_in_a_face() -> None:
    """Three curves on which V bends pass through (1/2, 1/4), where fields of all cells mix."""
    curves = ["y - x**2", "y - 2*x**3", "y - 4*x**4"]
    function = " + ".join(["x**2", "y**2", *(f"x**2*Abs({curve})" for curve in curves)])
    rhs = (" - ".join(["-x", *(f"sign({curve})" for curve in curves)]), "-y")
    proofs = asked(rhs, attracts({"within": "1", "surfaces": curves, "empty": []}, function))
    assert len(proofs.asked["face 000"].inequalities) == 8


def test_claims_are_compared_as_json() -> None:
    """Python takes 0 for False; a reader of the file need not."""
    about = subject("1 + sign(x)/2")
    hypotheses = {"cells": {"within": "1", "surfaces": ["x"], "empty": []}, "direction": ["1"]}
    entry, shown = Search().entry(read_system(about), "departure", hypotheses)
    assert {"equilibrium": False} in shown
    for value, accepted in ((False, True), (0, False)):
        statement = {"subject": about, "claims": [{"equilibrium": value}]}
        certificate = {"version": VERSION, "statement": statement, "evidence": [entry]}
        assert (refusal(certificate, 1000) == "") == accepted
