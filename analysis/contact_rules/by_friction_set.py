"""Rules without cells: the motion dissipates the least against forces in a set for each wheel.

A class on :class:`FrictionSetRule` states the set, an ellipse that a strip may cut; minimizers with proofs, exact
linearization, feedback and paths follow from it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from nonsmooth.analysis.cells.loads import LoadError, TipsThereError
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.contact_rule import SmoothRule
from nonsmooth.symbolic.contact_set import whole
from nonsmooth.symbolic.friction_set import CutEllipse

if TYPE_CHECKING:
    from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
    from nonsmooth.analysis.minimizers.dissipation import Functional
    from nonsmooth.analysis.minimizers.minimum import Minima
    from nonsmooth.analysis.trajectories.result import Trajectory
    from nonsmooth.symbolic.scene import Scene


class FrictionSetRule(SmoothRule):
    """``D = sum_i N_i h_i``, h_i the support function of the friction set of wheel i."""

    needs_loads = True

    @property
    def functional(self) -> Functional:
        """The sum of the support functions."""
        from nonsmooth.analysis.minimizers.dissipation import Functional

        return Functional.ELLIPSE

    def contacts(self, scene: Scene) -> ContactModel:
        """Each exact number rounded once."""
        from nonsmooth.analysis.fields.contact_model import contact_model, with_friction_sets

        return with_friction_sets(contact_model(scene), [self.friction_set(wheel.friction) for wheel in scene.wheels])

    def minima(self, scene: Scene, points: Floats) -> Minima:
        """By smoothing, finished by multipliers."""
        from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
        from nonsmooth.analysis.minimizers.float_loads import loads_at

        model = self.contacts(scene)
        return EllipseMinimizer().minimize(model, loads_at(model, points))

    def path(self, scene: Scene, start: Sequence[float], until: float) -> Trajectory:
        """The minimizer of D, integrated; of a body with an outline from contact set to contact set.

        Raises:
            LoadError: for a start without loads; of a body without an outline with the line that it tips over.
        """
        from nonsmooth.analysis.bodies.path import BodyPath
        from nonsmooth.analysis.bodies.supports import tipping_edge

        outlined = None if scene.body is None else whole(scene)
        try:
            return BodyPath(self.contacts(outlined or scene), outlined).follow(start, until)
        except TipsThereError as error:
            edge = tipping_edge(scene, frozenset(range(len(scene.wheels))), np.array(start, float))
            raise LoadError(f"{error} {edge}") from None


class FloatShape(CutEllipse[Any]):
    """A shape that floats alone know: bodies are followed, and whatever proves something refuses it.

    A shape on it writes ``searched``, ``support``, ``gauge``, ``excess``, ``nearest``, ``slip_cone``, ``room``,
    ``rounded_gradient`` and ``rounded_hessian``.  Slips r and s, and what ``support``, ``nearest``, ``excess`` and the
    rounded methods give, are about minus the force; ``gauge``, ``slip_cone`` and ``room`` are about the force.  Zero
    lies inside every set.
    """

    def piece(self, r: Any, s: Any) -> NoReturn:
        """Refused."""
        self.refuse()

    def gradient(self, r: Any, s: Any) -> NoReturn:
        """Refused."""
        self.refuse()

    def bend(self, r: Any, s: Any) -> NoReturn:
        """Refused."""
        self.refuse()

    def holds_strictly(self, x: Any, y: Any) -> NoReturn:
        """Refused."""
        self.refuse()

    def refuse(self) -> NoReturn:
        """Say that nothing is proved.

        Raises:
            RefusalError: always.
        """
        shape = type(self).__name__
        raise RefusalError(f"required friction sets with exact forces, received {shape}: nothing is proved of it")
