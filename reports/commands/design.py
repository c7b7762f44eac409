"""``nonsmooth design``: which headings, speeds and positions meet what is required, and do best."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.reports.console import RefusedError, write_json, write_views
from nonsmooth.reports.options import AllowOutside, At, Json, Radius, RuleOption, SceneText

if TYPE_CHECKING:
    from nonsmooth.reports.designs.freedom import Freedom
    from nonsmooth.reports.designs.search import Wish
    from nonsmooth.symbolic.scene import Scene

FREE = ("headings", "speeds", "positions")
REQUIRED = ("position", "heading", "pose")
MAXIMIZED = ("rate", "gain", "basin", "tolerance")
MOST_CHECKS = 100_000


def design(  # noqa: PLR0913, PLR0917  # one parameter for each option of the command
    scene: SceneText,
    free: Annotated[
        str, typer.Option("--free", metavar="NAMES", help="What may change: headings,speeds,positions.")
    ] = "headings",
    require: Annotated[
        str, typer.Option("--require", metavar="NAMES", help="Answers that must be good: position,heading,pose.")
    ] = "position",
    maximize: Annotated[
        str,
        typer.Option(
            "--maximize",
            metavar="NAME",
            help="rate (at which bodies come home), gain (of feedback), basin (whence they come home), or tolerance.",
        ),
    ] = "rate",
    move: Annotated[
        str | None,
        typer.Option(
            "--move", metavar="D", help="How far a wheel may move in x and y; a quarter of the square's side."
        ),
    ] = None,
    symmetry: Annotated[
        int | None,
        typer.Option("--symmetry", metavar="1|2|4", help="Turns that leave the array as it is; the most it has."),
    ] = None,
    checks: Annotated[int, typer.Option("--checks", metavar="N", help="How many arrays are checked at most.")] = 300,
    seed: Annotated[int, typer.Option("--seed", metavar="S", help="Of the search, which is repeatable.")] = 1,
    output: Annotated[
        str | None, typer.Option("-o", "--output", metavar="FILE", help="Write the scene that was found: .toml.")
    ] = None,
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    allow_outside: AllowOutside = False,
    json: Json = False,
) -> int:
    """Search for the headings, speeds and positions of the wheels that meet requirements and do best.

    Exit status: 0 found, 1 nothing found that meets the requirements, 2 bad input.
    """
    from nonsmooth.reports.designs.search import find_design, named
    from nonsmooth.reports.designs.toml_text import toml_text
    from nonsmooth.reports.designs.views import design_record, design_view
    from nonsmooth.reports.files import output_path, write_whole
    from nonsmooth.reports.progress import progress
    from nonsmooth.symbolic.files.scene_file import build_scene, deep_nesting_refused, read_document

    file = None if output is None else output_path(output, (".toml",))
    with deep_nesting_refused(scene):
        document, label, path = read_document(scene, rule=rule, radius=radius, at=at)
        given = build_scene(document, label, path, allow_outside=allow_outside)
    wish = _wish(require, maximize, checks, seed)
    if wish.maximize == "tolerance" and given.tolerances is None:
        raise RefusedError(f"{given.source}: tolerance: required a [tolerance] table to maximize it, received none")
    freedom = replace(_freedom(free, move, Fraction(float(given.check.radius)) / 2), order=_order(given, symmetry))
    with progress("checked") as report:
        found = find_design(document, path.parent, given, freedom, wish, report)
    found = named(found, f"{given.name}-designed", wish)
    if file is not None and found.is_found:
        write_whole(file, toml_text(found.document).encode())
    if json:
        write_json(design_record(found, wish))
    else:
        write_views([design_view(found, wish)])
    return 0 if found.is_found else 1


def _names(text: str, option: str, known: tuple[str, ...]) -> tuple[str, ...]:
    """Names of a list with commas, in the order in which they are known."""
    names = {name.strip() for name in text.split(",")}
    unknown = sorted(names - set(known))
    if unknown:
        raise RefusedError(f"{option}: required names among {', '.join(known)}, received {unknown[0][:60]!r}")
    return tuple(name for name in known if name in names)


def _wish(require: str, maximize: str, checks: int, seed: int) -> Wish:
    from nonsmooth.reports.designs.search import Wish

    (objective, *others) = _names(maximize, "--maximize", MAXIMIZED)
    if others:
        raise RefusedError(f"--maximize: required one name, received {maximize[:60]!r}")
    if not 1 <= checks <= MOST_CHECKS:
        raise RefusedError(f"--checks: required a number from 1 to {MOST_CHECKS}, received {checks}")
    if seed < 0:
        raise RefusedError(f"--seed: required a number of at least 0, received {seed}")
    return Wish(_names(require, "--require", REQUIRED), objective, checks, seed)


def _order(scene: Scene, asked: int | None) -> int:
    """Of the symmetry to keep: the largest that the scene has unless another is asked for."""
    from nonsmooth.reports.designs.symmetry import ORDERS, largest_symmetry, orbits_of

    if asked is None:
        return largest_symmetry(scene)
    if asked not in ORDERS or orbits_of(scene, asked) is None:
        required = f"one of {', '.join(str(order) for order in ORDERS if orbits_of(scene, order) is not None)}"
        raise RefusedError(f"--symmetry: required {required} for the places of these wheels, received {asked}")
    return asked


def _freedom(free: str, move: str | None, usual: Fraction) -> Freedom:
    """What may change; wheels move by a quarter of the square's side unless told otherwise."""
    from nonsmooth.reports.designs.freedom import Freedom
    from nonsmooth.symbolic.expression import ExpressionError
    from nonsmooth.symbolic.files.scene_values import read_exact

    kinds = _names(free, "--free", FREE)
    if move is None:
        return Freedom(kinds, move=usual.limit_denominator(1000))
    try:
        number = read_exact(move)
    except ExpressionError:
        number = Fraction(0)
    if not isinstance(number, Fraction) or number <= 0:
        raise RefusedError(f"--move: required a positive rational number such as 1/10, received {move[:60]!r}")
    return Freedom(kinds, move=number)
