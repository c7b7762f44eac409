"""Searches for theorems that show verdicts on plain systems, and their registry in the order of their trial.

A search looks for hypotheses of a theorem of :mod:`nonsmooth.proofs.checker.theorems` and for the evidence of its
claims.  A new one is a function with the signature of :data:`Show` and a line of :data:`THEOREM_SEARCHES`; its theorem
is a function of the checker and a line of ``THEOREMS`` there.  The V that decided a check is tried before all of these.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations, islice, permutations
from math import lcm
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from nonsmooth.proofs.checker.cells import MAX_STATES, Inclusion, System, pattern
from nonsmooth.proofs.checker.choice import BY_ONE, MAX_NESTED, chosen
from nonsmooth.proofs.checker.lyapunov import sign_along
from nonsmooth.proofs.checker.polynomials import Polynomial
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE, STABLE, UNSTABLE
from nonsmooth.proofs.falling_function import growth_hypotheses
from nonsmooth.proofs.findings import Equilibrium, Translation
from nonsmooth.proofs.kernel.cells import (
    BeyondReachError,
    StatedCells,
    build_inclusion,
    sharpened,
    started,
    stated_cells,
)
from nonsmooth.proofs.kernel.escapes import show_escape_of
from nonsmooth.proofs.kernel.fans import show_by_fan
from nonsmooth.proofs.kernel.first_terms import show_departure_of, show_linearization_of
from nonsmooth.proofs.kernel.search import Entry, NotShownError, Search, instability_hypotheses, stability_hypotheses
from nonsmooth.proofs.kernel.second_function import find_attraction
from nonsmooth.proofs.kernel.subject import NoCertificateError, about
from nonsmooth.proofs.many_states.lyapunov_search import LARGE, find_growing_product, find_growth, show_relay_of
from nonsmooth.proofs.many_states.weak_functions import energies_near, find_kept_function, find_weak_growth
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.proofs.systems.findings import DecidedSystem
from nonsmooth.proofs.systems.lyapunov_search import find_lyapunov
from nonsmooth.proofs.systems.ray_moves import are_cones
from nonsmooth.proofs.systems.scalar_stability import clear_distance, within
from nonsmooth.proofs.systems.system_stability import PlanePoint
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.formulas.trees import ExpressionError
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.plane import cross
from nonsmooth.symbolic.systems.switched_system import PLANE, SwitchedSystem

Show: TypeAlias = Callable[[SwitchedSystem, str], Entry]
ShowWithin: TypeAlias = Callable[[SwitchedSystem, str, Search], Entry]  # with no more work than a search is allowed


@dataclass(frozen=True)
class TheoremSearch:
    """A way to a theorem.

    Attributes:
        name: of what shows the verdict.
        show: finds the entry of a certificate for a system and a verdict; raises ``NotShownError`` where nothing is
            found, and ``BeyondReachError`` for systems that it does not look at.
        verdicts: those that it may show.
        most_states: of the systems that it is for.
    """

    name: str
    show: Show
    verdicts: tuple[str, ...]
    most_states: int = MAX_STATES


def show_growth_of(system: SwitchedSystem, verdict: str, search: Search | None = None) -> Entry:
    """Evidence that the point is unstable by a function that falls, or does not rise, and is negative near it.

    Args:
        system: in two states or more.
        verdict: unstable.
        search: with what was shown before.

    Returns:
        The entry of a certificate, and what it shows.

    Raises:
        NotShownError: where none is found.
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    subject, _ = started(system)
    growth = None
    if not system.is_planar:
        growth = find_growth(system) or find_growing_product(system) or find_growth(system, LARGE)
    if growth is not None:
        return Search(known=growth["proofs"]).entry(subject, "instability", growth["hypotheses"])
    entry = find_weak_growth(system, search)
    if entry is None:
        raise NotShownError("no function was found that shows instability")
    return entry


def show_attraction_of(system: SwitchedSystem, verdict: str) -> Entry:
    """Evidence that the point attracts by an energy that does not rise, and functions that rise where it is kept.

    Args:
        system: in two states or more.
        verdict: asymptotically stable.

    Returns:
        The entry of a certificate, and what it shows.

    Raises:
        NotShownError: where none is found.
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    entries = (find_attraction(system, potential, radius) for potential, radius in energies_near(system))
    entry = next(filter(None, entries), None)
    if entry is None:
        raise NotShownError("no energy was found that shows that the point attracts")
    return entry, [{"stability": verdict}]


def show_energy_of(system: SwitchedSystem, verdict: str) -> Entry:
    """Evidence that the point is stable by a V that solutions keep, of systems such as linear ones with turning pairs.

    Args:
        system: in two states or more.
        verdict: stable.

    Returns:
        The entry of a certificate, and what it shows.

    Raises:
        NotShownError: where none is found.
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    subject, search = started(system)
    energy = find_kept_function(system)
    if energy is None:
        raise NotShownError("no polynomial was found that is positive and kept")
    return search.entry(subject, "lyapunov", stability_hypotheses(energy.stated.record, energy.formula.text, STABLE))


# ---- the search for a switching law under which the point is unstable ----------------------------
#
# As :mod:`nonsmooth.proofs.checker.choice` states it.
#
# Tried are each right-hand side, the mean of two, and two of them above and below a coordinate or a switching surface:
# a disturbance of either sign that pushes along with the velocity is one of these.  In the plane the law that leaves
# fastest changes from one field to another where they are parallel; so lines near those on which the first terms of two
# fields are parallel are tried too, one by one and in pairs.


MOST_TRIED = 64
MOST_SEARCHED = 16  # of these, that first terms do not rule out
WORK = 2_000  # coefficients looked at for one claim: functions on cones need few
ANGLES = np.linspace(0.0, np.pi, 181)  # at which it is seen where two fields are parallel
DENOMINATOR = 8  # of slopes
IN_MANY: Sequence[ShowWithin] = (show_departure_of, show_linearization_of, show_escape_of)
IN_PLANE: Sequence[ShowWithin] = (*IN_MANY, show_by_fan, show_growth_of)


def show_choice_of(system: SwitchedSystem, verdict: str = UNSTABLE) -> Entry:
    """Evidence that the checked point is unstable for a choice among several right-hand sides.

    Args:
        system: in two states or more.
        verdict: unstable.

    Returns:
        The entry of a certificate, and what it shows.

    Raises:
        NotShownError: where none is found, and where right-hand sides only enclose the field.
        BeyondReachError: for irrational numbers.
    """
    if system.only_encloses or not system.others:
        raise NotShownError("a choice needs several right-hand sides that may act")
    subject, search = started(system)
    lines = parallel_lines(system, subject, search) if system.is_planar else []
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
                hypotheses = {"choice": choice, "theorem": entry["theorem"], "hypotheses": entry["hypotheses"]}
                return Search(known=entry["proofs"]).entry(subject, "choice", hypotheses)
    raise NotShownError("no choice among the right-hand sides was found that is unstable")


def _searches(system: SwitchedSystem) -> Sequence[ShowWithin]:
    """What is tried for one right-hand side: nothing where first terms show that the point attracts.

    Where they show a spiral that leaves, a V that grows is tried first.
    """
    if not system.is_planar:
        return IN_MANY
    point = PlanePoint(system)
    try:
        verdicts = {finding.verdict for finding in (point.fan, point.leading) if finding is not None}
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
    function = find_lyapunov(system, grows=True, is_linear=PlanePoint(system).is_led_by_linear_parts)
    if function is None or function.decrease is not Decrease.STRICT:
        raise NotShownError("no function was found that grows along every solution")
    try:
        return search.entry(subject, "instability", growth_hypotheses(system, function))
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
        surfaces |= dict.fromkeys(str(surface) for surface in system.surfaces() if surface.degree)
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
            slopes += [slope for slope in _zeros(cross(f, g)) if _touches(inclusion, cell.signs, slope)]
    if any(
        at and coordinate != name
        for coordinate, name, at in zip(subject.coordinates, subject.states, subject.at, strict=True)
    ):
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
    forms = [surfaces.signed(j, sign) for j, sign in enumerate(signs)]
    return any(all(sign_along(s, [side * c for c in direction]) >= 0 for s in forms) for side in (1, -1))


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


# ---- the registry --------------------------------------------------------------------------------


THEOREM_SEARCHES = (
    TheoremSearch("no equilibrium", show_departure_of, (UNSTABLE,)),
    TheoremSearch("linearization", show_linearization_of, (UNSTABLE, ASYMPTOTICALLY_STABLE)),
    TheoremSearch("solution that leaves", show_escape_of, (UNSTABLE,)),
    TheoremSearch("piecewise linear V on a fan", show_by_fan, (UNSTABLE, STABLE, ASYMPTOTICALLY_STABLE), len(PLANE)),
    TheoremSearch("energy that does not rise", show_attraction_of, (ASYMPTOTICALLY_STABLE,)),
    TheoremSearch("relative degree of a relay", show_relay_of, (UNSTABLE,)),
    TheoremSearch("function that shows instability", show_growth_of, (UNSTABLE,)),
    TheoremSearch("polynomial that is kept", show_energy_of, (STABLE,)),
    TheoremSearch("choice among right-hand sides", show_choice_of, (UNSTABLE,)),
)


def show_verdict(system: SwitchedSystem, verdict: str) -> Entry:
    """Evidence of a verdict by the first search that finds it.

    Args:
        system: in two states or more.
        verdict: asymptotically stable, stable or unstable.

    Returns:
        The entry of a certificate, and what it shows, the verdict among it.

    Raises:
        NotShownError: where none finds it, with the reason of each.
    """
    reasons = []
    for search_for in THEOREM_SEARCHES:
        if verdict not in search_for.verdicts or len(system.states) > search_for.most_states:
            continue
        try:
            return search_for.show(system, verdict)
        except (NotShownError, BeyondReachError) as error:
            reasons.append(str(error))
        except OverflowError:
            reasons.append("numbers beyond floats")
    raise NotShownError("; ".join(reasons) or "no theorem was found that shows it")


# ---- certificates of systems in one state --------------------------------------------------------
#
# A function V of the displacement, on the intervals between switchings.
#
# The point attracts with ``V = (x/a)^2`` left and ``(x/b)^2`` right of it, below the level 1 on ``(-a, b)``; it is
# stable with ``V = x^2``; a solution leaves it where V falls and is negative, or along one field that leads away.  The
# signs of the fields beside the point say which of these to write, and the checker shows it.  All is about the
# displacement from the point, or about that of the signed root where the state has one.


Theorem: TypeAlias = tuple[str, dict[str, Any]]  # its name, and its hypotheses


def scalar_theorem(result: DecidedSystem, system: System) -> Theorem:
    """The theorem that shows a verdict in one state, with its hypotheses.

    Args:
        result: of a check, not undecided.
        system: of the certificate.

    Raises:
        NoCertificateError: for a solution that leaves where right-hand sides only enclose the field.
        BeyondReachError: for too many surfaces or cells, and for numbers that are too large or too small.
    """
    (name,), scene = system.coordinates, result.scene
    if result.verdict is Translation.ASYMPTOTICALLY_STABLE:
        return _attraction(result, system)
    radius = within(clear_distance(scene))
    stated = _cells(scene, system, radius)
    if result.verdict is Translation.STABLE:
        return "lyapunov", stability_hypotheses(stated.record, f"{name}**2", STABLE)
    if result.equilibrium is Equilibrium.FAILS:  # all velocities at the point have one sign
        upward = result.deciding.proofs.right.values[0].sign() > 0
        return "departure", {"cells": stated.record, "direction": ["1" if upward else "-1"]}
    return _leaving(result, name, stated, radius)


def _cells(scene: SwitchedSystem, system: System, radius: Fraction) -> StatedCells:
    """The cells of an interval about the point, which the point parts."""
    stated = stated_cells(scene, scene.field(radius), scene.coordinates(), irrational=True)
    return sharpened(stated, system, Search())


def _attraction(result: DecidedSystem, system: System) -> Theorem:
    """``V < 1`` exactly on the interval of starts that reach the point."""
    (name,) = system.coordinates
    sides = result.deciding.proofs
    right, left = (within(side.reach) for side in (sides.right, sides.left) if side.reach is not None)
    function = f"relu({name})**2/({right**2}) + relu(-{name})**2/({left**2})"
    if left == right:
        function = f"{name}**2/({right**2})"
    cells = _cells(result.scene, system, max(left, right)).record
    return "lyapunov", {**stability_hypotheses(cells, function, ASYMPTOTICALLY_STABLE), "level": "1", "below": True}


def _leaving(result: DecidedSystem, name: str, stated: StatedCells, radius: Fraction) -> Theorem:
    """Every solution that starts on one side leaves, or one solution does.

    Where all fields of each side have one sign, V is the distance on a side where they lead back, and minus it where
    they lead away: that holds for all that several right-hand sides may enclose.  Else one of them is followed.
    """
    cells, sides = stated.record, result.deciding.proofs
    left, right = sides.left.outward, sides.right.outward
    turn, outward = (1, right) if max(right) > 0 else (-1, left)
    if abs(sum(left)) == len(left) and abs(sum(right)) == len(right):
        function = f"-{name}" if sum(left) < sum(right) else name if sum(left) > sum(right) else f"-Abs({name})"
        return "instability", instability_hypotheses(cells, function, [turn])
    if result.scene.only_encloses:
        raise NoCertificateError("one solution of fields that are only enclosed says nothing of the stated one")
    signs = pattern(surface((turn * radius / 2,)).sign() for surface in stated.surfaces)
    field = [signs, outward.index(max(outward)), "1", [str(turn)]]
    start = {"within": str(radius), "surfaces": cells["surfaces"], "signs": signs, "direction": [str(turn)]}
    rising = name if turn > 0 else f"-{name}"
    return "escape", {**start, "along": [], "mixture": [field], "barriers": [], "function": rising}
