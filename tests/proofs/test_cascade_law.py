"""Clause 4 where no quadratic V serves: theta first, then c along the rims; the laws followed step by step."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest

from nonsmooth.analysis.cells.fan import build_fan
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.fields.constant_field import feedback_field
from nonsmooth.analysis.fields.feedback_laws import cascade_law, tangential_law
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult, decide_feedback
from nonsmooth.proofs.clauses.feedback.cascade_law import CascadeLaw, Descent, find_cascade
from nonsmooth.proofs.clauses.feedback.control_fields import common_normal
from nonsmooth.proofs.findings import Feedback, Theorem4
from nonsmooth.proofs.theorem4 import check_cells
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_states import inner
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.conftest import Arrays
from tests.oracles.clause_evidence import evidence_holds
from tests.oracles.floats import Floats
from tests.oracles.wheels_in_floats import Contacts, J, NearestRows, Rate, followed
from tests.proofs.forged import with_results
from tests.thorough import few, keep, thorough

ROLL = (1, Fraction(1, 2))
SEEDS = range(120)


@cache
def decided(arrays: Arrays, seed: int) -> tuple[Scene, FeedbackResult]:
    scene = arrays.cocircular(seed, ROLL).recentred()
    return scene, decide_feedback(build_nearest_partition(scene))


def closed_loop(scene: Scene, law: CascadeLaw, eps: float = 1.0) -> Rate:
    """Pose rate under the law as its text says it, with the rows of rule nearest solved here; gain one."""
    rows = NearestRows(Contacts.of(scene))
    signs = {wheel.index: sign for wheel, sign in zip(law.wheels, law.signs, strict=True)}

    def rate(pose: Floats) -> Floats:
        c, theta = pose[:2], pose[2]
        nearest = rows.at(c)[0].wheel
        p, d = rows.contacts.positions[nearest], rows.contacts.rims[nearest]
        n = J @ d
        if law.descent is Descent.SLOW_TURNS:
            out = p / np.linalg.norm(p)
            x, y = c @ out, c @ (J @ out)
            omega = eps * y - (theta - eps * y * y / (2 * x))
            v = (1 - omega) * x * (J @ out)
        else:
            omega = -theta
            v = np.linalg.norm(c) * signs[nearest + 1] * d - (n @ (J @ p)) * omega * n
        wanted = np.array([*v, omega])
        return rows.rate(c, lambda row: row.row @ wanted)

    return rate


# ---- the laws serve ------------------------------------------------------------------------------


@pytest.mark.parametrize(("seed", "step"), keep(1, [(43, 0.01), *((seed, 0.005) for seed in (43, 46, 85, 115))]))
def test_full_turns_that_contract_bring_the_body_home(arrays: Arrays, seed: int, step: float) -> None:
    scene, feedback = decided(arrays, seed)
    assert feedback.verdict is Feedback.STABILIZABLE
    assert feedback.cascade is not None
    assert feedback.cascade.descent is Descent.TURNS
    start = np.array([0.03, 0.02, 0.02])
    end = followed(closed_loop(scene, feedback.cascade), start, until=30, step=step)[-1]
    assert np.linalg.norm(end) < 1e-4 * np.linalg.norm(start)


@pytest.mark.parametrize("step", keep(1, [0.004, 0.002]))
def test_inward_slides_bring_the_body_home(arrays: Arrays, step: float) -> None:
    """Also where a quadratic V serves: the four-wheel array slides home along the axes between its wheels."""
    scene = arrays.four_wheel(turn=(Fraction(4, 5), Fraction(3, 5)))
    law = find_cascade(build_fan(build_nearest_partition(scene)))
    assert law is not None
    assert law.descent is Descent.SLIDES
    end = followed(closed_loop(scene, law), np.array([0.1, 0.05, 0.3]), until=12, step=step)[-1]
    assert np.abs(end).max() < 1e-3


@pytest.mark.parametrize(("hundreds", "step"), keep(1, [(2, 0.04), (4, 0.02)]))
def test_an_omniwheel_drive_comes_home_slowly_by_turning_to_and_fro(hundreds: int, step: float) -> None:
    """The proof's function ``X^2 + Theta^2`` falls by about ``2 mu m x^3``: like ``1/t``, not exponentially."""
    scene = load_scene("conveyor-3").recentred()
    feedback = decide_feedback(build_nearest_partition(scene))
    assert feedback.cascade is not None
    assert feedback.cascade.descent is Descent.SLOW_TURNS
    assert feedback.none_serves
    rate, pose, sizes = closed_loop(scene, feedback.cascade), np.array([0.05, 0.02, 0.1]), list[float]()
    for _ in range(hundreds):
        pose = followed(rate, pose, until=100, step=step)[-1]
        sizes.append(float(np.linalg.norm(pose)))
    assert 1e-4 < sizes[-1] < sizes[0] < 0.15 * 0.11  # |pose| itself goes up and down on the way


def test_the_function_of_the_proof_decreases_near_the_equilibrium() -> None:
    """``W = X^2 + Theta^2`` by its definition, differentiated along the law in the middle of every cone."""
    scene = load_scene("conveyor-3").recentred()
    law = decide_feedback(build_nearest_partition(scene)).cascade
    assert law is not None
    rate = closed_loop(scene, law)
    tops = np.array([[float(x) for x in wheel.position] for wheel in law.wheels])
    mean = 1.0  # of z^2 over |z| <= tan(60 degrees)

    def w(pose: Floats) -> float:
        out = tops[np.argmax(tops @ pose[:2])]
        x, y = pose[:2] @ out, pose[:2] @ (J @ out)
        z = y / x
        return float((x + x * x * (z**3 / 3 - mean * z)) ** 2 + (pose[2] - x * z * z / 2) ** 2)

    rng = np.random.default_rng(2)
    for _ in range(200):
        angle = rng.uniform(0, 2 * np.pi)
        if min(abs((angle - np.pi / 3) % (2 * np.pi / 3)), 2) < 0.05:
            continue  # beside a ray
        pose = 1e-3 * np.array([np.cos(angle), np.sin(angle), rng.uniform(-1, 1)])
        pose[2] *= 10 ** -rng.uniform(0, 5)
        step = 1e-7
        slope = (w(pose + step * rate(pose)) - w(pose - step * rate(pose))) / (2 * step)
        assert slope < 0


@pytest.mark.parametrize(("seed", "until"), keep(1, [(43, 0.2), (43, 0.5), (0, 0.5)]))
def test_the_simulated_law_is_the_written_one(arrays: Arrays, seed: int, until: float) -> None:
    """Event-driven, by the control fields of the cells, against plain steps by the rows of the rule."""
    scene = arrays.cocircular(seed, ROLL).recentred()
    partition = build_nearest_partition(scene)
    law = find_cascade(build_fan(partition))
    assert law is not None
    signs = {wheel.index: sign for wheel, sign in zip(law.wheels, law.signs, strict=True)}
    start = (0.03, 0.02, 0.2)
    field = feedback_field(partition, cascade_law(1.0, signs), Kinematics.EXACT)
    end = simulate(field, start, until).end.state
    steps = followed(closed_loop(scene, law), np.array(start), until=until, step=1e-4)[-1]
    assert np.abs(np.array(end, dtype=float) - steps).max() < 1e-4


@thorough  # the small one: test_the_simulated_law_is_the_written_one
def test_the_simulated_tangential_law_is_the_written_one() -> None:
    scene = load_scene("conveyor-3").recentred()
    partition = build_nearest_partition(scene)
    law = find_cascade(build_fan(partition))
    assert law is not None
    field = feedback_field(partition, tangential_law(1.0, 0.5), Kinematics.EXACT)
    end = simulate(field, (0.05, 0.02, 0.1), 3.0).end.state
    steps = followed(closed_loop(scene, law, eps=2.0), np.array([0.05, 0.02, 0.1]), until=3.0, step=1e-4)[-1]
    assert np.abs(np.array(end, dtype=float) - steps).max() < 1e-4


# ---- which signs ---------------------------------------------------------------------------------


@few(1)
@pytest.mark.parametrize("seed", SEEDS)
def test_where_a_quadratic_v_serves_so_do_signs(arrays: Arrays, seed: int) -> None:
    """The cascade asks for less; and what it finds verifies itself."""
    scene, feedback = decided(arrays, seed)
    partition = build_nearest_partition(scene)
    if feedback.verdict is Feedback.NO_CERTIFICATE:
        assert feedback.witness is not None
        return
    assert feedback.verdict is Feedback.STABILIZABLE
    law = feedback.cascade or find_cascade(build_fan(partition))
    assert law is not None
    assert evidence_holds(law.fan)
    assert set(feedback.rim_signs) <= {1, -1}


@thorough  # about all random cases, which `make bench` runs
def test_most_arrays_are_decided(arrays: Arrays) -> None:
    """What is left open has an exact coincidence: a rim line through another wheel, or parallel rims."""
    open_seeds = [seed for seed in SEEDS if _is_open(decided(arrays, seed)[1])]
    print(f"open: {open_seeds} of {len(SEEDS)}")
    assert len(open_seeds) <= 0.02 * len(SEEDS)


def _is_open(feedback: FeedbackResult) -> bool:
    return feedback.verdict is Feedback.NO_CERTIFICATE and feedback.obstruction is None


def test_a_theorem_holds_by_the_cascade_alone() -> None:
    result = check_cells(load_scene("conveyor-3"))
    assert result.verdict is Theorem4.HOLDS
    assert result.check()
    assert isinstance(result.feedback, FeedbackResult)
    assert not with_results(result, feedback=replace(result.feedback, cascade=None)).check()


# ---- no feedback at all --------------------------------------------------------------------------


def test_a_common_normal_is_orthogonal_to_all(arrays: Arrays) -> None:
    field = arrays.four_wheel().field
    rng = np.random.default_rng(0)
    for count in (0, 1, 2, 5):
        first, second = (tuple(field(int(k)) for k in rng.integers(-5, 6, 3)) for _ in range(2))
        twists = []
        for _ in range(count):
            s, t = (int(k) for k in rng.integers(-3, 4, 2))
            x, y, w = (s * a + t * b for a, b in zip(first, second, strict=True))
            twists.append((x, y, w))
        normal = common_normal(twists, field)
        assert normal is not None
        assert any(normal)
        assert not any(inner(normal, twist) for twist in twists)
    zero, one = field.zero, field.one
    assert common_normal([(one, zero, zero), (one, one, zero), (zero, one, one)], field) is None
