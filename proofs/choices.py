"""The search for a switching law under which the point is unstable (:mod:`nonsmooth.proofs.checker.choice`).

Tried are each right-hand side, the mean of two, and two of them above and below a coordinate or a switching surface: a
disturbance of either sign that pushes along with the velocity is one of these.  In the plane the law that leaves
fastest changes from one field to another where they are parallel; so lines near those on which the first terms of two
fields are parallel are tried too, one by one and in pairs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from itertools import combinations, islice, permutations
from math import lcm
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.proofs.checker.cells import Inclusion, System
from nonsmooth.proofs.checker.choice import BY_ONE, MAX_NESTED, chosen
from nonsmooth.proofs.checker.lyapunov import sign_along
from nonsmooth.proofs.checker.polynomials import Polynomial
from nonsmooth.proofs.checker.theorems import UNSTABLE
from nonsmooth.proofs.falling_function import growth_hypotheses
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.kernel.cells import BeyondReachError, build_inclusion, started, stated_cells
from nonsmooth.proofs.kernel.escapes import show_escape_of
from nonsmooth.proofs.kernel.fans import show_by_fan, show_by_weights
from nonsmooth.proofs.kernel.first_terms import show_departure_of, show_linearization_of
from nonsmooth.proofs.kernel.search import Entry, NotShownError, Search
from nonsmooth.proofs.kernel.subject import NoCertificateError, about
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.proofs.systems.ray_moves import are_cones
from nonsmooth.proofs.systems.search import search_lyapunov
from nonsmooth.proofs.systems.system_stability import PlanePoint
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.formulas.expression import ExpressionError
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.systems.switched_system import PLANE, SwitchedSystem

MOST_TRIED = 64
MOST_SEARCHED = 16  # of these, that first terms do not rule out
WORK = 2_000  # coefficients looked at for one claim: functions on cones need few
ANGLES = np.linspace(0.0, np.pi, 181)  # at which it is seen where two fields are parallel
DENOMINATOR = 8  # of slopes
Show = Callable[[SwitchedSystem, str, Search], Entry]
IN_MANY: Sequence[Show] = (show_departure_of, show_linearization_of, show_escape_of)
IN_PLANE: Sequence[Show] = (*IN_MANY, show_by_fan, show_by_weights)


def show_choice_of(system: SwitchedSystem, verdict: str = UNSTABLE, search: Search | None = None) -> Entry:
    """Evidence that the checked point is unstable for a choice among several right-hand sides.

    Args:
        system: in two states or more.
        verdict: unstable.
        search: with what was shown before.

    Returns:
        The entry of a certificate, and what it shows.

    Raises:
        NotShownError: where none is found, and where right-hand sides only enclose the field.
        BeyondReachError: for irrational numbers.
    """
    if system.only_encloses or not system.others:
        raise NotShownError("a choice needs several right-hand sides that may act")
    subject, search = started(system, search)
    lines = parallel_lines(system, subject, search) if len(system.states) == len(PLANE) else []
    searched = 0
    for choice in islice(choices(subject, system, lines), MOST_TRIED):
        try:
            one = _with_choice(system, subject.rhs, choice)
        except (SceneError, ExpressionError):
            continue
        searches = _searches(one)
        searched += bool(searches)
        if searched > MOST_SEARCHED:
            break
        for show in searches:
            try:
                entry, _ = show(one, UNSTABLE, Search(WORK))
            except (NotShownError, BeyondReachError):
                continue
            if entry["theorem"] in BY_ONE:
                own = {"choice": choice, "theorem": entry["theorem"], "hypotheses": entry["hypotheses"]}
                return Search(known=entry["proofs"]).entry(subject, "choice", own)
    raise NotShownError("no choice among the right-hand sides was found that is unstable")


def _searches(system: SwitchedSystem) -> Sequence[Show]:
    """What is tried for one right-hand side: nothing where first terms show that the point attracts.

    Where they show a spiral that leaves, a V that grows is tried first.
    """
    if len(system.states) != len(PLANE):
        return IN_MANY
    point = PlanePoint(system)
    try:
        verdicts = {own.verdict for own in (point.fan, point.leading) if own is not None}
    except BeyondReachError:
        return IN_PLANE
    if Translation.ASYMPTOTICALLY_STABLE in verdicts:
        return ()
    leading = point.leading
    leaves = leading is not None and leading.growth is not None and leading.verdict is Translation.UNSTABLE
    return (show_by_growth, *IN_PLANE) if leaves and are_cones(point.cells) else IN_PLANE


def show_by_growth(system: SwitchedSystem, verdict: str, search: Search) -> Entry:
    """Evidence that the point is unstable by a V in the plane that grows along every solution.

    Raises:
        NotShownError: where none is found.
    """
    subject, search = started(system, search)
    found = search_lyapunov(system, PlanePoint(system).cells, grows=True)
    if found is None or found.decrease is not Decrease.STRICT:
        raise NotShownError("no function was found that grows along every solution")
    try:
        return search.entry(subject, "instability", growth_hypotheses(system, found))
    except NoCertificateError as error:
        raise NotShownError(str(error)) from None


def choices(subject: System, system: SwitchedSystem, lines: Sequence[str]) -> Iterator[Any]:
    """Choices from simple to rich.

    Args:
        subject: the right-hand sides.
        system: the same system, with its switching surfaces.
        lines: further ones.
    """
    numbers = range(len(subject.rhs))
    yield from numbers
    coordinates = list(map(_written, subject.states, subject.states, subject.at))
    surfaces = dict.fromkeys(coordinates)
    if system.by_roots is None:
        surfaces |= dict.fromkeys(str(own) for own in system.surfaces() if own.degree)
    for surface in surfaces | dict.fromkeys(lines):
        yield from (_beside(surface, i, j) for i, j in permutations(numbers, 2))
    yield from (_beside(["0"], i, j) for i, j in combinations(numbers, 2))
    for one, other in combinations((*coordinates, *lines), 2):
        for i, j in permutations(numbers, 2):
            yield _beside(one, _beside(other, i, j), _beside(other, j, i))


def _beside(surface: Any, first: Any, second: Any) -> dict[str, Any]:
    """One choice above a surface and another one below, or their mixture by a number."""
    return {"surface": surface, "first": first, "second": second}


def parallel_lines(system: SwitchedSystem, subject: System, search: Search) -> list[str]:
    """Lines with short slopes near those on which the first terms of two fields are parallel.

    There are none where the root of a state is not zero at the point.

    Raises:
        NotShownError: where the checker refuses the cells.
        BeyondReachError: for too many surfaces or cells.
    """
    inclusion = build_inclusion(stated_cells(system, system.check.radius), subject, search)
    slopes = []
    for cell in inclusion.cells:
        for (_, f), (_, g) in combinations(cell.fields, 2):
            slopes += [own for own in _zeros(f[0] * g[1] - f[1] * g[0]) if _touches(inclusion, cell.signs, own)]
    if any(at and own != name for own, name, at in zip(subject.coordinates, subject.states, subject.at, strict=True)):
        return []
    x, y = map(_written, subject.coordinates, subject.states, subject.at)
    return [_line(a, b, x, y) for a, b in dict.fromkeys(slopes) if a and b]


def _written(coordinate: str, state: str, at: Fraction) -> str:
    """A coordinate in the displacement from the point, as a formula of its state."""
    if coordinate != state:
        return f"sqrt(Abs({state}))*sign({state})"
    return state if not at else f"({state} - ({at}))"


def _line(a: Fraction, b: Fraction, x: str, y: str) -> str:
    """``b x - a y`` with whole coefficients, the first of which is positive."""
    scale = lcm(a.denominator, b.denominator) * (1 if b > 0 else -1)
    first, second = (f"{abs(c * scale)}*{name}".removeprefix("1*") for c, name in ((b, x), (a, y)))
    return f"{first} {'-' if a * scale > 0 else '+'} {second}"


def _zeros(value: Polynomial) -> Iterator[tuple[Fraction, Fraction]]:
    """Directions near those in which the first terms of a polynomial change sign."""
    lowest, first = min(map(sum, value.terms), default=0), np.zeros(len(ANGLES))
    for (i, j), coefficient in value.terms.items():
        if i + j == lowest:
            first += float(coefficient) * np.cos(ANGLES) ** i * np.sin(ANGLES) ** j
    for k in np.flatnonzero(np.diff(np.sign(first))):
        angle = (ANGLES[k] + ANGLES[k + 1]) / 2
        steep = abs(np.tan(angle)) > 1
        slope = Fraction(float(1 / np.tan(angle) if steep else np.tan(angle))).limit_denominator(DENOMINATOR)
        yield (slope, Fraction(1)) if steep else (Fraction(1), slope)


def _touches(inclusion: Inclusion, signs: Sequence[int], direction: Sequence[Fraction]) -> bool:
    """Whether a line through the point lies in the closure of a cell, on one side at least."""
    surfaces = inclusion.surfaces
    own = [surfaces.signed(j, sign) for j, sign in enumerate(signs)]
    return any(all(sign_along(s, [side * c for c in direction]) >= 0 for s in own) for side in (1, -1))


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
