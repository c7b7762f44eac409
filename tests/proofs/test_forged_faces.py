"""Certificates of false claims that hide what happens on faces: patterns without points, multiples, curves."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from nonsmooth.proofs.checker.cells import Inclusion, read_system
from nonsmooth.proofs.checker.positivity import Claim, Proofs
from nonsmooth.proofs.checker.statements import VERSION, refusal
from nonsmooth.proofs.kernel.search import NotShownError, Search
from tests.thorough import keep

Record = dict[str, Any]


def written(rhs: list[str], cells: Record, function: str, **more: Any) -> Record:
    """A certificate of attraction in the plane.

    Raises:
        NotShownError: where a claim of it is not shown.
    """
    subject = {"states": ["x", "y"], "rhs": [rhs], "at": ["0", "0"]}
    own = {"verdict": "asymptotically stable", "everywhere": False, "level": None, "below": False, "rate": None}
    hypotheses = {"cells": cells, "function": function, "second": None, **own, **more}
    entry, shown = Search().entry(read_system(subject), "lyapunov", hypotheses)
    return {"version": VERSION, "statement": {"subject": subject, "claims": shown}, "evidence": [entry]}


# Three lines meet at (1/4, 0), above and below which the fields are (1, -2) and (1, 2), beside it (-4 x, -y).
ABOVE, BELOW = "(1 + sign(y + x - 1/4))*(1 + sign(y - x + 1/4))/4", "(1 - sign(y + x - 1/4))*(1 - sign(y - x + 1/4))/4"
CROSSING = [
    f"{ABOVE} + {BELOW} - 4*x*(1 - {ABOVE} - {BELOW})",
    f"2*{BELOW} - 2*{ABOVE} - y*(1 - {ABOVE} - {BELOW})",
]


@pytest.mark.parametrize("empty", keep(1, [[], ["+--"], ["-++"], ["+--", "-++"]]))
def test_patterns_without_points_settle_no_face(empty: list[str]) -> None:
    """A mixture of the three fields rests at (1/4, 0), though V falls along each: no start near it may be claimed."""
    fields = np.array([[1.0, -2.0], [1.0, 2.0], [-1.0, 0.0]])
    assert np.allclose(np.array([1 / 4, 1 / 4, 1 / 2]) @ fields, 0.0)
    cells = {"within": "1/2", "surfaces": ["y", "y + x - 1/4", "y - x + 1/4"], "empty": empty}
    with pytest.raises(NotShownError, match="face"):
        written(CROSSING, cells, "x**2 + Abs(y)", level="1/4")


UPPER = "(1 + sign(y - x))*(1 + sign(y + x))/4"  # the quarter about the upper half of the axis
RIGHT = "(1 + sign(x))/2"
ESCAPING = [
    f"{UPPER}*({RIGHT}*y - 1) - (1 - {UPPER})*x",
    f"{UPPER}*{RIGHT}*(y - 2)/6 - (1 - {UPPER})*y",
]


def test_forms_on_a_cube_do_not_speak_of_all_space_where_their_fields_are_none() -> None:
    """V' is a form on all cells; on the axis beyond y = 2 the fields part, and what stays between them leaves."""
    right, left = np.array([3.0 - 1, (3 - 2) / 6]), np.array([-1.0, 0.0])
    between = (right + 2 * left) / 3  # at (0, 3)
    assert between[0] == 0
    assert between[1] > 0
    empty = ["++.-", "--.+", "+-+.", "-+-."]
    cells = {"within": "1/2", "surfaces": ["x", "y", "y - x", "y + x"], "empty": empty}
    function = f"4*Abs(y) + Abs(x) + {UPPER}*(2*y - 2*Abs(x))"
    record = written(ESCAPING, cells, function)
    text = json.dumps(record)
    assert refusal(json.loads(text), len(text)) == ""
    with pytest.raises(NotShownError, match="whole space"):
        written(ESCAPING, cells, function, everywhere=True)
    record["evidence"][0]["hypotheses"]["everywhere"] = True
    record["statement"]["claims"].append({"attracts": "everywhere"})
    assert "whole space" in refusal(record, len(text))


class Granted(Proofs):
    """Proofs of anything."""

    def show(self, claim: Claim) -> None:
        """Nothing is asked."""


def test_all_curves_through_a_place_make_a_face() -> None:
    """Three curves through (1/4, 0), on each of which V bends: what rests there mixes the fields of all six parts."""
    system = read_system({"states": ["x", "y"], "rhs": [["-x", "-y"]], "at": ["0", "0"]})
    curves = ["y - x**2 + 1/16", "y + x**2 - 1/16", "x**2 + y**2 - 1/16"]
    cells = {"within": "1/2", "surfaces": curves, "empty": []}
    inclusion = Inclusion(system, cells, [" + ".join(f"Abs({curve})" for curve in curves)], Granted({}))
    assert (0, 1, 2) in {face.zero for face in inclusion.faces()}
