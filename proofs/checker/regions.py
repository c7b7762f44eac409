"""Where bodies stay, and how they come home: discs and ellipses about the checked point of an array.

Let ``V* = max c' . grad V`` over the motions of all closed cells that hold c.  Every theorem here says, in its
docstring, what it shows of the solutions of ``c' = v + omega J c``, with v and omega in the hull of the motions.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any

from .contact import Cell, Cells, Motion
from .plane import Form, around, convex_hull, outweighs
from .positivity import Proofs
from .theorems import Statement
from .tower import Number, Vector, cross, dot, is_zero, signs
from .work import items, rational, require, take

MAX_STEPS = 64


def show_disc(cells: Cells, proofs: Proofs, squared_radius: Number) -> str:
    """V* keeps its sign, for ``V = |c|^2``, on a disc about the point, on which the body does not tip; here its sign.

    The disc lies in the square and in the support polygon, the convex hull of all wheels.  Cells away from the
    point where V* grows have their growing part outside the disc: a barrier ``(m, t)``, t >= 0, with
    ``m . c >= 1`` at all corners shows ``(m + t v) . c >= 1`` wherever ``v . c >= 0`` in the cell, so there
    ``|c| >= 1/|m + t v|``, which is at least the radius of the disc.
    """
    one, zero, radius = cells.one, cells.zero, cells.array.radius
    inside = squared_radius.sign() > 0 and (radius * radius - squared_radius).sign() >= 0
    require(inside and cells.highest <= 0, "a disc in the square where V* shows one")
    require(_stands_on(cells, Form(one, zero, one), squared_radius), "a disc in the support polygon")
    for k, cell in enumerate(cells.listed):
        for j, motion in enumerate(cell.motions):
            if cell.rays is None and max(motion.rates) > cells.highest:
                name = f"barrier {k} {j}"
                _show_barrier(name, cell, motion.twist, squared_radius, cells.vector(proofs.evidence(name), 3))
    return "strictly" if cells.highest < 0 else "weakly"


def _show_barrier(name: str, cell: Cell, v: Vector, squared_radius: Number, barrier: Vector) -> None:
    a, b, t = barrier
    one = v[3]
    margins = [t, *(dot((a, b, -one), corner) for corner in cell.corners)]
    n = (a + t * v[0], b + t * v[1])
    margins.append(one - squared_radius * dot(n, n))
    require(min(signs(margins)) >= 0, f"the {name}")


def _stands_on(cells: Cells, form: Form, level: Number) -> bool:
    """Whether the body does not tip where ``c^T P c <= level``."""
    hull = convex_hull([wheel.place for wheel in cells.array.wheels.values()])
    return len(hull) > 2 and min(form.margins(level, around(hull))) >= 0


def show_arrival(cells: Cells, rate: Number) -> None:
    """``|c|`` falls at least at a rate in the square: a start in the disc is home within ``|c0|/rate``.

    ``c . v + rate |c|`` is convex on a closed cell: not positive at its corners, it is so in all of it.
    """
    require(rate.sign() > 0, "a positive rate")
    for c, motion in _at_corners(cells):
        falls = outweighs(-dot(c, motion.twist), rate, dot(c, c))
        require(falls, "a rate at which the distance falls in the square")


def show_turning(cells: Cells, factor: Number) -> None:
    """From a start in the disc of :func:`show_disc` the body turns by at most ``factor |c0|`` in all.

    With ``factor c . v + |omega| |c| <= 0`` at the corners of every cell with ``omega != 0`` it is so on the closed
    cell, where it is convex; in the other cells the distance does not grow on the disc.  So ``|omega|`` is at most
    -factor times the derivative of ``|c|`` off the point, for mixtures of motions too.  At the point itself the body
    stays without turning: its drift is {0}.
    """
    bound = "a bound of the rotation for each unit of distance"
    require(factor.sign() >= 0, bound)
    for c, motion in _at_corners(cells):
        turn = motion.twist[2]
        require(not turn.sign() or outweighs(-dot(c, motion.twist) * factor, turn, dot(c, c)), bound)


def _at_corners(cells: Cells) -> Iterator[tuple[Vector, Motion]]:
    """Every corner of every cell with every motion there."""
    for cell in cells.listed:
        for motion in cell.motions:
            for x, y, _ in cell.corners:
                yield (x, y), motion


# ---- ellipses ------------------------------------------------------------------------------------


def show_ellipse(cells: Cells, data: Any, *, rests: bool) -> list[Statement]:
    """Every start in a disc stays in a larger one, and is at the point after a time in proportion to its distance.

    *Stays*: with ``V = c^T P c`` the ellipse ``V <= L`` holds the disc ``|c|^2 <= r`` of starts and lies in the disc
    ``|c|^2 <= w``, in the support polygon, and inside the cells at the point; there V does not grow.  So no solution
    from the disc leaves the ellipse.  It is inside these cells where it stays left of the lines of all their sides, or
    of these sides alone: what it holds of a ray between two cells it holds up to the point.

    *Arrives*: let ``W = c^T Q c``, not above M on the disc, fall in the ellipse, so that sqrt(W) falls at least with
    the speed ``r_k`` where ``sqrt(W) <= (k/n) sqrt(M)``, k = 1, ..., n, and ``r_1 >= ... >= r_n > 0``.  Then a solution
    from c0 with ``W(c0) = s^2 M`` is at the point after ``sqrt(M)`` times the integral of 1/r from 0 to s, at most
    ``sqrt(W(c0))`` times the mean of all ``1/r_k``.  With ``Q mean^2 rate^2 <= 1`` that is at most ``|c0|/rate``.

    *Turns*: where ``|omega| <= factor rate`` for all motions at the point and the drift is {0}, the body turns by at
    most ``factor |c0|`` until it is at the point, and rests there.
    """
    names = "squared_radius form level squared_swing bend arrival"
    start, form_data, level_data, swing, bend, arrival, turn, along = take(data, names, "turn sides")
    form, level = Form(*cells.vector(form_data, 3)), cells.parse(level_data)
    squared_radius, squared_swing = cells.parse(start), cells.parse(swing)
    sides = [side for cell in cells.listed if cell.rays is not None for side in around(cell.corners)]
    outer = [(a, b) for a, b in sides if cross(a, b).sign()]
    require(_is_within(form, squared_radius, level), "an ellipse that holds the disc of starts")
    require(form.scaled(squared_swing).is_at_least(level), "an ellipse in the disc that bodies stay in")
    require(along in (None, True), "true, where the lines of sides are crossed beyond these")
    require(min(form.margins(level, outer, whole=along is None)) > 0, "an ellipse inside the cells at the point")
    require(_stands_on(cells, form, level), "an ellipse in the support polygon")
    _require_falls(cells, form, level, rational(bend), [Fraction(0)])
    conclusions: list[Statement] = [{"swing": {"squared_radius": start, "squared_swing": swing}}]
    if arrival is not None:
        rate = _show_swift(cells, squared_radius, arrival)
        conclusions.append({"arrival": {"squared_radius": start, "rate": arrival["rate"]}})
    if turn is not None:
        require(arrival is not None and rests, "a body that arrives, and rests at the point without turning")
        largest = cells.parse(turn) * rate
        turns = [motion.twist[2] for motion in cells.here]
        require(
            min(signs(s for omega in turns for s in (largest - omega, largest + omega))) >= 0, "a bound of the rotation"
        )
        conclusions.append({"turning": {"squared_radius": start, "per_distance": turn}})
    return conclusions


def _show_swift(cells: Cells, squared_radius: Number, data: Any) -> Number:
    """The second part of :func:`show_ellipse`; here the rate."""
    form_data, level_data, bend, listed, rate_data = take(data, "form level bend speeds rate")
    form, level, rate = Form(*cells.vector(form_data, 3)), cells.parse(level_data), cells.parse(rate_data)
    speeds = [rational(speed) for speed in items(listed, most=MAX_STEPS)]
    require(speeds and speeds == sorted(speeds, reverse=True) and speeds[-1] > 0, "positive speeds, the largest first")
    require(_is_within(form, squared_radius, level), "a level that holds the disc of starts")
    _require_falls(cells, form, level, rational(bend), speeds)
    mean = sum((1 / speed for speed in speeds), Fraction(0)) / len(speeds)
    whole = rate * cells.rational(mean)
    require(rate.sign() > 0 and form.scaled(whole * whole).is_at_most(cells.one), "a rate at which bodies arrive")
    return rate


def _is_within(form: Form, squared_radius: Number, level: Number) -> bool:
    """Whether ``c^T P c <= level`` where ``|c|^2 <= squared_radius``."""
    return form.scaled(squared_radius).is_at_most(level)


def _require_falls(cells: Cells, form: Form, level: Number, bend: Fraction, speeds: Sequence[Fraction]) -> None:
    """On the cones of the cells at the point sqrt(V) falls with speed k of n where ``sqrt(V) <= (k/n) sqrt(level)``.

    ``V'/2 = c^T P v + omega c^T P J c``, and ``|c^T P J c| <= m V`` where ``4 m^2 det P`` is the squared difference of
    the eigenvalues of P.  So with a bend of at least ``m sqrt(level)`` it is enough that ``c^T P v + s sqrt(V) <= 0``
    for ``s = speed + |omega| bend k/n``, which is convex and homogeneous: it suffices at the corners of the cell.
    """
    square = cells.rational(4 * bend * bend) * form.determinant
    require(bend >= 0 and (square - form.spread * level).sign() >= 0, "a bound of what the rotation adds to V")
    for motion in cells.here:
        turn = motion.twist[2] if motion.twist[2].sign() > 0 else -motion.twist[2]
        for corner in cells.listed[motion.cell].corners:
            if is_zero(corner[:2]):
                continue
            down, size = -dot(form.image(corner), motion.twist), form.at(corner)
            for k, speed in enumerate(speeds, 1):
                least = cells.rational(speed) + turn * cells.rational(bend * k / len(speeds))
                require(outweighs(down, least, size), "a speed at which V falls in the cells at the point")
