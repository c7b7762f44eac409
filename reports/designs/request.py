"""What is asked of a design, read from what a user wrote: what may change, what is required, how long to search."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import combinations
from pathlib import Path
from typing import Any

from nonsmooth.analysis.cells.contact_rule import all_rules, rule_of
from nonsmooth.proofs.answers.answer import require_dynamics
from nonsmooth.reports.designs.freedom import KINDS, ORDERS, WHEELS, Freedom, Orbits, largest_symmetry, orbits_of
from nonsmooth.reports.designs.search import OBJECTIVES, Design, Evaluation, Fewest, Told, Wish, evaluate, find_design
from nonsmooth.reports.output.entries import entry
from nonsmooth.reports.simulations.heading_maps import require_outline
from nonsmooth.symbolic.files.scene_file import build_scene, one_by_one
from nonsmooth.symbolic.files.scene_values import read_exact
from nonsmooth.symbolic.formulas.expression import ExpressionError
from nonsmooth.symbolic.mechanics.contact_set import standing
from nonsmooth.symbolic.mechanics.scene import LoadTable, Scene
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact

FREE = (*KINDS, WHEELS)
REQUIRED = ("position", "heading", "pose")
MOST_CHECKS = 100_000
LARGEST_SEED = 2**32 - 1  # of NumPy's Mersenne twister
FINEST = 1000  # denominator of the usual distance that wheels may move


class DesignError(ValueError):
    """``keyword: required ..., received ...``; the command line puts two dashes before it."""


def read_wish(scene: Scene, require: str, maximize: str, checks: int, seed: int) -> Wish:
    """What is required and maximized.

    Args:
        scene: the given array.
        require: names of answers, with commas.
        maximize: name of an objective.
        checks: how many arrays are checked at most.
        seed: of the search.

    Raises:
        DesignError: for what cannot be used.
        SceneError: for a tolerance to maximize that the scene does not state, and a margin under a rule without one.
    """
    (objective, *others) = _names(maximize, "maximize", tuple(OBJECTIVES))
    if others:
        raise DesignError(f"maximize: required one name, received {maximize[:60]!r}")
    if not 1 <= checks <= MOST_CHECKS:
        raise DesignError(f"checks: required a number from 1 to {MOST_CHECKS}, received {checks}")
    if not 0 <= seed <= LARGEST_SEED:
        raise DesignError(f"seed: required a number from 0 to {LARGEST_SEED}, received {str(seed)[:60]}")
    if objective == "tolerance" and scene.tolerances is None:
        raise SceneError(scene.source, "tolerance", "a [tolerance] table to maximize it", StatedFact("nothing"))
    if objective == "margin" and not rule_of(scene).keeps_rows:
        known = " or ".join(f'"{rule.name}"' for rule in all_rules() if rule.keeps_rows)
        wanted = f"{known}, of which the margin of feedback is known, to maximize it"
        raise SceneError(scene.source, "contact.rule", wanted, scene.contact.rule)
    if objective == "settling":
        require_dynamics(scene, "maximize")
    if objective == "heading":
        require_outline(scene)
    return Wish(_names(require, "require", REQUIRED), objective, checks, seed)


def read_freedom(scene: Scene, free: str, move: Any, symmetry: int | None) -> Freedom:
    """What may change.

    Args:
        scene: the given array.
        free: names of what may change, with commas.
        move: how far wheels may move in x and y; None for a quarter of the side of the checked square.
        symmetry: turns that leave the array as it is: 1, 2 or 4; None for the most that it has.

    Raises:
        DesignError: for what cannot be used.
    """
    kinds = _names(free, "free", FREE)
    if WHEELS in kinds and len(kinds) > 1:
        raise DesignError(f"free: required wheels alone, received {free[:60]!r}")
    if WHEELS in kinds and isinstance(scene.contact.loads, LoadTable):
        raise DesignError("free: required loads that some of the wheels have too, received loads stated for all wheels")
    distance = _distance(scene, move)
    if move is not None and "positions" not in kinds:
        raise DesignError(f"move: required positions among what is free, received {', '.join(kinds)}")
    return replace(Freedom(kinds, move=distance), order=_order(scene, symmetry))


def _names(text: str, keyword: str, known: tuple[str, ...]) -> tuple[str, ...]:
    """Names of a list with commas, in the order in which they are known."""
    names = {name.strip() for name in str(text).split(",")}
    unknown = sorted(names - set(known))
    if unknown:
        raise DesignError(f"{keyword}: required names among {', '.join(known)}, received {unknown[0][:60]!r}")
    return tuple(name for name in known if name in names)


def _distance(scene: Scene, move: Any) -> Fraction:
    if move is None:
        return (Fraction(float(scene.check.radius)) / 2).limit_denominator(FINEST)
    try:
        given = read_exact(entry(move))
        number, turns = (given, Fraction(0)) if isinstance(given, Fraction) else given.parts_in_pi()
    except ExpressionError:
        number = turns = Fraction(0)
    if turns or number <= 0:
        raise DesignError(f"move: required a positive rational number such as 1/10, received {str(move)[:60]!r}")
    return number


def _order(scene: Scene, asked: int | None) -> int:
    """Of the symmetry to keep: the largest that the scene has unless another is asked for."""
    if asked is None:
        return largest_symmetry(scene)
    if asked not in ORDERS or orbits_of(scene, asked) is None:
        allowed = ", ".join(str(order) for order in ORDERS if orbits_of(scene, order) is not None)
        raise DesignError(f"symmetry: required one of {allowed} for the places of these wheels, received {asked}")
    return asked


# ---- fewest wheels -------------------------------------------------------------------------------
#
# Every choice is an exact scene that is checked, so that where all smaller ones are refuted none of them suffices.


LEAST = 2  # wheels: under no rule a body stands on fewer


def find_fewest(base: Mapping[str, Any], folder: Path, scene: Scene, order: int, wish: Wish, told: Told) -> Design:
    """The smallest choice of the wheels under the body that meets what is required; of that size the best.

    Args:
        base: the document of the given scene.
        folder: where its files lie.
        scene: the same, read.
        order: of the symmetry that choices keep.
        wish: what is asked for.
        told: called with the choices checked and allowed.
    """
    under = standing(scene)
    own = evaluate(scene, wish.required, OBJECTIVES[wish.maximize])
    orbits = orbits_of(under, order) or tuple((k,) for k in range(len(under.wheels)))
    best: tuple[Evaluation, dict[str, Any], Scene] | None = None
    checks = undecided = 0
    for chosen in _choices(orbits):
        if best is not None and len(chosen) > len(best[2].wheels):
            break
        if checks >= wish.checks:
            break
        document = _document(base, under, chosen)
        candidate = build_scene(document, scene.name, folder / f"{scene.name}.toml")
        found = evaluate(candidate, wish.required, OBJECTIVES[wish.maximize])
        checks += 1
        told(checks, wish.checks)
        undecided += bool(found.unmet) and not found.is_refuted
        if not found.unmet and (best is None or found.cost < best[0].cost):
            best = found, document, candidate
    count = None if best is None else len(best[2].wheels)
    fewest = Fewest(count, undecided, checks < wish.checks or best is not None, len(orbits[0]))
    if best is None or count == len(scene.wheels):  # nothing smaller than the scene itself
        return Design(dict(base), scene, own, own, checks, fewest=fewest)
    return Design(best[1], best[2], best[0], own, checks, fewest=fewest)


def _choices(orbits: Orbits) -> Iterator[tuple[int, ...]]:
    """Sets of wheels made of whole orbits, which have one size, by their number."""
    for count in range(1, len(orbits) + 1):
        for some in combinations(orbits, count):
            chosen = sorted(wheel for orbit in some for wheel in orbit)
            if len(chosen) >= LEAST:
                yield tuple(chosen)


def _document(base: Mapping[str, Any], scene: Scene, chosen: tuple[int, ...]) -> dict[str, Any]:
    return one_by_one(base, replace(scene, wheels=tuple(scene.wheels[place] for place in chosen)))


# ---- the design that is named --------------------------------------------------------------------


def find_named(base: Mapping[str, Any], folder: Path, scene: Scene, freedom: Freedom, wish: Wish, told: Told) -> Design:
    """What :func:`nonsmooth.reports.designs.search.find_design` or ``find_fewest`` finds, with a name and a source."""
    if freedom.kinds == (WHEELS,):
        design = find_fewest(base, folder, scene, freedom.order, wish, told)
    else:
        design = find_design(base, folder, scene, freedom, wish, told)
    if design.best is design.base:  # the given array keeps its name
        return design
    how = f"designed from {scene.name}: {', '.join(wish.required)} required, {wish.maximize} maximized"
    rest = {key: value for key, value in design.document.items() if key not in ("name", "description")}
    return replace(design, document={"name": f"{scene.name}-designed", "description": how, **rest})
