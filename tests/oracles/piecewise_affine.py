"""Periodic orbits of piecewise-affine systems at 40 digits: matrix exponentials and root finding in mpmath.

Nothing of the program is used.  Motions are ``x' = A x + b``; a leg lasts until a linear function vanishes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mpmath

DIGITS = 40


def matrix(rows: Sequence[Sequence[Any]]) -> Any:
    return mpmath.matrix([[mpmath.mpf(x) for x in row] for row in rows])


class Motion:
    """``x' = A x + b`` in closed form."""

    def __init__(self, a: Sequence[Sequence[Any]], b: Sequence[Any]) -> None:
        self.a, self.b, self.n = matrix(a), mpmath.matrix([mpmath.mpf(x) for x in b]), len(b)
        self.whole = mpmath.zeros(self.n + 1)
        for i in range(self.n):
            self.whole[i, self.n] = self.b[i]
            for j in range(self.n):
                self.whole[i, j] = self.a[i, j]

    def at(self, x: Any, t: Any) -> Any:
        grown = mpmath.expm(self.whole * t)
        return mpmath.matrix([sum(grown[i, j] * x[j] for j in range(self.n)) + grown[i, self.n] for i in range(self.n)])

    def rate(self, x: Any) -> Any:
        return self.a * x + self.b


def arrival(motion: Motion, x: Any, normal: Sequence[Any], offset: Any, near: Any) -> tuple[Any, Any]:
    """Time near a guess at which ``normal . x = offset``, with the state then."""

    def height(t: Any) -> Any:
        y = motion.at(x, t)
        return sum(mpmath.mpf(n) * y[k] for k, n in enumerate(normal)) - offset

    t = mpmath.findroot(height, mpmath.mpf(near))
    return t, motion.at(x, t)
