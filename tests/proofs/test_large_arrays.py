"""Large arrays: what floats propose is decided exactly, what tables cost, and that rounding decides nothing."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flint import fmpq
from numpy.typing import NDArray
from scipy.optimize import minimize

from nonsmooth.analysis.cells.arrangement import Arrangement, is_multiple
from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.equilibria import find_equilibria
from nonsmooth.analysis.cells.loads import load_regions, value_at
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.slopes import Slopes
from nonsmooth.analysis.minimizers.friction_search import MANY, RimDemand, search_forces
from nonsmooth.proofs import theorem4
from nonsmooth.proofs.clauses.feedback.balanced_twists import wheel_forces
from nonsmooth.proofs.clauses.feedback.by_friction import decide_driven_feedback
from nonsmooth.proofs.clauses.feedback.twist_candidates import PromisingTwists, candidate_twists
from nonsmooth.proofs.clauses.translation import clause
from nonsmooth.proofs.clauses.translation.at_point import EllipseTranslation
from nonsmooth.proofs.findings import Feedback
from nonsmooth.proofs.theorem4 import Check, SmoothCheck, check_theorem4
from nonsmooth.symbolic.files import scene_values
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.wheel_csv import parse_wheels
from nonsmooth.symbolic.mechanics.contact_states import Triple, cross_product, independent, inner, scaled
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.coefficients import rational_quotient
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.conftest import Arrays
from tests.oracles.clause_evidence import evidence_holds
from tests.proofs.answers.test_enclosed_clauses import BY_ANGLE, EXACT
from tests.rounded_rings import RULES, contradiction, said_of_ring
from tests.thorough import few, keep

# ---- Arrays of too many candidates to try them all: what floats propose is decided exactly, and verifies.

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
    found = Slopes(arrangement, signs)
    listed = [found[k] for k in range(len(found))]
    table = [scaled(arrangement.lines.edge(slope.pair), slope.sense) for slope in listed]
    sides = [k for k, row in enumerate(arrangement.rows) if row.kind == "S"]
    for a in sides:
        for b in sides:
            direction = cross_product(arrangement.rows[a].normal, arrangement.rows[b].normal)
            if any(direction):
                parallel = [along for along in table if not any(cross_product(along, direction))]
                slopes = arrangement.slopes_along((a, b), signs)
                positive = [value_at(form, p).sign() > 0 for form in slopes for p in region.polygon.vertices]
                assert all(positive) or any(inner(along, direction).sign() > 0 for along in parallel)


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


@pytest.mark.usefixtures("without_law")
def test_many_wheels_are_sampled_at_fewer_points(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clause, "MOST_SLIPS", 16 * 9 + 1)
    found = check_theorem4(load_scene("grid-4x4", rule="ellipse"), prune=False).translation
    assert isinstance(found, EllipseTranslation)
    assert found.sampled is not None
    assert found.sampled.samples == 9


# ---- What a large table of wheels costs: no formula is parsed for a plain number, and few wheels are looked at
# twice.


def test_plain_directions_never_reach_the_formula_parser(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*arguments: object) -> None:
        raise AssertionError(f"required no formula, received {arguments}")

    monkeypatch.setattr(scene_values, "parse", refuse)
    table = parse_wheels('x,y,heading,speed\n0.1,0.2,"[0.6, 0.8]",1.5\n0.3,0.4,"[ -1 ,0 ]",2\n', "w.csv", "my.toml")
    assert len(table.rows) == 2


def test_equilibria_are_judged_among_few_wheels(arrays: Arrays, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each of them built a partition of the whole array before."""
    scene = arrays.grid(20, 20, radius=2).recentred()
    equilibria = find_equilibria(build_nearest_partition(scene))
    assert equilibria
    sizes: list[int] = []
    build = build_partition

    def counted(array: Scene, **options: Any) -> Partition:
        sizes.append(len(array.wheels))
        return build(array, **options)

    monkeypatch.setattr(theorem4, "build_partition", counted)
    theorem4.judge_equilibria(scene, equilibria)
    assert sizes
    assert max(sizes) < 30


def test_rows_are_looked_at_until_three_are_independent(arrays: Arrays) -> None:
    looked_at: list[int] = []

    def rows() -> Iterator[Triple]:
        one, zero = scene.field.one, scene.field.zero
        for k, row in enumerate([(zero, zero, zero), (one, zero, zero), (one + one, zero, zero), (zero, one, zero)]):
            looked_at.append(k)
            yield row
        for k in range(4, 100):
            looked_at.append(k)
            yield (one, one, one)

    scene = arrays.four_wheel()
    assert independent(rows()) == (1, 3, 4)
    assert looked_at == [0, 1, 2, 3, 4]


# ---- Where rounding decides nothing is said: rings against symmetry, tables against minima of D at moved headings.

Array = NDArray[np.float64]
MOVED = 1e-13  # radians by which headings are moved
MU_SIDE = 0.5

TRIANGLE = """
[friction]
mu_roll = 1
mu_side = "1/2"
[[wheel]]
position = [1, 0]
heading = 187
[[wheel]]
position = ["-1/2", "sqrt(3)/2"]
heading = 307
[[wheel]]
position = ["-1/2", "-sqrt(3)/2"]
heading = 67
"""


def check_of(tmp_path: Path, text: str, rule: str) -> Check:
    source = tmp_path / "my.toml"
    source.write_text(text)
    return check_theorem4(load_scene(source, rule=rule))


@pytest.mark.parametrize("rule", ["ellipse", "roller"])
def test_a_ring_in_degrees_is_not_said_to_throw_bodies_out(tmp_path: Path, rule: str) -> None:
    check = check_of(tmp_path, TRIANGLE, rule)
    verdicts = [str(check.results[name].verdict) for name in ("equilibrium", "translation", "rotation")]
    assert verdicts == ["holds", "asymptotically stable", "unstable"]
    assert isinstance(check, SmoothCheck)
    assert 0 < (check.equilibrium.rounding_distance or 0) < 1e-12
    assert check.check()


@pytest.mark.parametrize("rule", ["nearest", "box"])
def test_what_is_true_of_all_members_stays(tmp_path: Path, rule: str) -> None:
    check = check_of(tmp_path, TRIANGLE, rule)
    assert not check.by_rounding
    assert check.results["equilibrium"].verdict == "holds"
    assert check.results["translation"].verdict == {"nearest": "asymptotically stable", "box": "stable"}[rule]
    assert check.check()


@pytest.mark.parametrize("rule", ["ellipse", "roller"])
def test_an_equilibrium_of_the_rounded_member_alone_is_not_shown(tmp_path: Path, rule: str) -> None:
    """Three rims balance where they point along 3-4-5; one is stated by its angle, to sixteen digits."""
    by_vectors = check_of(tmp_path, EXACT.replace(BY_ANGLE, "[3, 4]"), rule)
    by_angle = check_of(tmp_path, EXACT, rule)
    assert isinstance(by_vectors, SmoothCheck)
    assert isinstance(by_angle, SmoothCheck)
    assert by_vectors.equilibrium.verdict == by_angle.equilibrium.verdict == "holds"
    assert by_vectors.equilibrium.rounding_distance is None
    assert by_angle.equilibrium.rounding_distance  # not the point itself
    assert by_angle.rotation.verdict == "undecided"


@pytest.mark.parametrize("rule", keep(1, ["box", "ellipse"]))
def test_unknown_loads_too(rule: str, tmp_path: Path) -> None:
    check = check_of(tmp_path, TRIANGLE + '[contact]\nloads = "any"\n', rule)
    assert check.results["equilibrium"].verdict != "fails"
    assert check.check()


@few(2)
@pytest.mark.parametrize(
    ("count", "turn", "rule"),
    keep(3, [(3, 7, "ellipse"), (3, 41, "nearest"), (4, 33, "box"), *product(range(3, 13), range(1, 90, 4), RULES)]),
)
def test_notations_of_a_ring_do_not_contradict_each_other(tmp_path: Path, count: int, turn: int, rule: str) -> None:
    assert not contradiction(said_of_ring(tmp_path, count, turn, rule))


# ---- random tables: the minimum of D by its definition, at headings beside those stated -------------


def random_table(draw: random.Random) -> tuple[str, Array, Array]:
    """Wheels about the unit circle, headings in whole degrees; the scene with its positions and headings."""
    count = draw.randint(3, 6)
    places, degrees = [], []
    for k in range(count):
        angle = 360 * k / count + draw.randint(-15, 15)
        x, y = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        places.append((round(x, 2), round(y, 2)))
        degrees.append(round(angle) + 180 + draw.randint(-25, 25))
    wheels = [
        f"[[wheel]]\nposition = [{x}, {y}]\nheading = {degree}\n"
        for (x, y), degree in zip(places, degrees, strict=True)
    ]
    head = f'[check]\nradius = "1/20"\n[friction]\nmu_roll = 1\nmu_side = {MU_SIDE}\n'
    return head + "".join(wheels), np.array(places), np.radians(degrees)


def least_loss(places: Array, headings: Array, *, still: bool) -> float:
    """Least power lost to friction (ellipse, elastic loads) at the middle; of ``still`` bodies only those that spin."""
    columns = np.column_stack([np.ones(len(places)), places])
    loads = columns @ np.linalg.pinv(columns.T @ columns) @ np.array([1.0, 0.0, 0.0])
    along = np.column_stack([np.cos(headings), np.sin(headings)])

    def loss(twist: Array) -> float:
        vx, vy, omega = (0.0, 0.0, twist[0]) if still else twist
        velocity = np.array([vx, vy]) + omega * np.column_stack([-places[:, 1], places[:, 0]])
        roll = np.sum(along * velocity, axis=1) - 1
        side = along[:, 0] * velocity[:, 1] - along[:, 1] * velocity[:, 0]
        return float(loads @ np.hypot(roll, MU_SIDE * side))

    size = 1 if still else 3
    options = {"xatol": 1e-10, "fatol": 1e-14, "maxiter": 4_000, "maxfev": 8_000}
    return float(minimize(loss, np.full(size, 0.01), method="Nelder-Mead", options=options).fun)


@pytest.mark.parametrize("seed", keep(4, range(60)))
def test_what_fails_fails_beside_the_stated_headings_too(tmp_path: Path, seed: int) -> None:
    draw = random.Random(seed)
    text, places, headings = random_table(draw)
    check = check_of(tmp_path, text, "ellipse")
    assert check.check()
    for _ in range(2):
        moved = headings + np.array([draw.uniform(-MOVED, MOVED) for _ in headings])
        gain = least_loss(places, moved, still=True) - least_loss(places, moved, still=False)
        if check.results["equilibrium"].verdict == "fails":
            assert gain > 1e-9  # a motion away from the point loses less than every spin
        assert not check.by_rounding or gain < 1e-9
