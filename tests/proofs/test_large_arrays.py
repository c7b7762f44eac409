"""Arrays of too many candidates to try them all: what floats propose is decided exactly, and verifies."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from flint import fmpq

from nonsmooth.analysis.cells.arrangement import Arrangement, is_multiple
from nonsmooth.analysis.cells.loads import load_regions, value_at
from nonsmooth.analysis.cells.slopes import Slopes
from nonsmooth.analysis.minimizers.friction_search import MANY, RimDemand, search_forces
from nonsmooth.proofs.clauses.feedback.balanced_twists import wheel_forces
from nonsmooth.proofs.clauses.feedback.by_friction import decide_driven_feedback
from nonsmooth.proofs.clauses.feedback.twist_candidates import PromisingTwists, candidate_twists
from nonsmooth.proofs.clauses.translation import clause
from nonsmooth.proofs.clauses.translation.at_point import EllipseTranslation
from nonsmooth.proofs.findings.verdicts import Feedback
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.constraints import Triple, cross_product, inner, scaled
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.coefficients import rational_quotient
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.oracles.clause_evidence import evidence_holds
from tests.thorough import few

GRID = """
name = "grid"
[friction]
mu_roll = 1
mu_side = "1/2"
[grid]
rows = 6
columns = 6
[field]
kind = "{field}"
[contact]
rule = "{rule}"
"""


def grid(folder: Path, field: str, rule: str) -> Scene:
    path = folder / "grid.toml"
    path.write_text(GRID.format(field=field, rule=rule), encoding="utf-8")
    return load_scene(path).recentred()


@few(1)
@pytest.mark.parametrize("rule", ["box", "ellipse"])
@pytest.mark.parametrize("field", ["radial", "saddle"])
def test_a_law_of_few_candidates_verifies(field: str, rule: str, tmp_path: Path) -> None:
    scene = grid(tmp_path, field, rule)
    assert len(scene.wheels) > MANY
    found = decide_driven_feedback(scene)
    assert found.verdict is Feedback.STABILIZABLE
    assert evidence_holds(found)
    assert found == decide_driven_feedback(scene)
    assert not evidence_holds(replace(found, kappa=(found.kappa or Fraction(0)) * 1000))


def test_proposals_are_candidates_and_come_once(tmp_path: Path) -> None:
    scene = grid(tmp_path, "saddle", "box")
    zero = scene.field.zero
    proposals = PromisingTwists(scene, load_regions(scene, (zero, zero))[0])
    taken: list[Triple] = []
    while (twist := proposals.next([])) is not None and len(taken) < 20:
        assert not any(not any(cross_product(twist, earlier)) for earlier in taken)
        taken.append(twist)
    candidates = set(candidate_twists(scene))
    assert len(taken) == 20
    assert candidates.issuperset(taken)


def test_forces_of_many_wheels_balance_within_their_limits(tmp_path: Path) -> None:
    scene = grid(tmp_path, "radial", "ellipse")
    zero, one = scene.field.zero, scene.field.one
    wheels = wheel_forces(scene, load_regions(scene, (zero, zero))[0], (one, one, zero))
    along, across = (np.array([[float(x) for x in getattr(w, name)] for w in wheels]) for name in ("along", "across"))
    signs = np.array([wheel.side for wheel in wheels])
    still = RimDemand(np.zeros(len(wheels)), np.zeros(len(wheels)))
    forces = search_forces(along, across, signs, np.ones(len(wheels)), still)
    assert forces is not None
    rho, tau = np.empty(len(wheels)), np.empty(len(wheels))
    slips = signs != 0
    rho[slips], tau[slips] = np.cos(forces.angles), signs[slips] * np.sin(forces.angles)
    rho[~slips], tau[~slips] = forces.sticking.T
    assert np.abs(rho @ along + tau @ across).max() < 1e-9
    assert ((forces.angles > 0) & (forces.angles < np.pi)).all()
    assert (np.linalg.norm(forces.sticking, axis=1) < 1).all()


@pytest.mark.parametrize("name", ["four-wheel", "elliptic", "ring-5"])
def test_slopes_against_all_pairs(name: str) -> None:
    """Each slope of each pair of tight rows is in the table up to a factor, or positive on the whole square."""
    scene = load_scene(name, rule="box").recentred()
    region = load_regions(scene)[0]
    arrangement = Arrangement(scene, region)
    signs = np.array([0 if row.kind == "S" else -1 for row in arrangement.rows])  # rest: all side rows hold
    table = [scaled(arrangement.edge(slope.pair), slope.sense) for slope in Slopes(arrangement, signs)]
    sides = [k for k, row in enumerate(arrangement.rows) if row.kind == "S"]
    for a in sides:
        for b in sides:
            direction = cross_product(arrangement.rows[a].normal, arrangement.rows[b].normal)
            if any(direction):
                known = [along for along in table if not any(cross_product(along, direction))]
                slopes = arrangement.slopes_along((a, b), signs)
                positive = [value_at(form, p).sign() > 0 for form in slopes for p in region.polygon.vertices]
                assert all(positive) or any(inner(along, direction).sign() > 0 for along in known)


def test_multiples_of_a_line() -> None:
    field = NumberField()
    one, root = field.one, field.sqrt(2)
    line = (one, root, one + root)
    for factor in (field.rational(-3), root, 1 - root, field.zero):
        assert is_multiple(tuple(factor * x for x in line), line)  # type: ignore[arg-type]
    assert not is_multiple((one, root, one - root), line)
    assert not is_multiple((one, root, root), (field.zero, one, one))
    assert rational_quotient((root * 3).terms, (root * 2).terms) == fmpq(3, 2)
    assert rational_quotient(root.terms, one.terms) is None


@pytest.mark.parametrize("size", [Fraction(10) ** 400, Fraction(1, 10**400), Fraction(1, 10**200)])
def test_multiples_beyond_floats_are_told_exactly(size: Fraction) -> None:
    field = NumberField()
    one, root, far = field.one, field.sqrt(2), field(size)
    line = (one, root * far, far)
    assert is_multiple((root, 2 * far, root * far), line)
    assert not is_multiple((root, 2 * far, root * far * (1 + Fraction(1, 10**30))), line)
    near = one + Fraction(1, 10**30)  # not to be told by floats
    assert not is_multiple((one, root * far * near, far), line)


def test_a_zero_form_is_a_multiple_over_a_base_of_higher_degree() -> None:
    field = NumberField(5)  # its coefficients are polynomials in the base
    zero, base = field.zero, field.two_cos(1)
    line = (base, field.one, base + 1)
    assert is_multiple((zero, zero, zero), line)
    assert not is_multiple((zero, zero, base), line)
    assert is_multiple((base * 3, field.rational(3), base * 3 + 3), line)


def test_many_wheels_are_sampled_at_fewer_points(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clause, "MOST_SLIPS", 16 * 9 + 1)
    found = check_theorem4(load_scene("grid-4x4", rule="ellipse"), prune=False).translation
    assert isinstance(found, EllipseTranslation)
    assert found.sampled is not None
    assert found.sampled.samples == 9
