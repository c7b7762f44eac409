"""Where the conditions on a V are looked at, a square about the point or the plane; and how fast V falls there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from fractions import Fraction
from itertools import count
from typing import Any

import numpy as np

from nonsmooth.analysis.cells.switched_cells import (
    FieldCell,
    LyapunovCell,
    lyapunov_cells,
    plane,
    square_regions,
    system_cells,
)
from nonsmooth.proofs.systems.ray_moves import are_cones
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import brief_text
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.systems.switched_system import PLANE, SwitchedSystem

SHRINKING = Fraction(1, 16)  # of the checked square, where V fails on all of it


WHOLE = {1: "the line", len(PLANE): "the plane"}


@dataclass(frozen=True)
class Domain:
    """Where the conditions on a V are proved: a cube about the equilibrium, in two states a square, or the whole space.

    Attributes:
        radius: half the side of the cube; None for the whole space.
    """

    radius: Number | None

    @property
    def rational(self) -> Domain:
        """The same, or a cube that is a little smaller: certificates know half-widths without roots."""
        if self.radius is None or self.radius.as_rational() is not None:
            return self
        return Domain(self.radius.field(simple_below(Fraction(float(self.radius)) * (1 - SLACK))))

    def text(self, states: Sequence[str]) -> str:
        """In words, with the names of the states."""
        if self.radius is None:
            return WHOLE.get(len(states), "the whole space")
        return cube_text(self.radius, states)

    def kind(self, states: Sequence[str]) -> str:
        """In one word."""
        whole, bounded = ("plane", "square") if len(states) == len(PLANE) else ("space", "cube")
        return whole if self.radius is None else bounded


def cube_text(radius: Number | Fraction, states: Sequence[str]) -> str:
    """A cube about the equilibrium in words."""
    bounded = ", ".join(f"abs({name})" for name in states)
    return f"{bounded} <= {radius if isinstance(radius, Fraction) else brief_text(radius)}"


def domains(scene: SwitchedSystem, lyapunov: PiecewiseExpression, cells: Sequence[FieldCell]) -> list[Domain]:
    """Where V is tried, in order; a system of cones with homogeneous V looks the same at every distance.

    Args:
        scene: in two states.
        lyapunov: V.
        cells: of the plane.
    """
    bent = lyapunov_cells(cells, lyapunov, scene.states, scene.origin)
    if are_cones(cells) and all(cell.potential.is_homogeneous for cell in bent):
        return [Domain(None)]
    return [Domain(scene.check.radius * factor) for factor in (1, SHRINKING)]


def plane_cells(scene: SwitchedSystem, radius: Number | None = None) -> tuple[FieldCell, ...]:
    """The cells of the square of a half-width, or of the whole plane."""
    return system_cells(scene, plane(scene) if radius is None else square_regions(radius))


def given_cells(scene: SwitchedSystem, radius: Number | None) -> tuple[LyapunovCell, ...]:
    """The same, cut further where the scene's V bends."""
    return lyapunov_cells(plane_cells(scene, radius), scene.check.lyapunov, scene.states, scene.origin)


# ---- rates, gains and regions --------------------------------------------------------------------
#
# How fast a proved V falls, how much an additive disturbance can do, and short numbers that floats propose for these.
#
# *Rates*: ``V' <= -kappa`` (arrival within ``V/kappa``), ``V' <= -kappa V`` (exponentially), or ``V' <= -kappa V^2``
# (``V <= V_0/(1 + kappa V_0 t)``, where terms of higher order alone lead to the point).  A rate holds where it is
# proved.  What it says of solutions (when they arrive, how V falls with time) holds of those that stay there, as all do
# that start where V is below its values on the border.
#
# *Gains*: ``V' <= -kappa V + gamma |d|`` along ``x' in F(x) + d``, Euclidean norms; ``gamma`` is an upper bound of
# ``|grad V|`` (:func:`nonsmooth.proofs.checker.theorems.show_rate`).


# Of what samples allow, from the largest one on.
SHARES = tuple(Fraction(k, 64) for k in (63, 60, 56, 52, 48, 40, 32, 16))
SLACK = Fraction(1, 1 << 30)  # by which floats may miss it
WIDTH = Fraction(1, 1 << 14)  # of a number: by how much a short fraction may be less
DENOMINATOR = 64  # of kappa and gamma; of slow rates twice as large until it holds FEWEST of them
FEWEST = 8
NEAR, FARTHER = 4.0, (32.0, 256.0)  # of the least distance of samples: up to the first, and between the others
VANISHES = 2.0**-2  # of the least ratio farther away: a smaller one near the point tends to zero there


def times(number: Fraction, name: str) -> str:
    """A multiple of what has a name, for people."""
    return name if number == 1 else f"{number} {name}"


class DecayKind(StrEnum):
    """The kinds of rates by the power of V on the right, the fastest first."""

    FINITE = ""
    EXPONENTIAL = "V"
    ALGEBRAIC = "V**2"

    @property
    def power(self) -> int:
        """The exponent p in ``V' <= -kappa V^p``."""
        return list(DecayKind).index(self)

    def inequality(self, kappa: Fraction) -> str:
        """``V' <= -kappa V^p``."""
        return f"V' <= -{times(kappa, self.value) if self.power else kappa}"

    def after(self, begin: Floats, fallen: float) -> Floats:
        """The largest values of V at a time t, of solutions that began with some and stay where the inequality holds.

        Args:
            begin: the values at the start.
            fallen: ``kappa t``.
        """
        if self is DecayKind.FINITE:
            return np.maximum(begin - fallen, 0)
        return begin * np.exp(-fallen) if self is DecayKind.EXPONENTIAL else begin / (1 + begin * fallen)

    def on_starts(self, kappa: Fraction, starts: str) -> str:
        """What the inequality says of starts whose solutions stay where it holds."""
        if self is DecayKind.FINITE:
            return f"{starts} arrives within {times(1 / kappa, 'V')}"
        if self is DecayKind.ALGEBRAIC:
            return f"from {starts} V falls at least like V0/(1 + {times(kappa, 'V0 t')}), V0 its value there"
        return f"from {starts} V falls at least like exp(-{times(kappa, 't')})"


@dataclass(frozen=True)
class DecayRate:
    """A proved rate.

    Attributes:
        decay: of which kind.
        kappa: the rate.
        domain: where it holds.
        function: V in one state, where nothing else names it; empty elsewhere.
        proofs: the evidence by the names of the checker's claims, where it is found in that form.
    """

    decay: DecayKind
    kappa: Fraction
    domain: Domain
    function: str = ""
    proofs: Mapping[str, Any] = field(default_factory=dict, hash=False)

    @property
    def record(self) -> dict[str, str]:
        """As a certificate states it."""
        return {"kind": self.decay.name.lower(), "kappa": str(self.kappa)}

    def __str__(self) -> str:
        return self.decay.inequality(self.kappa)


def slowest_ratio(ratios: Floats, distances: Floats) -> Fraction:
    """The largest rate that samples allow, and zero where it seems that none is positive.

    Args:
        ratios: of ``-V'`` to ``V^p``, shape (n,).
        distances: of the samples from the point, shape (n,).
    """
    least = float(ratios.min(initial=np.inf))
    if not 0 < least < np.inf:
        return Fraction(0)
    times = distances / distances.min()
    farther = ratios[(times >= FARTHER[0]) & (times <= FARTHER[1])]
    vanishes = len(farther) and ratios[times <= NEAR].min() < VANISHES * farther.min()
    return Fraction(0) if vanishes and least * DENOMINATOR < 1 else Fraction(least)


def rates_below(largest: Fraction) -> Iterator[Fraction]:
    """Short rates to be tried in turn, of the largest that samples allow: first that one itself, if it looks short."""
    if not largest:
        return
    nearest = largest.limit_denominator(DENOMINATOR)
    if nearest and abs(largest - nearest) <= SLACK * nearest:
        yield nearest
    denominator = DENOMINATOR
    while largest * denominator < FEWEST:
        denominator *= 2
    for share in SHARES:
        kappa = Fraction(int(largest * share * denominator * (1 + SLACK)), denominator)
        if kappa > 0:
            yield kappa


@dataclass(frozen=True)
class RegionRate:
    """``V' <= -kappa V`` where ``V < level`` in a square, of a V without bends; every solution from there stays there.

    Attributes:
        kappa: the rate.
        level: at most that of a certified region in the same square.
        radius: half the side of the square.
    """

    kappa: Fraction
    level: Fraction
    radius: Any

    def __str__(self) -> str:
        return DecayKind.EXPONENTIAL.inequality(self.kappa)


GAIN_SHARES = (Fraction(65, 64), Fraction(5, 4), Fraction(2))  # of what samples need, tried in turn


LETTERS = "dwuvqprst"  # of a disturbance: the first that is no state, of which there are at most eight


@dataclass(frozen=True)
class DisturbanceGain:
    """A proved gain.

    Attributes:
        gamma: of the disturbance.
        rate: of V without it.
        domain: where it holds, with the rate: the square, or the cube, on which V is proved, or of a V that is proved
            on the plane the checked one.
        level: of the region that is certified on that square; None where there is none, and everywhere.
        proofs: the evidence by the names of the checker's claims, where it is found in that form.
    """

    gamma: Fraction
    rate: DecayRate
    domain: Domain
    level: Fraction | None
    proofs: Mapping[str, Any] = field(default_factory=dict, hash=False)

    @property
    def everywhere(self) -> bool:
        """Whether it holds in the whole space."""
        return self.domain.radius is None

    @property
    def largest(self) -> Fraction | None:
        """Disturbances below it leave the certified region invariant, or let solutions arrive all the same.

        None without a region, and where solutions stay bounded under any.
        """
        whole = self.rate.kappa / self.gamma
        if self.rate.decay is DecayKind.FINITE and (self.everywhere or self.level is not None):
            return whole
        return None if self.level is None else whole * self.level

    @property
    def ultimate(self) -> Fraction | None:
        """``V <= ultimate delta`` in the end; None where solutions arrive at the point itself."""
        return None if self.rate.decay is DecayKind.FINITE else self.gamma / self.rate.kappa

    def inequality(self, disturbance: str) -> str:
        """In words, with the letter of the disturbance."""
        return f"with x' in F + {disturbance}: {self.rate} + {times(self.gamma, f'abs({disturbance})')}"

    def on_starts(self, disturbance: str) -> str:
        """What it says of starts below the level, or of all; empty where it says nothing."""
        if self.largest is None and not self.everywhere:
            return ""
        if self.ultimate is None:
            ends = f"arrives all the same, within V/({self.rate.kappa} - {times(self.gamma, 'delta')})"
        else:
            ends = f"ends in V <= {times(self.ultimate, 'delta')}"
        below = "" if self.largest is None else f" < {self.largest}"
        starts = "every start" if self.everywhere else f"every start with V < {self.level} there"
        return f"where abs({disturbance}) <= delta{below} {starts} {ends}"


def disturbance_letter(states: Sequence[str]) -> str:
    """What a disturbance is called: ``d``, unless a state is."""
    return next(letter for letter in LETTERS if letter not in states)


def simple_below(value: Fraction) -> Fraction:
    """A simple fraction below a positive number, or at it, and nearly as large."""
    powers = ((value * (1 - WIDTH / 2)).limit_denominator(1 << k) for k in count())
    return next(power for power in powers if value * (1 - WIDTH) <= power <= value)


def gain_above(needed: Fraction | float) -> Fraction:
    """A short number above another one."""
    return Fraction(int(needed * DENOMINATOR) + 1, DENOMINATOR)


# ---- regions of attraction that are certified by a level of V ------------------------------------
#
# Solutions that start where ``V < c`` stay there and reach the point if V is at least c on the border of a cube about
# it, and falls where ``V < c``.  Just above the largest certified c a point refutes: on the border with V below it, or
# inside with ``V' >= 0``.


@dataclass(frozen=True)
class SublevelRegion:
    """Starts that stay in the square and reach the equilibrium.

    Attributes:
        level: every solution from ``V < level`` stays there.
        refuted: a larger level for which that is not shown; None where none was looked at.
        point: a point with V at most the refuted level, on the border or with a V that does not fall; None where the
            larger level is merely undecided.
        radius: half the side of the square, a number of the system's field, or rational in many states.
        falls: whether V is proved to fall on all of the square.
        proofs: the evidence by the names of the checker's claims, where it is found in that form.
    """

    level: Fraction
    refuted: Fraction | None
    point: Any
    radius: Any
    falls: bool
    proofs: Mapping[str, Any] = field(default_factory=dict, hash=False)

    def __str__(self) -> str:
        return f"V < {self.level}"


@dataclass(frozen=True)
class ReshapedRegion:
    """Another V, whose region reaches farther than that of the V that decided.

    Attributes:
        formula: V, in the displacement under the states' names.
        region: every start with V below its level in the cube reaches the point.
        hypotheses: of theorem ``lyapunov``, whose evidence the region holds.
    """

    formula: PiecewiseExpression
    region: SublevelRegion
    hypotheses: dict[str, Any]
