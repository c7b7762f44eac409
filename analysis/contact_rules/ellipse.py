"""Rule ``ellipse``: the motion minimizes the dissipation with the friction ellipse of the paper's Fig. 3."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from nonsmooth.analysis.contact_rule import SmoothRule

if TYPE_CHECKING:
    from nonsmooth.analysis.fields.contact_model import Floats
    from nonsmooth.analysis.minimizers.dissipation import Functional
    from nonsmooth.analysis.minimizers.minimum import Minima
    from nonsmooth.analysis.trajectories.result import Trajectory
    from nonsmooth.symbolic.scene import Scene


class EllipseRule(SmoothRule):
    """``D = sum_i N_i sqrt(mu_R^2 r_i^2 + mu_S^2 s_i^2)``, the quasi-static limit of Newton-Euler dynamics."""

    name = "ellipse"
    summary = "friction losses are least under the friction ellipse: how a light body moves"
    hardware = "rubber wheels, rollers and belts: one friction limit for all directions of slip"
    needs_loads = True
    is_massless_limit = True

    @property
    def functional(self) -> Functional:
        """The sum of norms."""
        from nonsmooth.analysis.minimizers.dissipation import Functional

        return Functional.ELLIPSE

    def minima(self, scene: Scene, points: Floats) -> Minima:
        """By interior points, finished by Newton steps."""
        from nonsmooth.analysis.minimizers.sampling import ellipse_minima

        return ellipse_minima(scene, points)

    def path(self, scene: Scene, start: Sequence[float], until: float) -> Trajectory:
        """The minimizer of D, integrated."""
        from nonsmooth.analysis.dynamics.ellipse_path import ellipse_path
        from nonsmooth.analysis.fields.contact_model import contact_model

        return ellipse_path(contact_model(scene), start, until)
