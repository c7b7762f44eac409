"""Wheels of unequal height in MuJoCo: their loads lie in the set, and bodies come nearer whatever the loads are."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from nonsmooth.analysis.cells.load_sets import load_set
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.body import Body, Disc
from nonsmooth.symbolic.mechanics.scene import Contact, Scene
from nonsmooth.symbolic.mechanics.unknown_loads import LoadScatter, UnknownLoads
from tests.body_engine import SETTLING, SLOW, THICK, Floats, plate_engine
from tests.thorough import few

LOADS = 2e-3  # of the weight: what slip and tilt change in the engine
SHARE = Fraction(1, 5)  # of the mean deflection
MANY = 4.0  # mean deflections: wheels lift off


def plate_on_a_ring(name: str) -> Scene:
    """A disc that covers every wheel."""
    scene = load_scene(name, rule="ellipse")
    zero, one = scene.field.zero, scene.field.one
    return replace(scene, body=Body(Disc(scene.field(2)), (zero, zero), (one, zero)))


def deflection(scene: Scene) -> float:
    """How far the plate sinks in the middle, where all wheels carry alike."""
    plate = plate_engine(scene, (0.0, 0.0, 0.0), SLOW)
    plate.step(SETTLING)
    return float(THICK - plate.data.qpos[2])


def settled(scene: Scene, start: Floats, lowered: Floats) -> tuple[Floats, Floats, Floats]:
    """Pose, twist and loads of the engine."""
    plate = plate_engine(scene, (float(start[0]), float(start[1]), 0.0), SLOW, lowered=lowered)
    plate.step(SETTLING)
    return plate.pose, plate.twist, plate.loads()


@few(1)
@pytest.mark.parametrize("name", ["ring-6", "four-wheel", "ring-5"])
def test_loads_of_wheels_of_unequal_height_lie_in_the_set(name: str) -> None:
    scene, rng = plate_on_a_ring(name), np.random.default_rng(4)
    scatter = UnknownLoads(LoadScatter(scene.field(SHARE), scene.field.zero))
    unit, spread = deflection(scene), 0.0
    moments = np.array([[1.0, *map(float, wheel.position)] for wheel in scene.wheels])
    worst = np.sign(np.eye(len(moments)) - moments @ np.linalg.pinv(moments))
    for signs in (*worst[:2], *rng.choice([-1.0, 1.0], (4, len(moments)))):
        start, corner = rng.uniform(-0.15, 0.15, 2), signs * float(SHARE) * unit
        pose, _, loads = settled(scene, start, corner)
        x, y = (scene.field(Fraction(float(entry)).limit_denominator(10**6)) for entry in pose[:2])
        there = replace(scene, contact=Contact("ellipse", scatter)).checked_at((x, y), scene.field(Fraction(1, 100)))
        found = load_set(there.recentred())
        assert not found.remark
        least, largest = (np.array([float(n) for n in end]) for end in (found.bound.least, found.bound.largest))
        assert (loads >= least - LOADS).all()
        assert (loads <= largest + LOADS).all()
        elastic = np.array([float(n) for n in found.bound.middle])
        spread = max(spread, np.abs(loads - elastic).max() / (largest - elastic).max())
    assert spread > 0.99  # its ends are reached


@few(1)
@pytest.mark.parametrize("name", ["ring-6", "four-wheel"])
def test_bodies_come_nearer_on_wheels_of_any_height(name: str) -> None:
    """Also where wheels lift off: the verdict for every load says ``c . v < 0``."""
    scene, rng = plate_on_a_ring(name), np.random.default_rng(5)
    unit, lifted = deflection(scene), 0
    for _ in range(8):
        angle = rng.uniform(0, 2 * np.pi)
        start = 0.3 * np.array([np.cos(angle), np.sin(angle)])
        pose, twist, loads = settled(scene, start, rng.uniform(-MANY, MANY, len(scene.wheels)) * unit)
        lifted += loads.min() <= 0
        assert pose[:2] @ twist[:2] < 0
    assert lifted > 0
