"""A friction set of another shape needs nothing but itself: dissipation, forces, paths and bodies with mass follow."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from nonsmooth.analysis.bodies.mass_study import body_path, rule_path
from nonsmooth.analysis.bodies.newton_euler import EllipseFriction, RigidBody
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.contact_model import contacts_under
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.analysis.minimizers.many_twists import MovingTwists
from nonsmooth.analysis.minimizers.minimum import Functional, dissipation, usage
from nonsmooth.analysis.minimizers.sum_of_supports import SupportSums, by_multipliers
from nonsmooth.proofs.answers.answers import other_rules
from nonsmooth.proofs.clauses.feedback.by_friction import decide_whatever_friction
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.friction_set import CutEllipse
from nonsmooth.symbolic.mechanics.rule import CONTACT_RULES
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.rehearsals.superellipse import Superellipse, SuperellipseRule

PLACES = np.array([[0.2, 0.4], [-0.3, 0.1], [0.05, -0.6]])


@pytest.fixture
def scene(monkeypatch: pytest.MonkeyPatch) -> Scene:
    """Four wheels under the rule, which is listed in one line."""
    monkeypatch.setitem(CONTACT_RULES, "superellipse", "tests.rehearsals.superellipse:SuperellipseRule")
    return load_scene("four-wheel").under("superellipse")


def test_the_nearest_point_moves_as_it_says() -> None:
    sets, rng = Superellipse.searched(np.ones(1)), np.random.default_rng(0)
    points, change = rng.normal(size=(2, 50)) * 2, rng.normal(size=(2, 50)) * 1e-6
    near, after = sets.nearest(*points), sets.nearest(*(points + change))
    np.testing.assert_allclose(after.force - near.force, near.along(change), atol=1e-10)


@pytest.mark.parametrize("seed", range(4))
def test_multipliers_find_the_least_sum(seed: int) -> None:
    """Against a general minimizer that knows the sum alone; the proof is that of any other set."""
    rng, sets = np.random.default_rng(seed), Superellipse.searched(np.ones(5))
    maps, targets, weights = rng.normal(size=(5, 2, 3)), rng.normal(size=(2, 5, 1)), rng.dirichlet(np.ones(5), 2).T
    sums = SupportSums(weights, maps, targets, sets)
    found = by_multipliers(sums, np.zeros((3, 2)), np.zeros((2, 5, 2)), np.full(2, 10.0))
    values, _, lacks, _ = sums.judge(sums.slips(found.y), found.forces)
    assert lacks.max() < 1e-12
    for k in range(2):

        def value(y: Floats, k: int = k) -> float:
            slips = np.einsum("nij,j->in", maps, y) - targets[..., 0]
            return float((weights[:, k] * sets.support(*slips[..., None])[:, 0]).sum())

        other = minimize(value, rng.normal(size=3), method="Nelder-Mead", options={"xatol": 1e-7, "fatol": 1e-11})
        assert values[k] == pytest.approx(value(found.y[:, k]), abs=1e-14)
        assert values[k] <= other.fun + 1e-12
        assert values[k] >= other.fun - 1e-4


def test_minima_are_proved_by_their_forces(scene: Scene) -> None:
    """Of the dissipation written anew: the fourth norm's dual, wheel by wheel."""
    minima = minima_under(SuperellipseRule(), scene, PLACES)
    assert minima.check().all()
    model = minima.model
    slips = np.abs(model.slips(minima.twists) * model.friction.reshape(-1, 2)) ** (4 / 3)
    losses = (minima.loads * slips.sum(axis=2) ** 0.75).sum(axis=1)
    np.testing.assert_allclose(minima.values, losses, rtol=1e-12)
    used = ((minima.forces / model.limits(minima.loads)) ** 4).sum(axis=2) ** 0.25
    np.testing.assert_allclose(usage(Functional.ELLIPSE, model, minima.loads, minima.forces), used, atol=1e-12)
    beside = minima.twists + 1e-3 * np.random.default_rng(1).normal(size=(20, 1, 3))
    assert (dissipation(Functional.ELLIPSE, model, minima.loads, beside) > minima.values).all()


def test_bodies_with_mass_follow_its_forces(scene: Scene) -> None:
    """The Jacobian by differences, and a light body on the path of the rule, away from that of the ellipse."""
    model = contacts_under(SuperellipseRule(), scene)
    friction, loads, moves = EllipseFriction(model, 1e-3), np.full(4, 0.25), np.eye(3) * 1e-6
    centre, velocity = np.array([0.1, 0.2]), np.array([0.3, -0.2, 0.4])
    slopes = friction.slopes(centre, velocity, loads, np.zeros((4, 2)))[1]
    ahead = [
        friction.total(centre, velocity + move, loads) - friction.total(centre, velocity - move, loads)
        for move in moves
    ]
    np.testing.assert_allclose(slopes, np.array(ahead).T / 2e-6, rtol=1e-5, atol=1e-6)
    start, until = (0.2, 0.4, 0.0), 0.07
    path, ellipse = (rule_path(scene, rule, start, until).end.state for rule in ("superellipse", "ellipse"))
    light = body_path(scene, RigidBody(1e-4, 1e-4), start, until).trajectory.end.state
    off, apart = (float(np.hypot(*np.subtract(path, other)[:2])) for other in (light, ellipse))
    assert off < apart / 10


def test_methods_of_ellipses_alone_refuse_it(scene: Scene) -> None:
    with pytest.raises(ValueError, match="required friction ellipses, cut or whole, received Superellipse"):
        MovingTwists(contacts_under(SuperellipseRule(), scene), 1)


def test_nothing_is_proved_of_a_shape_that_floats_alone_know(scene: Scene) -> None:
    with pytest.raises(RefusalError, match="received Superellipse: nothing is proved of it"):
        check_theorem4(scene)
    with pytest.raises(RefusalError):
        decide_whatever_friction(scene)
    (row,) = [other for other in other_rules(load_scene("four-wheel")) if other.name == "superellipse"]
    assert not row.answers
    assert "nothing is proved" in row.why_not


def test_a_shape_is_not_proved_as_an_ellipse_by_mistake() -> None:
    with pytest.raises(TypeError, match="required piece, gradient, bend and holds_strictly of Larger"):

        class Larger(CutEllipse[float]):
            def support(self, r: float, s: float) -> float:
                return 2 * super().support(r, s)
