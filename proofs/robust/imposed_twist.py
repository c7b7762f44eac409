"""Rules ``ellipse`` and ``roller``: how far the motion of any array of a box is from the twist that its speeds command.

The speeds u that impose xi_m on the scene impose some other twist on an array within its tolerances.  On the border of
a cube about xi_m let every subgradient g of D have ``g . (xi - xi_m) > 0``.  Then D increases outward there, and, being
convex, has all its minimizers inside, for every array of the box at once.  The body is at the point.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from flint import arb

from nonsmooth.proofs.clauses.feedback.driven_law import rim_speeds
from nonsmooth.proofs.robust.array_forces import ArrayBox, PieceForces
from nonsmooth.proofs.robust.box_wheel import box_wheels
from nonsmooth.proofs.robust.friction_forces import FORCE_LAWS
from nonsmooth.proofs.robust.intervals import Floats, Intervals
from nonsmooth.proofs.robust.load_box import LoadBox
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.tolerances import Tolerance

if TYPE_CHECKING:
    from nonsmooth.proofs.clauses.feedback.driven_law import ImposedTwist

SIDE_PARTS = 10  # of each edge of the cube
SHARES = (0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4, 0.55, 0.7, 0.9)  # of the largest distance that serves


def distance_of_minimizers(
    own: Scene, box: Tolerance, loads: LoadBox, imposed: ImposedTwist, most: float
) -> arb | None:
    """A bound of ``|xi - xi_m|``, below ``most``, in the unit l of the scene; None where none is shown.

    Args:
        own: a centred scene under rule ``ellipse`` or ``roller``, with l for the unit of length.
        box: its tolerances.
        loads: of all its arrays.
        imposed: the twist, with the speeds that impose it.
        most: the largest bound that is of use.
    """
    arrays = ArrayBox(box_wheels(own, box), loads, FORCE_LAWS[own.contact.rule])
    forces = replace(PieceForces.at_point(arrays), speeds=_speeds(own, box, imposed))
    middle = np.array([float(entry) for entry in imposed.twist])
    rounding = 2.0**-40 * (most + float(np.abs(middle).max()))  # of the cube to floats
    for share in SHARES:
        half = share * most / np.sqrt(3)
        if _is_outward(forces, middle, half):
            return arb(half) * arb(3).sqrt() + arb(rounding)
    return None


def _speeds(scene: Scene, box: Tolerance, imposed: ImposedTwist) -> tuple[Intervals, Intervals]:
    """Along and across each wheel's friction axis: rims' speeds of the law, within their tolerance."""
    drive = 1 + box.speed.ball() * arb(0, 1)
    pairs = []
    for wheel, speed in zip(scene.wheels, rim_speeds(scene, imposed), strict=True):
        along, across = ((gain / wheel.grip_length).ball() for gain in wheel.gains)  # of the rim's direction
        pairs.append((along * speed * drive, across * speed * drive))
    return Intervals.about([pair[0] for pair in pairs]), Intervals.about([pair[1] for pair in pairs])


def _is_outward(forces: PieceForces, middle: Floats, half: float) -> bool:
    """Whether D increases outward all along the border of a cube about a twist."""
    ends = np.linspace(-1.0, 1.0, SIDE_PARTS + 1)
    part = Intervals(ends[:-1], ends[1:])
    first, second = np.indices((SIDE_PARTS, SIDE_PARTS)).reshape(2, -1)
    for k in range(3):
        for side in (-1.0, 1.0):
            offset = [part[first], part[first], part[first]]
            offset[(k + 1) % 3], offset[(k + 2) % 3] = part[first], part[second]
            offset[k] = Intervals.of(np.full(len(first), side))
            scaled = [entry[None] * Intervals.of(half) for entry in offset]
            if not _increases(forces, middle, scaled):
                return False
    return True


def _increases(forces: PieceForces, middle: Floats, offset: list[Intervals]) -> bool:
    """``g . (xi - xi_m) > 0`` on parts of one side: along their middles, and what is left of them."""
    x, y, spin = (entry + Intervals.of(value) for entry, value in zip(offset, middle, strict=True))
    pulls = forces.forces((x, y, spin))
    centres = [Intervals.of(entry.middle) for entry in offset]
    power = forces.power(pulls, (centres[0], centres[1], centres[2]))
    zero, one = Intervals.of(np.zeros((1, 1))), Intervals.of(np.ones((1, 1)))
    units = (one, zero, zero), (zero, one, zero), (zero, zero, one)
    for entry, centre, unit in zip(offset, centres, units, strict=True):
        power = power + (entry - centre) * forces.power(pulls, unit)
    return bool((power.low > 0).all())
