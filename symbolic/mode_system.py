"""Systems with modes: each has its own right-hand sides and is left for another where a guard is no longer negative.

Which mode acts is not decided by the state alone, so that modes may overlap (hysteresis) and last a least time (dwell).
The state is kept where the mode changes.  Such systems are followed in time; verdicts are about Filippov systems.
Source: Liberzon 2003, "Switching in Systems and Control", ch. 1 and 3.
"""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.symbolic.notebook import ShortRepr
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.switched_system import SwitchedSystem


@dataclass(frozen=True)
class ModeExit:
    """A way out of a mode.

    Attributes:
        guard: the mode may be left where this is not negative.
        target: name of the mode that follows.
    """

    guard: Polynomial
    target: str


@dataclass(frozen=True)
class OwnMode:
    """A mode.

    Attributes:
        name: of the mode.
        system: its right-hand sides; they may switch themselves.
        exits: ways out, the first of those reached at one time is taken.
        dwell: least time in the mode.
    """

    name: str
    system: SwitchedSystem
    exits: tuple[ModeExit, ...]
    dwell: Number


@dataclass(frozen=True, repr=False)
class ModeSystem(ShortRepr):
    """A system with modes; the first is that in which a path begins unless told.

    Attributes:
        name: of the scene.
        states: their names.
        modes: one or more.
        source: where it came from.
    """

    name: str
    states: tuple[str, ...]
    modes: tuple[OwnMode, ...]
    source: str = ""

    @property
    def origin(self) -> str:
        """Where it came from, for messages."""
        return self.source or self.name

    def mode(self, name: str) -> OwnMode:
        """The mode of a name.

        Raises:
            KeyError: for another name.
        """
        return {mode.name: mode for mode in self.modes}[name]
