"""Slides to first order about a pose at which a body rests with wheels under its edge, and what becomes of the pose.

Let ``nu . xi`` be the rate at which a spatial twist takes a wheel at p under the body: ``nu = (n, n . J p)`` with the
outward unit normal n of the edge there.
"""

from __future__ import annotations

from enum import StrEnum

from flint import arb, arb_mat

from nonsmooth.proofs.headings.ball_motion import UndecidedMotionError
from nonsmooth.symbolic.edge_headings import BallVector
from nonsmooth.symbolic.plane import dot


class Fate(StrEnum):
    """What becomes of a body that starts near a pose of rest."""

    RETURNS = "returns"
    LEAVES = "leaves"
    UNDECIDED = "undecided"


Fates = tuple[Fate, Fate]  # of the place and of the heading


def edge_rate(normal: BallVector, at: BallVector) -> arb_mat:
    """``nu`` as a row, (1, 3)."""
    return arb_mat([[normal[0], normal[1], dot(normal, (-at[1], at[0]))]])


def slide(centre: arb_mat, twist: arb_mat, mixed: arb_mat, rate: arb_mat) -> arb_mat:
    """``[I, J c] (I - xi nu^T/(nu . xi)) mixed``, (2, 2): the slide under one wheel, in c.

    Args:
        centre: of mass, (2, 1).
        twist: without the wheel, (3, 1).
        mixed: ``(D xi_1 + D xi_2/mu)/(1 + 1/mu)``, (3, 2).
        rate: nu, (1, 3).
    """
    along = twist * (rate * mixed) * (1 / (rate * twist)[0, 0])
    x, y = centre.entries()
    moved = arb_mat([[arb(1), arb(0), -y], [arb(0), arb(1), x]])
    return moved * (mixed - along)


def driven_off(velocity: BallVector, omega: arb) -> Fates:
    """A motion leads away at a speed bounded below: what it moves leaves."""
    moves = any(not entry.contains(0) for entry in velocity)
    turns = not omega.contains(0)
    return (Fate.LEAVES if moves else Fate.UNDECIDED), (Fate.LEAVES if turns else Fate.UNDECIDED)


def fates_of_slide(matrix: arb_mat, normal: BallVector) -> Fates:
    """What ``c' = A c`` does on a surface where c tells the heading, whose slope in c is a multiple of the normal.

    With both eigenvalues in the right half-plane some path leaves along an eigenvector that turns the body, or winds
    out.  With one of them positive the heading leaves if its eigenvector turns the body.

    Raises:
        UnprovedError: where no eigenvalue decides.
    """
    trace, determinant = matrix[0, 0] + matrix[1, 1], matrix.det()
    if trace < 0 and determinant > 0:
        return Fate.RETURNS, Fate.RETURNS
    if trace > 0 and determinant > 0:
        return Fate.LEAVES, Fate.LEAVES
    if not determinant < 0:
        raise UndecidedMotionError("eigenvalues on the imaginary axis, or nearly so")
    growth = (trace + (trace * trace - 4 * determinant).sqrt()) / 2
    ways = [(matrix[0, 1], growth - matrix[0, 0]), (growth - matrix[1, 1], matrix[1, 0])]
    turns = any(not dot(normal, way).contains(0) for way in ways)
    return Fate.LEAVES, Fate.LEAVES if turns else Fate.UNDECIDED
