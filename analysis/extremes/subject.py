"""What a stress test simulates: one switched field in floats, with exact or 60-digit arithmetic to measure it by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.analysis.extremes.reference_pieces import partition_pieces, system_pieces
from nonsmooth.analysis.extremes.taylor import ReferencePiece, reference_path
from nonsmooth.analysis.fields.constant_field import ConstantField, array_field
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.switched_field import SURFACE_SLACK
from nonsmooth.analysis.fields.system_field import constant_system, system_field
from nonsmooth.analysis.partitions.partition import Partition
from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.analysis.trajectories.smooth import onto
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.switched_system import SwitchedSystem

START = (0.6171, 0.3443)  # in units of the square's half-width: a place of no symmetry
HEADING = 0.1  # start of theta
INTEGRATOR = 1e-11  # error of DOP853 along a path: some ten steps of 1e-12
MOST_SURFACES = 6  # surfaces beside which paths start


@dataclass(frozen=True, eq=False)
class Subject:
    """One field to be followed.

    Attributes:
        field: what the product simulates, in floats.
        exact: the same field over exact numbers; None where it is not constant on polygons.
        pieces: the same field for the reference at 60 digits.
        radius: half-width of the checked square (length).
        centre: its centre.
        slack: distance within which a start counts as on a surface (length).
    """

    field: ConstantField | SignField
    exact: ConstantField | None
    pieces: tuple[ReferencePiece, ...]
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

    def error(self, path: Trajectory, reference: Sequence[Any]) -> float:
        """Distance of a path's end from a state: positions in half-widths, theta in radians."""
        return self.distance(path.end.state, reference)

    def distance(self, first: Sequence[Any], second: Sequence[Any]) -> float:
        """Distance of two states, as for :meth:`error`."""
        gaps = [abs(float(a) - float(b)) for a, b in zip(first, second, strict=True)]
        return max(gaps[0] / self.radius, gaps[1] / self.radius, *gaps[2:])

    def truth(self, start: Sequence[float], until: float) -> tuple[float, tuple[Any, ...]]:
        """Time and state that a path has to reach: exact where the field allows it, else at 60 digits.

        Raises:
            ValueError: for a start on a surface where only the reference at 60 digits is at hand.
        """
        if self.exact is not None:
            end = simulate(self.exact, (*start, 0)[:3], until).end
            return min(float(end.t), until), end.state[: len(start)]
        reached = reference_path(self.pieces, start, until)
        return reached.time, reached.state

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
        if isinstance(self.field, ConstantField):
            found = list(_edge_middles(self.field))
        else:
            found = [point for point in _surface_points(self) if point is not None]
        step = max(1, len(found) // MOST_SURFACES)
        return found[::step][:MOST_SURFACES]


def array_subject(partition: Partition, kinematics: Kinematics) -> Subject:
    """An array with its own speeds."""
    exact = array_field(partition, kinematics, exact=True) if kinematics is Kinematics.LEADING else None
    x, y = partition.scene.check.equilibrium
    field = array_field(partition, kinematics)
    radius = float(partition.scene.check.radius)
    pieces = partition_pieces(partition, kinematics)
    return Subject(field, exact, pieces, radius, (float(x), float(y)), field.cells.slack)


def system_subject(scene: SwitchedSystem) -> Subject:
    """A plain system, followed by the general integrator."""
    field, radius = system_field(scene, centred=True), float(scene.check.radius)
    exact = constant_system(scene, exact=True)
    return Subject(field, exact, system_pieces(scene), radius, (0.0, 0.0), SURFACE_SLACK * radius)


def _edge_middles(field: ConstantField) -> list[tuple[Floats, Floats]]:
    found = []
    for number, edge in enumerate(field.cells.edges):
        if edge.left is not None and edge.right is not None:
            a, b = field.cells.direction(number)
            start, end = (np.array(field.cells.points[k]) for k in (edge.start, edge.end))
            found.append(((0.55 * start + 0.45 * end), np.array([-b, a])))
    return found


def _surface_points(subject: Subject) -> list[tuple[Floats, Floats] | None]:
    if not isinstance(subject.field, SignField):
        return []
    found: list[tuple[Floats, Floats] | None] = []
    for surface in subject.field.surfaces:
        for seed in ((0.6171, 0.3443), (-0.5317, 0.4129)):
            point = onto(np.array(subject.place(*seed)), [surface], subject.radius)
            if np.abs(point).max() <= subject.radius:
                gradient = surface.gradient(point)
                found.append((point, gradient / np.hypot(*gradient)))
                break
    return found
