"""What a body does on one set of wheels at one centre of mass, in floats: a guess for ball arithmetic to prove."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nonsmooth.analysis.bodies.motions_on_sets import MotionsOnSets
from nonsmooth.analysis.cells.contact_rule import SmoothRule
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats, contacts_under
from nonsmooth.symbolic.mechanics.scene import Scene

STICKS, STICKS_BESIDE_ROLLERS = 1e-4, 1e-2  # slip, of the fastest wheel's speed, below which a wheel may stick


@dataclass(frozen=True)
class SetGuess:
    """A motion.

    Attributes:
        twist: spatial twist ``(v, omega)``.
        loaded: which of the wheels are pressed.
        stuck: which of them seem not to slip.
    """

    twist: tuple[float, float, float]
    loaded: tuple[bool, ...]
    stuck: tuple[bool, ...]


class SetGuesses:
    """Guesses for one array."""

    def __init__(self, scene: Scene, rule: SmoothRule) -> None:
        """For all wheels of a scene; its body is not looked at."""
        self.model: ContactModel = contacts_under(rule, scene)
        self._size = float(np.ptp(self.model.positions, axis=0).max()) or 1.0
        self._motions = MotionsOnSets(self.model, self._size)

    def of(self, wheels: Sequence[int], place: tuple[float, float]) -> SetGuess | None:
        """On some wheels, by their places in the list; None where the body tips or no motion is found."""
        carrying = np.zeros((1, self.model.wheels), bool)
        carrying[0, list(wheels)] = True
        found = self._motions.at(carrying, np.array([place]))
        if not found.known[0]:
            return None
        vx, vy, omega = _spatial(found.rates[0], np.array(place), self._size)
        twist = np.array([vx, vy, omega])
        loaded = tuple(bool(found.loads[0, k] > 0) for k in wheels)
        return SetGuess((float(vx), float(vy), float(omega)), loaded, _nearly_stuck(self.model, twist, wheels))


def _spatial(rate: Floats, place: Floats, size: float) -> Floats:
    """``(v, omega)`` of a rate ``(c', size theta')``."""
    omega = rate[2] / size
    return np.array([rate[0] + omega * place[1], rate[1] - omega * place[0], omega])


def _nearly_stuck(model: ContactModel, twist: Floats, wheels: Sequence[int]) -> tuple[bool, ...]:
    """Which wheels hardly slip."""
    fastest = float(np.abs(model.speeds).max()) or 1.0
    slips = np.abs(model.slips(twist)).max(axis=-1)[list(wheels)]
    limit = STICKS_BESIDE_ROLLERS if (model.cuts < 1).any() else STICKS
    return tuple(bool(slip <= limit * fastest) for slip in slips)
