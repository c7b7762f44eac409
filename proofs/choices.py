"""The search for a switching law under which the point is unstable (:mod:`nonsmooth.proofs.checker.choice`).

Tried are each right-hand side, the mean of two, and two of them above and below a coordinate, a switching surface, or a
speed in which they differ: a disturbance of either sign that pushes along with the velocity is one of these.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import combinations, permutations
from pathlib import Path
from typing import Any

from nonsmooth.proofs.checker.choice import BY_ONE, MAX_NESTED, chosen
from nonsmooth.proofs.checker.theorems import UNSTABLE
from nonsmooth.proofs.kernel.cells import BeyondReachError, started
from nonsmooth.proofs.kernel.escapes import show_escape_of
from nonsmooth.proofs.kernel.fans import show_by_fan, show_by_weights
from nonsmooth.proofs.kernel.first_terms import show_departure_of, show_linearization_of
from nonsmooth.proofs.kernel.search import Entry, NotShownError, Search
from nonsmooth.proofs.kernel.subject import about
from nonsmooth.symbolic.expression import ExpressionError
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.scene_error import SceneError
from nonsmooth.symbolic.switched_system import PLANE, SwitchedSystem

MOST_TRIED = 48
Show = Callable[[SwitchedSystem, str], Entry]
IN_MANY: Sequence[Show] = (show_departure_of, show_linearization_of, show_escape_of)
IN_PLANE: Sequence[Show] = (*IN_MANY, show_by_fan, show_by_weights)


def show_choice_of(system: SwitchedSystem) -> Entry:
    """Evidence that the checked point is unstable for a choice among several right-hand sides.

    Args:
        system: in two states or more.

    Returns:
        The entry of a certificate, and what it shows.

    Raises:
        NotShownError: where none is found, and where right-hand sides only enclose the field.
        BeyondReachError: for irrational numbers.
    """
    if system.only_encloses or not system.others:
        raise NotShownError("a choice needs several right-hand sides that may act")
    subject, _ = started(system, None)
    tried = [own for own, _ in zip(choices(subject.rhs, subject.states, system), range(MOST_TRIED), strict=False)]
    for choice in tried:
        try:
            one = _with_choice(system, subject.rhs, choice)
        except (SceneError, ExpressionError):
            continue
        for show in IN_PLANE if len(system.states) == len(PLANE) else IN_MANY:
            try:
                entry, _ = show(one, UNSTABLE)
            except (NotShownError, BeyondReachError):
                continue
            if entry["theorem"] in BY_ONE:
                own = {"choice": choice, "theorem": entry["theorem"], "hypotheses": entry["hypotheses"]}
                return Search(known=entry["proofs"]).entry(subject, "choice", own)
    raise NotShownError("no choice among the right-hand sides was found that is unstable")


def choices(sides: Sequence[Sequence[str]], states: Sequence[str], system: SwitchedSystem) -> Iterator[Any]:
    """Choices from simple to rich."""
    numbers = range(len(sides))
    yield from numbers
    surfaces = dict.fromkeys(states)
    if system.by_roots is None:
        surfaces |= dict.fromkeys(str(own) for own in system.surfaces() if own.degree)
    for surface in surfaces:
        yield from ({"surface": surface, "first": i, "second": j} for i, j in permutations(numbers, 2))
    yield from ({"surface": ["0"], "first": i, "second": j} for i, j in combinations(numbers, 2))


def choice_words(choice: Any) -> str:
    """A choice in words; right-hand sides are counted from 1."""
    if isinstance(choice, int):
        return f"right-hand side {choice + 1}"
    first, second = (choice_words(choice[key]) for key in ("first", "second"))
    if isinstance(choice["surface"], list):
        return f"the mean of {first} and {second}"
    return f"{first} where {choice['surface']} > 0, else {second}"


def _with_choice(system: SwitchedSystem, sides: Sequence[tuple[str, ...]], choice: Any) -> SwitchedSystem:
    """The system with one right-hand side.

    Raises:
        SceneError: for formulas that are too long.
    """
    subject = about(system)
    document = {
        "system": {"states": subject["states"], "rhs": list(chosen(choice, sides, MAX_NESTED))},
        "check": {"equilibrium": subject["at"], "radius": "1/2"},
    }
    return build_system(document, "choice", Path("choice"))
