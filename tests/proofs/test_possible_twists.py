"""Motions that unknown loads leave possible under rule ``box``, against minimizers and programs in floats."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.cells.polygon import convex_polygon
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.proofs.clauses.at_point.possible_twists import PossibleTwist, possible_twists
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_states import rows_with_friction
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.oracles.floats import Floats
from tests.oracles.wheels_in_floats import places_of

BESIDE = 1e-4  # of a side


def is_possible(scene: Scene, twist: PossibleTwist, place: Floats) -> bool:
    """Whether loads and friction forces balance: a linear program over loads and forces, row by row."""
    from scipy.optimize import linprog

    rows, count = list(rows_with_friction(scene)), len(scene.wheels)
    moments = np.array([[1.0, *map(float, wheel.position)] for wheel in scene.wheels])
    normals = np.array([[float(x) / float(row.wheel.length) for x in row.normal] for row in rows])
    balance = np.block([[moments.T, np.zeros((3, len(rows)))], [np.zeros((3, count)), normals.T]])
    limits = []
    for k, row in enumerate(rows):
        side = row.residual(twist.state.twist).sign()
        for sign in (1, -1):
            line = np.zeros(count + len(rows))
            line[scene.places[row.wheel.index]] = -float(row.friction) * (sign * side if side else 1)
            line[count + k] = sign
            limits.append(line)
    bounds = [(0, None)] * count + [(None, None)] * len(rows)
    solution = linprog(
        np.zeros(count + len(rows)), limits, np.zeros(len(limits)), balance, [1, *place, 0, 0, 0], bounds=bounds
    )
    return bool(solution.status == 0)


def test_with_three_wheels_the_areas_are_the_cells_of_the_one_load() -> None:
    scene = load_scene("ring-3", rule="box")
    areas = [each for each in possible_twists(scene) if len(each.corners) > 2]
    whole = convex_polygon([wheel.position for wheel in scene.wheels])
    assert sum((convex_polygon(each.corners).area for each in areas), whole.area * 0) == whole.area
    for cell in build_box_partition(replace(scene, check=replace(scene.check, radius=scene.check.radius / 4))).cells:
        (match,) = [each for each in areas if each.state.twist == cell.states[0].twist]
        assert all(match.holds(corner) for corner in cell.polygon.vertices)


def test_minimizers_under_random_loads_are_possible_where_they_are() -> None:
    scene = load_scene("four-wheel", rule="box")
    twists, rng = possible_twists(scene), np.random.default_rng(3)
    model, places = contact_model(scene), places_of(scene)
    loads = rng.dirichlet(np.full(4, 0.6), 60)
    minimizers = BoxHighs().minimize(model, loads).twists
    vectors = np.array([[float(x) for x in each.state.twist] for each in twists])
    hits = 0
    for load, twist in zip(loads, minimizers, strict=True):
        near = np.flatnonzero(np.abs(vectors - twist).max(axis=1) < 1e-6)
        if len(near):  # else a mean of several, where the minimizer is not unique
            field, centre = scene.field, load @ places
            x, y = (field.zero + round(float(entry) * 2**40) for entry in centre)
            assert twists[int(near[0])].holds((x / 2**40, y / 2**40))
            hits += 1
    assert hits > 50


def test_areas_end_where_forces_no_longer_balance() -> None:
    scene = load_scene("four-wheel", rule="box")
    wheels = convex_polygon([wheel.position for wheel in scene.wheels])
    for each in possible_twists(scene):
        corners = np.array([[float(x) for x in corner] for corner in each.corners])
        middle = corners.mean(axis=0)
        assert is_possible(scene, each, middle)
        for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            inside, outside = ((a + b) / 2 * (1 - s) + s * middle for s in (BESIDE, -BESIDE))
            assert is_possible(scene, each, inside)
            exact = tuple(scene.field.zero + round(float(x) * 2**30) for x in outside)
            if wheels.contains((exact[0] / 2**30, exact[1] / 2**30)):
                assert not is_possible(scene, each, outside)


def test_many_wheels_are_refused() -> None:
    with pytest.raises(RefusalError, match="required at most 1000 triples of rows"):
        possible_twists(load_scene("grid-4x4", rule="box"))
