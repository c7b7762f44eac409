"""The evidence: rows follow from numbers, the page holds them, and claims are checked by other means."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import dblquad

from nonsmooth.reports.figures.style import figure_bytes
from nonsmooth.symbolic.numbers.number_text import float_text
from tests.evidence.claims import TRIANGLE, claim_comparisons, linear_moment, stable_headings
from tests.evidence.comparison import Comparison, Verdict, measured_verdict, published
from tests.evidence.page import COMPUTED, Evidence, comparison_table, evidence_figure, filled, ranking_table
from tests.evidence.pushes import MODELS, Direction, load_pushes, push_comparisons, rank
from tests.evidence.vehicles import vehicle_comparisons
from tests.thorough import keep, thorough

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "evidence.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module", params=keep(1, ["two claims", "all claims"]))
def claims(request: pytest.FixtureRequest) -> list[Comparison]:
    """The first two rows of published claims, or all, which take some seconds."""
    return list(islice(claim_comparisons(), 2 if request.param == "two claims" else None))


# ---- rows ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("error", "verdict"),
    [
        (0.0, Verdict.AGREES),
        (-0.05, Verdict.AGREES),
        (0.051, Verdict.NEAR),
        (-0.15, Verdict.NEAR),
        (0.16, Verdict.MISSES),
    ],
)
def test_verdicts_of_measurements_follow_from_the_error(error: float, verdict: Verdict) -> None:
    assert measured_verdict(error) is verdict


def test_verdicts_of_claims_follow_from_the_numbers() -> None:
    assert published("a", "b", 2, 2, "").verdict is Verdict.AGREES
    refuted = published("a", "b", 1, 2, "w")
    assert (refuted.verdict, refuted.error, refuted.witness) == (Verdict.REFUTED, -0.5, "w")


def test_claims_have_a_source_and_a_witness(claims: list[Comparison]) -> None:
    assert all(claim.source and claim.witness for claim in claims)
    assert {claim.verdict for claim in claims} == {Verdict.AGREES, Verdict.REFUTED}
    assert all(claim.fitted == 0 for claim in claims)


@thorough  # the small one: test_claims_have_a_source_and_a_witness
def test_eight_claims_and_more() -> None:
    claims = list(claim_comparisons())
    assert len(claims) >= 8
    assert len({claim.source for claim in claims}) >= 6


# ---- the page ------------------------------------------------------------------------------------


def test_the_page_holds_the_rows_of_vehicles() -> None:
    rows = list(vehicle_comparisons())
    assert len(rows) == 12
    assert comparison_table(rows) in PAGE


def test_the_page_holds_the_rows_of_claims(claims: list[Comparison]) -> None:
    assert comparison_table(claims) in PAGE


def test_the_page_holds_the_figures_of_pushes_without_a_fit() -> None:
    for model in MODELS[:2]:
        one = rank(Direction.WRENCH, [model])[0]
        low, high = (float_text(value, 3) for value in one.interval)
        numbers = rf"{float_text(one.median, 3)} \| {low} to {high}"
        assert re.search(rf"\| wrench from motion \| \d \| {model.name} \| 0 \| {numbers} \|", PAGE)


def test_the_page_holds_the_engines_table() -> None:
    (part,) = (found for found in COMPUTED.finditer(PAGE) if found[2] == "engine")
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in part[0].splitlines()[3:]]
    assert {row[0] for row in rows} == {"fixed wheels", "free plate", "rollers", "rubber, rollers"}
    assert {row[2] for row in rows} == {"100"}


def test_computed_parts_are_replaced_and_the_text_stays() -> None:
    page = "a\n<!-- pushes -->\nold\n<!-- end -->\nb\n<!-- vehicles -->\nold\n<!-- end -->\nc\n"
    text = filled(page, {"vehicles": "cars\n", "pushes": "blocks\n"})
    assert text == "a\n<!-- pushes -->\nblocks\n<!-- end -->\nb\n<!-- vehicles -->\ncars\n<!-- end -->\nc\n"
    assert [found[2] for found in COMPUTED.finditer(PAGE)] == ["vehicles", "pushes", "ranking", "claims", "engine"]


# ---- force fields --------------------------------------------------------------------------------


def test_one_stable_pose_while_the_constant_is_small() -> None:
    assert [len(stable_headings(TRIANGLE, constant)) for constant in (0.005, 0.1, 0.2)] == [1, 1, 2]


def test_the_moment_of_a_linear_field_vanishes_by_quadrature_too() -> None:
    assert linear_moment(TRIANGLE, Fraction(3, 5), Fraction(4, 5)) == 0
    c, s = 0.6, 0.8
    corners = np.array([[c * float(x) - s * float(y), s * float(x) + c * float(y)] for x, y in TRIANGLE])
    a, b, rest = corners[1] - corners[0], corners[2] - corners[0], np.array([1.0, 0.0])

    def moment(v: float, u: float) -> float:
        arm = corners[0] + u * a + v * b
        pull = -(arm + rest) + rest
        return float(arm[0] * pull[1] - arm[1] * pull[0])

    assert dblquad(moment, 0, 1, 0, lambda u: 1 - u)[0] == pytest.approx(0, abs=1e-12)


def test_the_stable_pose_is_where_the_potential_is_least() -> None:
    """Energy of the part over headings, at the place of least energy: a search that knows no moment."""
    from scipy.optimize import minimize

    constant = 0.05
    (stable,) = stable_headings(TRIANGLE, constant)
    rng = np.random.default_rng(6)
    u, v = rng.random((2, 4000))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    corners = np.array([[float(x), float(y)] for x, y in TRIANGLE])
    points = corners[0] + u[:, None] * (corners[1] - corners[0]) + v[:, None] * (corners[2] - corners[0])
    points -= points.mean(axis=0)

    def energy(theta: float) -> float:
        turned = points @ np.array([[math.cos(theta), math.sin(theta)], [-math.sin(theta), math.cos(theta)]])
        place = minimize(
            lambda c: np.hypot(*(turned + c).T).mean() - constant * c[0], np.zeros(2), method="Nelder-Mead"
        ).x
        return float(np.hypot(*(turned + place).T).mean() - constant * place[0])

    headings = np.linspace(0, 2 * math.pi, 25)[:-1]
    best = headings[int(np.argmin([energy(float(theta)) for theta in headings]))]
    assert abs((best - stable + math.pi) % (2 * math.pi) - math.pi) < 0.3


# ---- pushes --------------------------------------------------------------------------------------


def test_pictures_are_drawn(claims: list[Comparison]) -> None:
    logs = [log._replace(motions=log.motions[:10], wrenches=log.wrenches[:10]) for log in load_pushes()[:1]]
    ranking = {direction: rank(direction, MODELS[:2], logs) for direction in Direction}
    evidence = Evidence(list(vehicle_comparisons()), ranking, claims)
    assert figure_bytes(lambda: evidence_figure(evidence), ".png").startswith(b"\x89PNG")
    assert len(ranking_table(ranking).splitlines()) == 2 + 4
    assert "above the one before" in ranking_table(ranking)


def test_rows_on_pushes_say_what_was_fitted() -> None:
    ranking = {Direction.WRENCH: rank(Direction.WRENCH, MODELS[:2])}
    assert [one.model.name for one in ranking[Direction.WRENCH]] == ["isotropic", "naive"]
    first = next(push_comparisons(ranking))
    assert (first.verdict, first.fitted, round(first.predicted, 1)) == (Verdict.AGREES, 0, 10.9)
