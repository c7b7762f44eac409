"""A periodic orbit of a plain system, as a script or a notebook holds it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from nonsmooth.reports.interface.short_text import short_lines
from nonsmooth.reports.interface.shown_result import ShownResult
from nonsmooth.reports.system_orbits import SystemOrbit, find_system_orbit
from nonsmooth.symbolic.notebook import html_table

if TYPE_CHECKING:
    from nonsmooth.symbolic.switched_system import SwitchedSystem


@dataclass(frozen=True, repr=False)
class OrbitResult(ShownResult):
    """A periodic orbit with its period, its Floquet multipliers and what is proved of it.

    Attributes:
        shown: the orbit in every form that ``nonsmooth simulate --orbit`` offers.
    """

    shown: SystemOrbit

    @property
    def period(self) -> float:
        """Time of one turn."""
        return self.shown.orbit.period

    @property
    def period_error(self) -> float:
        """How far the period may err; infinite where that is not known."""
        return self.shown.errors.period

    @property
    def multipliers(self) -> list[complex]:
        """The Floquet multipliers beside the one along the orbit, largest first."""
        return self.shown.multipliers

    @property
    def multiplier_errors(self) -> list[float]:
        """How far each multiplier may err; infinite where that is not known."""
        return list(self.shown.errors.multipliers)

    @property
    def stability(self) -> str:
        """``attracting``, ``repelling``, ``saddle`` or ``undecided``."""
        return self.shown.stability

    @property
    def proved(self) -> bool:
        """Whether the orbit and its stability are proved; else both are computed only."""
        return self.shown.proof.is_proved

    @property
    def reason(self) -> str:
        """How it is proved, or why it is not, in one sentence."""
        return self.shown.reason

    @property
    def t(self) -> NDArray[np.float64]:
        """Sample times of one turn, shape (m,)."""
        return np.array([float(t) for t in self.shown.orbit.path.times])

    @property
    def state(self) -> NDArray[np.float64]:
        """States at these times, shape (m, n)."""
        return self.shown.orbit.path.array

    def __repr__(self) -> str:
        return short_lines(f"{self.shown.system.name}: {self.shown.summary()}", self.shown.words())

    def _repr_html_(self) -> str:
        return html_table(f"{self.shown.system.name}: periodic orbit", ("what", "found"), self.shown.words())


def orbit_of(system: SwitchedSystem, start: tuple[float, ...], until: float) -> OrbitResult:
    """Find it; see :meth:`nonsmooth.reports.interface.system.System.orbit`."""
    return OrbitResult(find_system_orbit(system, start, until))
