"""Lyapunov functions and regions that others have published for polynomial systems, with where they stand."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

import numpy as np

from nonsmooth.analysis.cells.switched_cells import LyapunovCell
from nonsmooth.proofs.falling_function import claims_about
from nonsmooth.proofs.systems.domain import SublevelRegion, given_cells
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.oracles.floats import value
from tests.plain import built


class Published(NamedTuple):
    """A system in two states with what is published of its region.

    Attributes:
        name: of the system.
        rhs: its formulas.
        source: who published what.
        potential: V: theirs, or the square of the distance, whose level sets are the balls that they name.
        level: theirs, of V.
        limit: the largest level of V, by a short computation on the set where V' = 0.
        radius: half-width of the square in which regions are looked for here.
        degree: of the V that is searched here.
    """

    name: str
    rhs: tuple[str, str]
    source: str
    potential: str
    level: Fraction
    limit: float
    radius: int
    degree: int


DISTANCE = "x**2 + y**2"
VAN_DER_POL = Published(
    "van der Pol, reversed",
    ("-y", "x + (x**2 - 1)*y"),
    "Khalil 2002, example 8.9: V < 2.25; the same V in the demonstration gsosoptdemo1 of SOSOPT",
    "3*x**2/2 - x*y + y**2",
    Fraction(9, 4),
    2.30450,
    3,
    6,
)
NO_POLYNOMIAL = Published(
    "no polynomial V in the plane",
    ("-x + x*y", "-y"),
    "FOSSIL, NonPoly0: V in the annulus from 0.01 to 1",
    DISTANCE,
    Fraction(1),
    27 / 4,  # y**3/(y - 1) at y = 3/2
    3,
    6,
)
CUBIC = Published(
    "cubic damping",
    ("-x**3 + y", "-x - y"),
    "SOSTOOLS 4.00, guide, sec. 4.2 (findlyap); FOSSIL, Poly2: V in the annulus from 0.01 to 3",
    DISTANCE,
    Fraction(9),
    np.inf,
    3,
    4,
)
HYPERBOLA = Published(
    "attracts where x y < 1",
    ("-x + 2*x**2*y", "-y"),
    "FOSSIL, NonPoly1 (roa_1): discs of 0.1 about (-1, 1) and of 0.2 about (1, -1)",
    DISTANCE,
    Fraction(1),  # not published: these discs are beyond every level of the distance
    8 / 27**0.5,  # r**2 = 1/(2 cos(a)**3 sin(a)) at its least
    2,
    6,
)
PUBLISHED = [VAN_DER_POL, NO_POLYNOMIAL, CUBIC, HYPERBOLA]

GUIDE = ["-x**3 - x*z**2", "-y - x**2*y", "-z - 3*z/(z**2 + 1) + 3*x**2*z"]
GUIDE_POTENTIAL = "5.5489*x**2 + 4.1068*y**2 + 1.7945*z**2"  # SOSTOOLS 4.00, guide, sec. 4.2


def system_of(published: Published) -> SwitchedSystem:
    return built(published.rhs, radius=published.radius, lyapunov=published.potential)


def published_cells(system: SwitchedSystem) -> tuple[LyapunovCell, ...]:
    """The square with the published V."""
    return given_cells(system, system.check.radius)


def exact_level(system: SwitchedSystem) -> SublevelRegion | None:
    """The largest level that is certified of the published V."""
    found = claims_about(system, system.check.lyapunov, system.check.radius)
    return None if found is None else found.largest_sublevel(falls=False)


def area(potential: str, level: float, radius: float) -> float:
    """Of the part of a square in which V is below a level, by a grid."""
    line = (np.arange(1000) + 0.5) / 500 * radius - radius
    x, y = np.meshgrid(line, line)
    return float((value(potential, x=x, y=y) < level).mean() * 4 * radius**2)
