"""Paths of rule ``box`` close to a point, and whether verdicts and observed paths agree."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import combinations
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from nonsmooth.proofs.clauses.translation.fan_stability import Move
from nonsmooth.proofs.clauses.translation.on_cells import TranslationResult
from nonsmooth.proofs.findings import Translation
from tests.oracles.nearest_paths import End, Wheel

# ---- Paths of rule ``box`` close to a point, by the definitions alone: an oracle for verdicts about translation.
#
# All twists that satisfy three independent rows are listed once, in fractions. At a point the loads are those of
# identical springs (all sets of loaded wheels are tried), and the twist is the candidate of least dissipation. Paths
# are Euler steps of one per cent of the distance from the checked point, many starts at once. Nothing here knows of
# cells, cones or slopes.

Floats: TypeAlias = npt.NDArray[np.float64]

STEP = 0.01  # of the distance from the point
# A path that is so many times farther away, or nearer, than its start has left, or arrives.  A stable corner lets the
# distance grow too, by one over the sine of the angle between a velocity and a border: some 200-fold was seen.
FAR = 1000.0
STEPS = 2000
TIE = 1e-12  # dissipations closer than that, relative to one, are equal but for rounding
START = 1e-6  # distances near this: loads and dissipations of neighbours differ by much more than rounding


@dataclass(frozen=True)
class Observed:
    """How many of the paths did what.

    Attributes:
        left: grew a thousandfold.
        arrived: shrank a thousandfold.
        rested: came to a point where the twist is zero.
        unclear: none of these.
    """

    left: int
    arrived: int
    rested: int
    unclear: int


class BoxArray:
    """The literal rule for an array given in fractions, with elastic loads."""

    def __init__(self, wheels: Sequence[Wheel], at: tuple[Fraction, Fraction]) -> None:
        self.places = np.array([[float(w.position[0] - at[0]), float(w.position[1] - at[1]), 1.0] for w in wheels])
        self.friction = np.array([float(mu) for w in wheels for mu in (w.roll, w.side)])
        rows, speeds = _rows(wheels, at)
        twists = _candidates(rows, speeds)
        self.twists = np.array([[float(x) for x in twist] for twist in twists])
        # residuals in fractions first, so that rows which a twist satisfies leave exactly nothing
        self.slips = np.array(
            [[abs(float(_dot(row, twist) - u)) for row, u in zip(rows, speeds, strict=True)] for twist in twists]
        )

    def loads(self, points: Floats) -> Floats:
        """Elastic loads, shape (points, wheels): N_i = max(0, m_i . y), whatever set of wheels carries them."""
        count, wheels = len(points), len(self.places)
        targets = np.column_stack([points, np.ones(count)])
        found = np.full((count, wheels), np.nan)
        for active, others, inverse in self._loaded:
            open_ = np.isnan(found[:, 0])
            if not open_.any():
                break
            forms = targets @ inverse @ self.places.T
            fits = (forms[:, active] >= -1e-12).all(axis=1) & (forms[:, others] <= 1e-12).all(axis=1)
            loads = np.zeros((count, wheels))
            loads[:, active] = np.maximum(forms[:, active], 0)
            found[open_ & fits] = loads[open_ & fits]
        return found

    @cached_property
    def _loaded(self) -> list[tuple[list[int], list[int], Floats]]:
        """Sets of wheels that can carry the body, the largest first: they, the others, and ``(M^T M)^-1``."""
        wheels = range(len(self.places))
        sets = [list(active) for size in range(len(wheels), 2, -1) for active in combinations(wheels, size)]
        found: list[tuple[list[int], list[int], Floats]] = []
        for active in sets:
            m = self.places[active]
            if np.linalg.matrix_rank(m, tol=1e-9) == 3:
                found.append((active, [k for k in wheels if k not in active], np.linalg.inv(m.T @ m)))
        return found

    def twist_at(self, points: Floats, preferences: Floats) -> Floats:
        """The candidate of least dissipation, shape (points, 3); where several tie, that of largest preference."""
        limits = np.repeat(self.loads(points), 2, axis=1) * self.friction
        dissipation = limits @ self.slips.T
        least = dissipation.min(axis=1, keepdims=True)
        ties = dissipation <= least + TIE * (1 + np.abs(least))
        return np.asarray(self.twists[np.argmax(np.where(ties, preferences, -1.0), axis=1)])


def _rows(wheels: Sequence[Wheel], at: tuple[Fraction, Fraction]) -> tuple[list[tuple[Fraction, ...]], list[Fraction]]:
    rows: list[tuple[Fraction, ...]] = []
    speeds: list[Fraction] = []
    for wheel in wheels:
        (px, py), (dx, dy) = (wheel.position[0] - at[0], wheel.position[1] - at[1]), wheel.direction
        for (a, b), u in (((dx, dy), wheel.speed), ((-dy, dx), Fraction(0))):
            rows.append((a, b, b * px - a * py))
            speeds.append(u)
    return rows, speeds


def _candidates(rows: list[tuple[Fraction, ...]], speeds: list[Fraction]) -> list[tuple[Fraction, ...]]:
    """All twists with three independent rows, by Cramer's rule."""
    found: dict[tuple[Fraction, ...], None] = {}
    for triple in combinations(range(len(rows)), 3):
        matrix = [rows[k] for k in triple]
        whole = _determinant(matrix)
        if whole:
            entries = []
            for column in range(3):
                changed = [
                    [speeds[k] if c == column else row[c] for c in range(3)]
                    for k, row in zip(triple, matrix, strict=True)
                ]
                entries.append(_determinant(changed) / whole)
            found[tuple(entries)] = None
    return list(found)


def _determinant(m: Sequence[Sequence[Fraction]]) -> Fraction:
    (a, b, c), (d, e, f), (g, h, i) = m
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def _dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    return sum(x * y for x, y in zip(a, b, strict=True))


def observe_box(wheels: Sequence[Wheel], at: tuple[Fraction, Fraction], *, starts: int = 24) -> Observed:
    """Paths from starts all around the point."""
    array = BoxArray(wheels, at)
    angles = 2 * math.pi * (np.arange(starts) + 0.137) / starts
    points = START * np.column_stack([np.cos(angles), np.sin(angles)])
    preferences = np.random.default_rng(0).random((starts, len(array.twists)))
    ends = np.full(starts, "unclear", dtype=object)
    going = np.ones(starts, dtype=bool)
    for _ in range(STEPS):
        if not going.any():
            break
        here = points[going]
        twists = array.twist_at(here, preferences[going])
        moves = twists[:, :2] + twists[:, 2:] * np.column_stack([-here[:, 1], here[:, 0]])
        speed, distance = np.hypot(*moves.T), np.hypot(*here.T)
        resting = speed < 1e-12
        step = np.where(resting, 0, STEP * distance / np.maximum(speed, 1e-300))
        points[going] = here + step[:, None] * moves
        after = np.hypot(*points[going].T) / START
        said = np.where(resting, "rested", np.where(after > FAR, "left", np.where(after < 1 / FAR, "arrived", "")))
        indices = np.flatnonzero(going)
        for index, word in zip(indices, said, strict=True):
            if word:
                ends[index], going[index] = word, False
    counts = {word: int((ends == word).sum()) for word in ("left", "arrived", "rested", "unclear")}
    return Observed(**counts)


# ---- Whether a translation verdict and observed paths agree --------------------------------------


def contradiction(result: TranslationResult, ends: set[End]) -> str:
    """What the paths say against the verdict; empty where they agree."""
    leaves = End.LEAVES in ends
    if result.verdict is Translation.ASYMPTOTICALLY_STABLE and ends - {End.ARRIVES, End.UNCLEAR}:
        return f"asymptotically stable, but paths end {ends}"
    if result.verdict is Translation.STABLE and leaves:
        return "stable, but a path leaves"
    if result.verdict is Translation.UNSTABLE and not leaves:
        return "unstable, but no path leaves"
    return ""


def box_contradiction(result: TranslationResult, seen: Observed) -> str:
    """What paths of rule ``box`` say against the verdict; empty where they agree, or say nothing."""
    if result.verdict is Translation.ASYMPTOTICALLY_STABLE and (seen.left or seen.rested):
        return f"asymptotically stable, but {seen}"
    if result.verdict is Translation.STABLE and seen.left:
        return f"stable, but {seen}"
    followed = result.fan is not None and any(e.move is not Move.SLIDE for e in result.fan.evidence)
    if result.verdict is Translation.UNSTABLE and followed and not seen.left:
        return f"unstable, but {seen}"
    return ""
