"""Scenes: a planar array of driven wheels, its friction, its contact rule and what is to be checked.

World frame; the reference point of the body is its centre of mass ``c``.  Wheel ``i`` sits at ``p_i``, its
rim points along ``d_i = D_i/|D_i|`` (``D_i`` is kept as the user wrote it: its length is the only square
root of the wheel, so it is taken only when needed), and its surface runs along ``d_i`` with speed ``u_i``.

Friction is ``mu_R`` along an axis ``a_i = A_i/|A_i|`` and ``mu_S`` across it, along ``J a_i``.  The axis is the rim
unless the wheel names one: a mecanum wheel grips along the axes of its rollers, which stand askew to its rim.  The slip
``q = v(p_i) - u_i d_i`` is then ``a_i . v(p_i) - u_i a_i . d_i`` along the axis and
``J a_i . v(p_i) - u_i J a_i . d_i`` across it.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, fields, replace
from decimal import Context, Decimal
from fractions import Fraction
from functools import cached_property
from typing import ClassVar, Literal, NamedTuple, Self

from flint import arb, ctx, fmpq

from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression
from nonsmooth.symbolic.mechanics.body import Body, BodyInertia, ContinuousField, extent, outer_positions
from nonsmooth.symbolic.mechanics.load_model import Arithmetic, LoadModel, Three, UnknownLoads, X
from nonsmooth.symbolic.mechanics.units import Units
from nonsmooth.symbolic.messages.notebook import ShortRepr
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.messages.scene_kind import SceneKind
from nonsmooth.symbolic.numbers.coefficients import as_fraction, rational_ball
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.plane import XY, Vector, cross, dot, in_floats, minus, turned
from nonsmooth.symbolic.numbers.rounded import Rounded

# ---- the length l that weighs headings against places --------------------------------------------
#
# ``V = |c|^2 + l^2 theta^2``, what a scene takes by default.
#
# That length is a part of the array, whatever the unit: the root mean square distance of the wheels from the checked
# point, as ``a q`` with a rational a that scales with the array and three digits of the ratio q.  So it is rational,
# and the same length in every unit.


DIGITS = 3  # of the ratio q
_SETTLED = 12  # digits to which q is rounded first, so that a tie of the rounding is a tie in every unit
_BITS = 64  # of the distances
SMALL, LARGE = 2.0**-332, 2.0**332  # sums of squares of floats in between neither vanish nor overflow


def default_length(positions: Sequence[Vector], point: Vector) -> Fraction:
    """Root mean square distance (length) of the wheels from a point, to about three digits.

    Args:
        positions: of at least two wheels, at different places.
        point: the checked one.
    """
    outer = outer_positions(positions)
    unit = rational_size(max(extent(outer, 0), extent(outer, 1)))
    coordinates = [entry for position in positions for entry in minus(position, point) if entry]
    settled = _root_mean_square(coordinates, len(positions), unit)
    return unit * Fraction(Context(prec=DIGITS).plus(settled))


def _root_mean_square(coordinates: Sequence[Number], count: int, unit: Fraction) -> Decimal:
    """``sqrt(sum x^2/count)/unit`` to more digits than are kept: in floats, or beyond their range in balls."""
    sizes = [abs(float(entry)) for entry in coordinates]
    if SMALL < max(sizes) < LARGE and SMALL < unit < LARGE:
        mean = math.fsum(size * size for size in sizes) / count
        return Decimal(f"{math.sqrt(mean) / float(unit):.{_SETTLED}g}")
    with ctx.workprec(2 * _BITS):
        squares = sum((entry.accurate_ball(_BITS) ** 2 for entry in coordinates), arb(0))
        ratio = (squares / count).sqrt() / rational_ball(unit)
        return Decimal(ratio.str(_SETTLED, radius=False))


def rational_size(value: Number) -> Fraction:
    """A positive rational that scales with a nonzero number: its size, or of an irrational one its first coefficient.

    ``rational_size(k x) = |k| rational_size(x)`` for every rational k.
    """
    first = value.terms[min(value.terms)]
    rational = first if isinstance(first, fmpq) else next(entry for entry in first.coeffs() if entry)
    return abs(as_fraction(rational))


# ---- the scene -----------------------------------------------------------------------------------
#
# With how far the array that is built may be from it, a box of parameters: every number says by how much a value may
# differ, up or down, for each wheel on its own.


@dataclass(frozen=True)
class Tolerance:
    """A box of parameters around a scene; all entries are at least zero.

    Attributes:
        position: of each coordinate of each wheel (length).
        heading: of each rim direction, as ``pi * turn`` (radian).
        speed: of each surface speed, as a share of it.
        mu_roll: of each coefficient of friction along the axis, as a share of it.
        mu_side: the same across the axis.
        centre_of_mass: of each coordinate of the body's centre of mass in its own frame (length).
    """

    position: Number
    heading: Fraction
    speed: Number
    mu_roll: Number
    mu_side: Number
    centre_of_mass: Number

    @property
    def names(self) -> tuple[str, ...]:
        """The entries that are not zero."""
        return tuple(entry.name for entry in fields(self) if getattr(self, entry.name))

    def times(self, factor: Fraction) -> Tolerance:
        """Every entry times a factor that is not negative."""
        return Tolerance(**{entry.name: getattr(self, entry.name) * factor for entry in fields(self)})

    def without(self, name: str) -> Tolerance:
        """The same with one entry zero."""
        return replace(self, **{name: getattr(self, name) * 0})

    def scaled(self, factor: Fraction) -> Tolerance:
        """In another unit of length: lengths times a factor."""
        return replace(self, position=self.position * factor, centre_of_mass=self.centre_of_mass * factor)


# ---- what a feedback loop does not know in time, or not exactly ----------------------------------


class LoopErrors(NamedTuple):
    """How old the pose is that the law acts on, and how far it may be off; all entries are at least zero.

    Attributes:
        delay: age of the pose (time).
        position: largest distance of the place that the law is given from the true one (length).
        heading: largest difference of the heading that it is given, as ``pi * turn`` (radian).
    """

    delay: Number
    position: Number
    heading: Fraction


# ---- the scene -----------------------------------------------------------------------------------


DEFAULT_ACCURACY = Fraction(3, 100)  # of the root mean square distance of the wheels


@dataclass(frozen=True)
class Friction:
    """Coulomb coefficients along the friction axis (``roll``, mu_R) and across it (``side``, mu_S); both >= 0.

    ``rule`` is the contact rule of the wheel in an array whose wheels have different ones; empty where all have the
    scene's.
    """

    roll: Number
    side: Number
    rule: str = ""


class WheelNumber(int):
    """The number of a wheel, counted from 1; in words (``str``) its name, where the scene gives it one.

    ``f"{number:d}"`` is the number of a named wheel too, for symbols such as ``u_3``; JSON holds numbers.
    """

    def __new__(cls, number: int, name: str = "") -> Self:
        """A number with a name, or none."""
        made = super().__new__(cls, number)
        made.name = name
        return made

    name: str

    def __str__(self) -> str:
        return self.name or int.__repr__(self)


@dataclass(frozen=True)
class Wheel:
    """One driven wheel.

    Attributes:
        index: 1-based number, as in the paper; a :class:`WheelNumber` where the wheel has a name.
        position: ``p_i`` (length).
        direction: ``D_i``, the rim direction, of any nonzero length.
        given_speed: ``u_i`` along the rim (length/time); None means the magnitude ``|D_i|`` of a velocity field.
        friction: coefficients of this wheel.
        speed_limit: the largest ``|u_i|`` that its drive can do (length/time); None where that is not stated.
        axis: ``A_i``, the friction axis, of any nonzero length and not along the rim; None where it is the rim.
        named: keys of the scene file that the wheel states itself, such as ``mu_side``; the others are the scene's.
    """

    index: int
    position: Vector
    direction: Vector
    given_speed: Number | None
    friction: Friction
    speed_limit: Number | None = None
    axis: Vector | None = None
    named: frozenset[str] = field(default=frozenset(), compare=False, repr=False)

    @cached_property
    def length(self) -> Number:
        """``|D_i|``."""
        return dot(self.direction, self.direction).sqrt()

    @cached_property
    def speed(self) -> Number:
        """Surface speed ``u_i``."""
        return self.length if self.given_speed is None else self.given_speed

    @property
    def grip(self) -> Vector:
        """``A_i``, of the friction axis: ``D_i`` where that is the rim."""
        return self.direction if self.axis is None else self.axis

    @cached_property
    def grip_length(self) -> Number:
        """``|A_i|``."""
        return self.length if self.axis is None else dot(self.axis, self.axis).sqrt()

    @cached_property
    def unit_grip(self) -> Vector:
        """``a_i = A_i/|A_i|``."""
        return self.grip[0] / self.grip_length, self.grip[1] / self.grip_length

    @cached_property
    def normals(self) -> tuple[Three[Number], Three[Number]]:
        """``(A_i, A_i . J p_i)`` and ``(J A_i, J A_i . J p_i)``: left sides of the two rows, scaled by ``|A_i|``."""
        along, across, moved = self.grip, turned(self.grip), turned(self.position)
        return (*along, dot(along, moved)), (*across, dot(across, moved))

    @cached_property
    def unit_normals(self) -> tuple[Three[Number], Three[Number]]:
        """The same of a friction axis of length one."""
        scale = self.grip_length.inverse()
        (a, b, m), (c, d, n) = self.normals
        return (a * scale, b * scale, m * scale), (c * scale, d * scale, n * scale)

    @cached_property
    def gains(self) -> Vector:
        """``(A_i . d_i, J A_i . d_i)``: what the two rows, scaled by ``|A_i|``, demand for each unit of speed."""
        if self.axis is None:
            return self.length, self.direction[0] * 0
        along, across = dot(self.axis, self.direction), cross(self.axis, self.direction)
        return along and along / self.length, across and across / self.length

    @cached_property
    def scaled_speed(self) -> Number:
        """``|A_i| u_i a_i . d_i``: the right-hand side of the roll row ``A_i . v(p_i) = u_i A_i . d_i``."""
        if self.axis is not None:
            return self._scaled(dot(self.axis, self.direction))
        if self.given_speed is None:
            return dot(self.direction, self.direction)
        return self.length * self.given_speed if self.given_speed else self.given_speed

    @cached_property
    def scaled_side_speed(self) -> Number:
        """``|A_i| u_i J a_i . d_i``: the right-hand side of the side row, zero where the axis is the rim."""
        return self.direction[0] * 0 if self.axis is None else self._scaled(cross(self.axis, self.direction))

    @property
    def slip_speeds(self) -> Vector:
        """``(u_i a_i . d_i, u_i J a_i . d_i)``: the speeds of the surface along the friction axis and across it."""
        if self.axis is None:
            return self.speed, self.direction[0] * 0
        return self.scaled_speed / self.grip_length, self.scaled_side_speed / self.grip_length

    def _scaled(self, product: Number) -> Number:
        """A product with ``D_i`` for ``u_i d_i``."""
        if self.given_speed is None or not product:
            return product
        return self.given_speed and product * self.given_speed / self.length

    def naming_no_rule(self) -> Wheel:
        """The same wheel, under whatever contact rule its scene has."""
        if "contact" not in self.named and not self.friction.rule:
            return self
        return replace(self, friction=replace(self.friction, rule=""), named=self.named - {"contact"})

    @cached_property
    def unit_direction(self) -> Vector:
        """``d_i = D_i/|D_i|``."""
        return self.direction[0] / self.length, self.direction[1] / self.length


@dataclass(frozen=True)
class LoadTable(LoadModel):
    """Normal forces that are affine in the centre of mass: ``N_i = rows[i] . (1, c_x, c_y)``."""

    rows: tuple[tuple[Number, Number, Number], ...]
    lifts_off = False

    @property
    def words(self) -> str:
        """As scene files name it."""
        return "a table, affine in c"

    def forms(
        self, moments: Sequence[Three[X]], carrying: Collection[int], arithmetic: Arithmetic[X]
    ) -> list[Three[X]]:
        """The rows, whoever carries."""
        number = arithmetic.number
        return [(number(a), number(b), number(c)) for a, b, c in self.rows]

    def on(self, places: Sequence[int]) -> LoadModel | None:
        """Only of all of them: what some carry without the others is not in a table."""
        return self if list(places) == list(range(len(self.rows))) else None

    def moved(self, x: Number | Fraction, y: Number | Fraction) -> LoadTable:
        """With the wheels."""
        return replace(self, rows=tuple((a - b * x - c * y, b, c) for a, b, c in self.rows))

    def scaled(self, factor: Fraction) -> LoadTable:
        """With all lengths."""
        return replace(self, rows=tuple((a, b / factor, c / factor) for a, b, c in self.rows))


@dataclass(frozen=True)
class Contact:
    """Contact rule and load model; ``loads`` None means elastic (identical springs, no tension)."""

    rule: str
    loads: LoadModel | UnknownLoads | None = None

    @property
    def loads_are_unknown(self) -> bool:
        """Whether a set of loads is meant, not one load."""
        return isinstance(self.loads, UnknownLoads)


@dataclass(frozen=True)
class CheckedSquare:
    """What is checked: the equilibrium ``c*`` and the square ``|x - x*|, |y - y*| <= radius``.

    ``lyapunov`` is the V that an audit judges, a formula in the displacement ``(x, y)`` from ``c*``, if the scene
    names one; the clauses of Theorem 4 find their own.  ``length`` is the l of ``V = |c - c*|^2 + l^2 theta^2``, by
    which feedback weighs headings against places; ``has_default_length`` says that it follows the point (module
    :func:`default_length`), ``has_default_radius`` that the radius follows the wheels that carry the body.
    ``accuracy`` is how near a body must come (length); None where it is not stated (:attr:`Scene.accuracy`).
    ``wider`` is the radius that the scene states where the square is smaller, so that no wheel enters or leaves.
    """

    equilibrium: Vector
    radius: Number
    lyapunov: PiecewiseExpression | None = None
    length: Fraction = Fraction(1)
    has_default_length: bool = dataclasses.field(default=False, compare=False)
    has_default_radius: bool = dataclasses.field(default=False, compare=False)
    accuracy: Number | None = None
    wider: Number | None = dataclasses.field(default=None, compare=False)

    @property
    def place(self) -> XY:
        """The checked point in floats."""
        return in_floats(self.equilibrium)

    @property
    def half_width(self) -> float:
        """The radius in floats."""
        return float(self.radius)

    @property
    def named_lyapunov(self) -> str | None:
        """The V that the scene names."""
        return None if self.lyapunov is None else self.lyapunov.text


@dataclass(frozen=True, repr=False)
class Scene(ShortRepr):
    """A wheel array with everything a check needs; numbers live in one field.

    Attributes:
        name: its title.
        field: of all its numbers.
        wheels: those that may carry the body.
        contact: the contact rule and the model of loads.
        check: the point and the square about it that are checked.
        source: where it came from (a file or a built-in name), for messages and reports.
        continuum: the field that the array stands for, where its file gives one.
        units: labels, which no result depends on.
        body: what lies on the array; None where every wheel carries at every pose.
        idle: the wheels that do not carry it at the checked pose, where they were set apart
            (:func:`nonsmooth.symbolic.mechanics.contact_set.standing`).
        tolerances: how far the array that is built may be from this one; None where nothing is said of it.
        loop_errors: how late and how wrong the pose is that a feedback law acts on; None where it is exact.
        inertia: how heavy the body is; None where no unit of length is stated: then it has none, as in the paper.
    """

    kind: ClassVar[Literal[SceneKind.ARRAY]] = SceneKind.ARRAY

    name: str
    field: NumberField
    wheels: tuple[Wheel, ...]
    contact: Contact
    check: CheckedSquare
    source: str = ""
    continuum: ContinuousField | None = None
    units: Units = dataclasses.field(default=Units(), compare=False)
    body: Body | None = None
    idle: tuple[Wheel, ...] = ()
    tolerances: Tolerance | None = None
    loop_errors: LoopErrors | None = None
    inertia: BodyInertia | None = None

    @property
    def positions(self) -> list[Vector]:
        """Where the wheels are."""
        return [wheel.position for wheel in self.wheels]

    @property
    def numbers(self) -> tuple[int, ...]:
        """The numbers of the wheels, in their order."""
        return tuple(wheel.index for wheel in self.wheels)

    @property
    def fastest(self) -> float:
        """The speed of the fastest rim, zero of an array that stands."""
        return max((abs(float(wheel.speed)) for wheel in self.wheels), default=0.0)

    @property
    def speed_limits(self) -> dict[int, Number]:
        """The limits of the wheels that have one, by index."""
        return {wheel.index: wheel.speed_limit for wheel in self.wheels if wheel.speed_limit is not None}

    @property
    def origin(self) -> str:
        """Where the scene came from, for messages: its file or built-in name, else its own name."""
        return self.source or self.name

    @cached_property
    def accuracy(self) -> Fraction:
        """How near to the checked point a body must come to be there (length).

        Where it is not stated, 3 % of the root mean square distance of the wheels from the point.
        """
        stated = self.check.accuracy
        if stated is not None:
            rational = stated.as_rational()
            return rational_below(stated.ball()) if rational is None else as_fraction(rational)
        return DEFAULT_ACCURACY * default_length(self.positions, self.check.equilibrium)

    @cached_property
    def places(self) -> dict[int, int]:
        """Where each wheel stands in ``wheels``, by its number: a body leaves some out."""
        return {wheel.index: k for k, wheel in enumerate(self.wheels)}

    @cached_property
    def carrying_places(self) -> tuple[int, ...]:
        """Where the wheels that carry stand among all wheels by their numbers, the idle ones too."""
        numbers = sorted(wheel.index for wheel in (*self.wheels, *self.idle))
        return tuple(numbers.index(wheel.index) for wheel in self.wheels)

    def under(self, rule: str) -> Scene:
        """The same array with all wheels under one contact rule; as it is under the rule that it has."""
        if rule == self.contact.rule:
            return self
        wheels, idle = (tuple(wheel.naming_no_rule() for wheel in group) for group in (self.wheels, self.idle))
        return replace(self, wheels=wheels, idle=idle, contact=replace(self.contact, rule=rule))

    def rule_of_wheel(self, wheel: Wheel) -> str:
        """The contact rule of one wheel: its own in an array of wheels with different ones, else the scene's."""
        return wheel.friction.rule or self.contact.rule

    def checked_at(self, point: Vector, radius: Number) -> Scene:
        """The same array, checked at another point, within ``radius`` of it; a length that is not stated follows it."""
        check = replace(self.check, equilibrium=point, radius=radius)
        if check.has_default_length:
            check = replace(check, length=default_length(self.positions, point))
        return replace(self, check=check)

    def recentred(self) -> Scene:
        """The same array in coordinates whose origin is the checked equilibrium.

        ``V = |c - c*|^2`` and the leading-order kinematics are then those of the origin.
        """
        return self._recentred

    @cached_property
    def _recentred(self) -> Scene:
        x, y = self.check.equilibrium
        if not any(isinstance(entry, Rounded) or entry for entry in (x, y)):  # zero for every member
            return self
        wheels, idle = (
            tuple(replace(w, position=(w.position[0] - x, w.position[1] - y)) for w in group)
            for group in (self.wheels, self.idle)
        )
        loads = self.contact.loads
        if isinstance(loads, LoadModel):
            loads = loads.moved(-x, -y)
        zero, continuum = self.field.zero, self.continuum
        if continuum is not None:
            continuum = replace(continuum, centre=(continuum.centre[0] - x, continuum.centre[1] - y))
        return replace(
            self,
            wheels=wheels,
            idle=idle,
            continuum=continuum,
            contact=replace(self.contact, loads=loads),
            check=replace(self.check, equilibrium=(zero, zero)),
        )


def require_known_loads(scene: Scene, purpose: str) -> None:
    """Refuse a scene that leaves its loads open for a purpose that needs one load.

    Raises:
        SceneError: naming the loads.
    """
    loads = scene.contact.loads
    if isinstance(loads, UnknownLoads):
        expected = f'known loads ("elastic", a table, or measured) {purpose}'
        raise SceneError(scene.origin, "contact.loads", expected, StatedFact(loads.words))
