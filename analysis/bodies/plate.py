"""Mass and inertia of a body with an outline, as a uniform plate."""

from __future__ import annotations

from nonsmooth.analysis.continuum import moments
from nonsmooth.analysis.dynamics.newton_euler import RigidBody
from nonsmooth.symbolic import body


def plate(outlined: body.Body, mass: float) -> RigidBody:
    """``I = m ((int x^2 + int y^2)/area + |o|^2)``, o from the centre of mass to the centroid (per unit of weight)."""
    of = moments(outlined.outline)
    spread = float(of.xx + of.yy) / float(of.area)
    x, y = (float(entry) for entry in outlined.centre)
    return RigidBody(mass, mass * (spread + x * x + y * y))
