"""The checker of certificates of arrays in version 1 (``nonsmooth-certificate/1``), kept as an oracle.

It shares no code with the workbench that wrote the certificate and rebuilds every claim from the wheels.  A certificate
names the wheels, a contact rule, the cells of the checked square with their twists, and for each clause of Theorem 4
the evidence for its verdict.  The methods ``show_...`` at the end hold one claim each: what it says, and why the test
implies it.  A clause whose verdict is ``undecided`` claims nothing.

The file in order: limits, the shapes of JSON, exact numbers, planar geometry, the array with its rows and loads, the
cells, the fan of cones at the checked point, arrays within tolerances, the clauses, what is said of a certificate.

Conventions: J is the quarter turn.  A twist is ``(vx, vy, omega, 1)``; the body at c moves by ``c' = v + omega J c``,
measured from the checked point.  A row is the vector of an equation ``row . twist = 0``: rolling ``d . v(p) = u`` and
no side slip ``n . v(p) = 0`` with ``v(p) = v + omega J p``; of a wheel with a friction axis a these are
``a . v(p) = u a . d`` and ``J a . v(p) = u J a . d``.  A point is ``(X, Y, W)``, W > 0, for ``(X/W, Y/W)``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum
from fractions import Fraction
from functools import cmp_to_key
from itertools import combinations, pairwise, permutations, product
from typing import Any, TypeAlias

RATIONAL = re.compile(r"-?[0-9]{1,4000}(/[0-9]{1,4000})?")
MALFORMED = (KeyError, TypeError, ValueError, IndexError, AttributeError, ArithmeticError, RecursionError, MemoryError)


class RejectedError(ValueError):
    """A claim that does not hold, is not shown, or is shown by too much work."""


def require(holds: object, claim: str) -> None:
    """Reject the certificate unless something holds.

    Raises:
        RejectedError: with the claim.
    """
    if not holds:
        raise RejectedError(claim)


SCHEMA = "nonsmooth-certificate/1"
KEYS = "schema field at radius rule loads wheels points cells equilibrium translation rotation feedback theorem4 notes"
ROBUST = "robust"  # one more key, of a certificate about all arrays within tolerances

# ---- limits: no certificate keeps the checker busy for ever ------------------------------------

MAX_GENERATORS = 400
MAX_DEGREE = 400
MAX_WHEELS = 20_000
MAX_FACTORS = 64  # of one product of generators
MAX_WORK = 60_000_000  # operations on machine words, as they are charged below: some twenty seconds
PRECISIONS = (96, 384, 1536)  # bits with which a sign is looked for, one after the other
WORD = 30  # bits

# ---- words -------------------------------------------------------------------------------------

HOLDS, FAILS, HYPOTHESES_NOT_MET, UNDECIDED = "holds", "fails", "hypotheses not met", "undecided"
ASYMPTOTICALLY_STABLE, STABLE, UNSTABLE = "asymptotically stable", "stable", "unstable"
NEUTRAL = "stable, not attractive"
STABILIZABLE, NO_CERTIFICATE, NOT_APPLICABLE = "stabilizable", "no certificate", "not applicable"

# ---- shapes of JSON ----------------------------------------------------------------------------


def take(data: Any, names: str) -> list[Any]:
    """The values of an object that has these keys and no others, in their order."""
    keys = names.split()
    require(type(data) is dict and sorted(data) == sorted(keys), f"an object with the keys {names}")
    return [data[key] for key in keys]


def split(data: Any) -> tuple[list[Any], list[Any]]:
    """The entries that every certificate has, in their order, and the one that some have, in a list."""
    if type(data) is not dict or ROBUST not in data:
        return take(data, KEYS), []
    *entries, robust = take(data, f"{KEYS} {ROBUST}")
    return entries, [robust]


def items(data: Any, count: int | None = None) -> list[Any]:
    """The items of a list, of a given number where one is given; truth values are no items."""
    sound = type(data) is list and count in (None, len(data)) and not any(type(item) is bool for item in data)
    require(sound, f"a list of {count or 'any'} items")
    return list(data)


# ---- exact numbers -----------------------------------------------------------------------------

Monomial: TypeAlias = tuple[int, ...]  # a product of generators, by their numbers in ascending order
Vector: TypeAlias = tuple["Number", ...]


class Budget:
    """Work that is left; each operation on numbers is charged before it is done.

    No clock is asked: a certificate that is accepted on one machine is accepted on all.
    """

    def __init__(self) -> None:
        self.work = MAX_WORK

    def charge(self, work: int) -> None:
        """Take some work off; reject where none is left."""
        self.work -= work
        require(self.work >= 0, "less work: the limit is reached")


@dataclass(frozen=True)
class Generator:
    """The only root above a bound of a monic polynomial, whose lower coefficients are given, lowest first."""

    lower: Vector
    above: Fraction

    @property
    def degree(self) -> int:
        """Of the polynomial."""
        return len(self.lower)


class Field:
    """The rationals with generators, each a root of a polynomial over the rationals and those before it."""

    def __init__(self, data: Any) -> None:
        self.budget = Budget()
        self.generators: list[Generator] = []
        self._reduced: dict[Monomial, Number] = {}
        self._roots: dict[tuple[int, int], tuple[int, int]] = {}
        entries = items(data)
        require(len(entries) <= MAX_GENERATORS, "field: polynomials with one root")
        for entry in entries:
            self.generators.append(self._generator(entry))

    def _generator(self, entry: Any) -> Generator:
        """The claim: the polynomial is monic, with whole coefficients, and has exactly one root above the bound b >= 0.

        All coefficients of ``p(b + x)`` but the constant one are at least zero, and that is negative: so p increases
        for x > 0 from a negative value.
        """
        polynomial, above = take(entry, "polynomial above")
        require(type(polynomial) is not list or len(polynomial) <= MAX_DEGREE, f"a list of {MAX_DEGREE} items")
        coefficients, bound = self.vector(polynomial, len(polynomial)), self.parse(above)
        shifted = list(coefficients)
        for i in range(len(shifted)):
            for j in reversed(range(i, len(shifted) - 1)):
                shifted[j] = shifted[j] + shifted[j + 1] * bound
        first, *others = signs([*shifted, bound])
        monic = polynomial[-1] == "1" and len(polynomial) > 2 and all(c.bottom == 1 for c in coefficients)
        require(monic and first < 0 <= min(others), "field: polynomials with one root")
        return Generator(coefficients[:-1], Fraction(above))

    def constant(self, value: int) -> Number:
        """A whole number."""
        return Number(self, {(): value})

    def parse(self, data: Any) -> Number:
        """A number: a rational as text, or a list of ``[rational, generator, generator, ...]`` to be multiplied."""
        entries = [[data]] if type(data) is str else items(data)
        if not entries:
            raise ValueError("an empty list is no number")
        terms: dict[Monomial, Fraction] = {}
        for entry in entries:
            text, *factors = items(entry)
            monomial, coefficient = self._monomial(factors), self._rational(text)
            before = terms.get(monomial, Fraction(0))
            self.budget.charge((before.denominator.bit_length() // WORD) ** 2)
            terms[monomial] = before + coefficient
        words = sum(c.denominator.bit_length() // WORD for c in terms.values())  # as many as the common one may have
        self.budget.charge(len(terms) * (1 + words) + words**2)
        bottom = math.lcm(*(c.denominator for c in terms.values()))
        return Number(self, {m: c.numerator * (bottom // c.denominator) for m, c in terms.items()}, bottom)

    def _rational(self, text: Any) -> Fraction:
        require(RATIONAL.fullmatch(text), "numbers of the field")
        self.budget.charge(1 + (len(text) // 9) ** 2)
        return Fraction(text)

    def _monomial(self, factors: Sequence[Any]) -> Monomial:
        require(len(factors) <= MAX_FACTORS, f"products of at most {MAX_FACTORS} generators")
        known = all(0 <= k < len(self.generators) for k in factors)
        known = known and all(factors.count(k) < self.generators[k].degree for k in factors)
        require(known, "numbers of the field")
        return tuple(sorted(factors))

    def vector(self, data: Any, count: int) -> Vector:
        """A list of so many numbers."""
        return tuple(self.parse(entry) for entry in items(data, count))

    def reduced(self, monomial: Monomial) -> Number:
        """A product of generators, by products with powers below their degrees."""
        if monomial not in self._reduced:
            self.budget.charge(len(monomial) ** 2 + 1)
            self._reduced[monomial] = self._reduce(monomial)
        return self._reduced[monomial]

    def _reduce(self, monomial: Monomial) -> Number:
        for k in sorted(set(monomial)):
            generator, power = self.generators[k], monomial.count(k)
            if power >= generator.degree:  # x^degree = -(lower terms)
                others = [factor for factor in monomial if factor != k]
                total = self.constant(0)
                for j, coefficient in enumerate(generator.lower):
                    rest = tuple(sorted(others + [k] * (power - generator.degree + j)))
                    total = total - Number(self, {rest: 1}) * coefficient
                return total
        return Number(self, {monomial: 1})

    def root(self, k: int, bits: int) -> tuple[int, int]:
        """Enclosure of a generator, which is positive, in units of 2^-bits, by bisection."""
        if (k, bits) not in self._roots:
            self._roots[k, bits] = self._bisect(self.generators[k], bits)
        return self._roots[k, bits]

    def _bisect(self, generator: Generator, bits: int) -> tuple[int, int]:
        low = math.floor(generator.above * 2**bits)
        high = 2 * low + 2
        while self._is_below_root(generator, high, bits):
            low, high = high, 2 * high
        while high - low > 1:
            middle = (low + high) // 2
            if self._is_below_root(generator, middle, bits):
                low = middle
            else:
                high = middle
        return low, high

    def _is_below_root(self, generator: Generator, place: int, bits: int) -> bool:
        """Whether the polynomial is at most zero at ``place 2^-bits``; by Horner's scheme, scaled to whole numbers."""
        value = self.constant(1)
        for j, coefficient in enumerate(reversed(generator.lower), 1):
            value = value * self.constant(place) + coefficient * self.constant(1 << bits * j)
        return value.sign() <= 0


class Number:
    """An exact number: whole multiples of products of generators, over one positive denominator."""

    def __init__(self, field: Field, terms: dict[Monomial, int], bottom: int = 1) -> None:
        words = (bottom.bit_length() + sum(map(int.bit_length, terms.values()))) // WORD
        # what making any number takes, and the greatest common divisor of its parts: many words at a time
        field.budget.charge(8 + 2 * len(terms) + words * words // (4 * (len(terms) + 1)))
        shared = math.gcd(bottom, *terms.values())
        self.field = field
        self.bottom = bottom // shared
        self.terms = {monomial: c // shared for monomial, c in terms.items() if c}
        self.words = 1 + words

    def __add__(self, other: Number) -> Number:
        self.field.budget.charge(self.words + other.words)
        terms: dict[Monomial, int] = {}
        for number, factor in ((self, other.bottom), (other, self.bottom)):
            for monomial, c in number.terms.items():
                terms[monomial] = terms.get(monomial, 0) + c * factor
        return Number(self.field, terms, self.bottom * other.bottom)

    def __neg__(self) -> Number:
        return Number(self.field, {monomial: -c for monomial, c in self.terms.items()}, self.bottom)

    def __sub__(self, other: Number) -> Number:
        return self + -other

    def __mul__(self, other: Number) -> Number:
        self.field.budget.charge(len(self.terms) * len(other.terms) + self.words * other.words)
        terms: dict[Monomial, int] = {}
        for (left, a), (right, b) in product(self.terms.items(), other.terms.items()):
            reduced = self.field.reduced(tuple(sorted(left + right)))
            words = (a.bit_length() + b.bit_length()) // WORD
            self.field.budget.charge(len(left + right) + len(reduced.terms) + words * reduced.words)
            for monomial, c in reduced.terms.items():
                terms[monomial] = terms.get(monomial, 0) + a * b * c
        return Number(self.field, terms, self.bottom * other.bottom)

    def sign(self) -> int:
        """Certified sign -1, 0 or 1: zero if no terms are left, else shown by an interval, else rejected."""
        if not self.terms:
            return 0
        if self.terms.keys() == {()}:
            return 1 if self.terms[()] > 0 else -1
        for bits in PRECISIONS:
            low, high = self._interval(bits)
            if low > 0 or high < 0:
                return 1 if low > 0 else -1
        raise RejectedError(f"a sign that {PRECISIONS[-1]} bits show")

    def enclosure(self) -> tuple[Fraction, Fraction]:
        """Rational bounds, close to each other."""
        bits = PRECISIONS[1]
        low, high = self._interval(bits)
        return Fraction(low, self.bottom << bits), Fraction(high, self.bottom << bits)

    def _interval(self, bits: int) -> tuple[int, int]:
        """Bounds of the numerator in units of 2^-bits."""
        low = high = 0
        for monomial, c in self.terms.items():
            self.field.budget.charge((len(monomial) + 1) * (bits // WORD) ** 2 + (bits // WORD) * self.words)
            lower = upper = 1 << bits
            for k in monomial:
                a, b = self.field.root(k, bits)
                lower, upper = lower * a >> bits, (upper * b >> bits) + 1
            low += min(c * lower, c * upper)
            high += max(c * lower, c * upper)
        return low, high


# ---- planar geometry and vectors ---------------------------------------------------------------


def total(numbers: Sequence[Number]) -> Number:
    """The sum of at least one number."""
    first, *others = numbers
    return sum(others, start=first)


def dot(a: Sequence[Number], b: Sequence[Number]) -> Number:
    """The sum of products, up to the shorter's length."""
    return total([x * y for x, y in zip(a, b, strict=False)])


def cross(a: Sequence[Number], b: Sequence[Number]) -> Number:
    """The planar cross product."""
    return a[0] * b[1] - a[1] * b[0]


def normal_to(a: Vector, b: Vector) -> Vector:
    """The cross product in space: at right angles to both."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def negative(a: Vector) -> Vector:
    """The opposite vector."""
    return tuple(-x for x in a)


def signs(numbers: Iterable[Number]) -> list[int]:
    """Certified signs."""
    return [number.sign() for number in numbers]


def is_zero(vector: Iterable[Number]) -> bool:
    """Whether all entries are zero."""
    return not any(signs(vector))


def turns_once(steps: Iterable[tuple[Vector, Vector]]) -> bool:
    """Whether counterclockwise steps, each of less than a half turn, that return to their start go around once.

    They do iff they pass from the lower half plane into the upper one exactly once.
    """
    entries = 0
    for step in steps:
        before, after = ((v[1].sign() or v[0].sign()) > 0 for v in step)
        entries += after > before
    return entries == 1


def around(values: Sequence[Any]) -> list[tuple[Any, Any]]:
    """Neighbours in a closed chain."""
    return list(pairwise([*values, values[0]]))


def convex_hull(places: Sequence[Vector]) -> list[Vector]:
    """The corners of the convex hull of plane points, counterclockwise (Andrew's monotone chain)."""
    ordered = sorted(places, key=cmp_to_key(_compare_places))
    if len(ordered) < 3:
        return ordered
    return [*_half_hull(ordered), *_half_hull(ordered[::-1])]


def _compare_places(a: Vector, b: Vector) -> int:
    return (a[0] - b[0]).sign() or (a[1] - b[1]).sign()


def _half_hull(ordered: Sequence[Vector]) -> list[Vector]:
    """The corners below the line from the first point to the last, without the last one."""
    chain: list[Vector] = []
    for place in ordered:
        while len(chain) > 1 and _turn(chain[-2], chain[-1], place) <= 0:
            chain.pop()
        chain.append(place)
    return chain[:-1]


def _turn(a: Vector, b: Vector, c: Vector) -> int:
    """Sign of the turn from a over b to c, positive to the left."""
    return cross((b[0] - a[0], b[1] - a[1]), (c[0] - a[0], c[1] - a[1])).sign()


def _holds_disc(hull: Sequence[Vector], squared_radius: Number) -> bool:
    """Whether a disc about the origin lies in a convex polygon: left of each side, no nearer than its radius."""
    for a, b in around(hull):
        step = (b[0] - a[0], b[1] - a[1])
        reach = cross(a, b)  # the distance of the side times its length
        if reach.sign() <= 0 or (reach * reach - squared_radius * dot(step, step)).sign() < 0:
            return False
    return len(hull) > 2


# ---- the array ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Array:
    """The wheels of a certificate, seen from the checked point; wheels are named "1", "2", ...

    Attributes:
        places: position ``(p_x, p_y, 1)`` of each wheel.
        rows: the rows "R1" (rolling), "S1" (no side slip), ... as ``(a, b, c, -u)``.
        askew: the wheels with a friction axis; true where the drive of the wheel moves it along its axis and there is
            no friction across it, so that its speed can be any along the axis, as that of a rim can.
        friction: coefficient of each row.
        loads: for each wheel ``(b, c, a)`` with ``N = a + b x + c y`` where a table is given; empty otherwise.
        elastic: whether the wheels are identical springs.
    """

    places: dict[str, Vector]
    rows: dict[str, Vector]
    askew: dict[str, bool]
    friction: dict[str, Number]
    loads: dict[str, Vector]
    elastic: bool


@dataclass(frozen=True)
class Contact:
    """One wheel: its place, its rolling and its side row, their friction, and see ``askew`` of :class:`Array`."""

    place: Vector
    rows: tuple[Vector, Vector]
    friction: Vector
    askew: bool | None


def read_wheel(field: Field, at: Vector, name: str, entry: Any) -> Contact:
    """The claim: unit vectors for directions, and friction that is not negative.  Without an axis it is the rim."""
    named = dict(entry)
    axis = field.vector(named.pop("axis"), 2) if "axis" in named else None
    *pairs, speed = take(named, "position direction friction speed")
    position, direction, friction = (field.vector(pair, 2) for pair in pairs)
    grip = direction if axis is None else axis
    one, u = field.constant(1), field.parse(speed)
    lengths = signs(dot(v, v) - one for v in (direction, grip))
    sound = not any(lengths) and min(signs(friction)) >= 0
    require(sound, f"{name}: a unit direction, and friction that is not negative")
    (a, b), p, q = grip, position[0] - at[0], position[1] - at[1]
    along, across = dot(grip, direction), cross(grip, direction)
    rows = (a, b, b * p - a * q, -(u * along)), (-b, a, a * p + b * q, -(u * across))
    askew = None if axis is None else bool(along.sign()) and not friction[1].sign()
    return Contact((p, q, one), rows, friction, askew)


def read_array(field: Field, at: Vector, rule: str, loads: Any, wheels: Any) -> Array:
    """The wheels with their rows and loads."""
    require(rule == "box" or (rule == "nearest" and loads is None), "schema, rule, loads")
    entries = items(wheels)
    require(len(entries) <= MAX_WHEELS, f"at most {MAX_WHEELS} wheels")
    places: dict[str, Vector] = {}
    rows: dict[str, Vector] = {}
    friction: dict[str, Number] = {}
    askew: dict[str, bool] = {}
    for number, entry in enumerate(entries, 1):
        wheel = read_wheel(field, at, f"wheels[{number - 1}]", entry)
        places[str(number)] = wheel.place
        rows[f"R{number}"], rows[f"S{number}"] = wheel.rows
        friction[f"R{number}"], friction[f"S{number}"] = wheel.friction
        if wheel.askew is not None:
            askew[str(number)] = wheel.askew
    elastic = rule == "box" and loads == "elastic"
    table: dict[str, Vector] = {}
    if rule == "box" and not elastic:
        for name, form in zip(places, items(loads, len(places)), strict=True):
            a, b, c = field.vector(form, 3)
            table[name] = (b, c, a + b * at[0] + c * at[1])
    return Array(places, rows, askew, friction, table, elastic)


def friction_limits(array: Array, loaded: Any, corners: Sequence[Vector]) -> list[dict[str, Number]]:
    """The friction limits ``mu N`` of the loaded rows at each corner, up to one positive factor at each.

    The claim: the listed wheels are those that carry load in the cell.  Elastic: ``N_i = max(0, m_i . y)`` with
    ``m_i = (p_i, 1)`` and ``y = A^-1 (c, 1)``, A the sum of ``m m^T`` over the loaded wheels: a spring carries load
    where its form is not negative, and the others have no load because theirs is not positive.
    """
    forms, active = array.loads, set(array.loads)
    if array.elastic:
        active = {f"{number:d}" for number in items(loaded)}
        forms = _elastic_forms(array, active)
    loads = [{name: dot(form, corner) for name, form in forms.items()} for corner in corners]
    sound = all(
        load.sign() * (1 if name in active else -1) >= 0 for at_corner in loads for name, load in at_corner.items()
    )
    require(sound and (loaded is None) == (not array.elastic), "loaded: the loads of the model")
    return [
        {row: array.friction[row] * at_corner[row[1:]] for row in array.rows if row[1:] in active}
        for at_corner in loads
    ]


def _elastic_forms(array: Array, active: set[str]) -> dict[str, Vector]:
    """The forms ``m_i . adj(A) (c, 1)``: adj(A) is A^-1 up to a positive factor."""
    carrying = [array.places[name] for name in active]
    require(carrying, "loaded: wheels that are not collinear")
    gram = [tuple(total([m[r] * m[s] for m in carrying]) for s in range(3)) for r in range(3)]
    adjugate = [normal_to(gram[r - 2], gram[r - 1]) for r in range(3)]
    require(dot(gram[0], adjugate[0]).sign() > 0, "loaded: wheels that are not collinear")
    return {name: tuple(dot(column, m) for column in adjugate) for name, m in array.places.items()}


Limits: TypeAlias = Sequence[dict[str, Number]]


def edge_slopes(array: Array, slips: dict[str, int], limits: Limits) -> Iterator[tuple[Vector, list[int]]]:
    """Each way out of a twist along an edge, and the signs of the slope of D along it under each of the limits.

    D is a sum of ``limit |slip|`` over rows.  The planes of the rows that a twist satisfies cut the neighbourhood into
    cones on which D is linear; their edges are the intersections of two planes, in both senses.  The slope along m is
    the sum of ``limit |row . m|`` over those rows and of ``limit sign(slip) (row . m)`` over the others.
    """
    tight = [array.rows[row] for row, side in slips.items() if not side]
    for a, b in combinations(tight, 2):
        edge = normal_to(a, b)
        if is_zero(edge):
            continue
        for way in (edge, negative(edge)):
            pulls = {}
            for row in limits[0]:
                pull = dot(way, array.rows[row][:3])
                pulls[row] = pull if (slips[row] or pull.sign()) > 0 else -pull
            yield way, [total([pulls[row] * limit for row, limit in at.items()]).sign() for at in limits]


def has_rank_three(vectors: Sequence[Vector]) -> bool:
    """Whether vectors in space (their first three entries) span it."""
    spans = (normal_to(a, b) for a, b in combinations(vectors, 2))
    normal = next((n for n in spans if not is_zero(n)), None)
    return normal is not None and any(dot(normal, row[:3]).sign() for row in vectors)


# ---- cells -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Motion:
    """One twist of a cell.

    Attributes:
        cell: number of the cell.
        rows: names of the rows that give it.
        twist: ``(vx, vy, omega, 1)``.
        rates: signs of ``V*/2 = c . v`` for ``V = |c|^2`` at the cell's corners other than the checked point.
        barrier: evidence about where V* grows, as JSON; None where there is none.
    """

    cell: int
    rows: tuple[str, ...]
    twist: Vector
    rates: tuple[int, ...]
    barrier: Any


@dataclass(frozen=True)
class Cell:
    """A convex polygon with its motions.

    Attributes:
        polygon: numbers of its corners, counterclockwise.
        corners: the corners.
        loaded: the wheels that carry load, as JSON.
        motions: all twists that the rule gives in it.
        rays: numbers of the corners after and before the checked point, the rays of the cell's cone there;
            ``(-1, -1)`` where the point lies inside, None where it does not lie in the cell.
    """

    polygon: tuple[int, ...]
    corners: tuple[Vector, ...]
    loaded: Any
    motions: tuple[Motion, ...]
    rays: tuple[int, int] | None


class CellReader:
    """Reads the cells of a certificate and verifies each against the contact rule."""

    def __init__(self, field: Field, array: Array, rule: str, points: Sequence[Vector]) -> None:
        self.field = field
        self.array = array
        self.points = points
        self.check_rule: Callable[..., None] = self._check_box if rule == "box" else self._check_nearest
        # |c - p|^2 - |c|^2 as a form in (c, 1)
        two = field.constant(2)
        self.distances = {name: (-(two * p), -(two * q), p * p + q * q) for name, (p, q, _) in array.places.items()}

    def read(self, number: int, data: Any) -> Cell:
        """The claims: the polygon is convex, and the rule gives the listed twists, and no others, at all its points."""
        name = f"cells[{number}]"
        polygon, loaded, states = take(data, "polygon loaded states")
        corners = self._corners(name, polygon)
        self._check_convex(name, corners)
        rows, twists, barriers = self._states(name, states)
        self.check_rule(name, rows, twists, corners, loaded)
        origin = [k for k, corner in enumerate(corners) if is_zero(corner[:2])]
        away = [corner[:2] for k, corner in enumerate(corners) if k not in origin]
        motions = tuple(
            Motion(number, tuple(names), twist, tuple(dot(twist, place).sign() for place in away), barrier)
            for names, twist, barrier in zip(rows, twists, barriers, strict=True)
        )
        rays = self._rays(name, polygon, corners, origin)
        return Cell(tuple(polygon), tuple(corners), loaded, motions, rays)

    def _corners(self, name: str, polygon: Any) -> list[Vector]:
        numbers = items(polygon)
        require(all(0 <= k < len(self.points) for k in numbers), f"{name}: numbers of points")
        return [self.points[k] for k in numbers]

    def _check_convex(self, name: str, corners: Sequence[Vector]) -> None:
        """Each side turns left of the last one, or goes straight on; and all of them turn around once."""
        sides = [(q[0] * p[2] - p[0] * q[2], q[1] * p[2] - p[1] * q[2]) for p, q in around(corners)]
        turns = around(sides)
        bends = [(cross(a, b).sign(), dot(a, b).sign()) for a, b in turns]
        require(min(bends) > (0, 0) and turns_once(turns), f"{name}: a convex polygon, counterclockwise")

    def _states(self, name: str, states: Any) -> tuple[list[list[str]], list[Vector], list[Any]]:
        taken = [take(state, "rows twist barrier") for state in items(states)]
        rows, given, barriers = (list(column) for column in zip(*taken, strict=True))
        twists = [(*self.field.vector(twist, 3), self.field.constant(1)) for twist in given]
        for names, twist in zip(rows, twists, strict=True):
            slips = [dot(self.array.rows[row], twist) for row in items(names)]
            require(is_zero(slips), f"{name}: twists that satisfy their rows")
        return rows, twists, barriers

    def _rays(self, name: str, polygon: Any, corners: Sequence[Vector], origin: list[int]) -> tuple[int, int] | None:
        """The checked point lies in the cell iff it lies left of, or on, every side; on a side it is a vertex."""
        views = [cross(a, b).sign() for a, b in around(corners)]
        if min(views) < 0:
            return None
        require(bool(origin) == (min(views) == 0), f"{name}: the checked point as a vertex")
        if not origin:
            return (-1, -1)
        place, count = origin[0], len(polygon)
        return polygon[(place + 1) % count], polygon[place - 1]

    def _check_nearest(self, name: str, rows: list[Any], _: Any, corners: list[Vector], loaded: Any) -> None:
        """Rule nearest: both rows of the nearest wheel i, then of the second, j, the row of larger friction.

        If that row depends on those of i, the other one follows; where the frictions of j are equal, either may come
        first.  A row without friction limits nothing and is never taken.  Distances differ by functions that are affine
        in c, so their order at the corners is that in the cell.
        """
        i, j = rows[0][0][1:], rows[0][2][1:]
        expected = self._rows_of_nearest(i, j)
        require(rows == expected and loaded is None, f"{name}: the rows that the rule takes")
        others = [n for n in self.distances if n not in (i, j)]
        for near, far in [(i, j), *((j, n) for n in others)]:
            line = [b - a for a, b in zip(self.distances[near], self.distances[far], strict=True)]
            ahead = min(signs(dot(line, corner) for corner in corners)) >= 0
            require(not is_zero(line[:2]) and ahead, f"{name}: wheels {i} and {j} the nearest at every vertex")

    def _rows_of_nearest(self, i: str, j: str) -> list[list[str]]:
        """The rows of each motion where wheel i is nearest and j second; none where a row of i has no friction."""
        friction, rows = self.array.friction, self.array.rows
        if not friction[f"R{i}"].sign() or not friction[f"S{i}"].sign():
            return []
        gap = (friction[f"S{j}"] - friction[f"R{j}"]).sign()
        normal = normal_to(rows[f"R{i}"], rows[f"S{i}"])
        kinds = "SR" if gap > 0 else "RS"
        able = [kind + j for kind in kinds if friction[kind + j].sign() and dot(normal, rows[kind + j]).sign()]
        return [[f"R{i}", f"S{i}", row] for row in (able[:1] if gap else able)]

    def _check_box(self, name: str, rows: list[Any], twists: list[Vector], corners: list[Vector], loaded: Any) -> None:
        """Rule box: the twists minimize D at all points of the cell, and no other twist does throughout.

        D is convex and piecewise linear, so a twist at which no slope along an edge is negative is a minimizer; slopes
        are affine in c, so the corners decide.  Where a slope vanishes at all corners D is flat along the edge, which
        then leads to another twist of the list.
        """
        limits = friction_limits(self.array, loaded, corners)
        for names, twist in zip(rows, twists, strict=True):
            slips = {row: dot(normal, twist).sign() for row, normal in self.array.rows.items()}
            tight = [row for row in slips if not slips[row]]
            require(names == tight, f"{name}: all rows that a twist satisfies")
            require(has_rank_three([self.array.rows[row] for row in tight]), "tight rows of rank three")
            gaps = [tuple(a - b for a, b in zip(other, twist, strict=True))[:3] for other in twists]
            for way, slopes in edge_slopes(self.array, slips, limits):
                sound = min(slopes) >= 0 and (max(slopes) > 0 or _leads_along(way, gaps))
                require(sound, f"{name}: all twists that minimize D")


def _leads_along(way: Vector, gaps: Sequence[Vector]) -> bool:
    """Whether one of the gaps is a positive multiple of a direction."""
    return any(dot(way, gap).sign() > 0 and is_zero(normal_to(gap, way)) for gap in gaps)


def check_cover(cells: Sequence[Cell], points: Sequence[Vector], radius: Number) -> None:
    """The claim: the cells cover the square ``|x|, |y| <= radius`` once, and each point is a vertex of one.

    Neighbours list the same side in opposite senses, so these cancel.  What is left runs along the border of the
    square, counterclockwise and around once: so every point of the square is surrounded once by polygons that do not
    overlap.
    """
    sides = [side for cell in cells for side in around(cell.polygon)]
    unique = set(sides)
    used = {k for side in sides for k in side}
    once = len(sides) == len(unique) and used == set(range(len(points)))
    border = [(points[a], points[b]) for a, b in unique - {(b, a) for a, b in unique}]
    sound = once and _runs_around(border, radius)
    require(sound, "cells: they cover the square once, and each point is a vertex")


def _runs_around(border: Sequence[tuple[Vector, Vector]], radius: Number) -> bool:
    """Whether sides lie on the square's border, counterclockwise, and go around once."""
    if not all(_lies_on_one_edge(side, radius) for side in border):
        return False
    return all(cross(a, b).sign() > 0 for a, b in border) and turns_once(border)


def _lies_on_one_edge(side: tuple[Vector, Vector], radius: Number) -> bool:
    for axis in (0, 1):
        for edge in (radius, -radius):
            if all(not (point[axis] - edge * point[2]).sign() for point in side):
                return True
    return False


# ---- the fan of cones at the checked point -----------------------------------------------------


class Outcome(IntEnum):
    """What the moves of a fan do, from the best to the worst."""

    INWARD = 0
    REST = 1
    OPEN = 2
    OUTWARD = 3


SLIDE_OUTCOMES = {1: Outcome.OUTWARD, 0: Outcome.REST, -1: Outcome.INWARD}  # by the sign of the radial speed
VERDICT_OF = {
    Outcome.INWARD: ASYMPTOTICALLY_STABLE,
    Outcome.REST: STABLE,
    Outcome.OPEN: UNDECIDED,
    Outcome.OUTWARD: UNSTABLE,
}


@dataclass(frozen=True)
class Cone:
    """A cell at the checked point: from ray ``start`` counterclockwise to ray ``end``, with its twists.

    Rays are numbers of points; ``(-1, -1)`` for the whole plane.
    """

    start: int
    end: int
    twists: tuple[Vector, ...]

    @property
    def is_plane(self) -> bool:
        """Whether the checked point lies inside the cell."""
        return self.start < 0


@dataclass(frozen=True)
class Crossing:
    """From ray to ray through a cone: ``s'`` is of order ``s^order``.

    ``gain`` is ``(a, b)``, both of one sign, where ``s' = (a/b) s``; None where the order is not one, and where the
    body turns about the checked point itself and keeps its distance.
    """

    order: Fraction
    gain: tuple[Number, Number] | None = None


class Fan:
    """The cones that meet at the checked point, and what solutions do in them.

    The theorem (Filippov 1988, sec. 15-16, with the linear term of the pose): every solution near the point is a chain
    of escapes, slides and crossings.  If none leads outward and none rests, the point is asymptotically stable; if
    some rest, stable; if one leads outward, unstable.

    On a ray r at distance s the body's velocity has the normal part ``r x v + s omega |r|^2``, whose sign for all
    small s is that of the first term, or where that is zero of omega.
    """

    def __init__(self, cones: Sequence[Cone], points: Sequence[Vector]) -> None:
        self.cones = list(cones)
        self.points = points

    def verdict(self) -> str:
        """Stability of the checked point."""
        outcomes = [Outcome.INWARD]
        for cone in self.cones:
            outcomes += [self._escape(cone, twist) for twist in cone.twists]
        if not any(cone.is_plane for cone in self.cones):
            outcomes += self._slides()
            outcomes += [self._full_turn(sense) for sense in (1, -1)]
        return VERDICT_OF[max(outcomes)]

    def _escape(self, cone: Cone, twist: Vector) -> Outcome:
        """A velocity in its own closed cone carries the body straight away, unless omega bends it out along a ray."""
        if is_zero(twist[:2]):
            if not twist[2].sign():
                return Outcome.REST
            only_crossed = len(cone.twists) == 1 and not cone.is_plane
            return Outcome.INWARD if only_crossed else Outcome.OPEN
        if cone.is_plane:
            return Outcome.OUTWARD
        start, end, turning = self.points[cone.start], self.points[cone.end], twist[2].sign()
        after_start = cross(start, twist).sign() or turning * dot(start[:2], twist).sign()
        before_end = cross(twist, end).sign() or -turning * dot(end[:2], twist).sign()
        return Outcome.OUTWARD if after_start >= 0 and before_end >= 0 else Outcome.INWARD

    def _slides(self) -> Iterator[Outcome]:
        """Along a ray the hull of the velocities beside it holds a radial one where their normal parts are opposed."""
        beginning = {cone.start: cone.twists for cone in self.cones}
        for cone in self.cones:
            ray = self.points[cone.end][:2]
            twists = (*cone.twists, *beginning[cone.end])
            for first, second in product(twists, repeat=2):
                outcome = _slide(ray, first, second)
                if outcome is not None:
                    yield outcome

    def _full_turn(self, sense: int) -> Outcome:
        """The product of the orders of all crossings decides, and where that is one the product of their gains.

        In each cone the crossing with the most growth counts: a mixture of motions that tie gains no more, to first
        order, so a turn with a tied cone of another order is not said to contract.
        """
        choices = [self._crossings(cone, sense) for cone in self.cones]
        if not all(choices):
            return Outcome.INWARD  # no full turn exists
        steps = [_most_growth(crossings) for crossings in choices]
        order = math.prod((step.order for step in steps), start=Fraction(1))
        side = _side_of_one(steps) if order == 1 else (1 - order)
        if side > 0:
            return Outcome.OUTWARD
        mixed = any(len(cone.twists) > 1 for cone, step in zip(self.cones, choices, strict=True) if _has_no_gain(step))
        return Outcome.INWARD if side < 0 and not mixed else Outcome.OPEN

    def _crossings(self, cone: Cone, sense: int) -> list[Crossing]:
        found = (self._crossing(cone, twist, sense) for twist in cone.twists)
        return [step for step in found if step is not None]

    def _crossing(self, cone: Cone, twist: Vector, sense: int) -> Crossing | None:
        """How a motion crosses a cone, or None; along its circle ``c x v + omega |c|^2 / 2`` does not change.

        So ``(r x v) s + (omega |r|^2 / 2) s^2`` is the same at the entry and at the exit.
        """
        ends = [self.points[cone.start], self.points[cone.end]]
        entry, exit_ray = ends[::sense]
        entering, leaving = cross(entry, twist), cross(exit_ray, twist)
        before, after = sense * entering.sign(), sense * leaving.sign()
        bend = sense * twist[2].sign()
        if before > 0 and after > 0:
            return Crossing(Fraction(1), (entering, leaving))
        if bend <= 0 or before < 0 or after < 0:
            return None
        if before > 0:
            return Crossing(Fraction(1, 2))
        if after > 0:
            return Crossing(Fraction(2))
        if is_zero(twist[:2]):
            return Crossing(Fraction(1))
        # a half-plane with the velocity along its line: opposite rays, at equal distances
        at_entry, at_exit = dot(entry[:2], exit_ray) * exit_ray[2], dot(exit_ray[:2], exit_ray) * entry[2]
        return Crossing(Fraction(1), (-at_entry, at_exit))


def _has_no_gain(crossings: Sequence[Crossing]) -> bool:
    return any(step.gain is None for step in crossings)


def _slide(ray: Vector, first: Vector, second: Vector) -> Outcome | None:
    """A slide along a ray, or None: ``first`` pushes counterclockwise or not at all, ``second`` clockwise or not.

    With normal parts ``n + s m`` and radial parts r its speed at distance s has the sign of
    ``(n_1 r_2 - n_2 r_1) + s (m_1 r_2 - m_2 r_1)``, or of r where both normal parts vanish for all s.
    """
    (n1, r1), (n2, r2) = ((cross(ray, v), dot(ray, v)) for v in (first, second))
    m1, m2 = first[2], second[2]
    pushes = [n1.sign() or m1.sign(), n2.sign() or m2.sign()]
    if pushes[0] < 0 or pushes[1] > 0:
        return None
    if pushes == [0, 0]:
        return SLIDE_OUTCOMES[r1.sign()]
    speed = (n1 * r2 - n2 * r1).sign() or (m1 * r2 - m2 * r1).sign()
    return SLIDE_OUTCOMES[speed]


def _most_growth(crossings: Sequence[Crossing]) -> Crossing:
    """Of the lowest order, and then of the largest gain."""
    lowest = min(step.order for step in crossings)
    best, *others = [step for step in crossings if step.order == lowest]
    for step in others:
        if best.gain is not None and step.gain is not None:
            inverse = Crossing(lowest, (best.gain[1], best.gain[0]))
            best = step if _side_of_one([step, inverse]) > 0 else best
    return best


def _side_of_one(steps: Sequence[Crossing]) -> int:
    """Sign of the product of gains less one; zero, which decides nothing, where a crossing has no gain."""
    gains = [step.gain for step in steps if step.gain is not None]
    if len(gains) < len(steps):
        return 0
    above, below = gains[0]
    for a, b in gains[1:]:
        above, below = above * a, below * b
    return (above - below).sign() * below.sign()


# ---- arrays within tolerances, under rule nearest ----------------------------------------------

GRID = 1 << 128  # intervals end at multiples of its inverse
ABOVE_PI = Fraction(355, 113)
QUADRANTS = ((1, 1), (-1, 1), (-1, -1), (1, -1))
HALVINGS = 40  # of a side, to a point of it just inside a circle
MAX_BOUND = 200  # characters of a bound, so that all numbers here are about as long as the grid's
Point: TypeAlias = tuple[Fraction, Fraction]
HalfPlane: TypeAlias = tuple[Fraction, Fraction, Fraction]  # a, b, c of a x + b y <= c


@dataclass(frozen=True)
class Interval:
    """All numbers from ``low`` to ``high``."""

    low: Fraction
    high: Fraction

    def __add__(self, other: Interval) -> Interval:
        return rounded(self.low + other.low, self.high + other.high)

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def __sub__(self, other: Interval) -> Interval:
        return self + -other

    def __mul__(self, other: Interval) -> Interval:
        ends = [a * b for a in (self.low, self.high) for b in (other.low, other.high)]
        return rounded(min(ends), max(ends))

    def __truediv__(self, other: Interval) -> Interval:
        require(other.low > 0 or other.high < 0, "robust: a divisor that is not zero")
        return self * rounded(*sorted((1 / other.low, 1 / other.high)))

    @property
    def size(self) -> Fraction:
        """The largest absolute value."""
        return max(-self.low, self.high)


def rounded(low: Fraction, high: Fraction) -> Interval:
    """An interval that holds another, with ends of few digits."""
    return Interval(Fraction(math.floor(low * GRID), GRID), Fraction(math.ceil(high * GRID), GRID))


def exactly(value: int | Fraction) -> Interval:
    """One number."""
    return Interval(Fraction(value), Fraction(value))


def up_to(size: Fraction) -> Interval:
    """All numbers of at most a size."""
    return Interval(-size, size)


NOTHING = exactly(0)


@dataclass(frozen=True)
class Jet:
    """A function's value and its slopes in some parameters, enclosed."""

    value: Interval
    slopes: tuple[Interval, ...]

    def __add__(self, other: Jet) -> Jet:
        return Jet(self.value + other.value, tuple(a + b for a, b in zip(self.slopes, other.slopes, strict=True)))

    def __sub__(self, other: Jet) -> Jet:
        return Jet(self.value - other.value, tuple(a - b for a, b in zip(self.slopes, other.slopes, strict=True)))

    def __mul__(self, other: Jet) -> Jet:
        pairs = zip(self.slopes, other.slopes, strict=True)
        return Jet(self.value * other.value, tuple(a * other.value + self.value * b for a, b in pairs))

    def __truediv__(self, other: Jet) -> Jet:
        ratio = self.value / other.value
        pairs = zip(self.slopes, other.slopes, strict=True)
        return Jet(ratio, tuple((a - ratio * b) / other.value for a, b in pairs))


@dataclass(frozen=True)
class WheelTolerance:
    """A wheel with how far it may be from the certificate's.

    Attributes:
        place: each coordinate of the position.
        rim: each entry of the unit rim direction.
        speed: the surface speed.
        sizes: half-widths of speed, angle (radian), x and y.
        kinds: the rows that may have the larger friction, ``R`` and ``S``.
    """

    place: tuple[Interval, Interval]
    rim: tuple[Interval, Interval]
    speed: Interval
    sizes: tuple[Fraction, Fraction, Fraction, Fraction]
    kinds: str


class PairMotion:
    """The motion of an ordered pair of wheels: both rows of the first and one of the second, over all their builds.

    ``v(p_i) = u_i d_i`` and ``m . v(p_j) = u_m`` give ``omega = (u_m - u_i d_i . m)/(m . J (p_j - p_i))`` and
    ``v = u_i d_i - omega J p_i``, with m the second rim or J of it.  By the mean value theorem a function over a box is
    its value at the middle and, for each parameter, its slope over the box times what the parameter may change.
    """

    COUNT = 8  # speed, angle, x and y of either wheel

    def __init__(self, first: WheelTolerance, second: WheelTolerance, kind: str) -> None:
        self.wheels, self.kind = (first, second), kind

    def velocity(self) -> tuple[Interval, Interval]:
        """``(v_x, v_y)``; rejected where the rows may be dependent."""
        sizes = [size for wheel in self.wheels for size in wheel.sizes]
        middle, whole = self._at([NOTHING] * self.COUNT), self._at([up_to(size) for size in sizes])
        found = []
        for at_middle, over_all in zip(middle, whole, strict=True):
            total = at_middle.value
            for slope, size in zip(over_all.slopes, sizes, strict=True):
                total = total + slope * up_to(size)
            found.append(total)
        return found[0], found[1]

    def _at(self, shifts: list[Interval]) -> tuple[Jet, Jet]:
        u_i, (a, b), (p, q) = self._wheel(0, shifts)
        u_j, (c, d), (r, s) = self._wheel(1, shifts)
        if self.kind == "S":
            (c, d), u_j = (self._constant(NOTHING) - d, c), self._constant(NOTHING)
        omega = (u_j - u_i * (a * c + b * d)) / (d * (r - p) - c * (s - q))
        return u_i * a + omega * q, u_i * b - omega * p

    def _wheel(self, number: int, shifts: list[Interval]) -> tuple[Jet, tuple[Jet, Jet], tuple[Jet, Jet]]:
        wheel, start = self.wheels[number], 4 * number
        speed, angle, x, y = (self._parameter(shifts[start + k], start + k) for k in range(4))
        turn = angle.value.size
        cosine = Jet(Interval(1 - turn * turn / 2, Fraction(1)), tuple(-(angle.value * k) for k in angle.slopes))
        sine = Jet(angle.value, tuple(cosine.value * k for k in angle.slopes))
        a, b, p, q = (self._constant(entry) for entry in (*wheel.rim, *wheel.place))
        return self._constant(wheel.speed) + speed, (a * cosine - b * sine, a * sine + b * cosine), (p + x, q + y)

    def _constant(self, value: Interval) -> Jet:
        return Jet(value, (NOTHING,) * self.COUNT)

    def _parameter(self, value: Interval, number: int) -> Jet:
        return Jet(value, tuple(exactly(int(k == number)) for k in range(self.COUNT)))


class Robust:
    """The claim about all arrays whose wheels are built within tolerances.

    For each of them every Filippov solution with ``|c0| <= start`` has ``|c| <= radius`` from the time ``(start -
    radius)/rate`` on, c the true centre of mass.  For wherever the wheels i and j may be the two nearest, ``c . v <=
    -rate |c|`` outside the disc, for all builds of the two; and ``(c . c)' = 2 c . v``.
    """

    def __init__(self, field: Field, radius: Number, array: Array, wheels: Sequence[Any], data: Any) -> None:
        sizes, *bounds = take(data, "tolerance radius start rate")
        names = "position heading speed mu_roll mu_side"
        self.field = field
        step, turn, *shares = (self._interval(field.parse(entry)).high for entry in take(sizes, names))
        self.radius, self.start, self.rate = (self._rational(entry) for entry in bounds)
        sound = min(step, turn, *shares) >= 0 and max(shares) < 1 and turn < Fraction(1, 2)
        within = 0 < self.radius < self.start and self.rate > 0
        inside = (radius - field.parse(bounds[1])).sign() >= 0
        require(sound and within and inside and not array.askew, "robust: tolerances, and bounds within the square")
        self.step = step
        self.builds = [self._build(array, k, wheel, turn * ABOVE_PI, shares) for k, wheel in enumerate(wheels, 1)]

    def _rational(self, data: Any) -> Fraction:
        short = type(data) is str and len(data) <= MAX_BOUND
        require(short and RATIONAL.fullmatch(data), f"robust: rational bounds of at most {MAX_BOUND} characters")
        return Fraction(data)

    def _interval(self, number: Number) -> Interval:
        low, high = number.enclosure()
        require(max(-low, high) < GRID, "robust: numbers of moderate size")
        return rounded(low, high)

    def _build(
        self, array: Array, number: int, wheel: Any, turn: Fraction, shares: Sequence[Fraction]
    ) -> WheelTolerance:
        speed, roll, side = shares
        row = array.rows[f"R{number}"]
        p, q, _ = array.places[str(number)]
        place, rim = (self._interval(p), self._interval(q)), (self._interval(row[0]), self._interval(row[1]))
        u = self._interval(self.field.parse(wheel["speed"]))
        along, across = (self._interval(array.friction[f"{kind}{number}"]) for kind in "RS")
        require(along.low > 0 and across.low > 0, "robust: friction in both directions")
        kinds = "R" * (along.high * (1 + roll) >= across.low * (1 - side))
        kinds += "S" * (across.high * (1 + side) >= along.low * (1 - roll))
        return WheelTolerance(place, rim, u, (u.size * speed, turn, self.step, self.step), kinds)

    def show(self) -> None:
        """Every quadrant of the square, every pair of wheels that may carry there outside the disc."""
        motions: dict[tuple[int, int], list[Any]] = {}
        for quadrant in QUADRANTS:
            for pair, corners in self._cells(quadrant):
                if not any(self._is_outside(corner) for corner in corners):
                    continue
                if pair not in motions:
                    motions[pair] = self._motions(*pair)
                self._check(corners, motions[pair], quadrant)

    def _cells(self, quadrant: tuple[int, int]) -> Iterator[tuple[tuple[int, int], list[Point]]]:
        """Pairs of wheels with a polygon that holds all points of a quadrant at which they may be the two nearest."""
        wheels = range(len(self.builds))
        nearer: list[dict[int, HalfPlane]] = [{} for _ in wheels]
        for i, k in permutations(wheels, 2):
            nearer[i][k] = self._nearer(i, k, quadrant)
        square = self._quadrant(quadrant)
        for i in wheels:
            first = self._clipped(square, nearer[i].values())
            for j in wheels if first else ():
                others = (line for far, line in nearer[j].items() if far != i)
                corners = self._clipped(first, others) if j != i else []
                if corners:
                    yield (i, j), corners

    def _motions(self, i: int, j: int) -> list[Any]:
        second = self.builds[j]
        self.field.budget.charge(20_000)
        return [PairMotion(self.builds[i], second, kind).velocity() for kind in second.kinds]

    def _check(self, corners: list[Point], motions: Sequence[Any], quadrant: tuple[int, int]) -> None:
        """In a quadrant ``c . v <= c . w`` with one w, and ``c . w + rate |c|`` is convex along each side.

        Seen from the point, what a convex polygon has outside the disc lies behind its sides' parts outside the disc.
        """
        for motion in motions:
            w = tuple(entry.high if side > 0 else entry.low for entry, side in zip(motion, quadrant, strict=True))
            for a, b in around(corners):
                ends = [self._outer_end(a, b), self._outer_end(b, a)]
                require(all(end is None or self._falls(end, w) for end in ends), "robust: a rate outside the disc")

    def _outer_end(self, a: Point, b: Point) -> Point | None:
        """The end a of a side if it lies outside the disc, else a point inside just before the side leaves it."""
        if self._is_outside(a):
            return a
        if not self._is_outside(b):
            return None
        self.field.budget.charge(150 * HALVINGS)
        low, high = Fraction(0), Fraction(1)
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            low, high = (low, middle) if self._is_outside(_between(a, b, middle)) else (middle, high)
        return _between(a, b, low)

    def _is_outside(self, c: Point) -> bool:
        return c[0] ** 2 + c[1] ** 2 > self.radius**2

    def _falls(self, c: Point, w: Sequence[Fraction]) -> bool:
        """Whether ``c . w <= -rate |c|``."""
        self.field.budget.charge(100)
        change = c[0] * w[0] + c[1] * w[1]
        return change <= 0 and change**2 >= self.rate**2 * (c[0] ** 2 + c[1] ** 2)

    def _quadrant(self, quadrant: tuple[int, int]) -> list[Point]:
        far_x, far_y, zero = quadrant[0] * self.start, quadrant[1] * self.start, Fraction(0)
        return [(zero, zero), (far_x, zero), (far_x, far_y), (zero, far_y)][:: quadrant[0] * quadrant[1]]

    def _nearer(self, i: int, k: int, quadrant: tuple[int, int]) -> HalfPlane:
        """``(a, b, c)``: where wheel i may be nearer than k, in a quadrant, ``a x + b y <= c``.

        With t the tolerance of coordinates ``2 c . (p_k - p_i) - 4 t |c|_1 <= |p_k|^2 - |p_i|^2 + 2 t (|p_k|_1 +
        |p_i|_1) + 2 t^2``, and ``|c|_1`` is linear in the quadrant.
        """
        self.field.budget.charge(1500)
        near, far, step = self.builds[i].place, self.builds[k].place, self.step
        two, four, bound = exactly(2), exactly(4 * step), exactly(2 * step * step)
        slopes = []
        for a, b, side in zip(near, far, quadrant, strict=True):
            slope = two * (b - a) - (four if side > 0 else -four)
            slopes.append(slope.low if side > 0 else slope.high)
            bound = bound + (b * b - a * a) + exactly(2 * step * (a.size + b.size))
        return slopes[0], slopes[1], bound.high

    def _clipped(self, corners: list[Point], half_planes: Iterable[HalfPlane]) -> list[Point]:
        """The part of a convex polygon in half-planes; empty where no area is left."""
        for a, b, c in half_planes:
            if not corners:
                break
            self.field.budget.charge(300 * len(corners))
            above = [a * x + b * y - c for x, y in corners]
            kept: list[Point] = []
            for (p, q), (s, t) in zip(around(corners), around(above), strict=True):
                if s <= 0:
                    kept.append(p)
                if s * t < 0:
                    kept.append(_between(p, q, s / (s - t)))
            corners = kept if len(kept) > 2 else []
        return corners


def _between(a: Point, b: Point, share: Fraction) -> Point:
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])


# ---- the clauses -------------------------------------------------------------------------------


class Checker:
    """One certificate: reading it verifies array and cells; :meth:`check` verifies the clauses."""

    def __init__(self, data: Any) -> None:
        entries, robust = split(data)
        schema, field, at, radius, rule, loads, wheels, points, cells, *clauses, _ = entries
        require(schema == SCHEMA, "schema, rule, loads")
        self.field, self.rule = Field(field), rule
        self.zero, self.one = self.field.constant(0), self.field.constant(1)
        self.at, self.radius = self.field.vector(at, 2), self.field.parse(radius)
        self.array = read_array(self.field, self.at, rule, loads, wheels)
        self.points = [self.field.vector(point, 3) for point in items(points)]
        weights = [point[2] for point in self.points]
        require(min(signs([self.radius, *weights])) > 0, "radius, points: positive weights")
        reader = CellReader(self.field, self.array, rule, self.points)
        self.cells = [reader.read(number, cell) for number, cell in enumerate(items(cells))]
        check_cover(self.cells, self.points, self.radius)
        self.motions = [motion for cell in self.cells for motion in cell.motions]
        self.here = [motion for motion in self.motions if self.cells[motion.cell].rays is not None]
        self.highest = max(max(motion.rates) for motion in self.here)
        self.fan = self._fan_verdict() if self.highest >= 0 else ASYMPTOTICALLY_STABLE
        self._read_clauses(clauses)
        self.robust = self._read_robust(wheels, robust)

    def _read_robust(self, wheels: Sequence[Any], found: list[Any]) -> Robust | None:
        if not found:
            return None
        require(self.rule == "nearest", "robust: rule nearest")
        return Robust(self.field, self.radius, self.array, wheels, found[0])

    def _read_clauses(self, clauses: Sequence[Any]) -> None:
        equilibrium, translation, rotation, feedback, self.theorem4 = clauses
        self.said: dict[str, Any] = {}
        self.drift_signs: list[int] | None = None
        self.said["equilibrium"], self.separator = take(equilibrium, "verdict separator")
        self.said["translation"], self.squared_radius = take(translation, "verdict squared_radius")
        self.said["rotation"], *self.drift = take(rotation, "verdict lowest highest")
        self.said["feedback"], self.evidence = take(feedback, "verdict evidence")

    def _fan_verdict(self) -> str:
        cones = []
        for cell in self.cells:
            if cell.rays is not None:
                twists = tuple(motion.twist for motion in cell.motions)
                cones.append(Cone(*cell.rays, twists))
        return Fan(cones, self.points).verdict()

    def check(self) -> None:
        """Compare each verdict with what its evidence shows; ``undecided`` claims nothing."""
        shown = {"equilibrium": self.show_equilibrium()}
        shown["translation"] = self.show_translation()
        shown["rotation"] = self.show_rotation(shown["translation"])
        shown["feedback"] = self.show_feedback()
        for clause, found in shown.items():
            said = self.said[clause]
            require(said in (found, UNDECIDED), f"{clause}: {found}, received {said!r:.60}")
        verdict = self.show_conclusion()
        require(self.theorem4 == verdict, f"theorem4: {verdict}")
        if self.robust is not None:
            self.robust.show()

    @property
    def claims_nothing(self) -> bool:
        """Whether every clause is undecided, and nothing is said of arrays within tolerances."""
        return self.robust is None and set(self.said.values()) == {UNDECIDED}

    # ---- clause 1

    def show_equilibrium(self) -> str:
        """The claim: 0 lies in F(c*), the convex hull of the velocities at the checked point; or it does not.

        Convex weights of velocities that cancel show the first (:meth:`show_drift`).  A direction along which every
        velocity has a positive part shows the second: then so has every convex combination.
        """
        if self.separator is None:
            self.drift_signs = self.show_drift()
            return HOLDS
        margins = [dot(self.field.vector(self.separator, 2), motion.twist) for motion in self.here]
        sound = min(signs(margins)) > 0 and self.drift == [None, None]
        require(sound, "equilibrium: a separating direction")
        return FAILS

    def show_drift(self) -> list[int]:
        """The claim: both ends of the range of omega over the members of F(c*) with zero velocity; here their signs.

        The weights (not negative, not all zero) mix the velocities to zero, and omega to an end ``w``.  Multipliers
        ``(a, b, t, q)``, q > 0, with ``a vx + b vy - side q omega + t >= 0`` at every twist show that no mixture with
        zero velocity passes ``side omega = t/q``, and the mixture attains it.
        """
        ends = []
        for side, bound in zip((-1, 1), self.drift, strict=True):
            weights, multipliers = take(bound, "weights multipliers")
            a, b, shift, scale = self.field.vector(multipliers, 4)
            shares = self.field.vector(weights, len(self.here))
            twists = [motion.twist for motion in self.here]
            x, y, omega, whole = (dot(shares, [twist[k] for twist in twists]) for k in range(4))
            outward = omega if side > 0 else -omega
            attained = is_zero((x, y, shift * whole - scale * outward))
            form = (a, b, -scale if side > 0 else scale, shift)
            above = [dot(form, twist) for twist in twists]
            convex = min(signs([*shares, *above])) >= 0 and min(signs((whole, scale))) > 0
            require(attained and convex, "rotation: weights and multipliers of the drift")
            ends.append(omega.sign())
        return ends

    # ---- clause 2

    def show_translation(self) -> str:
        """The claim: the point is (asymptotically) stable or unstable in (x, y), and V* keeps its sign on a disc.

        ``V = |c|^2`` changes by ``V* = 2 c . v``, linear on each closed cell, so its sign at the corners of the cells
        at the point is that near the point.  Negative: asymptotically stable.  Not positive: stable (Lyapunov for
        differential inclusions), and asymptotically where the fan of cones shows that all paths come home.  Positive
        somewhere: V shows nothing and the fan decides alone.
        """
        self._check_disc()
        if self.highest > 0:
            return self.fan
        require(self.fan != UNSTABLE, "translation: V* and the fan of cones that agree")
        return self.fan if self.fan == ASYMPTOTICALLY_STABLE else STABLE

    def _check_disc(self) -> None:
        """The claim, where there is one: V* keeps its sign on a disc about the point, on which the body does not tip.

        The disc lies in the square and in the support polygon, the convex hull of all wheels.
        """
        if self.squared_radius is None:
            self._check_barriers(None)
            return
        disc = self.field.parse(self.squared_radius)
        inside = disc.sign() > 0 and (self.radius * self.radius - disc).sign() >= 0
        require(inside and self.highest <= 0, "translation: a disc in the square where V* shows one")
        hull = convex_hull([place[:2] for place in self.array.places.values()])
        require(_holds_disc(hull, disc), "translation: a disc in the support polygon")
        self._check_barriers(disc)

    def _check_barriers(self, disc: Number | None) -> None:
        """The claim: cells away from the point where V* grows have their growing part outside the disc.

        A barrier ``(m, t)``, t >= 0, with ``m . c >= 1`` at all corners shows ``(m + t v) . c >= 1`` wherever
        ``v . c >= 0`` in the cell, so there ``|c| >= 1/|m + t v|``, which is at least the radius of the disc.
        """
        for motion in self.motions:
            cell = self.cells[motion.cell]
            grows = disc is not None and cell.rays is None and max(motion.rates) > self.highest
            require((motion.barrier is not None) == grows, f"cells[{motion.cell}]: a barrier where V* grows")
            if disc is None or not grows:
                continue
            a, b, t = self.field.vector(motion.barrier, 3)
            v = motion.twist
            margins = [t, *(dot((a, b, -self.one), corner) for corner in cell.corners)]
            n = (a + t * v[0], b + t * v[1])
            margins.append(self.one - disc * dot(n, n))
            require(min(signs(margins)) >= 0, f"cells[{motion.cell}]: the barrier")

    # ---- clause 3

    def show_rotation(self, translation: str) -> str:
        """The claim: theta is unstable, or stable and not attractive (it never attracts: no twist depends on it).

        Unstable: the drift holds a rate other than zero, so the body may stay at the point and turn for ever.  With a
        drift of {0} theta is stable where the rotation along a path tends to zero with the distance of its start:
        ``|omega| <= K |v|`` on the polytope F(c*) (Hoffman 1952), so it is enough that paths near the point have
        lengths that do, as where all lead inward, or to rest without ties (tied motions might run to and fro).  It is
        also stable where the translation is and no motion at the point turns the body.
        """
        if self.drift_signs is None:
            return UNDECIDED
        if any(self.drift_signs):
            return UNSTABLE
        tied = any(len(cell.motions) > 1 for cell in self.cells if cell.rays is not None)
        short = self.fan == ASYMPTOTICALLY_STABLE or (self.fan == STABLE and not tied)
        turning = any(motion.twist[2].sign() for motion in self.here)
        stable = translation in (ASYMPTOTICALLY_STABLE, STABLE)
        return NEUTRAL if short or (stable and not turning) else UNDECIDED

    # ---- clause 4

    def show_feedback(self) -> str:
        """The claim: some law brings pose and heading home; or no static law does; or the clause does not apply.

        It speaks of wheels with less friction across the rim than along it: those whose rows act at the point under
        rule nearest, all of them under rule box.  Wheels with a friction axis are followed under rule box only, and
        only where nothing but the speed along the axis counts, and the drive can choose that: then the axis is the rim.
        """
        if self.said["feedback"] == UNDECIDED:
            return UNDECIDED
        gaps = (self.array.friction["S" + n] - self.array.friction["R" + n] for n in self._acting_wheels())
        if max(signs(gaps)) >= 0:
            return NOT_APPLICABLE
        if not self._axes_are_followed():
            return UNDECIDED
        if self.evidence is None:
            return UNDECIDED if self.rule == "box" else NO_CERTIFICATE
        if self.said["feedback"] == NO_CERTIFICATE:
            self._check_obstruction()
            return NO_CERTIFICATE
        serves = self._three_twists_serve() if self.rule == "box" else self._signs_serve()
        return STABILIZABLE if serves else UNDECIDED

    def _axes_are_followed(self) -> bool:
        """Whether speeds along the rims are speeds along the friction axes, as far as they count."""
        askew = [free for name, free in self.array.askew.items() if name in self._acting_wheels()]
        return not askew or (self.rule == "box" and all(askew))

    def _acting_wheels(self) -> set[str]:
        if self.rule == "box":
            return set(self.array.places)
        return {row[1:] for motion in self.here for row in motion.rows}

    def _check_obstruction(self) -> None:
        """The claim: all motions that any speeds give near the point lie in one plane ``m . xi = 0``.

        Then no static feedback stabilizes (Brockett's condition).  Under rule nearest the motions are those of the
        control fields: along both rims where a roll row stands third, along the nearest one's where a side row does.
        Under rule box every imposed motion lies in the hull of twists along which no rim slips at the edges of the
        arrangement of side rows.
        """
        normal = self.field.vector(self.evidence, 3)
        require(not is_zero(normal), "feedback: a plane of all motions")
        for a, b in self._pairs_of_edges():
            twist = normal_to(a, b)
            off = dot(normal, twist).sign()
            if off and (self.rule != "box" or self._is_imposed(twist, strictly=False)):
                raise RejectedError("feedback: a plane of all motions")

    def _pairs_of_edges(self) -> Iterator[tuple[Vector, Vector]]:
        rows = self.array.rows
        if self.rule == "nearest":
            for motion in self.here:
                rolling, side, third = motion.rows
                yield rows[side], rows[third]
                if third[0] == "R":
                    yield rows[side], rows[rolling]
            return
        sides = [row[:3] for name, row in rows.items() if name[0] == "S"]
        axes = []
        if not has_rank_three(sides):
            axes = [tuple(self.one if j == k else self.zero for j in range(3)) for k in range(3)]
        yield from combinations([*sides, *axes], 2)

    def _three_twists_serve(self) -> bool:
        """Three independent twists, each imposed as the only minimizer by speeds along the rims.

        Then so is any multiple of either sign, and ``-k (g . xi) xi``, g the state, with the largest ``|g . xi|`` of
        the three makes ``|g|^2`` fall.
        """
        three = [self.field.vector(twist, 3) for twist in items(self.evidence, 3)]
        independent = dot(normal_to(three[0], three[1]), three[2]).sign() != 0
        return independent and all(self._is_imposed(twist, strictly=True) for twist in three)

    def _is_imposed(self, twist: Vector, *, strictly: bool) -> bool:
        """Whether a twist minimizes D at the point when all rims move with it, strictly or not."""
        slips = {}
        for name, row in self.array.rows.items():
            slips[name] = 0 if name[0] == "R" else dot(row[:3], twist).sign()
        tight = [self.array.rows[name] for name, side in slips.items() if not side]
        if strictly:
            require(has_rank_three(tight), "tight rows of rank three")
        loaded = self.cells[self.here[0].cell].loaded
        limits = friction_limits(self.array, loaded, [(self.zero, self.zero, self.one)])
        least = 1 if strictly else 0
        return all(min(slopes) >= least for _, slopes in edge_slopes(self.array, slips, limits))

    def _signs_serve(self) -> bool:
        """Under rule nearest: theta is brought home first; then the body moves along the nearest rims, ``+-|c| d_i``.

        That planar field is a fan of cones; if all its paths lead inward, so do those of the law.  If all rims are
        tangential, full turns of gain one serve too: turning the body to and fro then brings it home.  Without
        turning every crossing is of order one, so nothing else is left open by the fan.
        """
        evidence = items(self.evidence)
        require(len(evidence) == len(self.here), "feedback: a sign for each motion at the point")
        require(all(type(s) is int and s in (1, -1) for s in evidence), "feedback: signs +1 or -1")
        if any(motion.rows[2][0] == "S" for motion in self.here):
            return False
        descent = Fan(self._cones_along_rims(evidence), self.points).verdict()
        return descent == ASYMPTOTICALLY_STABLE or (descent == UNDECIDED and self._has_tangential_rims())

    def _cones_along_rims(self, evidence: Sequence[int]) -> list[Cone]:
        """The cones at the point with the translations along the nearest wheel's rim, by the signs."""
        by_cell: dict[int, list[Vector]] = {}
        for motion, s in zip(self.here, evidence, strict=True):
            rim = self.array.rows[motion.rows[0]]
            along = rim if s > 0 else negative(rim)
            by_cell.setdefault(motion.cell, []).append((along[0], along[1], self.zero))
        return [Cone(*(self.cells[k].rays or (-1, -1)), tuple(twists)) for k, twists in by_cell.items()]

    def _has_tangential_rims(self) -> bool:
        nearest = {motion.rows[0] for motion in self.here}
        return all(not dot(self.array.rows[row][:2], self.array.places[row[1:]]).sign() for row in nearest)

    # ---- Theorem 4

    def show_conclusion(self) -> str:
        """The claim: Theorem 4 holds for the array, fails, or its hypotheses are not met.

        Its hypothesis is that the point is an equilibrium.  It says: (x, y) stable, theta unstable, both stabilizable
        by feedback; so a clause that shows the opposite refutes it, and one left open leaves it open.
        """
        if self.said["equilibrium"] != HOLDS:
            return HYPOTHESES_NOT_MET if self.said["equilibrium"] == FAILS else UNDECIDED
        obstructed = self.said["feedback"] == NO_CERTIFICATE and self.evidence is not None
        if self.said["translation"] == UNSTABLE or self.said["rotation"] == NEUTRAL or obstructed:
            return FAILS
        is_open = {UNDECIDED, NO_CERTIFICATE} & set(self.said.values())
        return UNDECIDED if is_open else HOLDS


# ---- what is said of a certificate -------------------------------------------------------------


def check_certificate(data: Any) -> str:
    """The claim of a certificate (parsed JSON) that is not shown; empty where all are."""
    try:
        Checker(data).check()
    except MALFORMED as error:
        return str(error) if isinstance(error, RejectedError) else f"well-formed data, not a {type(error).__name__}"
    return ""
