"""Arrays within a box of tolerances, written anew in floats."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from nonsmooth.analysis.fields.contact_model import ContactModel, with_friction_sets
from nonsmooth.symbolic.mechanics.friction_set import FrictionSet
from nonsmooth.symbolic.mechanics.scene import Scene, Tolerance
from tests.oracles.floats import Floats


def small_box(scene: Scene) -> Tolerance:
    def share(top: int, bottom: int) -> object:
        return scene.field(Fraction(top, bottom))

    return Tolerance(share(1, 1000), Fraction(1, 1800), share(1, 500), share(1, 100), share(1, 100), share(0, 1))  # type: ignore[arg-type]


def drawn_model(
    scene: Scene, box: Tolerance, rng: np.random.Generator, *, corner: bool, speeds: Floats | None = None
) -> ContactModel:
    """One array of the box, a corner of it or one inside; its rims run at the scene's speeds, or at given ones."""

    def shift(*size: int) -> Floats:
        return rng.choice([-1.0, 1.0], size) if corner else rng.uniform(-1, 1, size)

    wheels = scene.wheels
    n = len(wheels)
    places = np.array([[float(x) for x in wheel.position] for wheel in wheels]) + float(box.position) * shift(n, 2)
    angles = np.array([np.arctan2(float(y), float(x)) for x, y in (wheel.unit_direction for wheel in wheels)])
    angles = angles + np.pi * float(box.heading) * shift(n)
    nominal = np.array([float(wheel.speed) for wheel in wheels]) if speeds is None else speeds
    roll = np.array([float(wheel.friction.roll) for wheel in wheels]) * (1 + float(box.mu_roll) * shift(n))
    side = np.array([float(wheel.friction.side) for wheel in wheels]) * (1 + float(box.mu_side) * shift(n))
    rims, nominal = np.column_stack([np.cos(angles), np.sin(angles)]), nominal * (1 + float(box.speed) * shift(n))
    rolls = [(wheel.friction.rule or scene.contact.rule) == "roller" for wheel in wheels]
    if not any(rolls):
        return ContactModel.build(places, rims, nominal, np.column_stack([roll, side]))
    across, cuts = np.where(rolls, roll, side), np.where(rolls, np.minimum(side / roll, 1.0), 1.0)
    model = ContactModel.build(places, rims, nominal, np.column_stack([roll, across]))
    sets = [FrictionSet(*axes) for axes in zip(roll, across, cuts, strict=True)]
    return with_friction_sets(model, sets)
