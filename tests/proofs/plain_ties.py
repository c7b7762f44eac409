"""Plain systems tied at the equilibrium, and what their formulas do there as numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.findings import Equilibrium, Translation
from nonsmooth.proofs.system_decision import StabilityResult
from nonsmooth.proofs.systems.findings import Method
from nonsmooth.proofs.systems.ray_moves import RayOfRest
from nonsmooth.proofs.systems.system_stability import PlanePoint
from tests.oracles.floats import spread

# ---- Plain systems with ties at the equilibrium, and what their solutions do there, found without the proving code.
#
# Guards touch the origin, pass it, vanish there alone, are tangent to each other, have cusps, even powers or common
# factors. The oracle knows the formulas only as numbers:
#
# - *F at a point*: signs of the guards on arcs ``y = c x^r`` (and ``x = c y^r``) with ``x = 2^-400`` in exact
# rational arithmetic. All guards have branches ``y ~ a x^(p/q)`` with exponents and factors from short lists, and
# there is an arc between any two of them, so every cell near the point is met. - *paths*: Euler polygons with steps
# in proportion to the distance, many at once. They tend to Filippov solutions as the steps shrink, and chatter along
# sliding surfaces.

Array: TypeAlias = NDArray[np.float64]

DEPTH = 400  # arcs are looked at where x is two to the power of minus this
TINY = Fraction(1, 2 ** (3 * DEPTH))  # size of a neighbourhood around a point beside which guards are looked at
FACTORS = tuple(Fraction(n, d) for n, d in ((1, 40), (1, 4), (3, 4), (5, 4), (7, 4), (5, 2), (40, 1)))
EXPONENTS = tuple(Fraction(k, 4) for k in range(4, 20))

# each vanishes at the origin or not; factors 1/2, 1, 3/2, 2, 3 are between those of the arcs
GUARDS = (
    "x", "y", "x - y", "x + 2*y", "y**2 - x**2", "x*y",
    "y - x**2", "y - 2*x**2", "y + x**2", "x - y**2", "2*y - 3*x**2", "y - x**3", "y - x**2 - x**4",
    "y**2 - x**3", "x**2 - y**3", "y**2 - x**5",
    "x**3 - x**2 - y**2", "x**4 - x**2*y**2 + y**4", "x**2 + y**2 - x**4*y", "(x**2 + y**2)*(x - 1)",
    "y + x**2 + 1", "x**2 + y**2 - 1", "x - 2", "x*y - y + 3", "y - x**2 - 1/3",
    "(x - y)**2*(y - x**2)", "(y - x**2)**2*x", "(y - x**2)*(y - 2*x**2)", "(y - x**2)*(y + x**2)", "x*(y - x**2)",
)  # fmt: skip
SMOOTH = (
    ("-x", "-y"), ("-x", "-2*y"), ("y", "-x - y"), ("-x + y", "-x - y"), ("y", "-x"), ("-x**3", "-y"),
    ("x", "-y"), ("x/2", "y"), ("0", "-y"), ("0", "0"), ("y", "-x + y"), ("-x", "0"),
)  # fmt: skip
JUMPS = (("0", "1"), ("1", "0"), ("1", "1"), ("1", "-2"), ("x", "0"), ("0", "y"), ("y", "-x"), ("x", "y"), ("0", "x"))


@dataclass(frozen=True)
class Tie:
    """``c' = smooth + sum_k factor_k sign(guard_k) jump_k``."""

    smooth: tuple[str, str]
    terms: tuple[tuple[str, str, tuple[str, str]], ...]

    @property
    def rhs(self) -> tuple[str, str]:
        """Both formulas."""
        parts = [[self.smooth[k], *(f"{f}*sign({g})*({j[k]})" for f, g, j in self.terms)] for k in (0, 1)]
        return " + ".join(parts[0]), " + ".join(parts[1])


def random_tie(seed: int) -> Tie:
    """One to three guards with fields."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 4))
    guards = rng.choice(len(GUARDS), size=count, replace=False)
    terms = []
    for k in guards:
        factor = str(rng.choice(["-1", "-2", "-1/2", "1", "1/2"]))
        terms.append((f"({factor})", GUARDS[k], JUMPS[int(rng.integers(len(JUMPS)))]))
    return Tie(SMOOTH[int(rng.integers(len(SMOOTH)))], tuple(terms))


class Oracle:
    """A tie as numbers; its texts are compiled, being this module's own."""

    def __init__(self, tie: Tie) -> None:
        self._guards = [_compiled(g) for _, g, _ in tie.terms]
        self._factors = [Fraction(f.strip("()")) for f, _, _ in tie.terms]
        self._jumps = [(_compiled(a), _compiled(b)) for _, _, (a, b) in tie.terms]
        self._smooth = _compiled(tie.smooth[0]), _compiled(tie.smooth[1])

    # ---- exactly ---------------------------------------------------------------------------

    def signs(self, x: Fraction, y: Fraction) -> tuple[int, ...]:
        """Signs of the guards."""
        values = [guard(x, y) for guard in self._guards]
        return tuple((v > 0) - (v < 0) for v in values)

    def limits(self, signs: tuple[int, ...], x: Fraction, y: Fraction) -> tuple[Fraction, Fraction]:
        """The field of a sign pattern at a point."""
        total = [Fraction(self._smooth[k](x, y)) for k in (0, 1)]
        for factor, side, jump in zip(self._factors, signs, self._jumps, strict=True):
            for k in (0, 1):
                total[k] += factor * side * jump[k](x, y)
        return total[0], total[1]

    def rests_at_origin(self) -> bool:
        """Whether 0 is in F at the origin."""
        patterns = {self.signs(x, y) for x, y in _arcs()}
        zero = Fraction(0)
        return holds_zero([self.limits(p, zero, zero) for p in patterns if 0 not in p])

    def limits_at(self, x: Fraction, y: Fraction) -> list[tuple[Fraction, Fraction]]:
        """The limits of the field at a point beside the origin, by the signs on small squares around it."""
        around = [(TINY * scale * a, TINY * scale * b) for scale in (1, 2**40) for a, b in _ring()]
        patterns = {self.signs(x + dx, y + dy) for dx, dy in around}
        return [self.limits(p, x, y) for p in patterns if 0 not in p]

    def rests_at(self, x: Fraction, y: Fraction) -> bool:
        """Whether 0 is in F at a point beside the origin."""
        return holds_zero(self.limits_at(x, y))

    def equilibria_nearby(self) -> list[tuple[Fraction, Fraction]]:
        """Points of the guards' branches, of the axes and of the arcs at which 0 is in F, at four small distances."""
        branches = [(f, e) for e in (1, 2, 3) for f in (Fraction(k, 2) for k in (-6, -4, -3, -2, -1, 0, 1, 2, 3, 4, 6))]
        equilibria = []
        for power in (8, 12, 20, 30):
            for large in (Fraction(1, 2**power), -Fraction(1, 2**power)):
                for factor, exponent in branches:
                    small = factor * large**exponent
                    equilibria += [p for p in ((large, small), (small, large)) if self.rests_at(*p)]
                cusp = [(large**2, large**3), (large**3, large**2), (large**2, large**5), (Fraction(0), large)]
                equilibria += [p for p in cusp if self.rests_at(*p)]
        return equilibria

    # ---- in floats -------------------------------------------------------------------------

    def velocity(self, points: Array) -> Array:
        """Fields at many points, one per row; a guard that is zero counts as positive."""
        x, y = points.T
        total = np.array([self._smooth[0](x, y) + 0 * x, self._smooth[1](x, y) + 0 * x], dtype=float)
        for factor, guard, jump in zip(self._factors, self._guards, self._jumps, strict=True):
            side = np.where(guard(x, y) >= 0, 1.0, -1.0) * float(factor)
            total += side * np.array([jump[0](x, y) + 0 * x, jump[1](x, y) + 0 * x])
        return total.T


def _compiled(text: str) -> Callable[[Any, Any], Any]:
    """A formula of this module as a function; fractions stay exact."""
    code = compile(text.replace("1/3", "Fraction(1, 3)").replace("x/2", "x*Fraction(1, 2)"), text, "eval")
    exact: dict[str, Any] = {"__builtins__": {}, "Fraction": Fraction}
    rounded: dict[str, Any] = {"__builtins__": {}, "Fraction": lambda n, d: n / d}

    def value(x: Any, y: Any) -> Any:
        names = rounded if isinstance(x, np.ndarray) else exact
        return eval(code, names, {"x": x, "y": y})  # noqa: S307 - texts of this module

    return value


def _arcs() -> Iterator[tuple[Fraction, Fraction]]:
    """Points very near the origin, between any two branches of the guards."""
    root = Fraction(1, 2 ** (DEPTH // 4))  # powers of a quarter stay rational
    for exponent in EXPONENTS:
        for factor in FACTORS:
            large, small = root**4, factor * root ** int(4 * exponent)
            for a in (1, -1):
                for b in (1, -1):
                    yield a * large, b * small
                    yield b * small, a * large


def _ring() -> Iterator[tuple[Fraction, Fraction]]:
    """The border of a square, eight points to a side."""
    for k in range(-4, 5):
        side = Fraction(k, 4) + Fraction(1, 97)
        yield from ((side, Fraction(1)), (side, Fraction(-1)), (Fraction(1), side), (Fraction(-1), side))


def holds_zero(vectors: list[tuple[Fraction, Fraction]]) -> bool:
    """Whether a convex combination of one, two or three of the vectors is zero (Caratheodory)."""
    if any(not a and not b for a, b in vectors):
        return True
    crosses = {(i, j): a[0] * b[1] - a[1] * b[0] for i, a in enumerate(vectors) for j, b in enumerate(vectors)}
    for (i, j), turn in crosses.items():
        if not turn and vectors[i][0] * vectors[j][0] + vectors[i][1] * vectors[j][1] < 0:
            return True
        if turn > 0 and any(crosses[j, k] > 0 and crosses[k, i] > 0 for k in range(len(vectors))):
            return True
    return False


# ---- Verdicts on plain systems held against the oracle of :mod:`tests.proofs.plain_ties` ---------

STARTS = (1e-2, 1e-5)  # distances; paths that begin nearer stay below the larger bound of the two
FAR, STEPS, FINENESS = 0.2, 3000, 2e-3
LEFT_BEHIND = 50.0  # growth of the distance that no stable equilibrium of the generator shows
NEAR = Fraction(1, 2**12)  # distance at which rays are looked at: beyond it guards of higher degree may switch


def contradictions(result: StabilityResult, oracle: Oracle) -> list[str]:
    """What the oracle says against a verdict; nothing where it agrees or does not know."""
    objections = []
    if result.equilibrium is not Equilibrium.UNDECIDED:
        claimed = result.equilibrium is Equilibrium.HOLDS
        objections += ["0 in F at the origin"] if claimed is not oracle.rests_at_origin() else []
    objections += [f"{ray}" for ray in PlanePoint(result.scene).rays if _is_refuted(ray, oracle)]
    stable = result.verdict in (Translation.STABLE, Translation.ASYMPTOTICALLY_STABLE)
    if stable and spread(oracle.velocity, STARTS[1], STEPS, FINENESS, FAR)[0] > LEFT_BEHIND:
        objections.append("a path leaves")
    if result.verdict is Translation.ASYMPTOTICALLY_STABLE and oracle.equilibria_nearby():
        objections.append(f"equilibria nearby: {oracle.equilibria_nearby()[:2]}")
    if result.method in (Method.GROWTH, Method.EQUILIBRIUM):
        growth = max(spread(oracle.velocity, start, STEPS, FINENESS, FAR)[0] for start in STARTS)
        objections += ["no path leaves"] if growth < 1.5 else []
    return objections


def _is_refuted(ray: RayOfRest, oracle: Oracle) -> bool:
    """Whether a ray of rest is none at a point near the origin (rational rays only)."""
    point = _rational(ray.place)
    if point is None or not ray.is_exact:
        return False
    size = max(abs(point[0]), abs(point[1])) / NEAR
    x, y = point[0] / size, point[1] / size
    return not oracle.rests_at(x, y)


def _rational(point: Point) -> tuple[Fraction, Fraction] | None:
    coordinates = [Fraction(str(q)) for v in point if (q := v.as_rational()) is not None]
    return (coordinates[0], coordinates[1]) if len(coordinates) == len(point) else None
