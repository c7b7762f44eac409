"""Clause 4: feedback that brings position and heading of an array home, at which rate; or that none does."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import combinations
from typing import Any

from .contact import Cells, Motion
from .fan import fan_at_point
from .plane import Form
from .positivity import Proofs
from .theorems import ASYMPTOTICALLY_STABLE
from .tower import Number, Vector, cross, dot, has_rank_three, is_zero, negative, normal_to, signs
from .wheels import BOX, NEAREST, edge_slopes, friction_limits
from .work import items, require, take

STABILIZABLE, NO_CERTIFICATE, NOT_APPLICABLE = "stabilizable", "no certificate", "not applicable"


def show_feedback(cells: Cells, proofs: Proofs) -> tuple[str | None, Any]:
    """The claim: some law brings pose and heading home; or no static law does, and why; or it does not apply.

    It speaks of wheels with less friction across the rim than along it: those whose rows act at the point under
    rule nearest, all of them under rule box.  Wheels with a friction axis are followed under rule box only, and
    only where nothing but the speed along the axis counts, and the drive can choose that: then the axis is the rim.
    """
    evidence, array = proofs.evidence_if_any("feedback"), cells.array
    acting = {k for motion in cells.here for _, k in motion.rows}
    wheels = [wheel for k, wheel in array.wheels.items() if array.rule == BOX or k in acting]
    if max((across - along).sign() for along, across in (wheel.friction for wheel in wheels)) >= 0:
        require(evidence is None, "no evidence of a clause that does not apply")
        return NOT_APPLICABLE, None
    drives = [wheel.drive for wheel in wheels if wheel.drive is not None]
    followed = all(drives) if array.rule == BOX else not drives and _are_pairs(cells)
    if not followed or evidence is None:
        require(evidence is None, "feedback of wheels that are followed")
        return (NO_CERTIFICATE if followed and array.rule != BOX else None), None
    kinds = {"signs": _show_signs, "twists": _show_twists, "plane": _show_plane}
    kind = next((name for name in kinds if name in evidence), "plane")
    (data,) = take(evidence, kind)
    kinds[kind](cells, data)
    return (NO_CERTIFICATE, data) if kind == "plane" else (STABILIZABLE, None)


def _are_pairs(cells: Cells) -> bool:
    """Whether the first two rows of every motion at the point are those of one wheel."""
    return all(row[1] == motion.rows[0][1] for motion in cells.here for row in motion.rows[:2])


def _show_plane(cells: Cells, data: Any) -> None:
    """The claim: all motions that any speeds give near the point lie in one plane ``m . xi = 0``.

    Then no static feedback stabilizes (Brockett's condition).  Under rule nearest the motions are those of the
    control fields: along both rims where a roll row stands third, along the nearest one's where a side row does.
    Under rule box every imposed motion lies in the hull of twists along which no rim slips at the edges of the
    arrangement of side rows.
    """
    normal = cells.vector(data, 3)
    require(not is_zero(normal), "a plane of all motions")
    for a, b in _pairs_of_edges(cells):
        twist = normal_to(a, b)
        off = dot(normal, twist).sign()
        allowed = not off or (cells.array.rule == BOX and not _is_imposed(cells, twist, strictly=False))
        require(allowed, "a plane of all motions")


def _pairs_of_edges(cells: Cells) -> Iterator[tuple[Vector, Vector]]:
    rows = cells.array.rows
    if cells.array.rule != BOX:
        for motion in cells.here:
            rolling, side, third = motion.rows
            yield rows[side], rows[third]
            if third[0] == "R":
                yield rows[side], rows[rolling]
        return
    sides = [row[:3] for (kind, _), row in rows.items() if kind == "S"]
    axes = []
    if not has_rank_three(sides):
        axes = [tuple(cells.one if j == k else cells.zero for j in range(3)) for k in range(3)]
    yield from combinations([*sides, *axes], 2)


def _show_twists(cells: Cells, data: Any) -> None:
    """Rule box: three independent twists, each imposed as the only minimizer by speeds along the rims.

    Then so is any multiple of either sign, and ``-k (g . xi) xi``, g the state, with the largest ``|g . xi|`` of
    the three makes ``|g|^2`` fall.
    """
    require(cells.array.rule == BOX, "signs of translations, under rule nearest")
    three = [cells.vector(twist, 3) for twist in items(data, 3)]
    independent = dot(normal_to(three[0], three[1]), three[2]).sign() != 0
    imposed = independent and all(_is_imposed(cells, twist, strictly=True) for twist in three)
    require(imposed, "three independent twists that speeds impose")


def _is_imposed(cells: Cells, twist: Vector, *, strictly: bool) -> bool:
    """Whether a twist minimizes D at the point when all rims move with it, strictly or not."""
    rows = cells.array.rows
    slips = {(kind, k): 0 if kind == "R" else dot(row[:3], twist).sign() for (kind, k), row in rows.items()}
    tight = [rows[row] for row, side in slips.items() if not side]
    if strictly:
        require(has_rank_three(tight), "tight rows of rank three")
    acting = cells.listed[cells.here[0].cell].acting
    limits = friction_limits(cells.array, acting, [(cells.zero, cells.zero, cells.one)])
    least = 1 if strictly else 0
    return all(min(slopes) >= least for _, slopes in edge_slopes(rows, slips, limits))


def _show_signs(cells: Cells, data: Any) -> None:
    """Rule nearest: theta is brought home first; then the body moves along the nearest rims, ``+-|c| d_i``.

    That planar field is a fan of cones; if all its paths lead inward, so do those of the law.  If all rims are
    tangential, full turns of gain one serve too: turning the body to and fro then brings it home.  Without
    turning every crossing is of order one, so nothing else is left open by the fan.
    """
    require(cells.array.rule != BOX, "three twists, under rule box")
    listed = items(data, len(cells.here))
    require(all(type(s) is int and s in (1, -1) for s in listed), "a sign, 1 or -1, of each motion at the point")
    by_motion = dict(zip(map(id, cells.here), listed, strict=True))

    def along(motion: Motion) -> Vector:
        rim = cells.array.rows[motion.rows[0]]
        x, y, *_ = rim if by_motion[id(motion)] > 0 else negative(rim)
        return x, y, cells.zero

    rolling = all(motion.rows[2][0] == "R" for motion in cells.here)
    descent = fan_at_point(cells, along)
    home = descent == ASYMPTOTICALLY_STABLE or (descent is None and _has_tangential_rims(cells))
    require(rolling and home, "signs of translations that all lead inward")


def _has_tangential_rims(cells: Cells) -> bool:
    nearest = {motion.rows[0] for motion in cells.here}
    return is_zero(dot(cells.array.rows[row][:2], cells.array.wheels[row[1]].place) for row in nearest)


# ---- the rate ------------------------------------------------------------------------------------


def show_feedback_rate(cells: Cells, data: Any) -> Any:
    """Rule nearest, the contact state known: the law by ``V = c^T P c + w theta^2`` makes V fall at a rate kappa.

    The motion of a cell with the rows R and S of wheel i and R of wheel j is ``u_i g_i + u_j g_j``, where every g
    satisfies two of the rows with speeds zero, and the third with speed one.  With ``tau = w theta + c^T P J c``,
    ``V'/2 = sum_k u_k a_k`` and ``a = P c . g_v + tau g_omega``.  The *law* is ``u_k = -K a_k``, with any gain K > 0,
    so ``V' = -2 K (a_i^2 + a_j^2)``.  It is shown that ``V' <= -2 K kappa V`` in the cells at the point, for any
    heading, at distances from it of at most ``reach``; without limit where P is a multiple of the unit matrix, so that
    ``q = c^T P J c`` is zero.

    Shown is ``a_i^2 + a_j^2 >= (1 + eta) kappa (c^T P c + tau^2/w)`` on the cone of every cell, for all tau.  This
    suffices: ``w theta^2 = (tau - q)^2/w <= ((1 + eta) tau^2 + (1 + 1/eta) q^2)/w``, and ``4 q^2 <= spread |c|^4`` is
    so small that ``(1 + 1/eta) q^2/w <= eta c^T P c``, by ``c^T P c >= least |c|^2``.
    """
    form_data, weight_data, kappa_data, reach_data, slack_data, least_data = take(
        data, "form weight kappa squared_reach", "slack least"
    )
    form, weight, kappa = Form(*cells.vector(form_data, 3)), cells.parse(weight_data), cells.parse(kappa_data)
    rolling = all(motion.rows[2][0] == "R" for motion in cells.here)
    axes = any(cells.array.wheels[k].drive is not None for motion in cells.here for _, k in motion.rows)
    sound = cells.array.rule == NEAREST and _are_pairs(cells) and rolling and not axes
    require(sound, "rolling rows of wheels with rims, under rule nearest")
    require(min(signs((weight, kappa))) > 0, "a positive weight and rate")
    if reach_data is not None:
        reach, slack, least = map(cells.parse, (reach_data, slack_data, least_data))
        kappa = kappa + kappa * slack
        room = cells.rational(Fraction(4)) * slack * slack * least * weight - reach * (cells.one + slack) * form.spread
        is_near = min(signs((reach, slack, least))) > 0 and form.is_at_least(least) and room.sign() >= 0
        require(is_near, "a distance at which the rotation adds little to V")
    else:
        require(not form.spread.sign(), "a distance within which the rate holds")
    for motion in cells.here:
        start, end = cells.listed[motion.cell].rays or (-1, -1)
        rays = (cells.points[start], cells.points[end])
        require(start >= 0 and cross(*rays).sign() > 0, "cells at the point of less than a half plane")
        require(_falls_on(cells, form, weight, kappa, motion, rays), "a rate at which the law lets V fall")
    return {"form": form_data, "weight": weight_data, "kappa": kappa_data, "squared_reach": reach_data}


def _falls_on(
    cells: Cells, form: Form, weight: Number, kappa: Number, motion: Motion, rays: tuple[Vector, Vector]
) -> bool:
    """Whether ``w (a_i^2 + a_j^2) - kappa (w c^T P c + tau^2) >= 0`` on the cone of two rays, for all tau.

    It is a quadratic form in ``(s, t, tau)`` where ``c = s r_1 + t r_2``, here times the square of the determinant d of
    the rows.  The entry of tau must be positive, and the Schur complement not negative for s, t >= 0.
    """
    first, side, second = (cells.array.rows[row][:3] for row in motion.rows)
    fields = (normal_to(side, second), normal_to(first, side))  # times d
    d = dot(first, fields[0])
    images = [form.image(ray) for ray in rays]
    gains = [(*(dot(image, field[:2]) for image in images), field[2]) for field in fields]
    share = kappa * d * d

    def entry(i: int, j: int) -> Number:
        value = weight * (gains[0][i] * gains[0][j] + gains[1][i] * gains[1][j])
        if i < 2 and j < 2:
            return value - share * weight * dot(images[i], rays[j])
        return value - share if i == j else value

    corner = entry(2, 2)
    s11, s12, s22 = (corner * entry(i, j) - entry(i, 2) * entry(j, 2) for i, j in ((0, 0), (0, 1), (1, 1)))
    copositive = min(s11.sign(), s22.sign()) >= 0 and (s12.sign() >= 0 or (s11 * s22 - s12 * s12).sign() >= 0)
    return corner.sign() > 0 and copositive
