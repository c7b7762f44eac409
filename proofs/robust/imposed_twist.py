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

from nonsmooth.proofs.boxes.enclosures import UNIT
from nonsmooth.proofs.boxes.intervals import Intervals
from nonsmooth.proofs.boxes.load_box import LoadBox
from nonsmooth.proofs.clauses.feedback.driven_law import rim_speeds
from nonsmooth.proofs.robust.array_forces import ArrayBox, PieceForces, Triple, force_law
from nonsmooth.proofs.robust.box import box_wheels
from nonsmooth.symbolic.mechanics.scene import Scene, Tolerance
from nonsmooth.symbolic.numbers.plane_arrays import Floats

if TYPE_CHECKING:
    from nonsmooth.proofs.clauses.feedback.twist_candidates import ImposedTwist

SIDE_PARTS = 10  # of each edge of the cube
SHARES = (0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4, 0.55, 0.7, 0.9)  # of the largest distance that serves


def distance_of_minimizers(
    own: Scene, box: Tolerance, loads: LoadBox, imposed: ImposedTwist, most: float
) -> arb | None:
    """A bound of ``|xi - xi_m|``, below ``most``, in the unit l of the scene; None where none is shown.

    Args:
        own: a centred scene under rule ``ellipse``, ``roller`` or ``mixed``, with l for the unit of length.
        box: its tolerances.
        loads: of all its arrays.
        imposed: the twist, with the speeds that impose it.
        most: the largest bound that is of use.
    """
    arrays = ArrayBox(box_wheels(own, box), loads, force_law(own))
    forces = replace(PieceForces.at_point(arrays), speeds=_speeds(own, box, imposed))
    middle = np.array([float(entry) for entry in imposed.twist])
    rounding = 2.0**-40 * (most + float(np.abs(middle).max()))  # of the cube to floats
    for share in SHARES:
        half = share * most / np.sqrt(3)
        if _is_outward(forces, middle, half):
            return arb(half) * arb(3).sqrt() + arb(rounding)
    return None


def _speeds(scene: Scene, box: Tolerance, imposed: ImposedTwist) -> Intervals:
    """Along and across each wheel's friction axis: rims' speeds of the law, within their tolerance (wheels, 2)."""
    drive = 1 + box.speed.ball() * UNIT
    pairs = zip(scene.wheels, rim_speeds(scene, imposed), strict=True)
    return Intervals.about(
        [[(gain / wheel.grip_length).ball() * speed * drive for gain in wheel.gains] for wheel, speed in pairs]
    )


def _is_outward(forces: PieceForces, middle: Floats, half: float) -> bool:
    """Whether D increases outward all along the border of a cube about a twist."""
    ends = np.linspace(-1.0, 1.0, SIDE_PARTS + 1)
    part = Intervals(ends[:-1], ends[1:])
    first, second = np.indices((SIDE_PARTS, SIDE_PARTS)).reshape(2, -1)
    for k in range(3):
        for side in (-1.0, 1.0):
            offset = [Intervals.of(np.full(len(first), side)), part[first], part[second]]
            x, y, spin = (offset[(axis - k) % 3][None] * Intervals.of(half) for axis in range(3))
            if not _increases(forces, middle, (x, y, spin)):
                return False
    return True


def _increases(forces: PieceForces, middle: Floats, offset: Triple) -> bool:
    """``g . (xi - xi_m) > 0`` on parts of one side: along their middles, and what is left of them."""
    x, y, spin = (entry + Intervals.of(value) for entry, value in zip(offset, middle, strict=True))
    pulls = forces.forces((x, y, spin))
    a, b, c = (Intervals.of(entry.middle) for entry in offset)
    power = forces.power(pulls, (a, b, c))
    for entry, centre, pull in zip(offset, (a, b, c), forces.wrench(pulls), strict=True):
        power = power + (entry - centre) * pull
    return bool((power.low > 0).all())
