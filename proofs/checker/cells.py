"""A switched system as a differential inclusion with cells: switching surfaces, patterns of their signs, fields, faces.

F(x) is the convex hull of the fields of all cells whose closure holds x.  Every switching expression of a formula must
be a product of listed surfaces.  All patterns of signs count, except those that are shown to have no point inside the
domain; patterns too many only add conditions, because F gets larger.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from itertools import combinations, product
from typing import Any, TypeAlias

from .formulas import MAX_WAVES, NAME, Formula, SignOf, WaveAt, parsed, series, waves_in
from .polynomials import Coefficient, Polynomial, are_coprime, constant, lie_derivative, solve, variable
from .positivity import Claim, Inequality, Proofs, cube_guards, identity
from .tower import Field, Number
from .work import BUDGET, RejectedError, items, rational, require, take, text, whole

MIN_STATES, MAX_STATES = 1, 8
MAX_FIELDS, MAX_SURFACES, MAX_CELLS, MAX_EMPTY = 64, 64, 1_000, 2_000
MAX_FACES = 2_000
MAX_ORDER = 4  # of sines and cosines

Pattern: TypeAlias = tuple[int, ...]  # a sign, -1 or 1, of every surface
SurfaceSigns: TypeAlias = Mapping[int, int]  # of some surfaces
Matrix: TypeAlias = list[list[Fraction]]
Maps: TypeAlias = tuple[list[Polynomial], list[Polynomial]]  # from coordinates to states, and back


@dataclass(frozen=True)
class System:
    """What is judged: ``x' in F(x)`` near a point.

    Attributes:
        states: their names.
        rhs: right-hand sides, each a formula for every state; with several of them all act (arbitrary switching).
        at: the point.
        numbers: the irrational numbers that formulas name.
        order: how many further terms of sines and cosines are taken (:func:`.formulas.series`).
    """

    states: tuple[str, ...]
    rhs: tuple[tuple[str, ...], ...]
    at: tuple[Coefficient, ...]
    numbers: Mapping[str, Number] = field(default_factory=dict)
    order: int = 0

    @property
    def count(self) -> int:
        """The number of states."""
        return len(self.states)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The names in V and in surfaces: the states, or what stands for them (:mod:`.roots`)."""
        return self.states

    @property
    def origin(self) -> tuple[Coefficient, ...]:
        """The point in the coordinates."""
        return self.at

    @property
    def orders(self) -> tuple[int, ...]:
        """Of the root that stands for each state; 1 where the state is a coordinate itself."""
        return (1,) * self.count

    @property
    def stated(self) -> System:
        """The system with the velocities of its states."""
        return self

    @property
    def in_time_of_states(self) -> bool:
        """Whether coordinates are roots of states, and velocities those of the states."""
        return False

    @property
    def waves(self) -> list[tuple[int, ...]]:
        """The number of sines and cosines in the formulas of each right-hand side."""
        return [tuple(len(waves_in(parsed(formula))) for formula in side) for side in self.rhs]

    def fields(self, place: Mapping[str, Polynomial], wave: WaveAt | None = None) -> Sequence[Sequence[Formula]]:
        """The formulas of the velocities at a place, for each right-hand side.

        A side with sines and cosines has fields for all ends of what these may be: velocities are in their hull.
        """
        wave, fields = wave or partial(series, order=self.order), []
        for side, counts in zip(self.rhs, self.waves, strict=True):
            require(sum(counts) <= MAX_WAVES, f"right-hand sides with at most {MAX_WAVES} sines and cosines")
            for ends in product((0, 1), repeat=sum(counts)):
                rest = iter(ends)
                by_state = [[next(rest) for _ in range(count)] for count in counts]
                listed = zip(self.states, side, by_state, strict=True)
                fields.append([self.formula(state, text, place, e, wave) for state, text, e in listed])
        return fields

    def formula(
        self, state: str, data: str, place: Mapping[str, Polynomial], ends: Sequence[int], wave: WaveAt
    ) -> Formula:
        """The formula of the velocity of a state at a place, with sines and cosines at ends of what they may be."""
        return Formula(data, place, ends, wave)

    def show_equivalent(self, inclusion: Inclusion) -> None:
        """Solutions in the coordinates are those of the states: nothing needs to be shown."""

    def along(self, field: Sequence[Polynomial], function: Polynomial, domain: Domain, sign_of: SignOf) -> Polynomial:
        """The derivative of a function along a field on a cell, in units of the half-width."""
        return lie_derivative(function, field)

    def across(self, field: Sequence[Polynomial], surface: Polynomial, domain: Domain) -> Polynomial:
        """The derivative of a surface along a field where it vanishes, times a number other than zero."""
        return lie_derivative(surface, field)

    def bends_at(self, surface: Polynomial, domain: Domain) -> bool:
        """Whether a function may bend on a surface though it is one polynomial around it."""
        return False


def read_system(data: Any) -> System:
    """The system that a certificate is about.

    Raises:
        RejectedError: for anything else.
    """
    names, sides, at, listed, order = take(data, "states rhs at", "numbers order")
    states = tuple(text(name) for name in items(names))
    require(MIN_STATES <= len(states) <= MAX_STATES, f"{MIN_STATES} to {MAX_STATES} states")
    require(len(set(states)) == len(states) and all(map(NAME.fullmatch, states)), "states with different names")
    rhs = tuple(tuple(text(f) for f in items(side, len(states))) for side in items(sides, most=MAX_FIELDS))
    require(rhs, "a right-hand side")
    tower, numbers = read_numbers([] if listed is None else listed)
    require(not set(numbers) & set(states), "names of numbers that are no states")
    place = tuple(tower.coefficient(value) for value in items(at, len(states)))
    return System(states, rhs, place, numbers, 0 if order is None else whole(order, MAX_ORDER))


def read_numbers(data: Any) -> tuple[Field, dict[str, Number]]:
    """The irrational numbers of a subject by their names: each is the only root above a bound of a polynomial.

    They are part of what is stated, so nothing is claimed of them but that there is one such root.
    """
    names, generators = [], []
    for entry in items(data):
        name, polynomial, above = take(entry, "name polynomial above")
        names.append(text(name))
        generators.append({"polynomial": polynomial, "above": above})
    require(len(set(names)) == len(names) and all(map(NAME.fullmatch, names)), "numbers with different names")
    tower = Field(generators)
    return tower, {name: tower.generator(k) for k, name in enumerate(names)}


def pattern(signs: Iterable[int | None]) -> str:
    """Signs as a text: - and +, 0 where a surface vanishes, a dot where its sign does not matter."""
    return "".join("." if sign is None else "-0+"[sign + 1] for sign in signs)


def read_signs(data: Any, size: int) -> dict[int, int]:
    """The signs of some surfaces from such a text."""
    marks = text(data)
    require(len(marks) == size and set(marks) <= {"-", "+", "."}, "a sign or a dot for each surface")
    return {j: -1 if mark == "-" else 1 for j, mark in enumerate(marks) if mark != "."}


class Domain:
    """The cube ``|z_k| <= radius`` about the point, in units of the radius; or the whole space.

    Of roots in the time of the states it may be a box ``|z_k| <= width_k``, in units of the widths.

    The coordinates z may be others than the states: x is ``T(z)`` from the point, and ``z' = DL(T(z)) f``, with
    polynomial maps of which ``L(T(z)) = z`` and ``T(0) = 0``.  So T maps neighbourhoods of 0 one to one onto those of
    the point.
    """

    def __init__(self, system: System, within: Any, maps: Maps | None = None) -> None:
        self.system, self.bounded, count = system, within is not None, system.count
        is_box = type(within) is list
        require(not is_box or system.in_time_of_states, "a cube, or a box of roots in the time of the states")
        self.radius = Fraction(1) if is_box or not self.bounded else rational(within)
        self.widths = [rational(width) for width in items(within, count)] if is_box else [self.radius] * count
        require(min(self.widths) > 0, "a cube of positive size")
        numbers = {name: constant(count, number) for name, number in system.numbers.items()}
        away = [variable(count, k, width) for k, width in enumerate(self.widths)]
        self.gradients: list[list[Polynomial]] | None = None  # of the parts of L, at T(z)
        if maps is not None:
            to_states, back = maps
            away = [polynomial.on(away, count) for polynomial in to_states]
            self.gradients = [[polynomial.derivative(k).on(away, count) for k in range(count)] for polynomial in back]
        at = [coordinate + constant(count, value) for coordinate, value in zip(away, system.origin, strict=True)]
        self.displacement = {**dict(zip(system.coordinates, away, strict=True)), **numbers}
        self.place = {**dict(zip(system.coordinates, at, strict=True)), **numbers}

    def velocity(self, field: Sequence[Polynomial]) -> tuple[Polynomial, ...]:
        """The velocity of the coordinates, by that of the states."""
        if self.gradients is None:
            return tuple(field)
        nothing = constant(self.system.count, 0)
        return tuple(sum((a * b for a, b in zip(gradient, field, strict=True)), nothing) for gradient in self.gradients)

    def guards(self) -> dict[str, Polynomial]:
        """The guards of the cube; none of the space."""
        count = self.system.count
        return cube_guards(identity(count), count) if self.bounded else {}


def read_maps(frame: Any, coordinates: Any, system: System) -> Maps | None:
    """T and L, as two matrices or two lists of formulas in the names of the states; None where z are the states."""
    if frame is None and coordinates is None:
        return None
    require(system.coordinates == system.states, "a frame without roots of states")
    require(frame is None or coordinates is None, "a frame, or other coordinates")
    count, units = system.count, list(identity(system.count))
    if coordinates is None:
        undone = "a frame of two matrices whose product is one"
        listed = [items(matrix, count) for matrix in items(frame, 2)]
        rows = [[[rational(value) for value in items(row, count)] for row in matrix] for matrix in listed]
        to_states, back = (applied(matrix, units) for matrix in rows)
    else:
        undone = "two maps of which one undoes the other"
        names = dict(zip(system.states, units, strict=True))
        texts = [items(formulas, count) for formulas in items(coordinates, 2)]
        to_states, back = ([Formula(text, names).on(no_switching) for text in formulas] for formulas in texts)
    require(not any(polynomial.at_origin for polynomial in to_states), "coordinates that are zero at the point")
    require([polynomial.on(to_states, count) for polynomial in back] == units, undone)
    return to_states, back


def applied(matrix: Matrix, vector: Sequence[Polynomial]) -> list[Polynomial]:
    """A matrix times a vector of polynomials."""
    return [sum((p.times(c) for p, c in zip(vector, row, strict=True)), constant(vector[0].count, 0)) for row in matrix]


def require_formulas(system: System) -> None:
    """Every right-hand side is made of formulas, for theorems that need only some of them.

    Raises:
        RejectedError: for one that is none.
    """
    for velocity in system.fields(Domain(system, None).place):
        for formula in velocity:
            formula.on(lambda _: 1)  # any signs: they are read on no cell


def no_switching(value: Polynomial) -> int:
    """Surfaces are polynomials: no formula of one may ask for a sign."""
    raise RejectedError("surfaces without switching")


class Surfaces:
    """The switching surfaces, as polynomials on the domain, and the patterns of their signs."""

    def __init__(self, domain: Domain, listed: Any, empty: Any, proofs: Proofs) -> None:
        self.domain, self.proofs = domain, proofs
        texts = items(listed, most=MAX_SURFACES)
        self.listed = tuple(Formula(formula, domain.displacement).on(no_switching) for formula in texts)
        require(all(surface.degree for surface in self.listed), "surfaces that are not constant")
        self._require_coprime()
        self._factors: dict[Polynomial, tuple[int, tuple[int, ...]]] = {}
        self.empty = [self._show_empty(entry) for entry in items(empty, most=MAX_EMPTY)]

    def _require_coprime(self) -> None:
        """No two surfaces have a common factor.

        Two of them then vanish together on a set of codimension two at least, which no path need meet: any two cells
        that have a point in common are joined, arbitrarily near it, by steps that change one sign each.
        """
        coprime = all(are_coprime(a, b) for a, b in combinations(self.listed, 2))
        require(coprime, "surfaces of which no two have a common factor")

    def _show_empty(self, mark: Any) -> dict[int, int]:
        """Signs that no inner point of the domain has: one signed surface is not positive where the others are."""
        signs = read_signs(mark, len(self.listed))
        last = max(signs)
        others = {f"s{j}": self.signed(j, s) for j, s in signs.items() if j != last}
        guards = {**others, **self.domain.guards()}
        inequality = Inequality(-self.signed(last, signs[last]), guards, open=frozenset(guards))
        self.proofs.show(Claim(f"empty {mark}", (inequality,), strict=False, bounded=self.domain.bounded))
        return signs

    def signed(self, j: int, sign: int) -> Polynomial:
        """A surface with a sign."""
        return self.listed[j] if sign > 0 else -self.listed[j]

    def patterns(self) -> Iterator[Pattern]:
        """All patterns of signs but those that are shown to be empty."""
        waiting: list[Pattern] = [()]
        count = 0
        while waiting:
            signs = waiting.pop()
            BUDGET.spend(1 + len(self.empty))
            if any(all(j < len(signs) and signs[j] == s for j, s in bad.items()) for bad in self.empty):
                continue
            if len(signs) < len(self.listed):
                waiting += [(*signs, -1), (*signs, 1)]
                continue
            count += 1
            require(count <= MAX_CELLS, f"at most {MAX_CELLS} cells")
            yield signs

    def sign_on(self, signs: Pattern, value: Polynomial) -> int:
        """The sign of a switching expression on a cell: of a product of surfaces and a factor that is positive there.

        Raises:
            RejectedError: for an expression that is no such product.
        """
        if value not in self._factors:
            self._factors[value] = self._factored(value)
        sign, numbers = self._factors[value]
        for j in numbers:
            sign *= signs[j]
        return sign

    def _factored(self, value: Polynomial) -> tuple[int, tuple[int, ...]]:
        numbers: list[int] = []
        for j, surface in enumerate(self.listed):
            while value.degree and (quotient := value.divided(surface)) is not None:
                value = quotient
                numbers.append(j)
        # What is left must have one sign, but on a set of measure zero: all its terms are even, with one sign.
        sign = 1 if min(value.terms.values()) > 0 else -1
        even = all(c * sign > 0 and not any(k % 2 for k in e) for e, c in value.terms.items())
        require(even, "switching expressions that are products of the surfaces")
        return sign, tuple(numbers)


@dataclass(frozen=True)
class Cell:
    """Where all surfaces have given signs.

    Attributes:
        signs: of every surface.
        fields: the different ones, each with the number of the first right-hand side that has it.
        functions: V there, and W where a theorem has one.
    """

    signs: Pattern
    fields: tuple[tuple[int, tuple[Polynomial, ...]], ...]
    functions: tuple[Polynomial, ...]


class Function:
    """V or W: one formula in the displacement, or one for each pattern of signs of some surfaces."""

    def __init__(self, domain: Domain, surfaces: Surfaces, data: Any) -> None:
        self.surfaces = surfaces
        pieces = [["." * len(surfaces.listed), data]] if type(data) is str else items(data)
        self.pieces = []
        for piece in pieces:
            mark, formula = items(piece, 2)
            self.pieces.append((read_signs(mark, len(surfaces.listed)), Formula(formula, domain.displacement)))

    def on(self, signs: Pattern) -> Polynomial:
        """The polynomial on a cell; all pieces that apply must agree."""
        BUDGET.spend(len(self.pieces))
        polynomials = {
            formula.on(lambda value: self.surfaces.sign_on(signs, value))
            for surface_signs, formula in self.pieces
            if all(signs[j] == s for j, s in surface_signs.items())
        }
        require(len(polynomials) == 1, "one formula of a function on every cell")
        return polynomials.pop()


class Inclusion:
    """The cells of a system on a domain, with the functions of a theorem.

    A frame is accepted of theorems that speak of solutions near the point alone.
    """

    def __init__(
        self, system: System, data: Any, functions: Sequence[Any], proofs: Proofs, *, framed: bool = False
    ) -> None:
        within, surfaces, empty, frame, coordinates = take(data, "within surfaces empty", "frame coordinates")
        maps = read_maps(frame, coordinates, system)
        require(maps is None or framed, "a frame where a V alone shows a verdict")
        self.domain, self.proofs = Domain(system, within, maps), proofs
        self.count, self.surfaces = system.count, Surfaces(self.domain, surfaces, empty, proofs)
        fields = system.fields(self.domain.place)
        piecewise = [Function(self.domain, self.surfaces, function) for function in functions]
        self.cells = [self._cell(signs, fields, piecewise) for signs in self.surfaces.patterns()]
        self.bending = self._bending_surfaces()
        self.parted = self._parted_pieces()
        system.show_equivalent(self)

    def _cell(self, signs: Pattern, fields: Sequence[Sequence[Formula]], functions: Sequence[Function]) -> Cell:
        def sign_of(value: Polynomial) -> int:
            return self.surfaces.sign_on(signs, value)

        velocities = [self.domain.velocity([formula.on(sign_of) for formula in field]) for field in fields]
        different = tuple((k, field) for k, field in enumerate(velocities) if field not in velocities[:k])
        return Cell(signs, different, tuple(function.on(signs) for function in functions))

    def _bending_surfaces(self) -> tuple[int, ...]:
        """The surfaces across which a function changes its polynomial."""
        by_signs = {cell.signs: cell for cell in self.cells}
        system, domain = self.domain.system, self.domain
        bending = {j for j, surface in enumerate(self.surfaces.listed) if system.bends_at(surface, domain)}
        for cell in self.cells:
            for j in range(len(cell.signs)):
                other = by_signs.get(flipped(cell.signs, j))
                if cell.signs[j] > 0 and other is not None and other.functions != cell.functions:
                    bending.add(j)
        return tuple(sorted(bending))

    def _parted_pieces(self) -> set[frozenset[Pattern]]:
        """Pairs of pieces that differ in one sign, and have no common point; the functions are shown to be continuous.

        The polynomials of all other such pairs differ by a multiple of that surface.  Cells that have a point in common
        are joined by such steps among cells that hold it, on surfaces that vanish there.
        """
        pieces: dict[Pattern, tuple[Polynomial, ...]] = {}
        for cell in self.cells:
            functions = pieces.setdefault(self.signs_of_piece(cell), cell.functions)
            require(functions == cell.functions, "functions that bend on their surfaces alone")
        parted = set()
        for signs, functions in pieces.items():
            for i, j in enumerate(self.bending):
                beside = pieces.get(flipped(signs, i))
                if signs[i] < 0 or beside is None:
                    continue
                gaps = [a - b for a, b in zip(functions, beside, strict=True)]
                if any(gap.divided(self.surfaces.listed[j]) is None for gap in gaps):
                    require(self._are_parted(signs, j), "functions that are continuous")
                    parted.add(frozenset((signs, flipped(signs, i))))
        return parted

    def signs_of_piece(self, cell: Cell) -> Pattern:
        """The signs of the bending surfaces on a cell."""
        return tuple(cell.signs[j] for j in self.bending)

    def _are_parted(self, signs: Pattern, j: int) -> bool:
        """Whether it is shown that pieces on the two sides of a surface have no common point but the checked one.

        The evidence is of ``-1 > 0`` off the point, where the surface vanishes and the others have the signs.
        """
        face = build_face(self, (j,))
        beside = {k: s for k, s in zip(self.bending, signs, strict=True) if k != j}
        guards = None if face is None else face.guards(beside)
        if face is None or guards is None or face.is_outside:
            return True
        name = pattern(0 if k == j else beside.get(k) for k in range(len(self.surfaces.listed)))
        empty = Inequality(constant(face.dimension, -1), guards, zeros=face.zeros())
        away = not face.holds_origin
        bounded = self.domain.bounded
        return self.proofs.shows(Claim(f"parted {name}", (empty,), strict=True, at_origin=away, bounded=bounded))

    def along(self, field: Sequence[Polynomial], function: Polynomial, cell: Cell) -> Polynomial:
        """The derivative of a function along a field, as on a cell."""
        sign_of = partial(self.surfaces.sign_on, cell.signs)
        return self.domain.system.along(field, function, self.domain, sign_of)

    def across(self, field: Sequence[Polynomial], j: int) -> Polynomial:
        """The derivative of the j-th surface along a field where it vanishes, times a number other than zero."""
        return self.domain.system.across(field, self.surfaces.listed[j], self.domain)

    def around(self) -> list[Cell]:
        """The cells whose closures may hold the point."""
        at = [surface.at_origin for surface in self.surfaces.listed]
        return [cell for cell in self.cells if all(s * v >= 0 for s, v in zip(cell.signs, at, strict=True))]

    def pieces(self) -> Iterator[tuple[str, SurfaceSigns, Cell]]:
        """A cell of each pattern of signs of the bending surfaces: its name, these signs, itself."""
        names = set()
        for cell in self.cells:
            BUDGET.spend(1 + len(cell.signs) // 4)
            name = pattern(s if j in self.bending else None for j, s in enumerate(cell.signs))
            if name not in names:
                names.add(name)
                yield name, {j: cell.signs[j] for j in self.bending}, cell

    def faces(self) -> list[Face]:
        """Every set of bending surfaces that may vanish together off the point, with all that vanish there with them.

        Of affine surfaces no more than there are variables need be chosen: they fix which others vanish with them.  Of
        curved ones any number may meet in a point.
        """
        curved = [j for j in self.bending if self.surfaces.listed[j].degree > 1]
        flat = [j for j in self.bending if j not in curved]
        faces: dict[tuple[int, ...], Face] = {}
        for size in range(1, len(curved) + min(len(flat), self.count) + 1):
            for chosen in combinations(self.bending, size):
                BUDGET.spend(100)
                if len(set(chosen).intersection(flat)) > self.count:
                    continue
                face = build_face(self, chosen)
                if face is not None:
                    faces.setdefault(face.zero, face)
                require(len(faces) <= MAX_FACES, f"at most {MAX_FACES} faces on which V bends")
        return [face for face in faces.values() if not face.is_outside]


def flipped(signs: Pattern, j: int) -> Pattern:
    """The pattern with another sign of one surface."""
    return (*signs[:j], -signs[j], *signs[j + 1 :])


def components(patterns: set[Pattern], parted: set[frozenset[Pattern]]) -> list[set[Pattern]]:
    """Some patterns in parts, so that steps of one sign each lead to the others of its part only.

    Args:
        patterns: at least one.
        parted: pairs between which no step leads.
    """
    remaining, parts = set(patterns), []
    while remaining:
        waiting = [min(remaining)]
        part = set(waiting)
        while waiting:
            signs = waiting.pop()
            BUDGET.spend(1 + len(signs))
            steps = {flipped(signs, j) for j in range(len(signs))} & remaining - part
            steps = {step for step in steps if frozenset((signs, step)) not in parted}
            part |= steps
            waiting += steps
        remaining -= part
        parts.append(part)
    return parts


@dataclass(frozen=True)
class Face:
    """Where some surfaces vanish: an affine subspace, on which curved surfaces may vanish too.

    Attributes:
        inclusion: with its surfaces.
        zero: numbers of the surfaces that vanish, none for the whole domain.
        curved: those of them that are not affine.
        coordinates: the variables as affine forms in those that stay free on the subspace.
        dimension: how many these are.
    """

    inclusion: Inclusion
    zero: tuple[int, ...]
    curved: tuple[int, ...]
    coordinates: tuple[Polynomial, ...]
    dimension: int

    def restricted(self, value: Polynomial) -> Polynomial:
        """A polynomial on the subspace."""
        return value.on(self.coordinates, self.dimension) if self.dimension < value.count else value

    @property
    def holds_origin(self) -> bool:
        """Whether the checked point lies in the subspace; it is then the origin of its coordinates."""
        return not any(form.at_origin for form in self.coordinates)

    @property
    def is_outside(self) -> bool:
        """Whether it does not meet the cube because one variable is a number there, or is the checked point alone."""
        still = [form.at_origin for form in self.coordinates if not form.degree]
        beyond = self.inclusion.domain.bounded and any(abs(value) > 1 for value in still)
        return beyond or (not self.dimension and self.holds_origin)

    def guards(self, signs: SurfaceSigns) -> dict[str, Polynomial] | None:
        """Surfaces with signs, and the cube; None where one of them is a negative number on the subspace."""
        bounded = self.inclusion.domain.bounded
        guards = cube_guards(self.coordinates, self.dimension) if bounded else {}
        for j, sign in signs.items():
            guard = self.restricted(self.inclusion.surfaces.signed(j, sign))
            if guard.degree:
                guards[f"s{j}"] = guard
            elif guard.at_origin < 0:
                return None
        return guards

    def zeros(self) -> dict[str, Polynomial]:
        """The curved surfaces, which vanish on the face."""
        return {f"s{j}": self.restricted(self.inclusion.surfaces.listed[j]) for j in self.curved}


def whole_domain(inclusion: Inclusion) -> Face:
    """The face on which no surface need vanish."""
    return Face(inclusion, (), (), identity(inclusion.count), inclusion.count)


def build_face(inclusion: Inclusion, chosen: Sequence[int]) -> Face | None:
    """Where some bending surfaces vanish together; None where the affine ones of them do nowhere.

    On the subspace of the affine ones all bending surfaces that are zero there belong to the face.
    """
    listed = inclusion.surfaces.listed
    flat = [j for j in chosen if listed[j].degree == 1]
    coordinates = solve([listed[j] for j in flat], inclusion.count)
    if coordinates is None:
        return None
    dimension = coordinates[0].count
    curved = tuple(j for j in chosen if j not in flat)
    bare = Face(inclusion, (), (), coordinates, dimension)
    zero = {j for j in inclusion.bending if not bare.restricted(listed[j])} | set(curved)
    still_curved = tuple(j for j in curved if bare.restricted(listed[j]))
    return Face(inclusion, tuple(sorted(zero)), still_curved, coordinates, dimension)
