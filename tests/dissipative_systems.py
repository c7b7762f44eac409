"""Random systems ``x' = S x - damping`` with S skew, along which |x|^2 never rises, and which of them attract."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

DAMPING = {"none": "", "linear": " - {0}", "cubic": " - {0}**3", "relay": " - sgn({0})"}


@dataclass(frozen=True)
class DissipativeSystem:
    """A system in three or four states.

    Attributes:
        states: their names.
        rhs: the right-hand sides.
        attracts: whether the origin attracts.
    """

    states: tuple[str, ...]
    rhs: tuple[str, ...]
    attracts: bool

    @property
    def energy(self) -> str:
        """V = |x|^2."""
        return " + ".join(f"{name}**2" for name in self.states)


def dissipative_systems(count: int) -> Iterator[DissipativeSystem]:
    """Random systems, the same each time."""
    rng = np.random.default_rng(1)
    for _ in range(count):
        states = ("x", "y", "z", "w")[: rng.integers(3, 5)]
        upper = np.triu(rng.integers(-2, 3, (len(states),) * 2) * rng.integers(0, 2, (len(states),) * 2), 1)
        skew = upper - upper.T
        damped = [str(kind) for kind in rng.choice(["none", "none", "linear", "cubic", "relay"], len(states))]
        rhs = []
        for row, name, kind in zip(skew.tolist(), states, damped, strict=True):
            terms = " + ".join(f"{c}*{other}" for c, other in zip(row, states, strict=True))
            rhs.append(terms + DAMPING[kind].format(name))
        yield DissipativeSystem(states, tuple(rhs), attracts(skew, damped))


def attracts(skew: np.ndarray, damped: Sequence[str]) -> bool:
    """Near the point relays hold their states at zero; what is left must be seen by the other dampers (Kalman)."""
    free = [k for k, kind in enumerate(damped) if kind != "relay"]
    if not free:
        return True
    own = skew[np.ix_(free, free)]
    seen = np.array([np.eye(len(free))[i] for i, k in enumerate(free) if damped[k] != "none"]).reshape(-1, len(free))
    blocks = [seen @ np.linalg.matrix_power(own, power) for power in range(len(free))]
    return int(np.linalg.matrix_rank(np.vstack(blocks))) == len(free)
