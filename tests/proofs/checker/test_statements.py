"""Each hypothesis of a theorem is asked: forged certificates that violate exactly one are refused, and it says which.

The forger has the search: evidence is found for every inequality that is asked.  What is claimed here is false, and a
comment says why; a checker that asks less accepts it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from itertools import product
from typing import Any

import numpy as np
import pytest

from nonsmooth.proofs.checker.cells import Inclusion, read_system
from nonsmooth.proofs.checker.files import check_file
from nonsmooth.proofs.checker.lyapunov import Lyapunov
from nonsmooth.proofs.checker.positivity import Proofs
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.checker.work import BUDGET, RejectedError, rational
from nonsmooth.proofs.kernel.search import NotShownError, Search
from tests.certificates.cases import Case, by_a_second_function, cells, instability, lyapunov, rate, subject
from tests.certificates.corpus import text_of
from tests.certificates.forgeries import certificate_text
from tests.certificates.inclusion import FloatInclusion, contradiction


def refused(rhs: Sequence[Any], theorem: str, hypotheses: dict[str, Any]) -> str:
    """Why a theorem does not apply; empty where it does, and then the checker accepts the certificate."""
    try:
        certificate = Case("forged", subject(rhs), theorem, hypotheses).certificate(WORK)
    except NotShownError as error:
        return str(error)
    return refusal(certificate, len(text_of(certificate)))


WORK = 3_000  # coefficients that the search for simplices may look at

# ---- surfaces, cells and functions ----------------------------------------------------------------

GROWS = ["x", "-sign(y)"]  # x' = x: whatever y does, the point is left
PADDED = "y*(1 + x**2)"  # vanishes where y does


@pytest.mark.parametrize(
    ("rhs", "surfaces", "function"),
    [
        # the field jumps on one surface and V bends on the other: no face where both do, and x' = x is not seen there
        (["x", f"-sign({PADDED})"], [PADDED, "y"], "x**2 + 3*Abs(y)"),
        (GROWS, ["y", "y**2"], "x**2 + 3*Abs(y)"),
        (GROWS, ["y*(1 + x)", "y*(1 + x**2)"], "x**2 + 3*Abs(y)"),
        (GROWS, ["y", "-3*y"], "x**2 + 3*Abs(y)"),
    ],
)
def test_surfaces_have_no_common_factor(rhs: list[str], surfaces: list[str], function: str) -> None:
    why = refused(rhs, "lyapunov", lyapunov(function, cells(*surfaces)))
    assert why == "required surfaces of which no two have a common factor"


def test_functions_are_continuous() -> None:
    """V jumps on y = 0: a turn that grows fivefold crosses it upward; the cells between are said to be empty."""
    gate = "(1 + sign(x))*(1 - sign(y))/4"
    rhs = [f"-{gate} + (1 - {gate})*(y - x/10)", f"-5*{gate} + (1 - {gate})*(-x - y/10)"]
    inclusion = FloatInclusion(subject(rhs), seed=1)
    places, _ = inclusion.follow(inclusion.sphere(1e-3), 1_500)
    assert np.linalg.norm(places[-1], axis=1).min() > 1
    pieces = [["++", "x**2 + y**2"], ["+-", "x**2 + 4*y**2 + 12*x"], ["-+", "x**2 + y**2"], ["--", "x**2 + 4*y**2"]]
    why = refused(rhs, "lyapunov", lyapunov(pieces, cells("x", "y", within="1/4")))
    assert why == "required functions that are continuous"
    padded = [["+.+", pieces[0][1]], ["-.+", pieces[1][1]], ["+.-", pieces[2][1]], ["-.-", pieces[3][1]]]
    where = cells("y", PADDED, "x", within="1/4", empty=["+-+", "-++"])
    assert refused(rhs, "lyapunov", lyapunov(padded, where)) == "required surfaces of which no two have a common factor"


@cache
def bang_bang_text() -> str:
    """A certificate with a V that bends on two halves of parabolas."""
    (case,) = (c for c in by_a_second_function() if c.name == "bang-bang-1")
    return json.dumps(case.certificate())


def bang_bang() -> tuple[dict[str, Any], dict[str, Any]]:
    """That certificate, to be changed, and the proofs in it."""
    certificate = json.loads(bang_bang_text())
    return certificate, certificate["evidence"][0]["proofs"]


def test_parted_pieces_and_faces_without_points_are_shown() -> None:
    """Without the proofs V is not seen to be continuous, and faces on which both parabolas vanish count."""
    certificate, proofs = bang_bang()
    assert not refusal(certificate, len(text_of(certificate)))
    optional = [name for name in proofs if name.split()[0] in ("parted", "apart")]
    assert sorted(optional) == ["apart .00", "apart 0.0", "apart 00.", "apart 000", "parted 0+-", "parted 0-+"]
    for name in optional:
        certificate, proofs = bang_bang()
        del proofs[name]
        why = refusal(certificate, len(text_of(certificate)))
        expected = "functions that are continuous" if name.startswith("parted") else "a proof of face "
        assert why.startswith(expected)


@pytest.mark.parametrize("name", ["parted 0+-", "apart 00."])
def test_proofs_of_common_points_belong_to_their_place(name: str) -> None:
    """The proof of another claim does not show it; one that is not asked is no evidence."""
    certificate, proofs = bang_bang()
    proofs[name] = proofs["V +++"] if "V +++" in proofs else proofs["empty .-+"]
    assert refusal(certificate, len(text_of(certificate)))
    certificate, proofs = bang_bang()
    proofs[name.replace("0", "+")] = proofs[name]
    assert refusal(certificate, len(text_of(certificate))) == "proofs of claims that are asked"


def test_pieces_with_common_points_are_not_parted() -> None:
    """V jumps on a line beyond 1/8, which both pieces reach there; within 1/16 they have no common point."""
    pieces = [["-+", "x**2 + y**2"], ["--", "x**2 + 2*y**2 + x"], ["+.", "x**2 + y**2"]]
    for within, why in (("1/4", "required functions that are continuous"), ("1/16", "")):
        assert refused(["-x", "-y"], "lyapunov", lyapunov(pieces, cells("1/8 - x", "y", within=within))) == why


def test_faces_with_points_are_not_left_out() -> None:
    """Two circles meet at the checked point and at another one, at which V does not fall: solutions rest there."""
    circles = ["(x - 1)**2 + y**2 - 1", "x**2 + (y - 1)**2 - 1"]  # both hold (0, 0) and (1, 1)
    towards = [f"-(x - 1) - x*({circles[0]})**2", "-(y - 1)"]
    function = f"x**2 + y**2 + {' + '.join(f'Abs({circle})' for circle in circles)}"
    for within, apart in (("3/2", False), ("1/2", True)):
        proofs = Search(WORK)
        theorem = Lyapunov(
            Inclusion(read_system(subject(towards)), cells(*circles, within=within), [function], proofs), proofs
        )
        both = next(face for face in theorem.inclusion.faces() if face.zero == (0, 1))
        assert theorem.is_left_out("00", both) is apart


def test_pieces_are_joined_beside_faces() -> None:
    """Six planes meet in the x axis, along which solutions leave; a piece without any point says that V falls there.

    No step of one sign joins it to the others, so these have to show it by themselves.
    """
    signs = "--+++-"
    lines = [(1, 0), (0, 1), (1, 1), (-1, 1), (2, 1), (-2, 1)]
    lines = [(a, b) if sign == "+" else (-a, -b) for (a, b), sign in zip(lines, signs, strict=True)]
    texts = [f"({a})*y + ({b})*z" for a, b in lines]
    angles = [2 * math.pi * (k + 0.37) / 360 for k in range(360)]
    real = {"".join("-+"[a * math.cos(t) + b * math.sin(t) > 0] for a, b in lines) for t in angles}
    distances = " + ".join(f"Abs({text})" for text in texts)
    pieces = [["+" * 6, "-9*x**2"], *([marks, f"x**2 + 3*({distances})"] for marks in sorted(real))]
    empty = sorted({"".join(marks) for marks in product("-+", repeat=6)} - real - {"+" * 6})
    why = refused(["x", "-sign(y)", "-sign(z)"], "lyapunov", lyapunov(pieces, cells(*texts, empty=empty)))
    assert why == "no proof was found of face 000000 part 0"


def test_fields_of_all_sides_count_on_a_face() -> None:
    """Two lines meet on a line on which V bends; from both sides other sectors reach this place, and it is at rest.

    Patterns that have no point change nothing, whether they are said to be empty or not.
    """
    first, second = "y - x + 1/2", "y + x - 1/2"
    a, b = f"(1 + sign({first}))/2", f"(1 + sign({second}))/2"
    above, below = f"({a})*({b})", f"(1 - {a})*(1 - {b})"
    beside = f"(1 - {above} - {below})"
    rhs = [f"{above} + {below} - x*{beside}", f"-{above} + {below} - y*{beside}"]
    for height, empty in (("y", []), ("-y", []), ("y", ["+--"]), ("y", ["-++"]), ("y", ["+--", "-++"])):
        hypotheses = lyapunov("x**2 + 3*Abs(y)", cells(height, first, second, empty=empty), level="99/100")
        assert "face 0.." in refused(rhs, "lyapunov", hypotheses)


def test_any_number_of_curved_surfaces_may_meet() -> None:
    """Three circles through one place of the plane, on all of which V bends."""
    circles = ["(x - 2)**2 + y**2 - 1", "(x - 1)**2 + (y - 1)**2 - 1", "(x - 1)**2 + (y + 1)**2 - 1"]
    function = f"x**2 + y**2 + {' + '.join(f'Abs({circle})' for circle in circles)}"
    inclusion = Inclusion(read_system(subject(["-x", "-y"])), cells(*circles, within="2"), [function], Proofs({}))
    assert (0, 1, 2) in {face.zero for face in inclusion.faces()}


@pytest.mark.parametrize(
    ("surfaces", "empty"), [(["x", "y"], ["++"]), (["x"], ["-"]), (["x - 1"], ["-"]), (["x", "y", "x + y"], ["+-+"])]
)
def test_cells_with_points_are_not_empty(surfaces: list[str], empty: list[str]) -> None:
    """Else the fields of a quadrant would not count."""
    why = refused(["-x", "-y"], "lyapunov", lyapunov("x**2 + y**2", cells(*surfaces, empty=empty)))
    assert why == f"no proof was found of empty {empty[0]}"


def test_surfaces_are_those_of_the_system() -> None:
    """A switching expression that is no product of them has no sign on a cell."""
    for surface in ("x - 1/2", "x**2", "y"):
        why = refused(["-sign(x)", "-y"], "lyapunov", lyapunov("x**2 + y**2", cells(surface)))
        assert why == "required switching expressions that are products of the surfaces"


# ---- theorem lyapunov ------------------------------------------------------------------------------

PLANE = "x**2 + y**2"


@pytest.mark.parametrize(
    ("rhs", "hypotheses", "why"),
    [
        (["-x", "-y"], lyapunov(f"{PLANE} - 1/100", cells()), "a V that is zero at the point"),
        (["-x", "y"], lyapunov("x**2 - y**2", cells()), "V "),  # a saddle
        (["-x", "0"], lyapunov("x**2", cells()), "V "),  # at rest on a line
        (["x", "y"], lyapunov(PLANE, cells()), "cell  field 0"),
        (["y", "-x"], lyapunov(PLANE, cells()), "cell  field 0"),  # a centre does not attract
        (["-x", "x/4"], lyapunov(PLANE, cells(), "stable"), "cell  field 0"),
        (["-x", "-y + 2*sign(x)*x"], lyapunov(PLANE, cells("x")), "cell + field 0"),
        ([["-x", "-y"], ["-x", "y"]], lyapunov(PLANE, cells()), "cell  field 1"),  # the second may act for ever
        (GROWS, lyapunov("x**2 + 3*Abs(y)", cells("y")), "face 0"),  # falls in both cells, grows on the line
        (["x/4 - sign(x)*Abs(y)", "1"], lyapunov("Abs(x) + y**2", cells("x", "y")), "cell ++ field 0"),
        (["-x", "-y"], lyapunov(PLANE, cells(), level="2"), "border"),  # V is one on the border
        (["-x", "-y + y**2"], lyapunov(PLANE, cells(within="2"), level="2"), "cell  field 0"),
        (["-x", "-y"], lyapunov(PLANE, cells(), rate=rate("exponential", "3")), "rate cell  field 0"),
        (["-x", "-y"], lyapunov(PLANE, cells(), rate=rate("finite", "1")), "rate cell  field 0"),
        (
            ["-x", "-y"],
            lyapunov(PLANE, cells(), rate=rate("finite", "0")),
            "a positive rate, finite, exponential",
        ),
        (["-x + x**3", "-y"], lyapunov(PLANE, cells(within="1/2"), everywhere=True), "cones and forms"),
        (["-x", "-y"], lyapunov(PLANE, cells("x - 3"), everywhere=True), "cones and forms"),
        (["y", "-x"], lyapunov(PLANE, cells(), "stable", everywhere=True), "an attracting point"),
        (["y", "-x"], lyapunov(PLANE, cells(), "stable", level="1/2"), "a positive level around a point that attracts"),
        (["-x", "-y"], lyapunov(PLANE, cells(within=None), level="1/2"), "a positive level around a point"),
        (["-x", "-y"], lyapunov(PLANE, cells(within=None), level="1/2", below=True), "a positive level around a point"),
        (["-x", "-y"], lyapunov(PLANE, cells(), level="-1", below=True), "a positive level around a point"),
        (["-x", "-y"], lyapunov(PLANE, cells(), "unstable"), "a verdict"),
    ],
)
def test_hypotheses_of_stability(rhs: list[Any], hypotheses: dict[str, Any], why: str) -> None:
    assert why in refused(rhs, "lyapunov", hypotheses)


def test_falls_where_functions_mu_scale() -> None:
    """V falls on all cells, and on faces within the cube; beyond it solutions slide outward on the x axis."""
    gate = "(1 + sign(y))/2"
    speed = f"({gate}*(4 - x**2) + 1 - {gate})"
    rhs = [f"-x - {speed}*(Abs(x)*sign(y) + 2*y)", f"-y + {speed}*(2*x + sign(x)*Abs(y))"]
    assert contradiction({"subject": subject(rhs), "claims": [{"attracts": "everywhere"}]})
    function = "x**2 + Abs(x*y) + y**2"
    assert not refused(rhs, "lyapunov", lyapunov(function, cells("x", "y")))
    everywhere = lyapunov(function, cells("x", "y"), everywhere=True)
    assert refused(rhs, "lyapunov", everywhere) == "required cones and forms, for the whole space"


def test_pieces_are_about_named_surfaces() -> None:
    """A claim about a V in pieces names the surfaces to whose signs they refer."""
    pieces = [["+", "x**2 + 2*y**2"], ["-", "x**2 + y**2"]]
    case = Case("pieces", subject(["-x", "-y"]), "lyapunov", lyapunov(pieces, cells("y"), level="1/2"))
    certificate = case.certificate()
    claim = certificate["statement"]["claims"][1]["attracts"]
    assert claim["surfaces"] == ["y"]
    for other in (["x"], None):
        forged = json.loads(json.dumps(certificate))
        forged["statement"]["claims"][1]["attracts"]["surfaces"] = other
        assert refusal(forged, 10_000).startswith("evidence of the claim")


# ---- theorems instability and departure ------------------------------------------------------------


@pytest.mark.parametrize(
    ("rhs", "hypotheses", "why"),
    [
        (["-x", "-y"], instability(f"-({PLANE})", cells(), ["1", "0"]), "cell  field 0"),
        (["x", "y"], instability(f"-({PLANE}) - 1", cells(), ["1", "0"]), "a V that is zero at the point"),
        (["-x", "-y"], instability(PLANE, cells(), ["1", "0"]), "a V that is negative in the direction"),
        (["x", "y"], instability(f"-({PLANE})", cells(), ["0", "0"]), "a V that is negative in the direction"),
        (["x", "y"], instability(f"-({PLANE})", cells("y"), ["1", "0"]), "a V that is negative in the direction"),
        (["x", "y"], instability(f"-({PLANE})", cells(within=None), ["1", "0"]), "a cube"),
        (["sign(x)", "-y"], instability("y**2 - x**2 + y", cells("x"), ["1", "0"]), "no proof was found"),
    ],
)
def test_hypotheses_of_instability(rhs: list[Any], hypotheses: dict[str, Any], why: str) -> None:
    assert why in refused(rhs, "instability", hypotheses)


@pytest.mark.parametrize(
    ("rhs", "surfaces", "direction"),
    [
        (["sign(x)", "1"], ["x"], ["1", "0"]),
        (["sign(y - x**2)", "-y"], ["y - x**2"], ["1", "0"]),  # both sides of the curve reach the point
        (["x", "y"], [], ["1", "0"]),
        ([["1", "0"], ["-1", "0"]], [], ["1", "0"]),
        (["1", "0"], [], ["0", "0"]),
        (["1", "0"], [], ["-1", "0"]),
    ],
)
def test_hypotheses_of_departure(rhs: list[Any], surfaces: list[str], direction: list[str]) -> None:
    hypotheses = {"cells": cells(*surfaces), "direction": direction}
    assert refused(rhs, "departure", hypotheses) == "required a direction in which all velocities at the point lead"


# ---- formulas and files ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    ["-x # valid\n", "-x\n", "(-x\n)", "-x*1j", "-x*True", "-x**0x1", "-x + (y := 0)", "-x if x else x", "-\uff58"],
)
def test_formulas_are_one_line_of_arithmetic(text: str, tmp_path: Any) -> None:
    """No comment and no line break of a formula gets into what the command prints; nothing but its grammar is read."""
    path = tmp_path / "forged.json"
    path.write_text(certificate_text(text, function="x**2"), encoding="utf-8")
    status, output = check_file(str(path))
    assert status == (0 if text == "-x\n" else 1)  # blanks around a formula are no part of it
    assert "\n" not in output.removeprefix("valid\n")


def test_brackets_that_are_nested_too_deeply(tmp_path: Any) -> None:
    """Python's parser runs out of its own memory there."""
    path = tmp_path / "forged.json"
    path.write_text(certificate_text("(x," * 1300 + "x"), encoding="utf-8")
    assert check_file(str(path)) == (1, "rejected: required well-formed data, not a MemoryError")


def test_a_certificate_that_is_too_much_work_stops_no_other() -> None:
    """What is left of the work of one file is not what the next one, or a search, may do."""
    with pytest.raises(RejectedError, match="limits of work"), BUDGET.granted(0):
        BUDGET.spend(1 << 40)
    assert rational("3/4") == Fraction(3, 4)
