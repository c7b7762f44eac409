"""What a stress test simulates: one switched field in floats, with exact or 60-digit arithmetic to measure it by."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.partition import Partition, RefusalError
from nonsmooth.analysis.fields.constant_field import ConstantField, array_field
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.switched_field import SURFACE_SLACK
from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.measurements.references.reference_fields import (
    ReferenceField,
    array_reference,
    system_reference,
)
from nonsmooth.analysis.trajectories.smooth_path import onto
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.switched_system import SwitchedSystem

START = (0.6171, 0.3443)  # in units of the square's half-width: a place of no symmetry
HEADING = 0.1  # start of theta
INTEGRATOR = 1e-11  # error of DOP853 along a path: some ten steps of 1e-12
MOST_SURFACES = 6  # surfaces beside which paths start


@dataclass(frozen=True, eq=False)
class FollowedField:
    """One field to be followed.

    Attributes:
        field: what the product simulates, in floats.
        reference: the same field without rounding.
        radius: half-width of the checked square (length).
        centre: its centre.
        slack: distance within which a start counts as on a surface (length).
    """

    field: ConstantField | SignField
    reference: ReferenceField
    radius: float
    centre: tuple[float, float]
    slack: float

    @property
    def speed(self) -> float:
        """A bound on the speeds at hand (length/time)."""
        if isinstance(self.field, ConstantField):
            return self.field.speed_scale or 1.0
        places = [self.place(a, b) for a in (-1, 0.3, 1) for b in (-1, 0.4, 1)]
        fields = [self.field.faces_at(np.array(place))[-1].members[0].velocity for place in places]
        return max(float(np.abs(f(0.0, np.array(x))).max()) for f, x in zip(fields, places, strict=True)) or 1.0

    @property
    def step_error(self) -> float:
        """What integration adds, in half-widths: nothing where paths are closed forms."""
        return 0.0 if isinstance(self.field, ConstantField) else INTEGRATOR

    @property
    def span(self) -> float:
        """Time in which a path crosses the square."""
        return self.radius / self.speed

    def place(self, x: float, y: float) -> tuple[float, ...]:
        """A state, its position in units of the half-width from the centre."""
        position = (self.centre[0] + x * self.radius, self.centre[1] + y * self.radius)
        return (*position, HEADING) if isinstance(self.field, ConstantField) else position

    def distance(self, first: Sequence[Any], second: Sequence[Any]) -> float:
        """Distance of two states: positions in half-widths, theta in radians."""
        gaps = [abs(float(a) - float(b)) for a, b in zip(first, second, strict=True)]
        return max(gaps[0] / self.radius, gaps[1] / self.radius, *gaps[2:])

    def amplification(self, start: Sequence[float], until: float, probe: float) -> float:
        """Largest growth, at least one, of a displacement of the start by ``probe`` (length) along an axis."""
        here = simulate(self.field, start, until).end.state
        growth = [1.0]
        for move in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)):
            displaced = [x + probe * m for x, m in zip(start, move, strict=False)]
            try:
                there = simulate(self.field, displaced, until).end.state
            except ValueError:  # beyond the border of the domain
                continue
            growth.append(self.distance(here, there) * self.radius / probe)
        return max(growth)

    def beside_surfaces(self) -> list[tuple[Floats, Floats]]:
        """Points on surfaces with unit normals: middles of edges, or points of plain systems' surfaces."""
        field = self.field
        found = list(_edge_middles(field) if isinstance(field, ConstantField) else _surface_points(self))
        step = max(1, len(found) // MOST_SURFACES)
        return found[::step][:MOST_SURFACES]


@lru_cache(maxsize=1)
def cells_of(scene: Scene) -> Partition | RefusalError:
    """The cells of an array, or why there are none; several cases ask for them one after the other."""
    try:
        return build_partition(scene)
    except RefusalError as refusal:
        return refusal


def followed_fields(scene: Scene | SwitchedSystem, kinematics: Kinematics) -> tuple[FollowedField, ...]:
    """The field of a scene; none where a contact rule has no cells, which the case of scales says once."""
    if isinstance(scene, SwitchedSystem):
        return (followed_system(scene),)
    cells = cells_of(scene)
    return () if isinstance(cells, RefusalError) else (followed_array(cells, kinematics),)


def followed_array(partition: Partition, kinematics: Kinematics) -> FollowedField:
    """An array with its own speeds."""
    x, y = partition.scene.check.equilibrium
    field = array_field(partition, kinematics)
    radius = float(partition.scene.check.radius)
    return FollowedField(field, array_reference(partition, kinematics), radius, (float(x), float(y)), field.cells.slack)


def followed_system(scene: SwitchedSystem) -> FollowedField:
    """A plain system, followed by the general integrator."""
    field, radius = system_field(scene, centred=True), float(scene.check.radius)
    return FollowedField(field, system_reference(scene), radius, (0.0, 0.0), SURFACE_SLACK * radius)


def _edge_middles(field: ConstantField) -> Iterator[tuple[Floats, Floats]]:
    for number, edge in enumerate(field.cells.edges):
        if edge.left is not None and edge.right is not None:
            a, b = field.cells.direction(number)
            start, end = (np.array(field.cells.points[k]) for k in (edge.start, edge.end))
            yield 0.55 * start + 0.45 * end, np.array([-b, a])


def _surface_points(followed: FollowedField) -> Iterator[tuple[Floats, Floats]]:
    for surface in followed.field.surfaces if isinstance(followed.field, SignField) else ():
        for seed in ((0.6171, 0.3443), (-0.5317, 0.4129)):
            point = onto(np.array(followed.place(*seed)), [surface], followed.radius)
            if np.abs(point).max() <= followed.radius:
                gradient = surface.gradient(point)
                yield point, gradient / np.hypot(*gradient)
                break
