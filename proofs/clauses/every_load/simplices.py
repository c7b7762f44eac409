"""Quadratic forms on the hull of finitely many points, by subdivision: positive, or not shown to be."""

from __future__ import annotations

from collections.abc import Sequence

from nonsmooth.symbolic.numbers.number import Number

MOST_PARTS = 400  # simplices that are looked at

Gram = Sequence[Sequence[Number]]


def is_positive_on_hull(gram: Gram) -> bool:
    """Whether ``sum l_v l_w gram[v][w] > 0`` is shown for all weights ``l >= 0`` that are not all zero.

    It is so where the diagonal is positive and no entry negative.  Otherwise the edge of the most negative entry is
    halved, which gives two simplices with the middle of the edge in place of one of its ends.
    """
    waiting, parts = [gram], 0
    while waiting:
        part = waiting.pop()
        parts += 1
        if parts > MOST_PARTS or any(row[k].sign() <= 0 for k, row in enumerate(part)):
            return False
        edges = [(part[v][w], v, w) for v in range(len(part)) for w in range(v)]
        worst = min(edges, key=lambda edge: edge[0], default=None)
        if worst is not None and worst[0].sign() < 0:
            waiting += [_halved(part, worst[1], worst[2]), _halved(part, worst[2], worst[1])]
    return True


def _halved(gram: Gram, replaced: int, kept: int) -> Gram:
    """The form in the corners of which one is replaced by its middle with another."""
    count = len(gram)
    middle = [(gram[replaced][k] + gram[kept][k]) / 2 for k in range(count)]
    middle[replaced] = (gram[replaced][replaced] + 2 * gram[replaced][kept] + gram[kept][kept]) / 4
    rows = [list(row) for row in gram]
    for k in range(count):
        rows[k][replaced] = rows[replaced][k] = middle[k]
    return rows
