"""The quasi-static limit: paths of full dynamics tend to that of rule ellipse, and to that of no other rule."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from nonsmooth.analysis.bodies.mass_path import simulate_dynamics
from nonsmooth.analysis.bodies.mass_study import MassStudy, mass_ladder, mass_study, path_distance, rule_path
from nonsmooth.analysis.bodies.path import ellipse_path
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.analysis.dynamics.newton_euler import RigidBody, disc
from nonsmooth.analysis.fields.contact_model import ContactModel, contact_model
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.thorough import few, keep, thorough

START, UNTIL = (0.2, 0.4, 0.0), 2.0
SLOPE = 0.15  # of log distance against log mass, where 1 is expected: what is left of the higher orders at m = 0.01


# The largest mass, how many there are, each a tenth of the one before, and until when they are followed.
STUDIES = {"two bodies": (0.001, 2, 0.3), "three bodies": (0.01, 3, 0.7), "three bodies for longer": (0.01, 3, 2.0)}


@pytest.fixture(scope="module", params=keep(1, STUDIES))
def study(request: pytest.FixtureRequest) -> MassStudy:
    mass, count, until = STUDIES[request.param]
    scene = load_scene("four-wheel")
    return mass_study(scene, mass_ladder(disc(contact_model(scene), mass), count), START, until)


def test_study_is_a_table_in_a_notebook(study: MassStudy) -> None:
    html = study._repr_html_()
    assert html.startswith("<table>")
    assert html.count("<tr>") == 1 + len(study.rows) * 4 + 3
    assert f"{study.rows[1].distance('ellipse').position:.3g}" in html


def test_ladder_keeps_the_shape_of_the_body() -> None:
    ladder = mass_ladder(RigidBody(0.1, 0.3), 3)
    assert [body.mass for body in ladder] == pytest.approx([0.1, 0.01, 0.001])
    assert [body.inertia / body.mass for body in ladder] == pytest.approx([3.0] * 3)


def test_distance_to_rule_ellipse_falls_like_the_mass(study: MassStudy) -> None:
    for heavy, light in pairwise(study.rows):
        for field in ("position", "rotation"):
            fall = getattr(heavy.distance("ellipse"), field) / getattr(light.distance("ellipse"), field)
            assert np.log10(fall) == pytest.approx(1, abs=SLOPE)
    assert study.rows[-1].distance("ellipse").position < 1e-3


def test_distance_to_the_other_rules_tends_to_theirs_from_ellipse(study: MassStudy) -> None:
    assert study.limits is not None
    limits = {limit.rule: limit for limit in study.limits}
    assert set(limits) == {"nearest", "box", "roller"}
    for row in study.rows:
        own = row.distance("ellipse")
        for rule, limit in limits.items():
            assert abs(row.distance(rule).position - limit.position) <= own.position
            assert abs(row.distance(rule).rotation - limit.rotation) <= own.rotation
    assert min(limit.position for limit in study.limits) > 0.1


@thorough
def test_flat_functional_puts_the_fall_off_until_the_mass_is_tiny() -> None:
    """Three wheels: the field turns around within 1e-4; the fall is that of sqrt(m) first, and that of m in the end."""
    scene = load_scene("ring-3")
    bodies = [disc(contact_model(scene), mass) for mass in (1e-4, 1e-5, 1e-8, 1e-9)]
    first, second, third, last = mass_study(scene, bodies, START, 0.15).rows
    for heavy, light, power in ((first, second, 0.5), (third, last, 1.0)):
        fall = heavy.distance("ellipse").position / light.distance("ellipse").position
        assert np.log10(fall) == pytest.approx(power, abs=SLOPE)


@pytest.mark.parametrize("until", keep(1, [0.005, 0.05, 0.5]))
def test_rules_without_a_path_are_named(until: float) -> None:
    scene = load_scene("conveyor-3")
    study = mass_study(scene, mass_ladder(disc(contact_model(scene), 0.01), 1), START, until)
    assert set(study.skipped) == {"nearest", "box"}
    assert "required a start inside the domain" in study.skipped["box"]
    assert [own.rule for own in study.rows[0].distances] == ["ellipse", "roller"]
    assert study.limits is not None
    assert [limit.rule for limit in study.limits] == ["roller"]


def test_paths_that_break_off_are_compared_while_they_last() -> None:
    scene = load_scene("outward")
    path, other = rule_path(scene, "nearest", START, UNTIL), rule_path(scene, "ellipse", START, UNTIL)
    distance = path_distance("ellipse", path, other, UNTIL)
    assert path.end.reason is EndReason.OUTSIDE
    assert distance.until == pytest.approx(float(path.end.t))
    assert distance.until < float(other.end.t) < UNTIL
    apart = np.array(path.at(distance.until), float) - np.array(other.at(distance.until))
    assert distance.position >= np.hypot(*apart[:2]) * (1 - 1e-12) > 0  # the same place, reached by other sums


def test_distance_is_that_of_known_motions() -> None:
    """Two conveyors side by side in the plane of velocities: one moves along x, one along y at twice the speed."""
    square = ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))
    along = [ContactModel.build(square, (rim,) * 4, (s,) * 4, (1.0, 1.0)) for rim, s in (((1, 0), 1.0), ((0, 1), 2.0))]
    first, second = (ellipse_path(model, (0.0, 0.0, 0.5), 0.25) for model in along)
    distance = path_distance("ellipse", first, second, 0.25)
    assert distance.position == pytest.approx(0.25 * np.sqrt(5), rel=1e-9)
    assert distance.rotation == pytest.approx(0, abs=1e-9)


@few(1)
@pytest.mark.parametrize("name", ["four-wheel", "spiral-30", "off-center"])
def test_settled_twist_is_the_minimizer_at_its_own_pose(name: str) -> None:
    """After a few settling times the velocity differs from the minimizer's by the order of the mass."""
    model = contact_model(load_scene(name))
    errors = []
    for mass in (1e-4, 1e-5):
        x, y, _, wx, wy, omega = simulate_dynamics(model, disc(model, mass), START, 0.1).states[-1]
        twist = np.array([wx + omega * y, wy - omega * x, omega])
        loads = loads_at(model, [[x, y]])
        errors.append(np.abs(twist - EllipseMinimizer().minimize(model, loads).twists[0]).max())
    assert errors[0] < 0.02
    assert errors[1] < errors[0] / 5


def test_ellipse_path_moves_with_the_minimizer_and_exact_kinematics() -> None:
    model = contact_model(load_scene("spiral-30"))
    path, step = ellipse_path(model, START, 1.0), 1e-4
    for t in (0.1, 0.5, 0.9):
        x, y, _ = path.at(t)
        ((vx, vy, omega),) = EllipseMinimizer().minimize(model, loads_at(model, [[x, y]])).twists
        rate = (np.array(path.at(t + step)) - np.array(path.at(t - step))) / (2 * step)
        assert np.allclose(rate, [vx - omega * y, vy + omega * x, omega], atol=1e-5)


def test_start_without_loads_or_time_is_refused() -> None:
    scene = load_scene("four-wheel")
    model = contact_model(scene)
    with pytest.raises(LoadError, match="the body tips there"):
        mass_study(scene, [disc(model, 0.1)], (1.5, 0.0, 0.0), 1.0)
    with pytest.raises(LoadError, match="the body tips there"):
        ellipse_path(model, (1.5, 0.0, 0.0), 1.0)
    with pytest.raises(ValueError, match="positive last time"):
        ellipse_path(model, START, 0.0)
