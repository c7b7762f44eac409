"""The checker of version 1 for certificates of plain systems in three to eight states, kept as an independent oracle.

It shares no code with the workbench that wrote the certificate.  A certificate names a switched system ``x' = f(x)`` by
its formulas, a point, a function V of the displacement z from it, the cube ``|z_k| <= radius`` and a verdict; with them
the switching surfaces, why some patterns of their signs do not occur, and sums of squares.  None of this is trusted:
the checker reads the formulas itself and derives what must be shown.

*Cells.*  Every sign that a formula asks for must be a product of surfaces of the list.  All patterns of their signs
count, except those for which a mixture of affine surfaces with these signs is nowhere positive in the cube.  Patterns
too many only add conditions, because F(x), the hull of the fields of all cells whose closure holds x, gets larger.

*V.*  V is one polynomial on each cell, and neighbouring ones agree on the hyperplane between them.  Hence V is
continuous and changes its polynomial on hyperplanes only: it bends there.

*Falls.*  Along a solution, at almost all times at which exactly the bending surfaces ``l_j, j in B`` vanish, the
velocity v has ``grad l_j . v = 0``; so V has the derivative ``grad P . v`` for any polynomial P that V is on this face,
and v is a mixture of the fields f of the cells that meet there.  If ``(grad P + sum_j mu_j grad l_j) . f < 0`` for
functions mu_j on the face and all these f, it is negative.  B runs through all sets of bending surfaces that vanish
together, with all that vanish on the same subspace; for B empty these are the conditions on closed cells.

*Inequalities.*  A polynomial is not negative where guards ``g >= 0`` hold if it is ``sum_j G_j m_j^T Q_j m_j`` with
products G_j of guards, vectors m_j of monomials and positive semidefinite Q_j.  It is positive off the origin if one
G_j is 1, this Q_j is definite, and the monomials vanish together at the origin only (Putinar 1993).

*Theorem* (Filippov 1988, Lyapunov).  V positive and falling off the point: asymptotically stable; not rising: stable.
Falling, and negative in some direction at all small distances: unstable.  Where ``V >= level`` on the border of the
cube, no solution leaves ``V < level``.  Where cells are cones and all inequalities are about forms, they hold in the
whole space.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from math import lcm, prod
from typing import Any, TypeAlias

from tests.oracles import earlier_formulas
from tests.oracles.earlier_formulas import (
    BUDGET,
    LONG,
    MALFORMED,
    MAX_DEGREE,
    NAME,
    WORD,
    RejectedError,
    add_to,
    rational,
    require,
    words_of,
)

SCHEMA = "nonsmooth-many-state-certificate/1"
KEYS = "schema states rhs at radius verdict everywhere lyapunov direction level rate surfaces empty faces proofs notes"
ASYMPTOTICALLY_STABLE, STABLE, UNSTABLE = "asymptotically stable", "stable", "unstable"

# ---- limits: no certificate keeps the checker busy for ever ------------------------------------

MIN_STATES, MAX_STATES = 3, 8
MAX_TERMS = 20_000
MAX_FIELDS, MAX_SURFACES, MAX_CELLS, MAX_EMPTY = 8, 32, 400, 2_000
MAX_FLATS, MAX_SQUARES, MAX_ROWS = 2_000, 400, 200
MAX_WORK = 4_000_000  # products of two short numbers, of some microseconds each; see Budget


Exponents: TypeAlias = tuple[int, ...]
Pattern: TypeAlias = tuple[int, ...]  # signs of surfaces


# ---- polynomials -------------------------------------------------------------------------------


class Polynomial:
    """A polynomial with rational coefficients in a number of variables."""

    __slots__ = ("count", "terms")

    def __init__(self, count: int, terms: dict[Exponents, Fraction]) -> None:
        self.count = count
        BUDGET.spend(len(terms) // 8)
        self.terms = {exponents: value for exponents, value in terms.items() if value}
        require(self.degree <= 2 * MAX_DEGREE, f"polynomials of degree at most {2 * MAX_DEGREE}")
        require(len(self.terms) <= MAX_TERMS, f"polynomials of at most {MAX_TERMS} terms")

    @property
    def degree(self) -> int:
        """The largest sum of exponents; 0 for the zero polynomial."""
        return max(map(sum, self.terms), default=0)

    @property
    def at_origin(self) -> Fraction:
        """Its value there."""
        return self.terms.get((0,) * self.count, Fraction(0))

    @property
    def is_form(self) -> bool:
        """Whether all terms have one degree."""
        return len(set(map(sum, self.terms))) <= 1

    def slope(self, k: int) -> Fraction:
        """The coefficient of a variable alone."""
        return self.terms.get(tuple(int(i == k) for i in range(self.count)), Fraction(0))

    def __bool__(self) -> bool:
        return bool(self.terms)

    def __eq__(self, other: object) -> bool:
        BUDGET.spend(len(self.terms) // 16)
        return isinstance(other, Polynomial) and self.count == other.count and self.terms == other.terms

    def __hash__(self) -> int:
        BUDGET.spend(len(self.terms) // 4)
        return hash(frozenset(self.terms.items()))

    def __add__(self, other: Polynomial) -> Polynomial:
        BUDGET.spend_on(len(other.terms), (*self.terms.values(), *other.terms.values()))
        total = dict(self.terms)
        for exponents, value in other.terms.items():
            add_to(total, exponents, value)
        return Polynomial(self.count, total)

    def __neg__(self) -> Polynomial:
        return Polynomial(self.count, {exponents: -value for exponents, value in self.terms.items()})

    def __sub__(self, other: Polynomial) -> Polynomial:
        return self + -other

    def __mul__(self, other: Polynomial) -> Polynomial:
        BUDGET.spend_on(len(self.terms) * len(other.terms), (*self.terms.values(), *other.terms.values()))
        total: dict[Exponents, Fraction] = {}
        for a, u in self.terms.items():
            for b, v in other.terms.items():
                key = tuple(map(int.__add__, a, b))
                add_to(total, key, u * v)
        return Polynomial(self.count, total)

    def derivative(self, k: int) -> Polynomial:
        """By one variable."""
        lowered = {(*e[:k], e[k] - 1, *e[k + 1 :]): c * e[k] for e, c in self.terms.items() if e[k]}
        return Polynomial(self.count, lowered)

    def on(self, coordinates: Sequence[Polynomial], count: int) -> Polynomial:
        """Itself with a polynomial in other variables for each of its own."""
        total = constant(count, 0)
        for exponents, value in self.terms.items():
            part = constant(count, value)
            for form, exponent in zip(coordinates, exponents, strict=True):
                for _ in range(exponent):
                    part *= form
            total += part
        return total

    def divided(self, divisor: Polynomial) -> Polynomial | None:
        """The quotient by a polynomial; None where a remainder is left."""
        lead = max(divisor.terms)
        quotient, rest = constant(self.count, 0), self
        while rest:
            top = max(rest.terms)
            step = tuple(map(int.__sub__, top, lead))
            if min(step) < 0:
                return None
            part = Polynomial(self.count, {step: rest.terms[top] / divisor.terms[lead]})
            quotient, rest = quotient + part, rest - part * divisor
        return quotient


def constant(count: int, value: Fraction | int) -> Polynomial:
    """A polynomial that is a number."""
    return Polynomial(count, {(0,) * count: Fraction(value)})


def variable(count: int, k: int, factor: Fraction | int = 1) -> Polynomial:
    """A multiple of a variable."""
    return Polynomial(count, {tuple(int(i == k) for i in range(count)): Fraction(factor)})


def along(potential: Polynomial, field: Sequence[Polynomial]) -> Polynomial:
    """``grad V . f``."""
    total = constant(potential.count, 0)
    for k, part in enumerate(field):
        total += potential.derivative(k) * part
    return total


# ---- formulas ----------------------------------------------------------------------------------


class Formula(earlier_formulas.Formula):
    """A formula in three states and more."""

    def constant(self, value: Fraction | int) -> Polynomial:
        """A polynomial in them."""
        return constant(next(iter(self.states.values())).count, value)


# ---- cells -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Cell:
    """Where the surfaces have given signs.

    Attributes:
        signs: of every surface.
        fields: the different ones, each with the number of its first right-hand side.
        potential: V.
    """

    signs: Pattern
    fields: tuple[tuple[int, tuple[Polynomial, ...]], ...]
    potential: Polynomial


class Surfaces:
    """The switching surfaces, in the displacement over the half-width of the cube, and their patterns of signs."""

    def __init__(self, listed: Sequence[Polynomial], empty: Any) -> None:
        self.listed = tuple(listed)
        require(len(listed) <= MAX_SURFACES and all(s.degree for s in listed), f"at most {MAX_SURFACES} surfaces")
        self._require_different()
        self.known: dict[Polynomial, tuple[int, tuple[int, ...]]] = {}
        require(type(empty) is list and len(empty) <= MAX_EMPTY, "a list of patterns that do not occur")
        self.empty = [self._shown_empty(entry) for entry in empty]

    def _require_different(self) -> None:
        """No surface is a multiple of another: neighbouring cells of affine ones then differ in one sign."""
        scaled = {Polynomial(s.count, {e: c / s.terms[max(s.terms)] for e, c in s.terms.items()}) for s in self.listed}
        require(len(scaled) == len(self.listed), "surfaces that differ")

    def _shown_empty(self, entry: Any) -> dict[int, int]:
        """Signs of affine surfaces that no point of the open cube has.

        With ``s_j l_j > 0`` a mixture ``sum_j w_j s_j l_j`` of weights w >= 0, not all zero, is positive.  Here its
        largest value on the cube, the constant and the absolute values of all slopes, is not.
        """
        require(type(entry) is list and entry, "surface, sign and weight for each part of a mixture")
        signs, total = {}, constant(self.listed[0].count, 0)
        for number, sign, weight in entry:
            require(type(number) is int and 0 <= number < len(self.listed), "numbers of surfaces")
            require(sign in ("+", "-") and number not in signs, "one sign for each surface")
            surface, own = self.listed[number], rational(weight)
            require(surface.degree == 1 and own >= 0, "affine surfaces with weights that are not negative")
            signs[number] = 1 if sign == "+" else -1
            total += surface * constant(surface.count, own * signs[number])
        require(any(rational(weight) for *_, weight in entry), "a mixture")
        most = total.at_origin + sum(abs(total.slope(k)) for k in range(total.count))
        require(most <= 0, "a mixture that is positive nowhere in the cube")
        return signs

    def patterns(self) -> Iterator[Pattern]:
        """All patterns of signs but those that were shown to be empty."""
        waiting: list[Pattern] = [()]
        found = 0
        while waiting:
            signs = waiting.pop()
            BUDGET.spend(len(self.empty) // 4)
            if any(all(j < len(signs) and signs[j] == s for j, s in bad.items()) for bad in self.empty):
                continue
            if len(signs) == len(self.listed):
                found += 1
                require(found <= MAX_CELLS, f"at most {MAX_CELLS} cells")
                yield signs
                continue
            require(len(waiting) <= MAX_CELLS, f"at most {MAX_CELLS} cells")
            waiting += [(*signs, -1), (*signs, 1)]

    def sign_on(self, signs: Pattern, value: Polynomial) -> int:
        """The sign of a switching expression on a cell: of a product of surfaces and a positive factor."""
        if value not in self.known:
            self.known[value] = self._factors(value)
        sign, numbers = self.known[value]
        for j in numbers:
            sign *= signs[j]
        return sign

    def _factors(self, value: Polynomial) -> tuple[int, tuple[int, ...]]:
        numbers: list[int] = []
        for j, surface in enumerate(self.listed):
            while value.degree and (quotient := value.divided(surface)) is not None:
                value = quotient
                numbers.append(j)
        sign = 1 if min(value.terms.values()) > 0 else -1
        even = all(c * sign > 0 and not any(k % 2 for k in e) for e, c in value.terms.items())
        require(even, "switching expressions that are products of the surfaces")  # else zero on a null set at most
        return sign, tuple(numbers)


# ---- faces -------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Face:
    """An affine subspace.

    Attributes:
        zero: numbers of the surfaces that vanish on it, none for the whole space.
        coordinates: the variables as affine forms in those that stay free.
        dimension: how many these are.
    """

    zero: tuple[int, ...]
    coordinates: tuple[Polynomial, ...]
    dimension: int

    def restricted(self, value: Polynomial) -> Polynomial:
        """A polynomial on the subspace."""
        return value.on(self.coordinates, self.dimension) if self.dimension < value.count else value

    @property
    def holds_origin(self) -> bool:
        """Whether the checked point lies in it; it is then the origin of its coordinates."""
        return not any(form.at_origin for form in self.coordinates)

    @property
    def is_outside(self) -> bool:
        """Whether it does not meet the cube because one variable is a number there, or is the checked point alone."""
        still = [form.at_origin for form in self.coordinates if not form.degree]
        return any(abs(value) > 1 for value in still) or (not self.dimension and self.holds_origin)

    def box(self) -> dict[str, Polynomial]:
        """Guards of the cube: ``1 - z_k^2``, ``1 - z_k`` and ``1 + z_k``."""
        found = {}
        one = constant(self.dimension, 1)
        for k, form in enumerate(self.coordinates):
            if form.degree:
                found.update({f"b{k}": one - form * form, f"u{k}": one - form, f"d{k}": one + form})
        return found

    def guards(self, surfaces: Sequence[Polynomial], signs: Iterable[tuple[int, int]]) -> dict[str, Polynomial] | None:
        """Those of some surfaces with signs, and of the cube; None where one is a negative number there."""
        found = self.box()
        for j, sign in signs:
            own = self.restricted(surfaces[j]) * constant(self.dimension, sign)
            if own.degree:
                found[f"s{j}"] = own
            elif own.at_origin < 0:
                return None
        return found


def whole_space(count: int) -> Face:
    """Where no surface vanishes."""
    return Face((), tuple(variable(count, k) for k in range(count)), count)


def build_face(forms: Sequence[Polynomial]) -> Face | None:
    """Where affine forms vanish together, by Gauss's elimination; None where they do nowhere."""
    count = forms[0].count
    rows = [[*(form.slope(k) for k in range(count)), form.at_origin] for form in forms]
    pivots: list[int] = []
    for column in range(count + 1):
        top = len(pivots)
        found = next((i for i in range(top, len(rows)) if rows[i][column]), None)
        if found is None:
            continue
        if column == count:
            return None
        BUDGET.spend_on(len(rows) * (count + 1), (value for row in rows for value in row), 2)
        rows[top], rows[found] = rows[found], rows[top]
        rows[top] = [value / rows[top][column] for value in rows[top]]
        for i, row in enumerate(rows):
            if i != top and row[column]:
                rows[i] = [a - row[column] * b for a, b in zip(row, rows[top], strict=True)]
        pivots.append(column)
    free = [k for k in range(count) if k not in pivots]
    size = len(free)
    coordinates = []
    for k in range(count):
        if k in free:
            coordinates.append(variable(size, free.index(k)))
            continue
        row = rows[pivots.index(k)]
        form = constant(size, -row[count])
        for i, other in enumerate(free):
            form += variable(size, i, -row[other])
        coordinates.append(form)
    return Face((), tuple(coordinates), size)


def faces_of(surfaces: Sequence[Polynomial], bending: Sequence[int]) -> list[Face]:
    """Every subspace on which bending surfaces vanish together, once, with all bending surfaces that vanish there.

    At a point of it where no other one vanishes, this is the set B of the theorem.
    """
    found: dict[tuple[int, ...], Face] = {}
    for size in range(1, min(len(bending), surfaces[0].count if surfaces else 0) + 1):
        for chosen in combinations(bending, size):
            BUDGET.spend(100)
            face = build_face([surfaces[j] for j in chosen])
            if face is None:
                continue
            zero = tuple(j for j in bending if not face.restricted(surfaces[j]))
            found.setdefault(zero, Face(zero, face.coordinates, face.dimension))
            require(len(found) <= MAX_FLATS, f"at most {MAX_FLATS} subspaces on which V bends")
    return [face for face in found.values() if not face.is_outside]


# ---- sums of squares ---------------------------------------------------------------------------


class Square:
    """``G m^T Q m``: a product of guards, monomials, and the rows of Q up to the diagonal."""

    def __init__(self, data: Any, count: int) -> None:
        require(type(data) is dict and sorted(data) == ["gram", "guards", "monomials"], "guards, monomials and gram")
        self.count, self.guards = count, data["guards"]
        require(type(self.guards) is list and len(self.guards) <= 4, "products of at most four guards")
        monomials, gram = data["monomials"], data["gram"]
        require(type(monomials) is list and len(monomials) <= MAX_ROWS, f"at most {MAX_ROWS} monomials")
        require(all(type(m) is list and len(m) == count for m in monomials), "an exponent for each variable")
        require(all(type(k) is int and 0 <= k <= MAX_DEGREE for m in monomials for k in m), "exponents")
        self.monomials = [tuple(m) for m in monomials]
        require(type(gram) is list and len(gram) == len(monomials), "a row of the matrix for each monomial")
        require(all(type(row) is list and len(row) == i + 1 for i, row in enumerate(gram)), "rows up to the diagonal")
        self.gram = [[rational(text) for text in row] for row in gram]

    def expanded(self, guards: dict[str, Polynomial]) -> Polynomial:
        """The polynomial that it is."""
        total: dict[Exponents, Fraction] = {}
        BUDGET.spend(1 + len(self.gram) ** 2)
        for i, row in enumerate(self.gram):
            for j, value in enumerate(row):
                key = tuple(map(int.__add__, self.monomials[i], self.monomials[j]))
                add_to(total, key, value if i == j else 2 * value)
        found = Polynomial(self.count, total)
        for name in self.guards:
            require(type(name) is str and name in guards, "guards that hold there")
            found *= guards[name]
        return found

    def rank(self) -> int:
        """The rank of Q.

        Raises:
            RejectedError: unless Q is positive semidefinite: by elimination without fractions (Bareiss 1968), in which
                every pivot is positive, or zero with the rest of its row.
        """
        bottom = self._common_denominator()
        rest = [[value.numerator * (bottom // value.denominator) for value in row] for row in self.gram]
        size, before, rank = len(rest), 1, 0
        for k in range(size):
            pivot = rest[k][k]
            column = [rest[i][k] for i in range(k, size)]
            require(pivot > 0 or not any(column), "positive semidefinite matrices")
            if not pivot:
                continue
            words = max(value.bit_length() for row in rest[k:] for value in row[k:]) // WORD
            BUDGET.spend((size - k) ** 2 * (1 + words * words // LONG))
            for i in range(k + 1, size):
                own = rest[i][k]
                for j in range(k + 1, i + 1):
                    rest[i][j] = (pivot * rest[i][j] - own * rest[j][k]) // before
            before = pivot
            rank += 1
        return rank

    def _common_denominator(self) -> int:
        """Of all entries of Q; it may have as many digits as all of them together, which is paid for entry by entry."""
        bottom = 1
        for row in self.gram:
            for value in row:
                words = bottom.bit_length() // WORD
                BUDGET.spend(words * (1 + words_of(value)) // LONG)
                bottom = lcm(bottom, value.denominator)
        return bottom

    def separates(self, *, at_origin: bool) -> bool:
        """Whether the monomials vanish together nowhere, or nowhere but at the origin."""
        if any(not any(m) for m in self.monomials):
            return True
        alone = {next(k for k, e in enumerate(m) if e) for m in self.monomials if sum(map(bool, m)) == 1}
        return not at_origin and len(alone) == self.count


class Proofs:
    """The evidence of a certificate; each condition uses its own once."""

    def __init__(self, data: Any) -> None:
        require(type(data) is dict and all(type(own) is list for own in data.values()), "proofs by name")
        self.left = dict(data)
        self.forms = True  # whether everything shown was about forms

    def show(
        self, name: str, value: Polynomial, guards: dict[str, Polynomial], *, strict: bool, at_origin: bool = False
    ) -> None:
        """``value >= 0`` where all guards are; strictly, ``> 0`` there off the origin, or at the origin too.

        Each square is not negative there: a product of numbers that are not, times ``m^T Q m`` with Q semidefinite.
        A square without guards and with a definite Q is positive wherever not all of its monomials vanish.
        """
        require(name in self.left, f"a proof of {name}")
        entries = self.left.pop(name)
        require(len(entries) <= MAX_SQUARES, f"at most {MAX_SQUARES} squares")
        squares = [Square(entry, value.count) for entry in entries]
        total, positive = constant(value.count, 0), False
        for square in squares:
            total += square.expanded(guards)
            definite = square.rank() == len(square.gram) and not square.guards
            positive = positive or (definite and square.separates(at_origin=at_origin))
        require(total == value, f"a sum of squares that is the polynomial of {name}")
        require(positive or not strict, f"a positive square in the proof of {name}")
        self.forms = self.forms and value.is_form

    def require_used(self) -> None:
        """Nothing is left over."""
        require(not self.left, "proofs of conditions alone")


# ---- the certificate ---------------------------------------------------------------------------


def pattern(signs: Iterable[int | None]) -> str:
    """Signs as text: - + and 0 where a surface vanishes, a dot where its sign does not matter."""
    return "".join("." if sign is None else "-0+"[sign + 1] for sign in signs)


class Certificate:
    """One certificate: reading it builds the cells; :meth:`check` shows the claims."""

    def __init__(self, data: Any) -> None:
        require(type(data) is dict and sorted(data) == sorted(KEYS.split()), f"an object with the keys {KEYS}")
        require(data["schema"] == SCHEMA, f"the schema {SCHEMA}")
        BUDGET.left = MAX_WORK
        self.states = data["states"]
        require(type(self.states) is list and MIN_STATES <= len(self.states) <= MAX_STATES, "three to eight states")
        require(all(type(name) is str and NAME.fullmatch(name) for name in self.states), "states with names")
        self.count = len(self.states)
        require(len(set(self.states)) == self.count, "states with different names")
        require(type(data["at"]) is list and len(data["at"]) == self.count, "a number for each state of the point")
        self.at, self.radius = [rational(text) for text in data["at"]], rational(data["radius"])
        require(self.radius > 0, "a cube of positive size")
        self.verdict, self.everywhere = data["verdict"], data["everywhere"]
        require(self.verdict in (ASYMPTOTICALLY_STABLE, STABLE, UNSTABLE), "a verdict")
        require(type(self.everywhere) is bool, "everywhere as true or false")
        self.level, self.rate, self.faces = data["level"], data["rate"], data["faces"]
        require(type(self.faces) is dict, "faces by name")
        self.direction = data["direction"]
        self.lyapunov = data["lyapunov"]
        self.proofs = Proofs(data["proofs"])
        self.cells = self._build(data["rhs"], data["surfaces"], data["empty"])
        self.bending = self._bending_surfaces()

    def _build(self, rhs: Any, surfaces: Any, empty: Any) -> list[Cell]:
        """All cells that are not shown to be empty, with the polynomials of fields and V there."""
        count = self.count
        small = {name: variable(count, k, self.radius) for k, name in enumerate(self.states)}
        moved = {name: own + constant(count, at) for (name, own), at in zip(small.items(), self.at, strict=True)}
        require(type(surfaces) is list, "a list of surfaces")
        self.surfaces = Surfaces([Formula(text, small).on(refused_sign) for text in surfaces], empty)
        require(type(rhs) is list and 0 < len(rhs) <= MAX_FIELDS, f"one to {MAX_FIELDS} right-hand sides")
        require(all(type(side) is list and len(side) == count for side in rhs), "a formula for each state")
        fields = [[Formula(text, moved) for text in side] for side in rhs]
        potential = Formula("0" if self.lyapunov is None else self.lyapunov, small)
        found = []
        for signs in self.surfaces.patterns():

            def sign_of(value: Polynomial, signs: Pattern = signs) -> int:
                return self.surfaces.sign_on(signs, value)

            own = [tuple(formula.on(sign_of) for formula in field) for field in fields]
            different = tuple((k, field) for k, field in enumerate(own) if field not in own[:k])
            found.append(Cell(signs, different, potential.on(sign_of)))
        return found

    def _bending_surfaces(self) -> tuple[int, ...]:
        """The surfaces across which V changes its polynomial; V is shown to be continuous.

        Neighbouring cells of hyperplanes differ in one sign, and any two cells at a point are joined by neighbours that
        hold the point in their closures; so V is continuous if neighbours agree on the hyperplane between them.
        """
        by_signs = {cell.signs: cell for cell in self.cells}
        found = set()
        for cell in self.cells:
            for j, sign in enumerate(cell.signs):
                other = by_signs.get((*cell.signs[:j], -sign, *cell.signs[j + 1 :]))
                if sign < 0 or other is None or other.potential == cell.potential:
                    continue
                require(self.surfaces.listed[j].degree == 1, "a V that bends on hyperplanes alone")
                face = build_face([self.surfaces.listed[j]])
                gap = cell.potential - other.potential
                require(face is not None and not face.restricted(gap), "a V that is continuous")
                found.add(j)
        bending = tuple(sorted(found))
        pieces: dict[Pattern, Polynomial] = {}
        for cell in self.cells:
            own = pieces.setdefault(tuple(cell.signs[j] for j in bending), cell.potential)
            require(own == cell.potential, "a V that bends on its surfaces alone")
        return bending

    # -- claims

    def check(self) -> None:
        """Show every claim."""
        require(self.verdict == UNSTABLE or self.direction is None, "a direction for instability alone")
        if self.lyapunov is None:
            self._show_no_equilibrium()
        else:
            self._show_function()
        self.proofs.require_used()

    def _show_function(self) -> None:
        """The conditions on V, and what else is claimed of it."""
        strict = self.verdict != STABLE
        require(all(not cell.potential.at_origin for cell in self._around()), "a V that is zero at the point")
        if self.verdict == UNSTABLE:
            self._show_negative()
        else:
            self._show_positive()
        self._show_falls("", lambda cell: constant(self.count, 0), strict=strict, at_origin=False)
        if self.everywhere:
            self._show_everywhere()
        if self.level is not None:
            self._show_region(rational(self.level))
        if self.rate is not None:
            self._show_rate()

    def _around(self) -> list[Cell]:
        """The cells whose closures may hold the point."""
        at = [surface.at_origin for surface in self.surfaces.listed]
        return [cell for cell in self.cells if all(s * v >= 0 for s, v in zip(cell.signs, at, strict=True))]

    def _along_direction(self, value: Polynomial) -> int:
        """The sign of a polynomial at all small distances from the point in the direction."""
        by_degree: dict[int, Fraction] = {}
        direction = self._direction()
        BUDGET.spend_on(value.count * len(value.terms), (*direction, *value.terms.values()), 1 + value.degree)
        for exponents, coefficient in value.terms.items():
            own = coefficient * prod(x**exponent for x, exponent in zip(direction, exponents, strict=True))
            add_to(by_degree, sum(exponents), own)
        first = next((by_degree[degree] for degree in sorted(by_degree) if by_degree[degree]), Fraction(0))
        return (first > 0) - (first < 0)

    def _direction(self) -> list[Fraction]:
        require(type(self.direction) is list and len(self.direction) == self.count, "a direction")
        return [rational(text) for text in self.direction]

    def _show_no_equilibrium(self) -> None:
        """0 is not in F at the point: all velocities there have a positive product with one direction.

        F is upper semicontinuous, so near the point all products stay above a positive number: every solution leaves.
        """
        require(self.verdict == UNSTABLE and not self.everywhere, "an unstable point without a V")
        require(self.level is None and self.rate is None and not self.faces, "nothing but a direction")
        direction = self._direction()
        for cell in self._around():
            for _, field in cell.fields:
                product = sum((n * part.at_origin for n, part in zip(direction, field, strict=True)), Fraction(0))
                require(product > 0, "a direction in which all velocities at the point lead")

    def _show_negative(self) -> None:
        """V is negative at all small distances in one direction, inside a cell.

        From there V falls, so the solution stays away from the point, where V is zero; away from it V falls at a speed
        that is bounded from below, and is bounded on the cube: the solution leaves it.
        """
        require(not self.everywhere and self.level is None and self.rate is None, "no region of an unstable point")
        for cell in self.cells:
            surfaces = zip(cell.signs, self.surfaces.listed, strict=True)
            inside = all(sign * self._along_direction(surface) > 0 for sign, surface in surfaces)
            if inside and self._along_direction(cell.potential) < 0:
                return
        raise RejectedError("a V that is negative in the direction")

    def _pieces(self) -> Iterator[tuple[str, tuple[tuple[int, int], ...], Polynomial]]:
        """V on each of its own cells: name, signs of the bending surfaces, polynomial."""
        seen = set()
        for cell in self.cells:
            name = pattern(s if j in self.bending else None for j, s in enumerate(cell.signs))
            if name not in seen:
                seen.add(name)
                yield name, tuple((j, cell.signs[j]) for j in self.bending), cell.potential

    def _show_positive(self) -> None:
        """V > 0 off the point."""
        space = whole_space(self.count)
        for name, signs, potential in self._pieces():
            guards = space.guards(self.surfaces.listed, signs)
            self.proofs.show(f"V {name}", potential, guards or {}, strict=True)

    def _show_falls(self, prefix: str, shift: Callable[[Cell], Polynomial], *, strict: bool, at_origin: bool) -> None:
        """V' plus a shift is negative on closed cells, and on all faces on which V bends.

        Args:
            prefix: of the names of proofs.
            shift: a function of the place, continuous as V is.
            strict: whether "not positive" is too little.
            at_origin: whether the point itself counts.
        """
        space = whole_space(self.count)
        for cell in self.cells:
            guards = space.guards(self.surfaces.listed, enumerate(cell.signs)) or {}
            for number, field in cell.fields:
                name = f"{prefix}cell {pattern(cell.signs)} field {number}"
                value = -(along(cell.potential, field) + shift(cell))
                self.proofs.show(name, value, guards, strict=strict, at_origin=at_origin)
        for face in faces_of(self.surfaces.listed, self.bending):
            BUDGET.spend(len(self.cells) * (1 + len(self.surfaces.listed)) // 8)
            groups: dict[str, list[Cell]] = {}
            for cell in self.cells:
                name = pattern(self._face_sign(face, j, s) for j, s in enumerate(cell.signs))
                groups.setdefault(name, []).append(cell)
            for name, cells in groups.items():
                if not self._is_settled(face, cells):
                    own = at_origin or not face.holds_origin
                    self._falls_on(face, f"{prefix}face {name}", cells, shift, strict=strict, at_origin=own)

    def _face_sign(self, face: Face, j: int, sign: int) -> int | None:
        if j in face.zero:
            return 0
        return sign if j in self.bending else None

    def _is_settled(self, face: Face, cells: Sequence[Cell]) -> bool:
        """Whether the conditions on closed cells suffice on a face.

        They do where V is one polynomial around it.  They do too where the fields on the face are all those of cells
        on one side of all its surfaces: v is a mixture of these, and V is one polynomial on that side.
        """
        if all(cell.potential == cells[0].potential for cell in cells):
            return True
        by_side: dict[Pattern, dict[Pattern, object]] = {}
        for cell in cells:
            side = tuple(cell.signs[j] for j in face.zero)
            rest = tuple(s for j, s in enumerate(cell.signs) if j not in face.zero)
            by_side.setdefault(side, {})[rest] = {tuple(map(face.restricted, field)) for _, field in cell.fields}
        whole = max(by_side.values(), key=len)
        return all(whole.get(rest) == fields for own in by_side.values() for rest, fields in own.items())

    def _falls_on(
        self,
        face: Face,
        name: str,
        cells: Sequence[Cell],
        shift: Callable[[Cell], Polynomial],
        *,
        strict: bool,
        at_origin: bool,
    ) -> None:
        """``(grad P + sum_j mu_j grad l_j) . f`` plus the shift is negative on a face, for each field f beside it.

        P and mu are named by the certificate.  P may be any polynomial of V beside the face: all agree on it, as is
        shown here, so they have one derivative along velocities that stay in it.
        """
        own = self.faces.get(name.removeprefix("rate ").removeprefix("face "))
        require(own is not None, f"multipliers for {name}")
        require(type(own) is dict and sorted(own) == ["cell", "mu"], "a cell and multipliers for each face")
        chosen = [cell for cell in cells if pattern(cell.signs) == own["cell"]]
        require(len(chosen) == 1, "a cell beside the face")
        gaps = (cell.potential - chosen[0].potential for cell in cells)
        require(not any(map(face.restricted, gaps)), "a V that is continuous")
        mu = self._multipliers(face, own["mu"])
        for cell in cells:
            others = [(j, s) for j, s in enumerate(cell.signs) if j not in face.zero]
            guards = face.guards(self.surfaces.listed, others)
            if guards is None:
                continue
            for number, field in cell.fields:
                value = face.restricted(along(chosen[0].potential, field) + shift(chosen[0]))
                for j, factor in mu.items():
                    value += factor * face.restricted(along(self.surfaces.listed[j], field))
                full = f"{name} cell {pattern(cell.signs)} field {number}"
                self.proofs.show(full, -value, guards, strict=strict, at_origin=at_origin)

    def _multipliers(self, face: Face, data: Any) -> dict[int, Polynomial]:
        """Functions mu on a face: coefficients and exponents of each, by the number of its surface."""
        require(type(data) is dict, "multipliers by surface")
        found = {}
        for j in face.zero:
            terms: dict[Exponents, Fraction] = {}
            for value, exponents in data.get(str(j), []):
                require(type(exponents) is list and len(exponents) == face.dimension, "exponents of multipliers")
                require(all(type(k) is int and 0 <= k <= MAX_DEGREE for k in exponents), "exponents of multipliers")
                add_to(terms, tuple(exponents), rational(value))
            found[j] = Polynomial(face.dimension, terms)
        require(set(data) <= {str(j) for j in face.zero}, "multipliers of surfaces that vanish on the face")
        return found

    def _show_everywhere(self) -> None:
        """The inequalities hold in the whole space: cells are cones and all of them are about forms.

        V is a form that is positive off the point, so its level sets are bounded and every solution goes on for ever.
        """
        cones = all(s.degree == 1 and s.is_form for s in self.surfaces.listed)
        require(cones and self.proofs.forms and self.level is None, "cones and forms, for the whole space")

    def _show_region(self, level: Fraction) -> None:
        """V is at least the level on the border of the cube: no solution leaves ``V < level`` in it."""
        require(self.verdict == ASYMPTOTICALLY_STABLE and level > 0, "a positive level around a point that attracts")
        count = self.count
        for name, signs, potential in self._pieces():
            for k in range(count):
                for side in (1, -1):
                    face = build_face([variable(count, k) - constant(count, side)])
                    guards = None if face is None else face.guards(self.surfaces.listed, signs)
                    if face is None or guards is None:
                        continue
                    above = face.restricted(potential) - constant(face.dimension, level)
                    self.proofs.show(f"border {name} {'-0+'[side + 1]}{k}", above, guards, strict=False)

    def _show_rate(self) -> None:
        """``V' <= -kappa V`` or ``V' <= -kappa`` on the cube; V' is ``grad V . f`` over the half-width here."""
        require(type(self.rate) is dict and sorted(self.rate) == ["kappa", "kind"], "a rate with kind and kappa")
        require(self.verdict == ASYMPTOTICALLY_STABLE, "a rate of a point that attracts")
        kappa, kind = rational(self.rate["kappa"]), self.rate["kind"]
        require(kappa > 0 and kind in ("finite", "exponential"), "a positive rate, finite or exponential")
        whole = constant(self.count, kappa * self.radius)
        finite = kind == "finite"
        self._show_falls(
            "rate ", lambda cell: whole if finite else whole * cell.potential, strict=False, at_origin=False
        )


def refused_sign(value: Polynomial) -> int:
    """Surfaces are polynomials: no formula of one may ask for a sign."""
    raise RejectedError("surfaces without switching")


def check_certificate(data: Any) -> str:
    """The claim of a certificate (parsed JSON) that is not shown; empty where all are."""
    try:
        Certificate(data).check()
    except MALFORMED as error:
        return str(error) if isinstance(error, RejectedError) else f"well-formed data, not a {type(error).__name__}"
    return ""
