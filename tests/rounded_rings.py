"""Rings of wheels whose headings are turned off inward by whole degrees, in three notations of the same table.

Wheel k of n stands at the angle 2 pi k/n of the unit circle, and all headings are turned by the same angle.  A turn of
the table by 2 pi/n is the same table again, so the motion at the middle is so too: its translation vanishes.  Hence the
middle is an equilibrium under every rule, and what says otherwise is wrong.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

from nonsmooth.proofs.answers.answers import answers_of
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.symbolic.files.scene_file import load_scene

ROUNDING = 1e-12  # of the radius of the ring: who comes so near is there
RULES = ("nearest", "box", "ellipse", "roller")
_FRICTION = '[friction]\nmu_roll = 1\nmu_side = "1/2"\n'


class Said(NamedTuple):
    """What a check says of a ring: of the position, of clause 1, and whether rounding leaves a clause open."""

    position: str
    equilibrium: str
    by_rounding: bool


def notations(folder: Path, count: int, turn: int) -> Iterator[Path]:
    """The ring in a field, wheel by wheel, and as a table."""
    field = folder / "field.toml"
    field.write_text(f'{_FRICTION}[ring]\ncount = {count}\n[field]\nkind = "spiral"\nangle = "{turn} deg"\n')
    yield field
    places = [f"{Fraction(2 * k, count)}*pi" for k in range(count)]
    headings = [Fraction(180 + turn) + Fraction(360 * k, count) for k in range(count)]
    wheels = [
        f'[[wheel]]\nposition = ["cos({place})", "sin({place})"]\nheading = "{heading} deg"\n'
        for place, heading in zip(places, headings, strict=True)
    ]
    one_by_one = folder / "wheels.toml"
    one_by_one.write_text(_FRICTION + "".join(wheels))
    yield one_by_one
    rows = [f"cos({place}),sin({place}),{heading}" for place, heading in zip(places, headings, strict=True)]
    (folder / "table.csv").write_text("\n".join(["x,y,heading", *rows, ""]))
    table = folder / "table.toml"
    table.write_text(f'{_FRICTION}[units]\nangle = "deg"\n[wheels]\nfile = "table.csv"\n')
    yield table


def said_of_ring(folder: Path, count: int, turn: int, rule: str) -> list[Said]:
    """What is said of each notation; all evidence is verified."""
    found = []
    for source in notations(folder, count, turn):
        check = check_theorem4(load_scene(source, rule=rule), beside=False)
        if not check.check():
            raise AssertionError(f"{count} wheels turned by {turn} degrees, rule {rule}: evidence does not verify")
        position, equilibrium = answers_of(check)[0], check.results["equilibrium"].verdict
        is_there = position.verdict == "comes near" and position["ends_within"] < ROUNDING
        verdict = "comes home" if is_there else str(position.verdict)
        found.append(Said(verdict, str(equilibrium), bool(check.by_rounding)))
    return found


def contradiction(said: list[Said]) -> str:
    """Why what is said cannot be true; empty where it can."""
    decided = {one.position for one in said} - {"undecided"}
    if len(decided) > 1:
        return f"the notations contradict each other: {', '.join(sorted(decided))}"
    if any(one.equilibrium == "fails" for one in said):
        return "the middle is an equilibrium by symmetry, and is said to be none"
    return ""
