"""Parts of a plain system that are decided by themselves (:mod:`nonsmooth.proofs.checker.parts`).

States are listed in the blocks of a cascade: those that drive each other are in one block, and a state under ``sign``
with those whose velocities jump with it, so that every velocity is continuous in the states of earlier blocks.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from nonsmooth.proofs.checker.parts import jumps, names_in
from nonsmooth.proofs.checker.polynomials import Polynomial, lie_derivative, variable
from nonsmooth.proofs.kernel.cells import SignCells, adjoining, stated_cells
from nonsmooth.proofs.kernel.written import formula_text
from nonsmooth.proofs.systems.findings import DecidedSystem
from nonsmooth.symbolic.files.system_builder import part_of
from nonsmooth.symbolic.files.system_document import with_parameters
from nonsmooth.symbolic.formulas.trees import formula_tree, tidied, written
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem


@dataclass(frozen=True)
class CascadeBlock:
    """A block of a cascade.

    Attributes:
        system: of its states, with the others at the point.
        is_driven: whether others drive it.
        jumps: whether its velocities jump with states of others.
    """

    system: SwitchedSystem
    is_driven: bool
    jumps: bool = False


@dataclass(frozen=True)
class SlidingSurface:
    """A switching surface on which solutions slide, and the system of the other states there.

    Attributes:
        cells: in which it has its number, as a certificate states them.
        number: of the surface.
        state: the one that it gives in terms of the others.
        surface: as a formula in the displacement.
        system: of the other states.
    """

    cells: dict[str, Any]
    number: int
    state: str
    surface: str
    system: SwitchedSystem

    @property
    def words(self) -> str:
        """The surface and the right-hand sides there, for people."""
        fields = (", ".join(f"{name}' = {written}" for name, written in side) for side in _plain_sides(self.system))
        return f"{self.surface} = 0 and slide there, where {' or '.join(fields)}"


@dataclass(frozen=True)
class Parts:
    """The parts by which a system was decided.

    Attributes:
        results: of each part, in an order in which none drives an earlier one.
        slide: the surface on which the only part is looked at; None of a cascade.
        carried: the numbers of parts that are only stable, though others drive them.
        jumping: of those whose velocities jump with states of others.
    """

    results: tuple[DecidedSystem, ...] = field(compare=False)  # the sentence of the finding says what they are
    slide: SlidingSurface | None = field(default=None, compare=False)
    carried: frozenset[int] = field(default=frozenset(), compare=False)
    jumping: frozenset[int] = field(default=frozenset(), compare=False)


def cascade(system: SwitchedSystem, *, jumping: bool = False) -> Iterator[CascadeBlock]:
    """The blocks of a system, of which none drives an earlier one.

    Args:
        system: in any number of states.
        jumping: whether velocities of a block may jump with states of earlier ones.

    Raises:
        SceneError: for formulas that cannot be used with the other states at the point.
    """
    at = dict(zip(system.stated_states, map(str, system.stated_point), strict=True))
    drivers = drivers_of(system, jumping=jumping)
    for driving in sorted(dict.fromkeys(tuple(filter(drivers[name].__contains__, at)) for name in at), key=len):
        states = tuple(name for name in driving if drivers[name] == set(driving))
        others = {name: f"({value})" for name, value in at.items() if name not in states}
        names_of_sides = [_under_jumps(tree) for name, tree in _trees(system) if name in states]
        jumps = any(names & others.keys() for names in names_of_sides)
        yield CascadeBlock(part_of(system, states, others), is_driven=states != driving, jumps=jumps)


def drivers_of(system: SwitchedSystem, *, jumping: bool = False) -> dict[str, set[str]]:
    """By state, all on which its velocity depends, directly or by others; itself among them.

    Unless velocities may be ``jumping`` with what drives them, it depends on them in turn: they are in one block.
    """
    states = system.stated_states
    drivers = {name: {name} for name in states}
    for name, tree in _trees(system):
        drivers[name] |= names_in(tree) & set(states)
        for driver in set() if jumping else _under_jumps(tree) & set(states):
            drivers[driver].add(name)
    for middle in states:
        for name in states:
            if middle in drivers[name]:
                drivers[name] |= drivers[middle]
    return drivers


def _trees(system: SwitchedSystem) -> Iterator[tuple[str, ast.expr]]:
    """The right-hand sides with the names of their states."""
    for formulas in system.stated_lists:
        for name, text in zip(system.stated_states, formulas, strict=True):
            yield name, formula_tree(text)


def _plain_sides(system: SwitchedSystem) -> Iterator[list[tuple[str, str]]]:
    """Each right-hand side by states, without brackets that say nothing."""
    sides = [(name, written(tidied(tree))) for name, tree in _trees(system)]
    count = len(system.states)
    yield from (sides[k : k + count] for k in range(0, len(sides), count))


def _under_jumps(tree: ast.AST) -> set[str]:
    """The names in arguments of functions that jump."""
    return {name for call in jumps(tree) for name in names_in(call)}


def slides(system: SwitchedSystem) -> Iterator[SlidingSurface]:
    """Surfaces through the point that the fields of all cells around it lead to, in terms of one state each.

    Raises:
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
        SceneError: for formulas that cannot be used.
    """
    stated = stated_cells(system, system.check.radius)
    for number, surface in enumerate(stated.cells.forms):
        if surface.at_origin or not _is_reached(stated.cells, number, surface):
            continue
        for k, name in enumerate(system.states):
            across = surface.derivative(k)
            if across and not across.degree and not _jumps_with(system, name):
                others = tuple(other for other in system.states if other != name)
                part = part_of(system, others, {name: _solved(system, surface, k)})
                yield SlidingSurface(stated.record, number, name, formula_text(surface, system.states), part)


def _is_reached(cells: SignCells, number: int, surface: Polynomial) -> bool:
    speeds = [
        cell.signs[number] * lie_derivative(surface, field).at_origin
        for cell in adjoining(cells)
        for field in cell.velocities
    ]
    return all(speed < 0 for speed in speeds)


def _jumps_with(system: SwitchedSystem, state: str) -> bool:
    """Whether the velocity of another state is not continuous in this one."""
    return any(state in _under_jumps(tree) for name, tree in _trees(system) if name != state)


def _solved(system: SwitchedSystem, surface: Polynomial, k: int) -> str:
    """A state on the surface, as a formula in the others."""
    count, slope = len(system.states), surface.slope(k)
    rest = (variable(count, k, slope) - surface).times(1 / slope)
    places = list(zip(system.states, map(str, system.check.equilibrium), strict=True))
    away = {name: f"({name} - ({value}))" for name, value in places if value != "0"}
    text, (_, value) = str(with_parameters(formula_text(rest, system.states), away)), places[k]
    return f"({text})" if value == "0" else f"({value} + {text})"


def names_of(states: Sequence[str]) -> str:
    """``x``, or ``x and y``."""
    *first, last = states
    return f"{', '.join(first)} and {last}" if first else last
