"""What is said about a path of constant twists: what it does at a switch, and whether it had to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from nonsmooth.analysis.cells.cell_complex import AtCorner, OnEdge
from nonsmooth.analysis.fields.constant_field import ConstantField
from nonsmooth.analysis.trajectories.cell_motion import State
from nonsmooth.analysis.trajectories.continuations import Choice
from nonsmooth.analysis.trajectories.result import Event, EventKind

RULE = "the path drawn rests if it can, else slides if it can, at the rate of smallest magnitude"


class EventLog:
    """Events of one path.

    Args:
        field: the field.
        turns_outward: whether a corner admits spirals that lead away from it.
    """

    def __init__(self, field: ConstantField, turns_outward: Callable[[int], bool]) -> None:
        self.field, self.turns_outward = field, turns_outward
        self.events: list[Event] = []
        self.unique = True
        self._tied: set[int] = set()

    def add(
        self,
        when: tuple[Any, State],
        kind: EventKind,
        surface: str,
        weights: tuple[tuple[str, Any], ...] = (),
        rates: tuple[Any, Any] | None = None,
        note: str = "",
        *,
        drift_only: bool = False,
    ) -> None:
        """Note an event at ``when = (time, state)``."""
        self.events.append(Event(*when, kind, surface, weights, rates, note, drift_only))

    def switch(
        self, when: tuple[Any, State], place: OnEdge | AtCorner, choices: Sequence[Choice], before: Sequence[int] | None
    ) -> None:
        """The first choice is taken, coming from a motion of the cells ``before`` (None at the start of the path)."""
        chosen, surface = choices[0], self.field.place_name(place)
        names = [self.field.names[cell] for cell in chosen.cells]
        weights = tuple(zip(names, chosen.weights, strict=True)) if chosen.weights else ()
        kind = chosen.kind
        if kind is EventKind.CROSS and before is not None and len(before) > 1:
            kind = EventKind.LEAVE
        stays = before is None or tuple(before) == chosen.cells
        if kind is not EventKind.CROSS or not stays:
            self.add(when, kind, surface, weights, chosen.rates)
        notes = [self._described(other) for other in choices[1:]]
        if isinstance(place, AtCorner) and kind is EventKind.REST and self.turns_outward(place.corner):
            notes.append("spiral outward")
        drift_only = not notes and chosen.free and chosen.rates is not None
        if chosen.free:
            notes.append("theta may drift at any rate of an interval" if chosen.rates else "the weights are free")
        if notes:
            self.unique = False
            note = f"also possible: {'; '.join(notes)}; {RULE}"
            self.add(when, EventKind.NONUNIQUE, surface, weights, chosen.rates, note, drift_only=drift_only)
        self.ties(when, chosen.cells)

    def ties(self, when: tuple[Any, State], cells: Sequence[int]) -> None:
        """Cells in which several motions tie leave the path open at every moment; said once for each."""
        for cell in cells:
            if cell not in self._tied and self.field.tied(cell):
                self._tied.add(cell)
                self.unique = False
                note = "also possible: any mixture of the motions that tie in this cell; the first is drawn"
                self.add(when, EventKind.NONUNIQUE, self.field.names[cell], note=note)

    def _described(self, other: Choice) -> str:
        if other.kind is EventKind.CROSS:
            return f"cross into {self.field.names[other.cells[0]]}"
        if other.ray is not None:
            return f"slide along {self.field.place_name(OnEdge(other.ray.edge))}"
        return "rest"
