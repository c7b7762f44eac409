from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.filippov import cell_derivatives
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.proofs.clauses.every_load.cocircular import cocircular_array, failed_hypotheses
from nonsmooth.symbolic.mechanics.scene import Contact, LoadTable, Scene
from tests.conftest import Arrays


def inward_array(arrays: Arrays, seed: int) -> Scene:
    """Inward rims at random rational points of one circle, random positive speeds, random mu_S per wheel."""
    rng = np.random.default_rng(seed)
    parameters = {Fraction(int(a), int(b)) for a, b in rng.integers([-9, 1], [10, 6], (int(rng.integers(3, 7)), 2))}
    wheels = []
    for x, y in sorted({arrays.circle_point(t) for t in parameters} | {(Fraction(-1), Fraction(0))}):
        speed = Fraction(int(rng.integers(1, 5)), 2)
        (wheel,) = arrays.inward([(x, y)], speed=speed)
        wheels.append(wheel._replace(friction=(1, Fraction(int(rng.integers(1, 30)), 10))))
    return replace(arrays.scene(wheels, radius=Fraction(1, 16)), contact=Contact("box"))


@pytest.mark.parametrize("seed", range(60))
def test_the_lemma_holds_on_every_cell_of_random_inward_arrays(arrays: Arrays, seed: int) -> None:
    scene = inward_array(arrays, seed)
    try:
        partition = build_box_partition(scene)
    except LoadError:
        return  # the support polygon does not hold the square
    lemma = cocircular_array(scene)
    assert lemma is not None
    assert all(derivative.largest[0].sign() <= 0 for derivative in cell_derivatives(partition))


def test_most_random_arrays_support_the_body(arrays: Arrays) -> None:
    """The test above is no empty promise."""
    supported = 0
    for seed in range(60):
        try:
            build_box_partition(inward_array(arrays, seed))
            supported += 1
        except LoadError:
            pass
    assert supported >= 20


def test_each_hypothesis_is_needed_and_named(arrays: Arrays) -> None:
    scene = replace(arrays.four_wheel(), contact=Contact("box"))
    assert failed_hypotheses(scene) == []
    first, *rest = scene.wheels
    field = scene.field
    cases = {
        "rule nearest": replace(scene, contact=Contact("nearest")),
        "one circle": replace(scene, wheels=(replace(first, position=(field(2), field(2))), *rest)),
        "inward": replace(scene, wheels=(replace(first, direction=(field(1), field(1))), *rest)),
        "speed": replace(scene, wheels=(replace(first, given_speed=field(-1)), *rest)),
        "mu_roll": replace(scene, wheels=(replace(first, friction=replace(first.friction, roll=field(2))), *rest)),
        "moments": replace(scene, contact=Contact("box", LoadTable(((field.one / 4, field.zero, field.zero),) * 4))),
    }
    for word, changed in cases.items():
        (reason,) = failed_hypotheses(changed)
        assert word in reason
        assert cocircular_array(changed) is None


def test_a_table_that_balances_moments_is_accepted(arrays: Arrays) -> None:
    scene = arrays.four_wheel()
    quarter = scene.field.one / 4
    rows = tuple((quarter, w.position[0] * quarter, w.position[1] * quarter) for w in scene.wheels)
    assert cocircular_array(replace(scene, contact=Contact("ellipse", LoadTable(rows)))) is not None
