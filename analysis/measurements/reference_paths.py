"""Paths to measure others by: exact over the scene's own number field, or at 60 digits by Taylor series.

A field that is constant on polygons has straight paths between events, so that states and event times are numbers of
the field, and every error is a difference of exact numbers, rounded once.  Any other field of polynomials is expanded
about a state by Picard iteration on truncated series (python-flint), to an order and step at which the remainder is
below ``10**-DIGITS``; where it first meets a side of its piece is isolated by ball arithmetic.  Only crossings are
followed: where a path would slide, meets a corner or touches a side without crossing it, the reference ends and says
so.  What it has computed until then is right, what comes later is not its business.  The series share no code with
the integrators.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from flint import arb, arb_poly, arb_series, ctx

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.switched_cells import fields_by_signs
from nonsmooth.analysis.fields.constant_field import ConstantField, array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.norm_zeros import NormField
from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.switched_field import SURFACE_SLACK
from nonsmooth.analysis.fields.system_field import constant_system, system_field
from nonsmooth.analysis.measurements.harness import LeftOut
from nonsmooth.analysis.trajectories.result import EndReason, Event, EventKind, State, Trajectory
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.numbers.coefficients import rational_ball
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import XY, Pose
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.numbers.rounded import plain
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

# ---- Taylor series -------------------------------------------------------------------------------

BITS = 320  # 96 digits: 60 remain after everything that follows
ORDER = 64  # terms of a series
DIGITS = 70  # decimal digits to which a step is accurate
TOUCHED = 1e-40  # a side whose height falls or rises more slowly is only touched
MAX_STEPS = 400
HALVINGS = 300  # of a step, in search of a root

Series: TypeAlias = Any  # arb_series
Form: TypeAlias = Callable[[Sequence[Series]], Series]


@dataclass(frozen=True)
class ReferencePiece:
    """A piece of a field: functions that are positive inside, and the rates of the states, all callable on series."""

    sides: tuple[Form, ...]
    rates: tuple[Form, ...]


@dataclass(frozen=True)
class ReferenceEnd:
    """Where a reference path ends: time, state, crossings passed, and why (empty: the time is over)."""

    time: float
    state: tuple[Any, ...]
    crossings: int = 0
    reason: str = ""


@contextmanager
def precision() -> Iterator[None]:
    """Working precision and length of series for the reference."""
    before = ctx.prec, ctx.cap
    ctx.prec, ctx.cap = BITS, ORDER
    try:
        yield
    finally:
        ctx.prec, ctx.cap = before


def follow_series(pieces: Sequence[ReferencePiece], start: Sequence[float], until: float) -> ReferenceEnd:
    """Follow a path over crossings, in steps of Taylor series.

    Args:
        pieces: the field.
        start: initial state, read as the binary fractions that the floats are.
        until: last time.

    Raises:
        ValueError: for a start that is not inside one piece.
    """
    with precision():
        state, time, crossings, reason = [arb(float(x)) for x in start], arb(0), 0, f"{MAX_STEPS} steps"
        holders = [piece for piece in pieces if all(height > 0 for height, _ in _sides(piece, state))]
        if len(holders) != 1:
            raise ValueError(f"required a start inside one piece, received {list(start)} in {len(holders)}")
        piece = holders[0]
        for _ in range(MAX_STEPS):
            series, left, near = _expand(piece, state), (arb(float(until)) - time).mid(), _near(state)
            step = _step_size(series, left)
            roots = (_first_root(side(series), step, near) for side in piece.sides)
            met = [root for root in roots if root is not None]
            moved = min([step, *met])
            state, time = [arb_poly(list(s))(moved).mid() for s in series], (time + moved).mid()
            if not met:
                if step is left:
                    return ReferenceEnd(float(until), _floats(state), crossings)
                continue
            following = _beyond(pieces, piece, state)
            if following is None:
                reason = "the path slides, touches a surface or meets a corner"
                break
            piece, crossings = following, crossings + 1
        return ReferenceEnd(float(time), _floats(state), crossings, reason)


def _floats(state: Sequence[arb]) -> tuple[float, ...]:
    return tuple(float(x.mid()) for x in state)


def _expand(piece: ReferencePiece, state: Sequence[arb]) -> list[Series]:
    """Taylor series of the path from a state: each Picard iteration makes one more coefficient right."""
    start = [arb_series([x.mid()], prec=ORDER) for x in state]
    series = start
    for order in range(2, ORDER + 1):
        known = [arb_series(list(s)[:order], prec=order) for s in series]
        rates = (arb_series(list(rate(known)), prec=ORDER - 1) for rate in piece.rates)
        series = [x + rate.integral() for x, rate in zip(start, rates, strict=True)]
    return [arb_series(list(s), prec=ORDER) for s in series]


def _step_size(series: Sequence[Series], left: arb) -> arb:
    """Largest step at which the last coefficients stay below the accuracy, relative to the state."""
    size = max((abs(s[0].mid()) for s in series), key=float)
    wanted, step = (size if size else arb(1)) * arb(10) ** -DIGITS, left
    for s in series:
        for k in (ORDER - 2, ORDER - 3):
            last = abs(s[k].mid())
            if last:
                step = min(step, ((wanted / last).log() / k).exp().mid())
    return step


def _first_root(height: Series, step: arb, near: arb) -> arb | None:
    """The first root within a step of the height over a side; one at the start is where the path has come from.

    Halves of the step are left out once a ball over them is positive, or both ends are and the slope has one sign;
    what remains after :data:`HALVINGS` is a root, or so near to one that the digits do not tell.
    """
    coefficients = [c.mid() for c in height]
    form = arb_poly(coefficients[1:] if abs(coefficients[0]) < near else coefficients)
    slope, waiting = form.derivative(), [(arb(0), step, 0)]
    while waiting:
        low, high, depth = waiting.pop()
        middle = ((low + high) / 2).mid()
        whole = arb(middle, (high - low).mid() / 2)
        if form(whole) > 0 or (form(low) > 0 and form(high) > 0 and not slope(whole).contains(0)):
            continue
        if depth == HALVINGS:
            return low
        waiting += [(middle, high, depth + 1), (low, middle, depth + 1)]
    return None


def _near(state: Sequence[arb]) -> arb:
    """The height below which a state is on a side."""
    return arb(10) ** (5 - DIGITS) * (1 + max((abs(x) for x in state), key=float))


def _sides(piece: ReferencePiece, state: Sequence[arb]) -> list[tuple[arb, arb]]:
    """The height over each side at a state, and its rate along the velocity of the piece."""
    at = [arb_series([x], prec=1) for x in state]
    line = [arb_series([x, rate(at)[0]], prec=2) for x, rate in zip(state, piece.rates, strict=True)]
    return [(height[0], height[1]) for height in (side(line) for side in piece.sides)]


def _beyond(pieces: Sequence[ReferencePiece], left: ReferencePiece, state: Sequence[arb]) -> ReferencePiece | None:
    """The piece that takes a path on at a side; None unless both velocities point across one side that they share."""
    near = _near(state)
    around = [piece for piece in pieces if all(height > -near for height, _ in _sides(piece, state))]
    if len(around) != 2:
        return None
    other = around[around[0] is left]
    for piece, onward in ((left, -1), (other, 1)):
        rates = [rate for height, rate in _sides(piece, state) if abs(height) < near]
        if len(rates) != 1 or not onward * rates[0] > TOUCHED:
            return None
    return other


# ---- fields without rounding ---------------------------------------------------------------------


def ball(number: Any) -> Any:
    """An exact number as a ball: at the working precision, or of 256 bits (77 digits) where it is evaluated late.

    Of a rounded number that is the one by which floats go, not the others close by.
    """
    if isinstance(number, Lazy):
        return number.ball
    return plain(number).ball() if isinstance(number, Number) else number


def array_pieces(partition: Partition, kinematics: Kinematics) -> tuple[ReferencePiece, ...]:
    """Cells with the pose rates of their (first) twists."""
    with precision():
        rates = []
        for vx, vy, omega in (map(ball, cell.twists[0]) for cell in partition.cells):
            turn = omega if kinematics is Kinematics.EXACT else 0
            rates.append((_linear(vx, 0, -turn), _linear(vy, turn), _linear(omega)))
        return _over_cells(partition, rates)


def gradient_pieces(partition: Partition, gain: float, weight: Fraction = Fraction(1)) -> tuple[ReferencePiece, ...]:
    """The closed loop ``u = -k (c, w theta) . g``, linear on every cell.

    Kinematics are of leading order at the checked point, as
    :func:`nonsmooth.analysis.fields.constant_field.feedback_field` has them.
    """
    with precision():
        x, y = map(ball, partition.scene.check.equilibrium)
        scale = -arb(gain) * rational_ball(weight)
        rates = []
        for cell in partition.cells:
            fields = [[ball(entry) for entry in field] for field in cell.states[0].control_fields.values()]
            moved = [(a - c * y, b + c * x, c) for a, b, c in fields]  # velocities at the checked point
            pulls = [(a * -gain, b * -gain, c * scale) for a, b, c in fields]
            pairs = list(zip(pulls, moved, strict=True))
            matrix = [[sum(p[j] * m[k] for p, m in pairs) for j in range(3)] for k in range(3)]
            rates.append(tuple(_linear(0, *row) for row in matrix))
        return _over_cells(partition, rates)


def system_pieces(scene: SwitchedSystem) -> tuple[ReferencePiece, ...]:
    """The modes of a plain system, each bounded by every surface."""
    surfaces, modes = fields_by_signs(scene)
    with precision():
        return tuple(
            ReferencePiece(
                tuple(_polynomial(surface, sign) for surface, sign in zip(surfaces, signs, strict=True)),
                tuple(map(_polynomial, rates)),
            )
            for signs, rates in modes.items()
        )


def _over_cells(partition: Partition, rates: Sequence[tuple[Form, ...]]) -> tuple[ReferencePiece, ...]:
    """A piece for each cell, with sides where its half-planes end."""
    pieces = []
    for cell, forms in zip(partition.cells, rates, strict=True):
        bounds = [(ball(side.offset), *map(ball, side.normal)) for side in cell.polygon.sides]
        pieces.append(ReferencePiece(tuple(_linear(c, -a, -b) for c, a, b in bounds), forms))
    return tuple(pieces)


def _linear(constant: Any, *slopes: Any) -> Form:
    return lambda x: sum((entry * slope for entry, slope in zip(x, slopes, strict=False)), x[0] * 0 + constant)


def _polynomial(polynomial: Polynomial, sign: int = 1) -> Form:
    """A polynomial, or its negative, as a function of series."""
    terms = [(exponents, sign * ball(coefficient)) for exponents, coefficient in polynomial.terms.items()]

    def value(x: Sequence[Series]) -> Series:
        total = x[0] * 0
        for exponents, coefficient in terms:
            term = x[0] * 0 + coefficient
            for variable, exponent in zip(x, exponents, strict=True):
                for _ in range(exponent):
                    term = term * variable
            total = total + term
        return total

    return value


# ---- a field beside its reference ----------------------------------------------------------------

INTEGRATOR = 1e-11  # error of DOP853 along a path: some ten steps of 1e-12
HEADING = 0.1  # start of theta


@dataclass(frozen=True, eq=False)
class MeasuredField:
    """One switched field in floats, as the program simulates it, with the same field in which nothing is rounded."""

    field: ConstantField | SignField
    pieces: tuple[ReferencePiece, ...]
    exact: ConstantField | None  # over exact numbers; None where the field is not constant on polygons
    radius: float  # half-width of the checked square (length)
    centre: XY
    slack: float  # distance within which a start counts as on a surface (length)

    @property
    def speed(self) -> float:
        """A bound on the speeds at hand (length/time)."""
        if isinstance(self.field, ConstantField):
            return self.field.speed_scale or 1.0
        places = [np.array(self.place(a, b)) for a in (-1, 0.3, 1) for b in (-1, 0.4, 1)]
        velocities = [self.field.faces_at(place)[-1].members[0].velocity(0.0, place) for place in places]
        return max(float(np.abs(velocity).max()) for velocity in velocities) or 1.0

    @property
    def step_error(self) -> float:
        """What integration adds, in half-widths: nothing where paths are closed forms."""
        return 0.0 if isinstance(self.field, ConstantField) else INTEGRATOR

    @property
    def span(self) -> float:
        """Time in which a path crosses the square."""
        return self.radius / self.speed

    def place(self, x: float, y: float) -> tuple[float, ...]:
        """A state, its position in units of the half-width from the centre."""
        position = (self.centre[0] + x * self.radius, self.centre[1] + y * self.radius)
        return (*position, HEADING) if isinstance(self.field, ConstantField) else position

    def distance(self, first: Sequence[Any], second: Sequence[Any]) -> float:
        """Distance of two states: positions in half-widths, theta in radians."""
        gaps = [abs(float(a) - float(b)) for a, b in zip(first, second, strict=True)]
        return max(gaps[0] / self.radius, gaps[1] / self.radius, *gaps[2:])

    def reached(self, start: Sequence[float], until: float) -> ReferenceEnd:
        """Time and state that a path has to reach: exact where the field allows it, else at 60 digits.

        Raises:
            ValueError: for a start on a surface where only the reference at 60 digits is at hand.
        """
        if self.exact is None:
            return follow_series(self.pieces, start, until)
        end = simulate(self.exact, (*start, 0)[:3], until).end
        return ReferenceEnd(min(float(end.t), until), end.state[: len(start)])


def measured_array(partition: Partition, kinematics: Kinematics) -> MeasuredField:
    """An array with its own speeds."""
    field, check = array_field(partition, kinematics), partition.scene.check
    exact = array_field(partition, kinematics, exact=True) if kinematics is Kinematics.LEADING else None
    pieces = array_pieces(partition, kinematics)
    return MeasuredField(field, pieces, exact, float(check.radius), check.place, field.cells.slack)


def measured_system(scene: SwitchedSystem) -> MeasuredField:
    """A plain system, followed by the general integrator.

    Raises:
        LeftOut: for one that divides by norms, of which no reference is at hand where these are zero.
    """
    field, radius = system_field(scene, centred=True), scene.check.half_width
    if isinstance(field, NormField):
        raise LeftOut("no reference path where a norm that is divided by is zero")
    exact = constant_system(scene)
    return MeasuredField(field, system_pieces(scene), exact, radius, (0.0, 0.0), SURFACE_SLACK * radius)


# ---- exact paths of arrays -----------------------------------------------------------------------

# Starts in sixteenths of the half-width from the checked point, the same shares of every square so that no array is
# given one that suits it: in all directions, near and far, none on a symmetry axis.
STARTS = ((15, 10), (11, -3), (-5, 11), (-8, -13), (6, -14), (-13, 2), (3, 8), (-10, -4))
BEFORE, AFTER = Fraction(15, 16), Fraction(5, 4)  # of the time of what ends a path: not yet there, and well past it
COMPARED = 256  # states of a path that are compared, evenly spread over its samples
FIRST_CROSSINGS = {EventKind.CROSS, EventKind.SLIDE, EventKind.REST}  # events at which a surface is reached


@dataclass(frozen=True)
class ExactPath:
    """The exact solution from one start, leading-order kinematics, up to the last time that is compared."""

    start: Pose
    until: float
    path: Trajectory

    @property
    def events(self) -> tuple[Event, ...]:
        """What happens after the start and before the last time."""
        return tuple(e for e in self.path.events if 0 < e.t < Fraction(self.until))

    def path_error(self, times: Sequence[Any], states: Sequence[State]) -> float:
        """Largest difference of a coordinate over at most :data:`COMPARED` samples."""
        chosen = np.unique(np.linspace(0, len(times) - 1, COMPARED).astype(int))
        return max(self.error_at(times[k], states[k]) for k in chosen)

    def error_at(self, time: Any, state: State) -> float:
        """Largest difference of a coordinate at one time: exact, then rounded."""
        return max(abs(float(mine - _exact(value))) for mine, value in zip(self.path.at(time), state, strict=True))

    def event_error(self, events: Sequence[Event]) -> float | None:
        """Largest difference of the times at which a path first meets the same edges; None where it never does."""
        waiting, errors = list(events), []
        for mine in self.events:
            met = (k for k, other in enumerate(waiting) if _cells(other) == _cells(mine))
            k = next(met, None) if mine.kind in FIRST_CROSSINGS else None
            if k is not None:
                errors.append(float(abs(mine.t - _exact(waiting[k].t))))
                del waiting[: k + 1]
        return max(errors, default=None)


def reference_paths(partition: Partition) -> tuple[ConstantField, tuple[ExactPath, ...]]:
    """The exact field of a partition and its exact solutions from all starts, without starts of more than one path."""
    field, check = array_field(partition, Kinematics.LEADING, exact=True), partition.scene.check
    paths = []
    for shares in STARTS:
        x, y = (float(c + check.radius * share / 16) for c, share in zip(check.equilibrium, shares, strict=True))
        path = _unique_path(field, (x, y, 0.0))
        paths += [] if path is None else [path]
    return field, tuple(paths)


def _unique_path(field: ConstantField, start: Pose) -> ExactPath | None:
    """The path from a start, up to shortly before it stops being the only one or leaves the square, and shortly after
    it has come to rest for good; None where it never is the only one.
    """
    path = simulate(field, start, None)
    branching = next((float(event.t) for event in path.events if event.kind is EventKind.NONUNIQUE), None)
    ends = float(path.end.t)
    if branching == 0:
        return None
    if branching is not None:
        until = float(BEFORE) * branching
    elif path.end.reason in {EndReason.REST, EndReason.TURNING} and ends > 0:
        until = float(AFTER) * ends
    else:
        until = float(BEFORE) * ends if 0 < ends < math.inf else 1.0
    return ExactPath(start, until, path)


def _exact(value: Any) -> Any:
    """A float as the binary fraction that it is."""
    return Fraction(float(value)) if isinstance(value, float | int) else value


def _cells(event: Event) -> frozenset[str]:
    """The cells whose common edge an event lies on."""
    return frozenset(event.surface.split(" | "))
