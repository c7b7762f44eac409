"""The evidence: rows follow from numbers, the page holds them, and claims are checked by other means."""

from __future__ import annotations

import csv
import math
import re
from fractions import Fraction
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import dblquad

from nonsmooth.analysis.pushes.measured_pushes import load_pushes
from nonsmooth.analysis.pushes.models import MODELS
from nonsmooth.analysis.pushes.ranking import Direction, differences, rank
from nonsmooth.reports.evidence.claim import ClaimKind, ClaimVerdict, measured_verdict, published
from nonsmooth.reports.evidence.force_fields import TRIANGLE, centred, linear_moment, stable_headings
from nonsmooth.reports.evidence.literature import literature_claims
from nonsmooth.reports.evidence.pack import Evidence, gather
from nonsmooth.reports.evidence.page import claims_table, page_text, ranking_table
from nonsmooth.reports.evidence.pushes import PushEvidence, push_claims
from nonsmooth.symbolic.number_text import float_text
from tests.thorough import keep, thorough

ROOT = Path(__file__).resolve().parents[3]
PAGE = (ROOT / "docs" / "evidence.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module", params=keep(1, ["two claims", "all claims"]))
def found(request: pytest.FixtureRequest) -> Evidence:
    """The rows of vehicles, and of the claims of papers the first two or all, which take some seconds."""
    if request.param == "all claims":
        return gather([ClaimKind.VEHICLES, ClaimKind.CLAIMS])
    return Evidence((*gather([ClaimKind.VEHICLES]).claims, *islice(literature_claims(), 2)), None)


# ---- rows ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("error", "verdict"),
    [
        (0.0, ClaimVerdict.AGREES),
        (-0.05, ClaimVerdict.AGREES),
        (0.051, ClaimVerdict.NEAR),
        (-0.15, ClaimVerdict.NEAR),
        (0.16, ClaimVerdict.MISSES),
    ],
)
def test_verdicts_of_measurements_follow_from_the_error(error: float, verdict: ClaimVerdict) -> None:
    assert measured_verdict(error) is verdict


def test_verdicts_of_claims_follow_from_the_numbers() -> None:
    assert published("a", "b", 2, 2, "").verdict is ClaimVerdict.AGREES
    refuted = published("a", "b", 1, 2, "w")
    assert (refuted.verdict, refuted.error, refuted.witness) == (ClaimVerdict.REFUTED, -0.5, "w")


def test_claims_have_a_source_and_a_witness(found: Evidence) -> None:
    claims = [claim for claim in found.claims if claim.kind is ClaimKind.CLAIMS]
    assert all(claim.source and claim.witness for claim in claims)
    assert {claim.verdict for claim in claims} == {ClaimVerdict.AGREES, ClaimVerdict.REFUTED}
    assert all(claim.fitted == 0 for claim in claims)


@thorough  # the small one: test_claims_have_a_source_and_a_witness
def test_eight_claims_and_more() -> None:
    claims = list(literature_claims())
    assert len(claims) >= 8
    assert len({claim.source for claim in claims}) >= 6


@pytest.mark.parametrize("kind", [ClaimKind.VEHICLES, ClaimKind.CLAIMS])
def test_the_page_holds_the_figures(found: Evidence, kind: ClaimKind) -> None:
    table = claims_table(found, kind).rstrip()
    assert table
    assert table in PAGE


def test_the_page_holds_the_figures_of_pushes_without_a_fit() -> None:
    for model in MODELS[:2]:
        one = rank(Direction.WRENCH, [model])[0]
        low, high = (float_text(value, 3) for value in one.interval)
        numbers = rf"{float_text(one.median, 3)} \| {low} to {high}"
        assert re.search(rf"\| wrench from motion \| \d \| {model.name} \| 0 \| {numbers} \|", PAGE)


def test_the_page_holds_the_engines_table() -> None:
    header, *rows = csv.reader((ROOT / "docs" / "evidence" / "engine.csv").read_text(encoding="utf-8").splitlines())
    assert header[0] == "kind"
    assert {row[2] for row in rows} == {"100"}
    assert all(f"| {' | '.join(row)} |" in PAGE for row in rows)


def test_parts_that_were_not_computed_stay(found: Evidence) -> None:
    page = "<!-- pushes -->\nold\n<!-- end --><!-- vehicles -->\nold\n<!-- end -->"
    text = page_text(page, found, "kind\n")
    assert "<!-- pushes -->\nold\n<!-- end -->" in text
    assert "husky-a200" in text


# ---- force fields --------------------------------------------------------------------------------


def test_one_stable_pose_while_the_constant_is_small() -> None:
    part = centred(TRIANGLE)
    assert [len(stable_headings(part, constant)) for constant in (0.005, 0.1, 0.2)] == [1, 1, 2]


def test_the_moment_of_a_linear_field_vanishes_by_quadrature_too() -> None:
    part = centred(TRIANGLE)
    assert linear_moment(part, Fraction(3, 5), Fraction(4, 5)) == 0
    c, s = 0.6, 0.8
    corners = np.array([[c * float(x) - s * float(y), s * float(x) + c * float(y)] for x, y in part])
    a, b, rest = corners[1] - corners[0], corners[2] - corners[0], np.array([1.0, 0.0])

    def moment(v: float, u: float) -> float:
        arm = corners[0] + u * a + v * b
        pull = -(arm + rest) + rest
        return float(arm[0] * pull[1] - arm[1] * pull[0])

    assert dblquad(moment, 0, 1, 0, lambda u: 1 - u)[0] == pytest.approx(0, abs=1e-12)


def test_the_stable_pose_is_where_the_potential_is_least() -> None:
    """Energy of the part over headings, at the place of least energy: a search that knows no moment."""
    from scipy.optimize import minimize

    part, constant = centred(TRIANGLE), 0.05
    (stable,) = stable_headings(part, constant)
    rng = np.random.default_rng(6)
    u, v = rng.random((2, 4000))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    corners = np.array([[float(x), float(y)] for x, y in part])
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


# ---- pushes ---------------------------------------------------------------------------------------


def test_pictures_are_drawn(found: Evidence) -> None:
    logs = load_pushes()[:1]
    ranked = {direction: rank(direction, MODELS[:2], logs) for direction in Direction}
    whole = Evidence(found.claims, PushEvidence(ranked, {d: differences(one) for d, one in ranked.items()}))
    assert whole.picture(".png").startswith(b"\x89PNG")
    assert len(whole.record()["ranking"]) == 4
    assert "above the one before" in ranking_table(whole.pushes or PushEvidence({}, {}))


def test_claims_on_pushes_say_what_was_fitted() -> None:
    evidence = PushEvidence({Direction.WRENCH: rank(Direction.WRENCH, MODELS[:2])}, {Direction.WRENCH: ()})
    assert [row["model"] for row in evidence.record()] == ["isotropic", "naive"]
    first = next(push_claims(evidence))
    assert (first.verdict, first.fitted, round(first.predicted, 1)) == (ClaimVerdict.AGREES, 0, 10.9)
