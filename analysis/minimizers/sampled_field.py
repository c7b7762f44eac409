"""The velocity field of a rule without cells at the points of a grid, in floats: sampled, and said to be.

``c' = v + omega J c`` by the minimizer of D at each point, each with the forces that prove it; where a minimizer is not
unique or not proved the point has no velocity.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.analysis.minimizers.minimum import free_motions, proved
from nonsmooth.symbolic.mechanics.scene import Scene

RESTS = 1e-9  # of the fastest velocity: slower is what rounding leaves of rest


@dataclass(frozen=True, eq=False)
class SampledField:
    """Velocities at ``count x count`` points of the checked square.

    Attributes:
        scene: the array; points in its coordinates.
        count: points in a row and in a column.
        points: positions of the centre of mass (m, 2), x first.
        velocities: ``c'`` (m, 2); not a number where the motion is not determined.
        rates: omega (m,).
    """

    scene: Scene
    count: int
    points: Floats
    velocities: Floats
    rates: Floats

    @property
    def speeds(self) -> Floats:
        """``|c'|`` (m,)."""
        return np.asarray(np.hypot(*self.velocities.T))

    @property
    def is_determined(self) -> NDArray[np.bool_]:
        """Where the motion is unique and proved (m,)."""
        return ~np.isnan(self.velocities[:, 0])

    @property
    def rests(self) -> NDArray[np.bool_]:
        """Where c stands still (m,)."""
        fastest = float(np.nanmax(self.speeds, initial=0.0))
        return self.is_determined & (self.speeds <= RESTS * fastest)

    @property
    def upper_derivative(self) -> Floats:
        """``V* = 2 (c - c*) . c'`` of ``V = |c - c*|^2`` (m,); zero where it is what rounding leaves of zero."""
        centre = np.array([float(entry) for entry in self.scene.check.equilibrium])
        found = 2 * ((self.points - centre) * self.velocities).sum(axis=1)
        least = RESTS * float(self.scene.check.radius) * float(np.nanmax(self.speeds, initial=0.0))
        return np.asarray(np.where(np.abs(found) <= least, 0.0, found))


def sample_field(scene: Scene, count: int) -> SampledField:
    """The field at an even grid over the checked square, its border included.

    Raises:
        TypeError: for a rule with cells.
        RefusalError: where some motion meets no friction, so that no velocity is determined.
    """
    free = free_motions(scene)
    if free:
        raise RefusalError(f"friction: required friction against every motion, received: {free}")
    centred, rule = scene.recentred(), smooth_rule_of(scene)
    radius = float(scene.check.radius)
    x, y = np.meshgrid(*[np.linspace(-radius, radius, count)] * 2)
    places = np.column_stack([x.ravel(), y.ravel()])
    minima = minima_under(rule, centred, places)
    vx, vy, omega = minima.twists.T
    velocities = np.column_stack([vx - omega * places[:, 1], vy + omega * places[:, 0]])
    unknown = ~proved(minima)
    unknown[list(minima.faces)] = True
    velocities[unknown], omega = np.nan, np.where(unknown, np.nan, omega)
    centre = np.array([float(entry) for entry in scene.check.equilibrium])
    return SampledField(scene, count, places + centre, velocities, omega)
