"""Pushed bodies: Mason's voting theorem as an oracle, the measured pushes, and fitted limit surfaces."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from nonsmooth.symbolic.numbers.plane_arrays import Floats, turned
from tests.evidence.limit_surfaces import exponents, fit_surface, monomials
from tests.evidence.pushed_body import Contacts, Push, Tip, masons_vote, push, random_push
from tests.evidence.pushes import (
    DATA,
    MODELS,
    SUPPORTS,
    Direction,
    angles,
    gap,
    load_pushes,
    median_interval,
    rank,
    supports,
)
from tests.thorough import few, keep, thorough

BODIES = 60  # random pushes
CLOSE = 1e-6


# ---- a pusher with a velocity --------------------------------------------------------------------


@pytest.mark.parametrize("bodies", keep(1, [20, BODIES]))
def test_the_sense_of_rotation_is_that_of_masons_votes(bodies: int) -> None:
    rng, tips = np.random.default_rng(1986), set[Tip]()
    for _ in range(bodies):
        contacts, tip = random_push(rng)
        found = push(contacts, *tip)
        assert np.sign(found.twist[2]) == masons_vote(*tip)
        tips.add(found.tip)
    assert tips == {Tip.STICKS, Tip.SLIDES}


@thorough  # the small one: test_the_sense_of_rotation_is_that_of_masons_votes
def test_contact_and_balance_hold_and_friction_opposes_the_slip() -> None:
    rng = np.random.default_rng(2)
    for _ in range(BODIES):
        contacts, (point, normal, velocity, friction) = random_push(rng)
        found = push(contacts, point, normal, velocity, friction)
        slip = velocity - found.twist[:2] - found.twist[2] * turned(point)  # of the tip over the body
        assert slip @ normal == pytest.approx(0, abs=CLOSE)
        along, across = found.force @ normal, found.force @ turned(normal)
        if found.tip is Tip.STICKS:
            assert slip == pytest.approx(np.zeros(2), abs=CLOSE)
            assert abs(across) <= friction * along * (1 + CLOSE)
        else:
            assert abs(across) == pytest.approx(friction * along)
            assert across * (slip @ turned(normal)) > 0
        assert_balanced(contacts, found, point)


def assert_balanced(contacts: Contacts, found: Push, point: Floats) -> None:
    """Friction of the moving supports balances the push; one about which the body turns takes up to its limit."""
    speeds = np.linalg.norm(contacts.velocities(found.twist[None])[0], axis=1)
    moving = speeds > CLOSE * speeds.max()
    sliding = Contacts(contacts.points, np.where(moving, contacts.loads, 0.0), contacts.shape)
    moment = point[0] * found.force[1] - point[1] * found.force[0]
    left = np.array([*found.force, moment]) - sliding.wrenches(found.twist[None])[0]
    if moving.all():
        assert left == pytest.approx(np.zeros(3), abs=CLOSE)
        return
    (pivot,) = contacts.points[~moving]
    assert left[2] == pytest.approx(pivot[0] * left[1] - pivot[1] * left[0], abs=CLOSE)
    assert np.hypot(*left[:2]) <= contacts.loads[~moving][0] * (1 + CLOSE)


def test_a_literal_search_finds_the_motion_of_a_wrench() -> None:
    """Least D over motions of power one, by a simplex search in the plane of these motions."""
    rng = np.random.default_rng(3)
    for _ in range(5):
        contacts, _ = random_push(rng)
        wrench = rng.normal(size=3)
        base, plane = wrench / (wrench @ wrench), np.linalg.svd(wrench[None])[2][1:]
        options = {"xatol": 1e-10, "fatol": 1e-14, "maxiter": 2000}

        def dissipation(y: Floats, contacts: Contacts = contacts, base: Floats = base, plane: Floats = plane) -> float:
            return float(contacts.dissipation((base + y @ plane)[None])[0])

        found = minimize(dissipation, np.zeros(2), method="Nelder-Mead", options=options).x
        assert contacts.twist_of(wrench) == pytest.approx(base + found @ plane, abs=1e-4)


def test_a_tip_that_leaves_moves_nothing() -> None:
    body = Contacts.isotropic(np.array([[1.0, 0], [-1, 1], [-1, -1]]), np.array([0.5, 0.25, 0.25]))
    found = push(body, np.array([0.0, 1]), np.array([0.0, -1]), np.array([1, 0.5]), 0.0)
    assert found.tip is Tip.LEAVES
    assert not found.twist.any()


def test_a_push_through_the_middle_does_not_turn_a_symmetric_body() -> None:
    body = Contacts.isotropic(np.array([[1.0, 1], [-1, 1], [-1, -1], [1, -1]]), np.full(4, 0.25))
    found = push(body, np.array([-1.0, 0]), np.array([1.0, 0]), np.array([0.5, 0]), 0.0)
    assert found.twist == pytest.approx([0.5, 0, 0], abs=CLOSE)
    assert found.force == pytest.approx([1, 0], abs=CLOSE)
    assert body.wrenches(np.array([[1.0, 0, 0]]))[0] == pytest.approx([1, 0, 0])


# ---- the measured pushes -------------------------------------------------------------------------


def test_the_table_holds_eight_logs_of_fifty_pushes_and_says_where_it_is_from() -> None:
    assert [(log.surface, log.support_set, len(log.motions)) for log in load_pushes()] == [
        (surface, number, 50) for surface in ("plywood", "hardboard") for number in SUPPORTS
    ]
    page = (DATA / "README.md").read_text(encoding="utf-8")
    assert all(word in page for word in ("1602.06056", "robinzhoucmu/Pushing", "Apache", "Changes"))


@pytest.mark.parametrize("number", SUPPORTS)
def test_supports_carry_the_block(number: int) -> None:
    block = supports(number)
    assert block.loads.sum() == pytest.approx(1)
    assert block.loads @ block.points == pytest.approx(np.zeros(2), abs=1e-12)
    assert block.loads.min() > 0


def test_wrenches_of_all_pushes_with_nothing_fitted() -> None:
    """The figures of the evidence page; an independent first try gave a median of 10.9 and a mean of 16.0."""
    naive, isotropic = (rank(Direction.WRENCH, [model])[0] for model in MODELS[:2])
    assert len(isotropic.errors) == 400
    assert round(isotropic.median, 1) == 10.9
    assert round(float(isotropic.errors.mean()), 1) == 16.0
    per_log = np.median(naive.errors.reshape(8, 50), axis=1)
    assert (round(per_log.min()), round(per_log.max())) == (12, 47)
    assert gap(isotropic, naive)[0] > 0
    assert isotropic.interval[0] < isotropic.median < isotropic.interval[1] < naive.interval[0]


@few(1)
@pytest.mark.parametrize("name", ["ellipse", "ellipsoid", "quartic"])
def test_fitted_models_are_judged_on_pushes_that_they_have_not_seen(name: str) -> None:
    """With wrenches that were dealt to the wrong pushes a fit sees no more than a guess does."""
    model = next(model for model in MODELS if model.name == name)
    log = load_pushes()[3]
    assert rank(Direction.WRENCH, [model], [log])[0].median < 25
    dealt = np.random.default_rng(4).permutation(50)
    mixed = log._replace(wrenches=log.wrenches[dealt])
    assert rank(Direction.WRENCH, [model], [mixed])[0].median > 50


@pytest.mark.parametrize(("degree", "pushes"), keep(2, [(2, 20), (4, 20), (2, 60), (4, 60)]))
def test_a_limit_surface_is_recovered_from_its_own_pushes(degree: int, pushes: int) -> None:
    """Wrenches and normals of an ellipsoid are fitted by it; of degree 4 its square is."""
    rng = np.random.default_rng(5)
    shape = np.diag([1.0, 2.0, 0.5])
    wrenches = rng.normal(size=(pushes, 3))
    wrenches /= np.sqrt(np.einsum("ni,ij,nj->n", wrenches, shape, wrenches))[:, None]
    motions = wrenches @ shape
    surface = fit_surface(degree, motions, wrenches)
    assert angles(surface.gradients(wrenches), motions).max() < 0.1
    assert angles(surface.wrenches(motions), wrenches).max() < 0.5
    assert np.linalg.eigvalsh(surface.hessians(rng.normal(size=(200, 3)))).min() > -1e-6


def test_monomials_and_their_number() -> None:
    assert [len(exponents(degree)) for degree in (2, 4)] == [6, 15]
    assert monomials(2, np.array([[2.0, 3.0, 5.0]]))[0].tolist() == [4, 6, 10, 9, 15, 25]


def test_motion_of_a_wrench_is_the_inverse_of_the_wrench_of_a_motion() -> None:
    log = load_pushes()[0]
    contacts = supports(1)
    motions = log.motions[:5]
    back = np.array([contacts.twist_of(wrench) for wrench in contacts.wrenches(motions)])
    assert angles(back, motions).max() < 1e-3


def test_the_interval_of_a_median() -> None:
    low, high = median_interval(np.arange(101.0))
    assert 35 < low < 50 < high < 65
