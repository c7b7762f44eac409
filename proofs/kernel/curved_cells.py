"""Patterns of signs that curved surfaces do not have in a cube: samples propose them, the checker's claims show them.

Of affine surfaces alone an exact linear program finds all patterns that do not occur
(:mod:`nonsmooth.proofs.kernel.stated_cells`).  Beside a curved surface it takes both signs everywhere, also in cones
that the surface does not meet near the point.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from nonsmooth.proofs.checker.cells import Domain, Inclusion, Pattern, Surfaces, System, pattern
from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.kernel.samples import Floats, sample_points, values_at
from nonsmooth.proofs.kernel.search import NotShownError, Search
from nonsmooth.proofs.kernel.stated_cells import StatedCells
from nonsmooth.proofs.kernel.subject import NoCertificateError, about
from nonsmooth.symbolic.switched_system import SwitchedSystem

LARGEST = 3  # signs that contradict each other
TRIALS = 6  # contradictions that are tried, for one pattern


def started(system: SwitchedSystem, search: Search | None) -> tuple[System, Search]:
    """The subject of a certificate, and a search.

    Raises:
        NotShownError: for a system that no certificate can name.
    """
    try:
        return read_subject(about(system)), search or Search()
    except (NoCertificateError, RejectedError) as error:
        raise NotShownError(str(error)) from None


def build_inclusion(stated: StatedCells, subject: System, search: Search, functions: Sequence[str] = ()) -> Inclusion:
    """The cells with their fields as the checker builds them.

    Raises:
        NotShownError: where it refuses to.
    """
    try:
        return Inclusion(subject, stated.record, functions, search)
    except RejectedError as error:
        raise NotShownError(f"required {error}") from None


def sharpened(stated: StatedCells, subject: System, search: Search) -> StatedCells:
    """The same cells with further patterns that are shown to be empty.

    Args:
        stated: of a cube.
        subject: the system.
        search: keeps the proofs.
    """
    if all(surface.degree == 1 for surface in stated.surfaces):
        return stated
    found = stated
    known = build_inclusion(stated, subject, search)
    signs = _sampled_signs(known.surfaces)
    occurring = {tuple(map(int, row)) for row in np.unique(signs, axis=0)}
    for cell in known.cells:
        is_known = any(_holds(cell.signs, mark) for mark in found.empty)
        if cell.signs in occurring or is_known:
            continue
        for mark in _contradictions(cell.signs, signs, known.surfaces):
            if _is_shown(stated, mark, subject, search):
                found = replace(found, empty={**found.empty, mark: search.found[f"empty {mark}"][1]})
                break
    return found


def _sampled_signs(surfaces: Surfaces) -> Floats:
    """The signs of all surfaces at random points, one row for each point."""
    points = np.concatenate([sample_points(surfaces.domain.system.count, bounded=True, seed=k) for k in range(20)])
    return np.stack([np.sign(values_at(own, points)[0]) for own in surfaces.listed], axis=1)


def _holds(signs: Pattern, mark: str) -> bool:
    """Whether a pattern has the signs of a text."""
    return all(m in (".", "-+"[s > 0]) for m, s in zip(mark, signs, strict=True))


def _contradictions(signs: Pattern, sampled: Floats, surfaces: Surfaces) -> Iterator[str]:
    """A few of its signs, one of a curved surface among them, that no sample has together; the smallest first."""
    curved = {j for j, own in enumerate(surfaces.listed) if own.degree > 1}
    left = TRIALS
    for size in range(1, LARGEST + 1):
        for chosen in combinations(range(len(signs)), size):
            wanted = [signs[j] for j in chosen]
            if left and curved.intersection(chosen) and not (sampled[:, chosen] == wanted).all(axis=1).any():
                left -= 1
                yield pattern(s if j in chosen else None for j, s in enumerate(signs))


def _is_shown(stated: StatedCells, mark: str, subject: System, search: Search) -> bool:
    try:
        Surfaces(Domain(subject, stated.within), stated.record["surfaces"], [mark], search)
    except (NotShownError, RejectedError):
        return False
    return True
