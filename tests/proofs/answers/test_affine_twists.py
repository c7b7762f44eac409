"""The twist over small polygons, to first order, and what it shows of slow spirals, against another minimizer."""

from __future__ import annotations

import math
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nonsmooth.proofs.boxes.balanced_forces import BalancedForces
from nonsmooth.proofs.boxes.enclosed_rest import enclosed_rest
from nonsmooth.proofs.boxes.intervals import Intervals
from nonsmooth.proofs.robust import touching_rings
from nonsmooth.proofs.robust.ends import COARSE, _field_beside, _velocity
from nonsmooth.proofs.robust.level_sets import (
    Distance,
    LevelFunction,
    RingPieces,
    SectorFunction,
    shapes_about,
    short_levels,
)
from nonsmooth.proofs.robust.rest_points import _affine_twists, _rising, affine_rates, is_carried_away, refined_rates
from nonsmooth.proofs.robust.touching_rings import FINER, FINEST, FIRST_PIECES, least_rate, piece_rates
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.friction_set import CutEllipse
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.oracles.measured_tables import MeasuredTable, SmallSteps
from tests.thorough import thorough

LEVELS = short_levels(np.array([0.3, 0.275]), 16)  # mm: on these tables motions change fast
SHAPES = (Distance(), SectorFunction.of_ellipse(np.array([[2.0, 0.5], [0.5, 1.0]]), 64))
NEWTON = 2e-4  # of the fastest rim: what small steps round away


def measured(folder: Path, table: MeasuredTable) -> Scene:
    file = folder / "table.toml"
    file.write_text(table.toml, encoding="utf-8")
    return load_scene(str(file)).recentred()


@pytest.mark.parametrize(("seed", "rule"), [(1, "ellipse"), (2, "ellipse"), (0, "roller"), (1, "roller")])
def test_twists_are_those_of_an_independent_minimizer(seed: int, rule: str, tmp_path: Path) -> None:
    table = MeasuredTable.random(seed, rule, off=9.0)
    forces, body, rng = BalancedForces(measured(tmp_path, table)), SmallSteps(table), np.random.default_rng(seed)
    pieces = SHAPES[1].pieces(LEVELS[1:], LEVELS[:1])
    free = forces.minimizers(pieces.middles)
    found = _affine_twists(forces, pieces, free)
    assert found is not None
    middle, by_place, rest, is_enclosed = found
    assert is_enclosed.mean() > 0.5
    shares = rng.dirichlet(np.ones(4), len(pieces.corners))
    places = (shares[:, :, None] * pieces.corners).sum(axis=1)
    away, slack = places - pieces.middles, NEWTON * body.speeds.max()
    twists = body.twists(places)
    for ends, sign in (("low", 1), ("high", -1)):
        slope = getattr(by_place, ends)
        bound = getattr(middle, ends) + (slope * away[:, None]).sum(axis=2) + getattr(rest, ends)
        assert (sign * (twists - bound)[is_enclosed] >= -slack).all()
    assert (rest.high - rest.low)[is_enclosed].max() < 0.2 * np.abs(by_place.low).max() * LEVELS[0]


@pytest.mark.parametrize("shape", SHAPES)
def test_rates_bound_how_fast_small_steps_fall(shape: LevelFunction, tmp_path: Path) -> None:
    """At random places of quadrangles and of their halves, for V and for -V."""
    table = MeasuredTable.random(1, "ellipse", off=9.0)
    forces, body, rng = BalancedForces(measured(tmp_path, table)), SmallSteps(table), np.random.default_rng(0)
    for turned in (False, True):
        pieces = shape.pieces(LEVELS[1:], LEVELS[:1])
        pieces = pieces.turned if turned else pieces
        pieces = pieces.halves[0]
        free = forces.minimizers(pieces.middles)
        rates = affine_rates(forces, pieces, free)
        shares = rng.dirichlet(np.ones(4), len(rates))
        places = (shares[:, :, None] * pieces.corners).sum(axis=1)
        slopes = np.stack([(shares * slope.middle).sum(axis=1) for slope in pieces.slopes], axis=1)
        sizes = np.hypot(*places.T) if isinstance(shape, Distance) else np.ones(len(places))
        falls = -(slopes * body.velocity(places)).sum(axis=1) / sizes
        known = np.isfinite(rates)
        assert (rates[known] <= falls[known] + NEWTON * body.speeds.max()).all()
        assert known.any()  # the point is not where bodies rest: they come nearer, or go away


def test_halves_cover_quadrangles_exactly() -> None:
    levels = short_levels(np.array([3.0, 2.0]), 16)
    pieces = SHAPES[1].pieces(levels[1:], levels[:1])
    area, halves, is_exact = _areas(pieces.corners).sum(), pieces, np.array(True)
    for _ in range(4):
        halves, is_exact = halves.halves
        assert is_exact.all()
        assert _areas(halves.corners).min() > 0
        assert _areas(halves.corners).sum() == pytest.approx(area, rel=1e-14)
    longest = SHAPES[1].pieces(np.array([math.pi]), np.array([math.pi * 1.1])).halves
    assert not longest[1].all()  # no bits to spare: levels of 53 bits


def _areas(corners: np.ndarray) -> np.ndarray:
    first, second = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    return np.asarray(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / 2


def test_forces_and_bends_of_intervals_hold_those_of_the_slips_inside() -> None:
    rng = np.random.default_rng(0)
    cuts = np.where(rng.random(400) < 0.3, 1.0, rng.uniform(0.1, 0.9, 400))
    low = rng.uniform(-1, 1, (2, 400))
    r, s = (Intervals(entry, entry + rng.uniform(0, 0.5, 400)) for entry in low)
    exact: CutEllipse[Any] = CutEllipse(0.8, 0.5, cuts)
    enclosed: CutEllipse[Any] = CutEllipse(*(Intervals.of(x) for x in (0.8, 0.5, cuts)))
    with np.errstate(all="ignore"):
        bounds = [*enclosed.gradient(r, s), enclosed.bend(r, s)]
        for _ in range(50):
            inside = [entry.low + rng.random(400) * (entry.high - entry.low) for entry in (r, s)]
            (along, across), bend = exact.gradient(*inside), exact.bend(*inside)
            for bound, value in zip(bounds, (along, across, bend), strict=True):
                assert ((bound.low <= value) & (value <= bound.high)).all()
    # where a wheel may stick, or rollers turn while the rim may not slip, no number bounds the bend
    sticks = np.where(cuts == 1, r.holds_zero & s.holds_zero, r.holds_zero)
    assert not np.isfinite(bounds[2].high)[sticks].any()
    whole = (cuts == 1) & r.holds_zero & ~s.holds_zero
    assert whole.any()
    assert np.isfinite(bounds[2].high)[whole].all()


def test_rings_of_a_slow_spiral_are_shown_to_rise(tmp_path: Path) -> None:
    """It turns forty times as fast as it grows: forces that balance a pull show nothing of that."""
    table = MeasuredTable.symmetric(6, "ellipse")
    scene = measured(tmp_path, table)
    rest, forces, body = enclosed_rest(scene), BalancedForces(scene), SmallSteps(table)
    assert rest is not None
    slope = np.array([float(entry) for entry in rest.slope.entries()]).reshape(2, 2)
    shape = next(_rising(slope))
    assert isinstance(shape, SectorFunction)
    levels = short_levels(float(scene.accuracy) / 8 * np.array([1.0, 0.9]), 16)
    pieces = shape.pieces(levels[1:], levels[:1]).turned
    (rate,) = refined_rates(forces, pieces)
    rises = (-pieces.middle_slopes * body.velocity(pieces.middles)).sum(axis=1)
    assert 0 < rate <= rises.min() * 1.001


@thorough  # the small one: the ring before
def test_a_slow_spiral_carries_bodies_out_of_the_disc_of_the_accuracy(tmp_path: Path) -> None:
    table = MeasuredTable.symmetric(6, "ellipse")
    scene = measured(tmp_path, table)
    assert is_carried_away(scene, scene.accuracy, Fraction(1, 10**9))
    accuracy = float(scene.accuracy)
    assert SmallSteps(table).end(np.array([0.9 * accuracy, 0.0]), 60.0, accuracy)[1] > accuracy


def test_rings_fall_in_small_pieces_where_twists_turn_round_over_an_edge(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    table = MeasuredTable.symmetric(19, "roller")
    scene = measured(tmp_path, table)
    accuracy, forces, velocity = float(scene.accuracy), BalancedForces(scene), _velocity(scene)
    assert velocity is not None
    _, coarse = _field_beside(velocity, np.zeros(2), COARSE * accuracy)
    shape = list(shapes_about(coarse))[1]
    outer = accuracy * 0.9
    levels = short_levels(np.geomspace(outer, 0.8 * outer, FINEST[0] + 1))[:2]
    pieces = shape.pieces(levels[1:], levels[:1], FINEST[0])
    rate = least_rate(forces, pieces)
    falls = -(pieces.middle_slopes * SmallSteps(table).velocity(pieces.middles)).sum(axis=1)
    assert 0 < rate <= falls.min() * 1.001
    seen: list[int] = []

    def counted(forces: BalancedForces, pieces: RingPieces, *args: Any, more: bool) -> Any:
        seen.append(len(pieces.corners))
        return piece_rates(forces, pieces, *args, more=more)

    monkeypatch.setattr(touching_rings, "piece_rates", counted)
    assert least_rate(forces, shape.pieces(levels[1:], levels[:1], FINER[-1])) == 0
    assert seen == [FIRST_PIECES[0]], "where the slowest fail, the others need no look"
