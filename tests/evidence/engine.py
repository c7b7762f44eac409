"""A hundred random arrays of each kind in the physics engine, as a table that the evidence page shows.

- fixed wheels: exported MJCF files, rims in all directions with friction ellipses, run as anybody would;
- free plate: a plate with an outline over a grid of 36 wheels, on those that the engine itself finds under it;
- rollers: wheels with real rollers on bearings, which rule ``roller`` is about;
- rubber beside rollers: every other wheel of rubber, by the engine's own loads.

Errors are those of the twist, relative to its largest entry.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.reports.interface.array import Array
from nonsmooth.reports.simulations.mjcf import export_scene
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.body_engine import pose_beside_engine
from tests.engine_export import error
from tests.roller_engine import mixed_errors, random_array, relative_errors

ARRAYS = 100
MARGIN = 0.05  # pitches: plates with a wheel nearer to their edge are left out


class Kind(NamedTuple):
    """Errors of one kind."""

    name: str
    rule: str
    errors: Floats

    def row(self) -> tuple[str, ...]:
        """Kind, rule, number of arrays, median, what nine of ten are below, the largest."""
        numbers = np.median(self.errors), np.quantile(self.errors, 0.9), self.errors.max()
        return self.name, self.rule, str(len(self.errors)), *(f"{value:.1e}" for value in numbers)


def random_document(seed: int) -> dict[str, object]:
    """Four to eight wheels with rims and friction axes of all kinds, and a place for the body."""
    rng = np.random.default_rng(seed)
    count, side = int(rng.integers(4, 9)), int(rng.integers(2, 21))
    places = rng.integers(-150, 151, (count, 2))
    headings = rng.integers(-9, 10, (count, 2)).tolist()
    centre = rng.dirichlet(np.full(count, 3.0)) @ (places / 100)
    wheels = [
        {"position": _hundredths(place), "heading": heading if any(heading) else [1, 0], "speed": f"{speed}/10"}
        for place, heading, speed in zip(places, headings, rng.integers(3, 11, count), strict=True)
    ]
    return {
        "name": f"random {seed}",
        "friction": {"mu_roll": 1, "mu_side": f"{side}/20"},
        "wheel": wheels,
        "check": {"equilibrium": _hundredths(100 * centre)},
        "contact": {"rule": "ellipse"},
    }


def _hundredths(place: Floats) -> list[str]:
    return [f"{round(x)}/100" for x in place]


def fixed_wheels(count: int) -> Kind:
    errors: list[float] = []
    seed = 0
    while len(errors) < count:
        scene = Array.of_document(random_document(seed)).scene
        seed += 1
        try:
            exported = export_scene(scene, scene.check.equilibrium)
        except LoadError:  # the place lies outside the wheels
            continue
        errors.append(error(exported.text()))
    return Kind("fixed wheels", "ellipse", np.array(errors))


def free_plates(count: int) -> Kind:
    errors: list[float] = []
    seed = 0
    while len(errors) < count:
        pose = pose_beside_engine(seed)
        seed += 1
        if not pose.tips and not pose.fell and pose.margin > MARGIN:
            errors.append(pose.twist_error)
    return Kind("free plate", "ellipse", np.array(errors))


def rollers(count: int) -> list[Kind]:
    errors = np.array([relative_errors(*random_array(seed)) for seed in range(count)])
    return [Kind("rollers", rule, column) for rule, column in zip(("roller", "ellipse", "box"), errors.T, strict=True)]


def rubber_and_rollers(count: int) -> list[Kind]:
    errors = np.array([mixed_errors(seed) for seed in range(count)])
    return [Kind("rubber, rollers", rule, column) for rule, column in zip(("mixed", "ellipse"), errors.T, strict=True)]


def engine_errors(count: int = ARRAYS) -> list[Kind]:
    """All kinds."""
    return [fixed_wheels(count), free_plates(count), *rollers(count), *rubber_and_rollers(count)]
