"""All zeros of a map in a box: boxes are dropped, narrowed or halved until each holds one zero, or is left.

A box is dropped where a guard is negative, a value or its mean value form is not zero, or Krawczyk's operator has no
point in it; it holds one zero where the operator maps it into its interior
(:mod:`nonsmooth.proofs.boxes.enclosures`).  So every zero lies in what is found or left.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import prod
from typing import TypeAlias

from flint import arb, arb_mat

from nonsmooth.proofs.boxes.enclosures import (
    UNIT,
    Map,
    approximate_inverse,
    isolated_zero,
    krawczyk,
    lies_inside,
    newton,
)

MOST_BOXES = 4_000  # that are looked at for the zeros of one set of equations
SPLIT = 1 / 2 + 2.0**-5  # of a side: a zero in the middle is on no border of boxes then
WIDER = 1 + 2.0**-3  # than a box is the one in which a zero is shown, so that one on its border is
LEAST = 2.0**-40  # of the cube: by so much it is wider in any case
MOST_SLENDER = 8  # the longest side over the shortest one
FINEST = 2.0**-20  # of the cube: smaller boxes are left
NEWTON_STEPS = 6  # from the middle of a box in which a zero is isolated

Box: TypeAlias = list[arb]
Guards: TypeAlias = Sequence[Callable[[Sequence[arb]], arb]]  # positive where the equations are meant


@dataclass
class Zeros:
    """The zeros of a map in a box: where its guards may be positive, all of them are in what is found or left."""

    found: list[Box] = field(default_factory=list)
    regions: list[Box] = field(default_factory=list)  # in each of which there is one zero, that which is found
    left: list[Box] = field(default_factory=list)


def all_zeros(equations: Map, guards: Guards, box: Box, narrow: Callable[[Box], Box | None], shown: int) -> Zeros:
    """All zeros in a box on which no guard is negative.

    Args:
        equations: the map.
        guards: the guards.
        box: the box.
        narrow: a part of a box that holds all its zeros; None where there are none.
        shown: how many sides of a box, the first ones, are told apart: where these are small it is left.
    """
    result, waiting, looked = Zeros(), deque([box]), 0
    sizes = [float(side.rad()) or 1.0 for side in box]
    while waiting:
        whole, looked = waiting.popleft(), looked + 1  # the largest first
        part = None if any(bool(guard(whole) < 0) for guard in guards) else narrow(whole)
        if part is None:
            continue
        narrowed = _narrowed(whole, part, sizes)
        wide = [a.mid() + (a.rad() * WIDER + size * LEAST) * UNIT for a, size in zip(narrowed, sizes, strict=True)]
        image, is_inside = _image(equations, wide)
        if not overlap(image, narrowed):
            continue
        if is_inside:
            _keep(result, _refined(equations, image, wide), wide, narrowed)
            continue
        longest = max(float(a.rad()) / size for a, size in zip(narrowed[:shown], sizes, strict=False))
        if looked > MOST_BOXES or longest < FINEST:
            result.left.append(narrowed)
            continue
        rest = _narrowed(narrowed, image, sizes)
        shrinks = prod(float(a.rad()) / (float(b.rad()) or 1.0) for a, b in zip(rest, whole, strict=True))
        waiting += [rest] if shrinks < 1 / 4 else halves(rest, sizes)
    return result


def _narrowed(box: Box, image: Box, sizes: Sequence[float]) -> Box:
    """The part of a box in which all its zeros are, but not much narrower in one direction than in others."""
    rest = [a.intersection(b) for a, b in zip(image, box, strict=True)]
    least = max(float(a.rad()) / size for a, size in zip(rest, sizes, strict=True)) / MOST_SLENDER
    wide = [a.union(a.mid() + least * size * UNIT) for a, size in zip(rest, sizes, strict=True)]
    return [a.intersection(b) for a, b in zip(wide, box, strict=True)]


def _image(equations: Map, box: Box) -> tuple[Box, bool]:
    """Where all zeros of a box are, and whether there is one, no more; nowhere in it, if it holds none."""
    column = arb_mat([[side] for side in box])
    middle = arb_mat([[arb(side.mid())] for side in box])
    over, here = equations(column), equations(middle)
    if over is None or here is None:
        return box, False
    nearer = here[0] + over[1] * (column - middle)
    if any(not a.contains(0) or not b.contains(0) for a, b in zip(over[0].entries(), nearer.entries(), strict=True)):
        return [side.upper() + 1 for side in box], False
    inverse = approximate_inverse(over[1])
    if inverse is None:
        return box, False
    image = krawczyk(middle, here[0], inverse, over[1], column)
    return list(image.entries()), lies_inside(image, column)


def _refined(equations: Map, image: Box, region: Box) -> Box:
    """A smaller box about the one zero in a box."""
    centre = newton(equations, arb_mat([[side.mid()] for side in image]), NEWTON_STEPS)
    zero = None if centre is None else isolated_zero(equations, centre)
    if zero is None or not all(a.contains(b) for a, b in zip(region, zero.entries(), strict=True)):
        return image
    return [a.intersection(b) for a, b in zip(image, zero.entries(), strict=True)]


def _keep(result: Zeros, zero: Box, region: Box, box: Box) -> None:
    """Note a zero that may lie in a box, unless it is known."""
    if not overlap(zero, box):
        return
    for known, other in zip(result.found, result.regions, strict=True):
        if all(b.contains(a) for a, b in zip(zero, other, strict=True)) or all(
            b.contains(a) for a, b in zip(known, region, strict=True)
        ):
            return
    result.found.append(zero)
    result.regions.append(region)


def halves(box: Box, sizes: Sequence[float]) -> list[Box]:
    """Its two parts across the side that is longest beside that of the first box."""
    k = max(range(len(box)), key=lambda j: float(box[j].rad()) / sizes[j])
    low, high = box[k].lower(), box[k].upper()
    cut = (low + (high - low) * SPLIT).mid()
    return [[*box[:k], a.union(b), *box[k + 1 :]] for a, b in ((low, cut), (cut, high))]


def overlap(first: Sequence[arb], second: Sequence[arb]) -> bool:
    """Whether two boxes may have a place in common."""
    return all(a.overlaps(b) for a, b in zip(first, second, strict=True))
