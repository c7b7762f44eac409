"""Square roots in a number field: found where they exist, adjoined where they provably do not.

To adjoin ``sqrt(a)`` safely one must know that no product ``a * prod_{i in S} g_i`` is a square already.
Residue symbols decide it: modulo a prime p at which every inner number of the field has a residue,
each radicand is a square (0) or not (1), and these bits are additive.  If no S reproduces the bits of
``a`` at the chosen primes, the root is new: a proof.  If one S does, the exact root of the product is
taken (and verified by squaring); should it not exist, more primes are added.

Rational radicands are split into primes first, so ``sqrt(8)`` is ``2 sqrt(2)`` and ``sqrt(6)`` is
``sqrt(2) sqrt(3)``.  Cofactors too long to factor stay whole, which the residue test allows.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import count

from flint import fmpq, fmpq_mat, fmpq_poly, fmpz, nmod_mat

from nonsmooth.symbolic.numbers.coefficients import as_fmpq, bits
from nonsmooth.symbolic.numbers.number import Number, Tower

_FACTOR_BITS = 128  # longer cofactors are not factored (quadratic sieve takes over a second there)
_SMOOTH_BITS = 16
_SPARE_PRIMES = 40  # residue tests beyond the number of generators
_MAX_INNER = 8  # one prime in 2^8 serves eight nested roots; more would make the search slow


class NestingError(ValueError):
    """Too many square roots of square roots for one field."""


def square_root(field: Tower, value: Number) -> Number:
    """Non-negative square root of ``value``, adjoining generators where needed.

    Raises:
        ValueError: if the value is negative.
        NestingError: if the scene nests more square roots than the field can test.
    """
    if value.sign() < 0:
        raise ValueError(f"required a non-negative number under the square root, received {value}")
    if not value:
        return value
    rational = value.as_rational()
    if rational is not None:
        return _rational_root(field, rational)
    content = _rational_content(value)
    if not (content.p.is_square() and content.q.is_square()):
        root = _find(field, value)  # (1 + sqrt 3)^2 = 2 (2 + sqrt 3) needs no sqrt 2
        if root is not None:
            return root
    return _rational_root(field, content) * _root(field, value / content)


def _rational_content(value: Number) -> fmpq:
    """Positive rational whose removal leaves coprime integer coefficients."""
    parts: list[fmpq] = []
    for c in value.terms.values():
        parts += [c] if isinstance(c, fmpq) else [q for q in c.coeffs() if q]
    top, bottom = fmpz(0), fmpz(1)
    for q in parts:
        top, bottom = top.gcd(abs(q.p)), bottom.lcm(q.q)
    return fmpq(top, bottom)


def _rational_root(field: Tower, value: fmpq) -> Number:
    """``sqrt(a^2 p / (b^2 q)) = a sqrt(p) sqrt(q) / (b q)`` with p, q squarefree, prime by prime."""
    squares_above, primes_above = _split_squares(value.p)
    squares_below, primes_below = _split_squares(value.q)
    below = squares_below
    for prime in primes_below:
        below *= prime
    result = field.rational(fmpq(squares_above, below))
    for prime in primes_above + primes_below:
        result = result * _root(field, field.rational(fmpq(prime)))
    return result


def _split_squares(number: fmpz) -> tuple[fmpz, list[fmpz]]:
    """``number = square^2 * product(primes)``."""
    square, primes = fmpz(1), list[fmpz]()
    for prime, power in factor(number):
        square *= prime ** (power // 2)
        if power % 2:
            primes.append(prime)
    return square, primes


def factor(number: fmpz) -> list[tuple[fmpz, int]]:
    """Prime factors of a positive integer; a long cofactor without small factors stays whole."""
    if int(number).bit_length() <= _FACTOR_BITS:
        return [(p, int(k)) for p, k in number.factor()]
    parts: list[tuple[fmpz, int]] = []
    for piece, power in number.factor_smooth(_SMOOTH_BITS):
        if int(piece).bit_length() <= _FACTOR_BITS:
            parts += [(p, int(k) * int(power)) for p, k in piece.factor()]
        elif piece.is_square():
            parts += [(p, 2 * k * int(power)) for p, k in factor(piece.isqrt())]
        else:
            parts.append((piece, int(power)))
    return parts


def _root(field: Tower, radicand: Number) -> Number:
    """Root of a positive radicand: an element of the field where it exists, else a new generator."""
    if radicand in field.square_roots:
        return field.square_roots[radicand]
    rational = radicand.as_rational()
    if rational == 1:
        return field.one
    if rational is not None and field.modulus is None and _is_new_prime(field, rational):
        root = field.adjoin(radicand)
    else:
        root = _find(field, radicand) or field.adjoin(radicand)
    field.square_roots[radicand] = root
    return root


def _is_new_prime(field: Tower, radicand: fmpq) -> bool:
    """Over Q, a prime that divides no earlier radicand is no square times a product of them."""
    rationals = [g.as_rational() for g in field.radicands]
    return radicand.p.is_prime() and all(g is not None and g.p % radicand.p != 0 for g in rationals)


def _find(field: Tower, radicand: Number) -> Number | None:
    """Root of ``radicand`` in the field, or None with the residue proof that there is none."""
    inner = _inner_generators(field, radicand)
    if len(inner) > _MAX_INNER:
        raise NestingError(f"required at most {_MAX_INNER} nested square roots in a scene")
    outer = [i for i in range(len(field.radicands)) if i not in inner]
    radicands = [field.radicands[i] for i in outer]
    rows: list[list[int]] = []  # one residue equation per prime: bits of those of the field, bit of the radicand
    characters = _characters(field, inner, [*radicands, radicand])
    while True:
        needed = len(rows) + len(radicands) + _SPARE_PRIMES
        while len(rows) < needed:
            rows.append(next(characters))
        subset = _solve_mod_2(rows, len(radicands))
        if subset is None:
            return None
        product = radicand
        for k in subset:
            product = product * radicands[k]
        root = _exact_root(field, product, sorted(inner))
        if root is not None:
            for k in subset:
                monomial = Number(field, {1 << outer[k]: field.one.terms[0]})
                root = root / monomial
            return abs(root)


def _inner_generators(field: Tower, radicand: Number) -> set[int]:
    """Generators that occur inside a radicand (nested roots)."""
    inner: set[int] = set()
    for number in [*field.radicands, radicand]:
        for mask in number.terms:
            inner.update(bits(mask))
    return inner


def _characters(field: Tower, inner: set[int], numbers: list[Number]) -> Iterator[list[int]]:
    """Residue bits of the numbers at primes where the base and the inner roots have residues.

    A root that occurs in no other root may be taken with either sign.  Both are asked: for ``p = 3 mod 4`` the root
    that is found is a residue itself, so that of nested roots the first sign alone would say nothing.
    """
    step = max(field.order, 1)
    outermost = set(inner) - {i for k in inner for mask in field.radicands[k].terms for i in bits(mask)}
    for k in count((1 << 40) // step):
        p = fmpz(k * step + 1)
        if not p.is_prime():
            continue
        residues = _ResidueMap(field, p, sorted(inner))
        if not residues.exists:
            continue
        for _ in range(2 if outermost else 1):
            values = [residues(number) for number in numbers]
            if all(v is not None and v != 0 for v in values):
                yield [0 if fmpz(v).jacobi(p) == 1 else 1 for v in values if v is not None]
            residues.negate(outermost)


class _ResidueMap:
    """Ring homomorphism from the inner field to the integers modulo p."""

    def __init__(self, field: Tower, p: fmpz, inner: list[int]) -> None:
        self.p, self.roots = p, dict[int, fmpz]()
        self.base = fmpz(0) if field.modulus is None else _two_cos(field.order, p)
        self.exists = True
        for i in inner:
            value = self(field.radicands[i])
            if value is None or value == 0 or value.jacobi(p) != 1:
                self.exists = False
                return
            self.roots[i] = value.sqrtmod(p)

    def negate(self, generators: Iterable[int]) -> None:
        """Take the other roots of generators that occur in no other root."""
        for i in generators:
            self.roots[i] = self.p - self.roots[i]

    def __call__(self, number: Number) -> fmpz | None:
        """Residue of a number, or None where p divides a denominator."""
        total = fmpz(0)
        for mask, c in number.terms.items():
            coefficients = [c] if isinstance(c, fmpq) else c.coeffs()
            term = fmpz(0)
            for q in reversed(coefficients):
                if q.q % self.p == 0:
                    return None
                residue = q.p if q.q == 1 else q.p * fmpz(pow(int(q.q), -1, int(self.p)))
                term = (term * self.base + residue) % self.p
            for i in bits(mask):
                term = term * self.roots[i] % self.p
            total = (total + term) % self.p
        return total


def _two_cos(order: int, p: fmpz) -> fmpz:
    """A conjugate of ``2 cos(2 pi/N)`` modulo a prime ``p = 1 mod N``: ``z + 1/z`` for a z of order N."""
    modulo = int(p)
    roots = (pow(h, (modulo - 1) // order, modulo) for h in count(2))
    z = next(z for z in roots if all(pow(z, order // int(q), modulo) != 1 for q, _ in fmpz(order).factor()))
    return (z + pow(z, -1, modulo)) % p


def _solve_mod_2(rows: list[list[int]], unknowns: int) -> list[int] | None:
    """A subset S with ``sum_{k in S} row[k] = row[-1]`` modulo 2 in every row, or None."""
    kernel, nullity = nmod_mat(rows, 2).nullspace()
    solutions = [[int(kernel[k, j]) for k in range(unknowns + 1)] for j in range(nullity)]
    solution = next((solution for solution in solutions if solution[-1]), None)
    return None if solution is None else [k for k in range(unknowns) if solution[k]]


def _exact_root(field: Tower, value: Number, inner: list[int]) -> Number | None:
    """Square root inside base(inner roots), by descent: ``(x + y s)^2 = a + b s``, ``s^2 = g``."""
    if value.sign() < 0:
        return None
    if not value:
        return value
    if not inner:
        return _base_root(field, value)
    *lower, top = inner
    flag = 1 << top
    g = field.radicands[top]
    s = Number(field, {flag: field.one.terms[0]})
    a = Number(field, {m: c for m, c in value.terms.items() if not m & flag})
    b = Number(field, {m ^ flag: c for m, c in value.terms.items() if m & flag})
    if not b:
        root = _exact_root(field, a, lower)
        if root is None:
            other = _exact_root(field, a / g, lower)
            root = None if other is None else other * s
        return None if root is None else abs(root)
    norm = _exact_root(field, a * a - g * b * b, lower)
    if norm is None:
        return None
    for half in ((a + norm) / 2, (a - norm) / 2):
        x = _exact_root(field, half, lower)
        if x:
            return abs(x + b / (2 * x) * s)
    return None


def _base_root(field: Tower, value: Number) -> Number | None:
    """Square root in the base field Q(c), or None.

    ``chi_b(X^2)``, chi the characteristic polynomial of multiplication by b, has an irreducible factor
    ``h(X) = E(X^2) + X O(X^2)`` that vanishes at the root s; then ``s = -E(b)/O(b)``.
    """
    rational = value.as_rational()
    if rational is not None and rational.p.is_square() and rational.q.is_square():
        return field.rational(fmpq(rational.p.isqrt(), rational.q.isqrt()))
    if field.modulus is None:
        return None
    for shift in count():  # multiply by squares until b generates the base field
        twist = field.two_cos(1) + shift if shift else field.one
        b = value * twist * twist
        characteristic = _characteristic(field, b)
        if characteristic.gcd(characteristic.derivative()).degree() == 0:
            break
    doubled = fmpq_poly([q for c in characteristic.coeffs() for q in (c, fmpq(0))])
    for h, _ in doubled.factor()[1]:
        parts = h.coeffs()
        even, odd = _at(field, parts[0::2], b), _at(field, parts[1::2], b)
        if odd:
            root = -even / odd
            if root * root == b:
                return abs(root / twist)
    return None


def _characteristic(field: Tower, b: Number) -> fmpq_poly:
    """Characteristic polynomial of multiplication by b on the base field."""
    degree, generator = field.base_degree, field.two_cos(1)
    rows, power = [], b
    for _ in range(degree):
        coefficients = power.terms[0].coeffs() if power.terms else []
        rows.append(list(coefficients) + [as_fmpq(0)] * (degree - len(coefficients)))
        power = power * generator
    return fmpq_mat(rows).charpoly()


def _at(field: Tower, coefficients: list[fmpq], x: Number) -> Number:
    total = field.zero
    for c in reversed(coefficients):
        total = total * x + fmpq(c)
    return total
