"""Equal springs under a rigid plate, without tension, the loads of a scene that states no others; measured loads."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from nonsmooth.symbolic.mechanics.body import DIGITS, default_radius
from nonsmooth.symbolic.mechanics.contact_states import Triple, cofactors, gram, inner, scaled
from nonsmooth.symbolic.mechanics.load_model import Arithmetic, LoadModel, Three, UnknownLoads, X
from nonsmooth.symbolic.mechanics.rule import CELLS_BY_LOADS
from nonsmooth.symbolic.mechanics.scene import Contact, LoadTable, Scene
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import lower_text
from nonsmooth.symbolic.numbers.plane import Vector, minus


@dataclass(frozen=True)
class EqualSprings(LoadModel):
    """``form_i = G_A^-1 m_i``: the least ``sum N_i^2`` that carries the weight and balances moments."""

    @property
    def words(self) -> str:
        """Their name in scene files."""
        return "elastic (identical springs, no tension)"

    def forms(
        self, moments: Sequence[Three[X]], carrying: Collection[int], arithmetic: Arithmetic[X]
    ) -> list[Three[X]] | None:
        """None for wheels on one line."""
        if len(carrying) < 3:
            return None
        columns = arithmetic.inverse(*gram([moments[k] for k in sorted(carrying)]))
        if columns is None:
            return None
        x, y, z = columns
        return [(inner(x, m), inner(y, m), inner(z, m)) for m in moments]

    def on(self, places: Sequence[int]) -> EqualSprings:
        """As all of them."""
        return self


def exact_inverse(a: Triple, b: Triple, c: Triple) -> tuple[Triple, Triple, Triple] | None:
    """The columns of the inverse of the matrix with rows a, b, c, by its cofactors."""
    x, y, z = cofactors(a, b, c)
    determinant = inner(a, x)
    if not determinant:
        return None
    share = determinant.inverse()
    return scaled(x, share), scaled(y, share), scaled(z, share)


EXACT: Arithmetic[Number] = Arithmetic(lambda number: number, exact_inverse, lambda number: number.sign())


def exact_moments(scene: Scene) -> list[Triple]:
    """``(1, p_i)`` of all wheels."""
    return [(scene.field.one, *wheel.position) for wheel in scene.wheels]


def load_model(scene: Scene) -> LoadModel:
    """The loads of the wheels of a scene that carry, which are known.

    Raises:
        TypeError: for loads that the scene leaves open.
        ValueError: where some wheels are idle, and it is not known what the others carry without them.
    """
    loads = scene.contact.loads
    if isinstance(loads, UnknownLoads):
        raise TypeError(f"required loads that are known, received {loads.words}")
    if loads is None:
        return EqualSprings()
    model = loads.on(scene.carrying_places) if scene.idle else loads
    if model is None:
        raise ValueError(f"required loads that are known of some wheels alone, received {loads.words}")
    return model


# ---- the checked square --------------------------------------------------------------------------

MANY_WHEELS = 64  # of a hundred, a thousand sets carry in the square that reaches half-way to the edge


def radius_to_check(positions: Sequence[Vector], point: Vector, contact: Contact) -> Number:
    """Half-width of the square about a point that is checked where a scene names none."""
    return _pressed(default_radius(positions, point), positions, point, contact)


def under_rule(scene: Scene, rule: str) -> Scene:
    """The array under one contact rule, in a square that is not larger than that which is then checked."""
    other = scene.under(rule)
    if other is scene or not other.check.has_default_radius:
        return other
    check, places = other.check, other.positions
    radius = _pressed(check.radius, places, check.equilibrium, other.contact)
    return other if radius is check.radius else replace(other, check=replace(check, radius=radius))


def _pressed(radius: Number, positions: Sequence[Vector], point: Vector, contact: Contact) -> Number:
    """A half-width, or less where only the square in which all wheels carry is checked.

    That is so of many wheels on equal springs, under a rule with cells for each set of wheels that carry, about a point
    at which all do: a load ``N_i = a_i + b_i x + c_i y`` stays positive there within the half-width ``a_i/(|b_i| +
    |c_i|)``, with coordinates from the point.
    """
    if contact.rule not in CELLS_BY_LOADS or contact.loads is not None or len(positions) <= MANY_WHEELS:
        return radius
    import numpy as np

    moments = np.array([(1.0, *map(float, minus(position, point))) for position in positions])
    if np.linalg.matrix_rank(moments) < 3:
        return radius
    loads, *rates = np.linalg.inv(moments.T @ moments) @ moments.T
    width = Fraction(float((loads / np.abs(rates).sum(axis=0)).min()))
    return min(radius, radius.field.rational(Fraction(lower_text(width, DIGITS)))) if width > 0 else radius


# ---- loads measured at one pose ------------------------------------------------------------------
#
# Let springs of equal stiffness but unknown heights carry the body: ``N_i = k (m_i . y - h_i)``, ``m_i = (1, p_i)``, as
# long as no wheel lifts off.  Then the loads at two centres of mass differ by the elastic ones, whatever the heights::
#
#     N_i(c) = N_i(c_0) + m_i^T G^-1 (0, c - c_0),      G = sum_j m_j m_j^T.
#
# ``c_0`` is the centre of the measured loads, ``sum N_i p_i / sum N_i``: so sum and moments balance at every c.  Where
# a load would become negative a wheel lifts off, and the table ends there
# (:func:`nonsmooth.analysis.cells.loads.load_regions` refuses such a square).
#
# What some of the wheels carry without the others follows too, where every wheel was pressed: their heights are the
# measured loads, but for the pose of the body (:class:`RaisedSprings`).


class NoSpringsError(ValueError):
    """Wheels on one line: elastic loads are undetermined."""


@dataclass(frozen=True)
class RaisedSprings(LoadModel):
    """Springs of equal stiffness and different heights: ``N_i = max(0, m_i . y + e_i)``, total weight 1.

    Sum and moments determine y, so while a set A carries ::

        N_i = m_i . G_A^-1 ((1, c) - sum over A of e_j m_j) + e_i

    Attributes:
        offsets: e_i of every wheel, the same up to ``m_i . y`` of any pose: loads measured at one, as shares.
    """

    offsets: tuple[Number, ...]

    @property
    def words(self) -> str:
        """For people."""
        return "springs of equal stiffness, whose heights are those of the measured loads"

    def forms(
        self, moments: Sequence[Three[X]], carrying: Collection[int], arithmetic: Arithmetic[X]
    ) -> list[Three[X]] | None:
        """None for wheels on one line."""
        equal = EqualSprings().forms(moments, carrying, arithmetic)
        if equal is None:
            return None
        raised = [(i, arithmetic.number(self.offsets[i])) for i in sorted(carrying)]
        forms = []
        for k, form in enumerate(equal):
            (x, y, z), shift = form, arithmetic.number(self.offsets[k])
            for i, offset in raised:
                shift = shift - inner(form, moments[i]) * offset
            forms.append((x + shift, y, z))
        return forms

    def on(self, places: Sequence[int]) -> RaisedSprings:
        """With the heights of these wheels."""
        return RaisedSprings(tuple(self.offsets[k] for k in places))


@dataclass(frozen=True)
class MeasuredTable(LoadTable):
    """Loads of springs that were measured at one pose.

    Attributes:
        measured: there, as shares of the weight.
    """

    measured: tuple[Number, ...] = ()

    @property
    def words(self) -> str:
        """As scene files name it."""
        return "measured loads"

    def under(self, moments: Sequence[Three[X]], arithmetic: Arithmetic[X]) -> list[Three[X]] | None:
        """The forms where wheels stand elsewhere, and with them the centre of the measured loads; None on one line."""
        equal = EqualSprings().forms(moments, range(len(moments)), arithmetic)
        if equal is None:
            return None
        shares = [arithmetic.number(share) for share in self.measured]
        (_, first_x, first_y), *others = moments
        x, y = shares[0] * first_x, shares[0] * first_y
        for share, (_, own_x, own_y) in zip(shares[1:], others, strict=True):
            x, y = x + share * own_x, y + share * own_y
        return [(share - b * x - c * y, b, c) for share, (_, b, c) in zip(shares, equal, strict=True)]

    def on(self, places: Sequence[int]) -> LoadModel | None:
        """What some of the springs carry without the others, where every wheel was pressed."""
        whole = super().on(places)
        if whole is not None or not all(share.sign() > 0 for share in self.measured):
            return whole
        return RaisedSprings(tuple(self.measured[k] for k in places))


def spring_forms(positions: Sequence[Vector]) -> list[Triple]:
    """``G^-1 m_i`` for every wheel: its elastic load ``form . (1, c)`` while all wheels carry, total weight 1.

    Raises:
        NoSpringsError: for wheels on one line.
    """
    one = positions[0][0].field.one
    forms = EqualSprings().forms([(one, *position) for position in positions], range(len(positions)), EXACT)
    if forms is None:
        raise NoSpringsError("required three wheels that are not collinear")
    return forms


def centre_of(values: Sequence[Number], positions: Sequence[Vector]) -> Vector:
    """``sum N_i p_i / sum N_i`` of loads in any unit that are not all zero."""
    zero = values[0].field.zero
    weight = sum(values, zero)
    x, y = (sum((value * p[axis] for value, p in zip(values, positions, strict=True)), zero) for axis in (0, 1))
    return x / weight, y / weight


def carried_table(values: Sequence[Number], positions: Sequence[Vector]) -> MeasuredTable:
    """The affine loads of total weight 1 that have these values (in any unit, not all zero) at their own centre.

    Raises:
        NoSpringsError: for wheels on one line.
    """
    weight = sum(values, values[0].field.zero)
    x, y = centre_of(values, positions)
    shares = tuple(value / weight for value in values)
    forms = spring_forms(positions)
    rows = tuple((share - b * x - c * y, b, c) for share, (_, b, c) in zip(shares, forms, strict=True))
    return MeasuredTable(rows, shares)


def largest_correction(table: LoadTable, centre: Vector, at: Vector) -> Number:
    """By how much a load changes at most where measured loads are taken to balance at ``at`` instead of their centre.

    As a share of the weight.
    """
    dx, dy = minus(at, centre)
    return max(abs(b * dx + c * dy) for _, b, c in table.rows)
