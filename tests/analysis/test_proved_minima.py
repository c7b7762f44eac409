"""Rule ``ellipse`` without friction across the rims: only what forces prove is shown as a number.

With ``mu_S = 0`` the functional of rule ``ellipse`` is ``sum N_i mu_R |r_i|``, that of rule ``box``: the exact cells of
that rule say what the motion is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy as np
import pytest

from nonsmooth.analysis.bodies.path import ellipse_path
from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.fields.contact_model import ContactRows, contact_model
from nonsmooth.analysis.measurements.studies import ellipse_references
from nonsmooth.analysis.minimizers.agreement import compare_rules
from nonsmooth.analysis.minimizers.dissipation import Functional, dissipation
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.minimum import Minima, free_motions, minima_without_proof, proved
from nonsmooth.analysis.minimizers.point_location import PointLocator
from nonsmooth.analysis.minimizers.sampling import SampledLaw, sample_smooth_derivative
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.proofs.clauses.feedback.sampled_laws import with_samples
from nonsmooth.proofs.theorem4 import check_smooth
from nonsmooth.proofs.theorem4_result import SmoothCheck
from nonsmooth.symbolic.mechanics.scene import Contact, Scene
from tests.conftest import Arrays, Pair, WheelData
from tests.thorough import few

FREE_ROLLERS: Pair = (1, 0)
FAST = 1e3  # no array here has a speed above 3 at a distance below 1: a rate above that is no motion
TURNED: Pair = (Fraction(3, 5), Fraction(4, 5))


def under_ellipse(scene: Scene) -> Scene:
    return replace(scene, contact=Contact("ellipse"))


def omniwheels(arrays: Arrays) -> Scene:
    """Three tangential rims: the wheels carry the body around without any slip, D = 0."""
    positions: list[Pair] = [(1, 0), (Fraction(-3, 5), Fraction(4, 5)), (Fraction(-3, 5), Fraction(-4, 5))]
    wheels = [WheelData((x, y), (-y, x)) for x, y in positions]
    return under_ellipse(arrays.scene(wheels, FREE_ROLLERS, radius=Fraction(1, 10)))


def turned_rims(arrays: Arrays, count: int = 6) -> Scene:
    """Rims turned by one angle from the centre, on the unit circle."""
    (c, s), wheels = TURNED, []
    for t in (Fraction(0), Fraction(1, 3), Fraction(3, 2), Fraction(-4), Fraction(-2, 3), Fraction(-1, 5))[:count]:
        x, y = arrays.circle_point(t)
        wheels.append(WheelData((x, y), (s * y - c * x, -s * x - c * y)))
    return under_ellipse(arrays.scene(wheels, FREE_ROLLERS, radius=Fraction(1, 10)))


def inward_rims(arrays: Arrays) -> Scene:
    """Nothing resists the rotation about the centre."""
    return under_ellipse(arrays.four_wheel(FREE_ROLLERS))


@pytest.mark.parametrize("build", [omniwheels, turned_rims])
def test_every_minimum_is_proved_and_right(arrays: Arrays, build: object) -> None:
    scene = build(arrays)  # type: ignore[operator]
    model = contact_model(scene)
    points = np.random.default_rng(0).uniform(-0.1, 0.1, (300, 2))
    minima = EllipseMinimizer().minimize(model, loads_at(model, points))
    assert proved(minima).all()
    boxed = replace(scene, contact=Contact("box"))
    exact = PointLocator(build_box_partition(boxed)).twists(points)
    value = dissipation(Functional.BOX, model, minima.loads, exact)
    assert minima.values == pytest.approx(value, abs=1e-9)


@cache
def checked(build: Callable[[Arrays], Scene]) -> SmoothCheck:
    """What several tests look at."""
    return check_smooth(build(Arrays()), prune=False)


@few(1)
@pytest.mark.parametrize("build", [inward_rims, omniwheels, turned_rims])
def test_no_sampled_rate_is_beyond_what_a_body_can_do(build: Callable[[Arrays], Scene]) -> None:
    result = checked(build)
    assert result.check()
    sampled = result.translation.sampled
    assert sampled is not None
    assert sampled.largest_relative is None or abs(sampled.largest_relative) < FAST
    for sample in result.feedback.samples:
        assert sample.worst_rate is None or abs(sample.worst_rate) < FAST


def test_free_motions_are_named_instead_of_numbers(arrays: Arrays) -> None:
    scene = inward_rims(arrays)
    assert free_motions(scene) == "no row with friction resists the motion xi = (0, 0, 1)"
    sampled = sample_smooth_derivative(scene, 100)
    assert (sampled.samples, sampled.largest, sampled.largest_relative, sampled.at) == (0, None, None, None)
    assert sampled.not_certified == free_motions(scene)
    for sample in with_samples(checked(inward_rims).feedback, scene).samples:
        assert (sample.states, sample.worst_rate, sample.worst_state, sample.fails) == (0, None, None, None)
        assert sample.not_certified == free_motions(scene)


def test_two_free_motions(arrays: Arrays) -> None:
    """Parallel rims on one line: neither the translation across nor the rotation is resisted."""
    scene = arrays.scene([WheelData((x, 0), (1, 0)) for x in (-1, 0, 1)], FREE_ROLLERS)
    assert free_motions(scene) == "no row with friction resists the motions xi = (0, 0, 1), (0, 1, 0)"
    for motion in ((0, 0, 1), (0, 1, 0)):
        assert not any(np.array(motion) @ row for row in contact_model(scene).rows[::2])


def test_minima_without_proof_do_not_count(arrays: Arrays, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every other answer spoiled: half of them are left, and the sentence says so."""
    honest = EllipseMinimizer.minimize

    def spoilt(self: EllipseMinimizer, model: ContactRows, loads: object) -> Minima:
        found = honest(self, model, loads)  # type: ignore[arg-type]
        twists = found.twists.copy()
        twists[::2] *= 1e200
        return replace(found, twists=twists)

    monkeypatch.setattr(EllipseMinimizer, "minimize", spoilt)
    scene = under_ellipse(arrays.four_wheel())
    with np.errstate(over="ignore", invalid="ignore"):
        sampled = sample_smooth_derivative(scene, 100)
        agreement = compare_rules(scene)
    assert sampled.samples == 50
    assert sampled.largest_relative is not None
    assert abs(sampled.largest_relative) < FAST
    assert sampled.not_certified == "50 of 100 minima without proof"
    assert agreement.differences["ellipse", "box"].points == 800
    assert agreement.differences["ellipse", "box"].not_certified == "800 of 1600 minima without proof"
    assert agreement.differences["ellipse", "box"].largest is not None
    assert agreement.differences["ellipse", "box"].largest <= 2


def test_no_sentence_where_nothing_is_missing() -> None:
    assert minima_without_proof(np.array([True, True])) == ""


def test_own_speeds_at_every_point(arrays: Arrays) -> None:
    """Speeds by point: the same minima as one model after the other, and proofs against the point's own speeds."""
    model = contact_model(under_ellipse(arrays.four_wheel()))
    rng = np.random.default_rng(1)
    points = rng.uniform(-0.4, 0.4, (20, 2))
    targets = np.zeros((20, 8))
    targets[:, ::2] = rng.uniform(-1, 1, (20, 4))
    loads = loads_at(model, points)
    together = EllipseMinimizer().minimize(ContactRows(model.rows, targets, model.friction), loads)
    assert proved(together).all()
    for k in range(20):
        alone = EllipseMinimizer().minimize(replace(model, targets=targets[k]), loads[k])
        assert together.twists[k] == pytest.approx(alone.twists[0], abs=1e-12)
        assert together[k].check()
    forged = replace(together, model=ContactRows(model.rows, targets[::-1], model.friction))
    assert not proved(forged).any()


def test_paths_of_unproved_motions_end_in_words(arrays: Arrays) -> None:
    with pytest.raises(TrajectoryError, match=r"a minimum without proof at \(0.02, 0.01\)"):
        ellipse_path(contact_model(inward_rims(arrays)), (0.02, 0.01, 0.0), 0.1)


def test_references_leave_out_kinks(arrays: Arrays) -> None:
    """Without friction across the rims D has no curvature along them: Newton's method has nothing to solve."""
    assert ellipse_references(turned_rims(arrays)) == ()


def test_laws_are_listed_best_first_and_unknown_last(arrays: Arrays) -> None:
    scene = under_ellipse(arrays.four_wheel())
    samples = with_samples(check_smooth(scene).feedback, scene).samples
    assert {sample.law for sample in samples} == set(SampledLaw)
    rates = [sample.worst_rate for sample in samples]
    assert all(rate is not None for rate in rates)
    assert rates == sorted(rates)  # type: ignore[type-var]
