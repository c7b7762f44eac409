"""Stand-alone checker of certificates: ``python -I -S checker.py FILE``, with the standard library alone.

It shares no code with the workbench and rebuilds every claim from the wheels.  Exit status 0 valid, 1 rejected, 2 not
readable.  A number is zero if no terms are left; any other sign needs an interval that shows it, else it rejects.
"""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from functools import cache
from itertools import combinations, pairwise, product
from typing import Any, TypeAlias

SCHEMA, CALM, NEITHER = "nonsmooth-certificate/1", "stable, not attractive", "no certificate"
KEYS = "schema field at radius rule loads wheels points cells equilibrium translation rotation feedback theorem4 notes"
MAX_BYTES, MAX_SIZE, MAX_WORK, PRECISIONS = 64 << 20, 400, 30_000_000, (96, 384, 1536)  # of a field; words; bits
RATIONAL = re.compile(r"-?[0-9]{1,4000}(/[0-9]{1,4000})?")
MALFORMED = (KeyError, TypeError, ValueError, IndexError, AttributeError, ArithmeticError, RecursionError)
ASYMPTOTIC, STABLE, UNDECIDED, UNSTABLE = TRANSLATION = ("asymptotically stable", "stable", "undecided", "unstable")

RejectedError = type("RejectedError", (ValueError,), {"__doc__": "A claim that does not hold or is not shown."})
Vector: TypeAlias = tuple["Number", ...]  # a twist, a row, or a point (X, Y, W) at X/W, Y/W with W > 0


def _require(holds: object, claim: str) -> None:
    if not holds:
        raise RejectedError(claim)


def _take(data: Any, names: str) -> list[Any]:
    _require(type(data) is dict and sorted(data) == sorted(names.split()), f"an object with the keys {names}")
    return [data[name] for name in names.split()]


def _items(data: Any, count: int | None = None) -> list[Any]:
    sound = type(data) is list and count in (None, len(data)) and not any(type(item) is bool for item in data)
    _require(sound, f"a list of {count or 'any'} items")
    return list(data)


class Field:
    """The rationals and generators: each the only root above a bound of a monic polynomial over those before it."""

    def __init__(self, data: Any) -> None:
        self.count, self.work, self.generators = len(_items(data)), 0, list[tuple[Vector, Fraction]]()
        for entry in data:
            polynomial, above = _take(entry, "polynomial above")
            coefficients, low = self.vector(polynomial, min(len(polynomial), MAX_SIZE)), self.parse(above)
            shifted = list(coefficients)  # p(x + low): negative at 0 and increasing for x > 0, so it has one root there
            for j in (j for i in range(len(shifted)) for j in reversed(range(i, len(shifted) - 1))):
                shifted[j] = shifted[j] + shifted[j + 1] * low
            first, *others = _signs([*shifted, low])
            monic = polynomial[-1] == "1" and len(polynomial) > 2 and all(c.bottom == 1 for c in coefficients)
            _require(monic and first < 0 <= min(others) and self.count <= MAX_SIZE, "field: polynomials with one root")
            self.generators.append((coefficients, Fraction(above)))

    def parse(self, data: Any) -> Number:
        """A number: a rational as text, or a list of ``[rational, generator, generator, ...]`` to be multiplied."""
        out = Number(self, {})
        for text, *factors in map(_items, [[data]] if type(data) is str else _items(data) or [data]):  # [] is none
            powers = tuple(map(factors.count, range(self.count)))
            known = all(0 <= k < len(self.generators) and powers[k] < len(self.generators[k][0]) - 1 for k in factors)
            _require(known and RATIONAL.fullmatch(text), "numbers of the field")
            out = out + Number(self, {powers: Fraction(text).numerator}, Fraction(text).denominator)
        return out

    def vector(self, data: Any, count: int) -> Vector:
        """A list of so many numbers."""
        return tuple(self.parse(entry) for entry in _items(data, count))

    @cache  # noqa: B019  (one field to a certificate)
    def reduced(self, powers: tuple[int, ...]) -> dict[tuple[int, ...], int]:
        """A product of generators, by powers below their degrees."""
        for k, ((*lower, _), _) in enumerate(self.generators):
            if powers[k] >= len(lower):  # x^degree = -(lower terms)
                rests = ((*powers[:k], powers[k] - len(lower) + j, *powers[k + 1 :]) for j in range(len(lower)))
                return _dot([Number(self, {rest: -1}) for rest in rests], lower).terms
        return {powers: 1}

    @cache  # noqa: B019
    def root(self, k: int, bits: int) -> tuple[int, int]:
        """Enclosure of a generator, which is positive, in units of 2^-bits, by bisection."""
        polynomial, above = self.generators[k]
        low, high = math.floor(above * 2**bits), 0
        while high - low != 1:
            middle = (low + high) // 2 if high else 2 * low + 2
            powers = [Number(self, {(0,) * self.count: middle**j}, 1 << bits * j) for j in range(len(polynomial))]
            low, high = (middle, high) if _dot(powers, polynomial).sign() <= 0 else (low, middle)
        return low, high


class Number:
    """An exact number: whole multiples of products of generators, over one denominator."""

    def __init__(self, field: Field, terms: dict[tuple[int, ...], int], bottom: int = 1) -> None:
        field.work += len(terms) ** 2 + 1 + sum(map(int.bit_length, terms.values())) // 64
        _require(field.work < MAX_WORK, "less work: the limit is reached")  # no certificate keeps it busy for ever
        shared = math.gcd(bottom, *terms.values())
        self.field, self.bottom = field, bottom // shared
        self.terms = {powers: c // shared for powers, c in terms.items() if c}

    def __add__(self, other: Number) -> Number:
        a, b, m, n = self.terms, other.terms, self.bottom, other.bottom
        return Number(self.field, {powers: a.get(powers, 0) * n + b.get(powers, 0) * m for powers in a | b}, m * n)

    def __sub__(self, other: Number) -> Number:
        return self + other * -1

    def __mul__(self, other: Number | int) -> Number:
        other = Number(self.field, {(0,) * self.field.count: other}) if isinstance(other, int) else other
        terms = dict[tuple[int, ...], int]()
        for (s, a), (t, b) in product(self.terms.items(), other.terms.items()):
            for powers, c in self.field.reduced(tuple(map(int.__add__, s, t))).items():
                terms[powers] = terms.get(powers, 0) + a * b * c
        return Number(self.field, terms, self.bottom * other.bottom)

    def sign(self) -> int:
        """Certified sign -1, 0 or 1."""
        for bits in PRECISIONS if self.terms else ():
            low = high = 0
            for powers, c in self.terms.items():
                lower = upper = 1 << bits
                for a, b in (self.field.root(k, bits) for k, power in enumerate(powers) for _ in range(power)):
                    lower, upper = lower * a >> bits, (upper * b >> bits) + 1
                low, high = low + min(c * lower, c * upper), high + max(c * lower, c * upper)
            if low > 0 or high < 0:
                return 1 if low > 0 else -1
        _require(not self.terms, f"a sign that {PRECISIONS[-1]} bits show")
        return 0


def _dot(a: Sequence[Number], b: Sequence[Number]) -> Number:
    return sum((x * y for x, y in zip(a, b, strict=False)), Number(a[0].field, {}))  # up to the shorter's length


def _cross(a: Sequence[Number], b: Sequence[Number]) -> Number:
    return a[0] * b[1] - a[1] * b[0]


def _outer(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _signs(numbers: Iterable[Number]) -> list[int]:
    return [number.sign() for number in numbers]


def _is_one_turn(steps: Iterable[tuple[Vector, Vector]]) -> bool:
    """Whether counterclockwise steps, each of less than a half turn, that return to their start go around once."""
    return sum(b > a for a, b in ([(v[1].sign() or v[0].sign()) > 0 for v in step] for step in steps)) == 1


class Checker:
    """One certificate, seen from the checked point; twists are ``(vx, vy, omega, 1)``, rows vanish on them."""

    def __init__(self, data: Any) -> None:
        schema, field, at, radius, rule, loads, wheels, points, cells, *self.clauses, _ = _take(data, KEYS)
        _require(schema == SCHEMA and (rule == "box" or (rule, loads) == ("nearest", None)), "schema, rule, loads")
        self.field, self.box = Field(field), rule == "box"
        self.zero, self.one = self.field.parse("0"), self.field.parse("1")
        (x, y), self.radius = self.field.vector(at, 2), self.field.parse(radius)
        self.places, self.rows, self.friction = dict[str, Vector](), dict[str, Vector](), dict[str, Number]()
        for n, wheel in enumerate(_items(wheels), 1):
            *pairs, speed = _take(wheel, "position direction friction speed")
            (p, q), (a, b), (roll, side) = (self.field.vector(pair, 2) for pair in pairs)
            sound = not (a * a + b * b - self.one).sign() and min(_signs((roll, side))) >= 0
            _require(sound, f"wheels[{n - 1}]: a unit direction, and friction that is not negative")
            p, q, u, self.places[str(n)] = p - x, q - y, self.field.parse(speed) * -1, (p - x, q - y, self.one)
            self.rows |= {f"R{n}": (a, b, b * p - a * q, u), f"S{n}": (b * -1, a, a * p + b * q, self.zero)}
            self.friction |= {f"R{n}": roll, f"S{n}": side}
        forms = _items(loads, len(self.places)) if self.box and loads != "elastic" else []
        given = ((n, self.field.vector(form, 3)) for n, form in zip(self.places, forms, strict=False))
        self.table: dict[str, Vector] = {n: (b, c, a + b * x + c * y) for n, (a, b, c) in given}
        self.points = [self.field.vector(point, 3) for point in _items(points)]
        _require(min(_signs([self.radius, *(w for _, _, w in self.points)])) > 0, "radius, points: positive weights")
        self.rays = dict[int, tuple[int, int]]()  # by cell at the checked point: its first and last ray, as points
        self.cells = [self._cell(k, *_take(cell, "polygon loaded states")) for k, cell in enumerate(_items(cells))]
        self.motions = [(k, *motion) for k, (*_, motions) in enumerate(self.cells) for motion in motions]
        self.here = [motion for motion in self.motions if motion[0] in self.rays]
        sides = [side for cell in cells for side in pairwise([*cell["polygon"], cell["polygon"][0]])]
        once = len(sides) == len(set(sides)) and {k for side in sides for k in side} == set(range(len(self.points)))
        border = [(self.points[a], self.points[b]) for a, b in set(sides) - {(b, a) for a, b in sides}]  # others cancel
        ends = list(product((0, 1), (1, -1)))
        on = [any(not any(_signs(p[k] - self.radius * p[2] * s for p in side)) for k, s in ends) for side in border]
        around = all(on) and all(_cross(a, b).sign() > 0 for a, b in border) and _is_one_turn(border)
        _require(once and around, "cells: they cover the square once, and each point is a vertex")
        self.highest = max(max(rates) for *_, rates, _ in self.here)  # of V* = 2 c . v on the cells at the point
        self.fan = self._decide_fan([(k, v) for k, _, v, *_ in self.here]) if self.highest >= 0 else ASYMPTOTIC

    def _cell(self, number: int, polygon: Any, loaded: Any, states: Any) -> tuple[Any, ...]:
        """A convex cell where the rule gives the twists: corners, places but the checked point, and states."""
        name, count = f"cells[{number}]", len(self.points)
        _require(all(0 <= k < count for k in _items(polygon)), f"{name}: numbers of points")
        corners = [self.points[k] for k in polygon]
        ring = list(pairwise([*corners, corners[0]]))
        steps = [(q[0] * p[2] - p[0] * q[2], q[1] * p[2] - p[1] * q[2]) for p, q in ring]
        turns = list(pairwise([*steps, steps[0]]))
        bends = [(_cross(a, b).sign(), _dot(a, b).sign()) for a, b in turns]
        _require(min(bends) > (0, 0) and _is_one_turn(turns), f"{name}: a convex polygon, counterclockwise")
        rows, given, barriers = zip(*(_take(state, "rows twist barrier") for state in _items(states)), strict=True)
        twists = [(*self.field.vector(v, 3), self.one) for v in given]
        slips = [_dot(self.rows[row], v) for names, v in zip(rows, twists, strict=True) for row in _items(names)]
        _require(not any(_signs(slips)), f"{name}: twists that satisfy their rows")
        (self._check_box if self.box else self._check_nearest)(name, list(rows), twists, corners, loaded)
        views = [_cross(a, b).sign() for a, b in ring]
        origin = [k for k, corner in enumerate(corners) if not any(_signs(corner[:2]))]
        if min(views) >= 0:
            _require(bool(origin) == (min(views) == 0), f"{name}: the checked point as a vertex")
            self.rays[number] = (polygon[origin[0] + 1 - len(polygon)], polygon[origin[0] - 1]) if origin else (-1, -1)
        places = [corner[:2] for k, corner in enumerate(corners) if k not in origin]
        rates = [[_dot(v, place).sign() for place in places] for v in twists]  # V* = 2 c . v
        return corners, places, loaded, zip(rows, twists, rates, barriers, strict=True)

    def _check_nearest(self, name: str, rows: list[Any], _: Any, corners: list[Vector], loaded: Any) -> None:
        """Wheel i nearest, j second at every vertex; both rows of i, then of j the row of larger friction."""
        i, j = rows[0][0][1:], rows[0][2][1:]
        gap = (self.friction[f"S{j}"] - self.friction[f"R{j}"]).sign()
        normal = _outer(self.rows[f"R{i}"], self.rows[f"S{i}"])
        regular = [kind for kind in ("SR" if gap > 0 else "RS") if _dot(normal, self.rows[kind + j]).sign()]
        expected = [[f"R{i}", f"S{i}", kind + j] for kind in (regular[:1] if gap else regular)]
        _require(rows == expected and loaded is None, f"{name}: the rows that the rule takes")
        forms = {n: (p * -2, q * -2, p * p + q * q) for n, (p, q, _) in self.places.items()}  # |c - p|^2 - |c|^2
        for near, far in [(i, j), *((j, n) for n in forms if n not in (i, j))]:
            line = [b - a for a, b in zip(forms[near], forms[far], strict=True)]
            ahead = min(_signs(_dot(line, corner) for corner in corners)) >= 0
            _require(any(_signs(line[:2])) and ahead, f"{name}: wheels {i} and {j} the nearest at every vertex")

    def _check_box(self, name: str, rows: list[Any], twists: list[Vector], corners: list[Vector], loaded: Any) -> None:
        """No slope of D at a twist is negative, and where one vanishes throughout, another twist follows."""
        forces = self._forces(loaded, corners)
        for names, twist in zip(rows, twists, strict=True):
            slips = {row: _dot(normal, twist).sign() for row, normal in self.rows.items()}
            _require(names == [row for row in slips if not slips[row]], f"{name}: all rows that a twist satisfies")
            gaps = [tuple(a - b for a, b in zip(other, twist, strict=True)) for other in twists]
            for way, slopes in self._slopes(slips, forces, fixed=True):
                follows = any(_dot(way, gap).sign() > 0 and not any(_signs(_outer(gap, way))) for gap in gaps)
                _require(min(slopes) >= 0 and (max(slopes) or follows), f"{name}: all twists that minimize D")

    def _forces(self, loaded: Any, corners: list[Vector]) -> list[dict[str, Number]]:
        """The friction limits of the loaded rows at each corner, by the model of the loads."""
        forms, active = self.table, set(self.table) or {f"{n:d}" for n in _items(loaded)}
        if not forms:  # elastic: N_i = max(0, m_i . y), by the loaded wheels, up to one positive factor
            held = [self.places[n] for n in active]
            gram = [tuple(sum((m[r] * m[s] for m in held), self.zero) for s in range(3)) for r in range(3)]
            adjugate = [_outer(gram[r - 2], gram[r - 1]) for r in range(3)]
            _require(_dot(gram[0], adjugate[0]).sign() > 0, "loaded: wheels that are not collinear")
            forms = {n: tuple(_dot(column, m) for column in adjugate) for n, m in self.places.items()}
        loads = [{n: _dot(form, corner) for n, form in forms.items()} for corner in corners]
        signs = [load.sign() * (1 if n in active else -1) for at in loads for n, load in at.items()]
        _require(min(signs) >= 0 and (loaded is None) == bool(self.table), "loaded: the loads of the model")
        return [{row: self.friction[row] * at[row[1:]] for row in self.rows if row[1:] in active} for at in loads]

    def _slopes(self, slips: dict[str, int], forces: Any, *, fixed: bool) -> Iterator[tuple[Vector, list[int]]]:
        """Each way out of a twist, and the signs of the slope of D along it under each of the forces."""
        tight = [self.rows[row] for row in slips if not slips[row]]
        ways = [m for a, b in combinations(tight, 2) if any(_signs(m := _outer(a, b)))]
        _require(not fixed or any(_signs(_dot(m, row) for m in ways[:1] for row in tight)), "tight rows of rank three")
        for way in (w for m in ways for w in (m, tuple(x * -1 for x in m))):
            pulls = {row: (pull := _dot(way, self.rows[row])) * (slips[row] or pull.sign()) for row in forces[0]}
            yield way, _signs(sum((pulls[row] * at[row] for row in pulls), self.zero) for at in forces)

    def _drift(self, separator: Any, *bounds: Any) -> tuple[str, str]:
        """0 in F and the range of omega there, by weights and multipliers; or a direction into which F points."""
        twists = [twist for _, _, twist, *_ in self.here]
        if separator is not None:
            margins = [_dot(self.field.vector(separator, 2), v) for v in twists]
            _require(min(_signs(margins)) > 0 and bounds == (None, None), "equilibrium: a separating direction")
            return "fails", UNDECIDED
        ends = list[int]()
        for side, bound in zip((-1, 1), bounds, strict=True):
            weights, multipliers = _take(bound, "weights multipliers")
            (a, b, shift, scale), shares = self.field.vector(multipliers, 4), self.field.vector(weights, len(twists))
            x, y, omega, whole = (_dot(shares, [v[k] for v in twists]) for k in range(4))
            tight = not any(_signs((x, y, shift * whole - scale * omega * side)))  # at omega/whole = side shift/scale
            above = (_dot((a, b, scale * -side, shift), v) for v in twists)
            convex = min(_signs([*shares, *above])) >= 0 < min(_signs((whole, scale)))
            _require(tight and convex, "rotation: weights and multipliers of the drift")
            ends.append(omega.sign())
        # drift {0}: |omega| <= K |v| in F, and paths that lead inward or to rest are bounded; ties may run to and fro
        short = self.fan in (ASYMPTOTIC, STABLE)[: 1 + (len(self.here) == len(self.rays))]
        calm = short or not any(v[2].sign() for _, _, v, *_ in self.motions)
        return "holds", UNSTABLE if any(ends) else CALM if calm else UNDECIDED

    def _translation(self, squared: Any) -> str:
        """By V = |c|^2 on the closed cells at the point; what it leaves open by the fan of their cones."""
        disc = None if self.highest > 0 else self.field.parse(squared)
        inside = squared is None if disc is None else disc.sign() > 0 <= (self.radius * self.radius - disc).sign()
        _require(inside, "translation: a disc in the square where V* shows one")
        for k, _, v, rates, barrier in self.motions:
            grows = disc is not None and k not in self.rays and max(rates) > self.highest
            _require((barrier is not None) == grows, f"cells[{k}]: a barrier where V* grows")
            if disc is not None and grows:  # (n - t v) . c >= 1, t >= 0, shows |c| |n| >= 1 where v . c >= 0
                a, b, t = self.field.vector(barrier, 3)
                margins = [t, *(_dot((a, b, self.one * -1), corner) for corner in self.cells[k][0])]
                margins.append(self.one - disc * _dot(n := (a + t * v[0], b + t * v[1]), n))
                _require(min(_signs(margins)) >= 0, f"cells[{k}]: the barrier")
        return self.fan if disc is None or self.fan == ASYMPTOTIC else STABLE

    def _decide_fan(self, motions: Sequence[tuple[int, Vector]]) -> str:
        """Escapes along a velocity, slides along a ray, full turns: 0 all lead inward, 1 rest, 2 open, 3 outward."""
        worst, points = [0], self.points
        fan = [(a, b, [v for k, v in motions if k == cell]) for cell, (a, b) in self.rays.items()]
        for start, end, v in ((a, b, v) for a, b, twists in fan for v in twists):
            leaving = _cross(points[start], v).sign(), _cross(v, points[end]).sign()
            bend = [(v[2] * _dot(points[k][:2], v)).sign() for k in (start, end)]
            stays = start < 0 or (leaving[0] or bend[0]) >= 0 <= (leaving[1] or -bend[1])
            worst.append((3 if stays else 0) if any(_signs(v[:2])) else 2 if v[2].sign() else 1)
        fan = [cone for cone in fan if cone[0] >= 0]
        after = {start: twists for start, _, twists in fan}
        for ray, pool in ((points[end][:2], [*twists, *after[end]]) for _, end, twists in fan):
            for f, g in product(pool, repeat=2):  # f pushes counterclockwise, g clockwise
                (n, r, w), (m, q, z) = ((_cross(ray, v), _dot(ray, v), v[2]) for v in (f, g))
                if (n.sign() or w.sign()) >= 0 >= (m.sign() or z.sign()):
                    speed = (n * q - m * r).sign() or (w * q - z * r).sign()
                    worst.append((1, 3, 0)[speed or (0 if any(_signs((n, m, w, z))) else r.sign())])
        for sense in (1, -1) if fan else ():  # each way through a cone multiplies the distance by entry / exit
            ways = [[(_cross(points[a], v) * sense, _cross(points[b], v) * sense) for v in vs] for a, b, vs in fan]
            for choice in product(*([way[::sense] for way in cone if min(_signs(way)) > 0] for cone in ways)):
                gains = [math.prod((way[k] for way in choice), start=self.one) for k in (0, 1)]
                worst.append((2, 3, 0)[(gains[0] - gains[1]).sign()])
        return TRANSLATION[max(worst)]

    def _feedback(self, said: str, evidence: Any) -> str:
        """A law by translations along the nearest rims, or by three imposed twists; or a plane of all motions."""
        held = {row[1:] for _, rows, *_ in self.here for row in (self.rows if self.box else rows)}
        outside = any((self.friction["S" + n] - self.friction["R" + n]).sign() >= 0 for n in held)
        if outside or evidence is None:
            return "not applicable" if outside else UNDECIDED if self.box else NEITHER
        if said == NEITHER:
            normal, sides = self.field.vector(evidence, 3), [row for name, row in self.rows.items() if name[0] == "S"]
            full = any(_dot(_outer(a, b), c).sign() for a, b, c in combinations(sides, 3))
            axes = [tuple(self.one if j == k else self.zero for j in range(3)) for k in range(3) if not full]
            # control fields: of both rims where a roll row stands third, of the nearest one where a side row does
            fields = ((self.rows[s], self.rows[y]) for _, (r, s, x), *_ in self.here for y in (x, r)[: 1 + (x < "S")])
            for a, b in combinations(sides + axes, 2) if self.box else fields:
                off = _dot(normal, m := _outer(a, b)).sign() and (not self.box or self._imposes(m, 0))
                _require(any(_signs(normal)) and not off, "feedback: a plane of all motions")
            return said
        if self.box:
            a, b, c = three = [self.field.vector(twist, 3) for twist in _items(evidence, 3)]
            serves = all(self._imposes(v, 1) for v in three) and _dot(_outer(a, b), c).sign()
        else:
            rims = [(k, self.rows[r], self.places[r[1:]], x[0]) for k, (r, _, x), *_ in self.here]
            law = zip(rims, _items(evidence), strict=True)
            descent = self._decide_fan([(k, (a * s, b * s, self.zero)) for (k, (a, b, *_), *_), s in law])
            turned = any(_dot(row[:2], p).sign() for _, row, p, _ in rims)  # tangential rims may turn with gain one
            serves = descent in (ASYMPTOTIC, UNDECIDED)[: 2 - turned] and "S" not in [x for *_, x in rims]
        return "stabilizable" if serves else UNDECIDED

    def _imposes(self, twist: Vector, least: int) -> bool:
        """Whether all slopes of D at the checked point have such a sign, at a twist along which no rim slips."""
        slips = {row: 0 if row[0] == "R" else _dot(normal[:3], twist).sign() for row, normal in self.rows.items()}
        forces = self._forces(self.cells[self.here[0][0]][2], [(self.zero, self.zero, self.one)])
        return all(min(slopes) >= least for _, slopes in self._slopes(slips, forces, fixed=least > 0))

    def check(self) -> None:
        """Compare each verdict with what its evidence shows; ``undecided`` claims nothing."""
        keys = ("verdict separator", "verdict squared_radius", "verdict lowest highest", "verdict evidence")
        clauses = [_take(*pair) for pair in zip(self.clauses, keys, strict=False)]
        equilibrium, rotation = self._drift(clauses[0][1], *clauses[2][1:])
        shown = (equilibrium, self._translation(clauses[1][1]), rotation, self._feedback(*clauses[3]))
        for name, (said, *_), found in zip(KEYS.split()[9:], clauses, shown, strict=False):
            _require(said in (found, UNDECIDED), f"{name}: {found}, received {said!r:.60}")
        words = [said for said, *_ in clauses]
        refuted = words[1] == UNSTABLE or words[2] == CALM or (words[3] == NEITHER and clauses[3][1] is not None)
        verdict = "fails" if refuted else UNDECIDED if {UNDECIDED, NEITHER} & {*words} else "holds"
        verdict = "hypotheses not met" if words[0] == "fails" else verdict
        _require(self.clauses[4] == verdict, f"theorem4: {verdict}")


def check_certificate(data: Any) -> str:
    """The claim of a certificate (parsed JSON) that is not shown; empty where all are."""
    try:
        Checker(data).check()
    except MALFORMED as error:
        return str(error) if isinstance(error, RejectedError) else f"well-formed data, not a {type(error).__name__}"
    return ""


def check_file(path: str) -> tuple[int, str]:
    """Exit status and one line: 0 valid, 1 rejected, 2 unreadable."""
    try:
        with open(path, "rb") as file:
            _require(len(text := file.read(MAX_BYTES + 1)) <= MAX_BYTES, f"more than {MAX_BYTES} bytes")
        once = lambda pairs: dict(pairs) if len(dict(pairs)) == len(pairs) else _require(0, "a key twice")  # noqa: E731
        data = json.loads(text, parse_float=str, parse_constant=str, object_pairs_hook=once)
    except (OSError, *MALFORMED) as error:
        return 2, f"unreadable: {error}"
    return (1, f"rejected: required {claim}") if (claim := check_certificate(data)) else (0, "valid: all claims hold")


if __name__ == "__main__":
    STATUS, LINE = check_file(sys.argv[1]) if len(sys.argv) == 2 else (2, "usage: checker.py FILE")
    print(LINE)
    sys.exit(STATUS)
