"""The squared radius of gyration ``rho^2 = I/m`` of the body of a scene, exactly."""

from __future__ import annotations

from nonsmooth.symbolic.mechanics import body
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number import Number


def squared_radius(scene: Scene) -> Number:
    """As it is stated, else of a uniform plate of the outline, else of a disc as large as the array (length^2)."""
    if scene.inertia is not None and scene.inertia.squared_radius is not None:
        return scene.inertia.squared_radius
    return squared_radius_of_disc(scene) if scene.body is None else squared_radius_of_plate(scene.body)


def squared_radius_of_plate(outlined: body.Body) -> Number:
    """``(int x^2 + int y^2)/area + |o|^2``, o from the centre of mass to the centroid."""
    from nonsmooth.analysis.bodies.continuum import moments

    of, (x, y) = moments(outlined.outline), outlined.centre
    return (of.xx + of.yy) / of.area + x * x + y * y


def squared_radius_of_disc(scene: Scene) -> Number:
    """``rho^2`` of a uniform disc as large as the array.

    That is half the mean squared distance of the wheels from their middle, as the full dynamics takes it unless told
    otherwise (:func:`nonsmooth.analysis.bodies.newton_euler.disc`).
    """
    count, zero = len(scene.wheels), scene.field.zero
    places = scene.positions
    middle = [sum((place[axis] for place in places), zero) / count for axis in range(2)]
    offsets = [(x - middle[0], y - middle[1]) for x, y in places]
    return sum((x * x + y * y for x, y in offsets), zero) / (2 * count)
