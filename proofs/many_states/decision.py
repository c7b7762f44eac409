"""Strong stability of the checked point of a plain system in three states and more.

1. ``0`` must be in F at the point; otherwise every solution leaves it.
2. The linearization, where there is one; a relay of relative degree three or more
   (:mod:`nonsmooth.proofs.many_states.lyapunov_search`).
3. The V that the scene names, on the checked cube (:mod:`nonsmooth.proofs.many_states.examination`); a solution that
   leaves (:mod:`nonsmooth.proofs.kernel.escapes`), also along a ray that has no rational vector.
4. A V that is searched (:mod:`nonsmooth.proofs.many_states.lyapunov_search`); for a linearization whose eigenvalues all
   have negative real parts its own quadratic form on smaller cubes, if nothing else is proved.
5. A V that shows instability (:mod:`nonsmooth.proofs.many_states.lyapunov_search`).
6. An energy that is searched (:mod:`nonsmooth.proofs.many_states.weak_functions`).  By a V that does not increase the
   point attracts where nothing else stays where V does not fall (:mod:`nonsmooth.proofs.kernel.second_function`);
   otherwise it is ``stable``, and whether it attracts is left open.
7. What the kernel finds beside (:mod:`nonsmooth.proofs.kernel_strategies`).

Rays, fans and leading terms are used for two states only.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from fractions import Fraction
from functools import cached_property
from itertools import product

import numpy as np
from flint import ctx, fmpq, fmpq_mat, fmpq_poly

from nonsmooth.proofs.findings import Equilibrium, Translation
from nonsmooth.proofs.inequalities.linear_program import best_mixture, mixtures_to_zero
from nonsmooth.proofs.inequalities.real_roots import RealRoot, complex_roots, positive_roots
from nonsmooth.proofs.kernel.bases import quadratic_text
from nonsmooth.proofs.kernel.cells import (
    BeyondReachError,
    Field,
    SignCells,
    adjoining,
    build_cells,
    require_denominators,
)
from nonsmooth.proofs.kernel.first_terms import axis_factor, common_jacobian
from nonsmooth.proofs.kernel.written import rational_slopes, slopes
from nonsmooth.proofs.many_states.examination import ExaminedLyapunov, examine
from nonsmooth.proofs.many_states.lyapunov_search import LARGE, SCALES, find_lyapunov, high_degree_relay
from nonsmooth.proofs.sums_of_squares.conic_program import is_definite, simplest
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.proofs.systems.derivatives import Decrease, InvariantMotion
from nonsmooth.proofs.systems.findings import (
    KEPT,
    NOT_ATTRACTING,
    CheckedPoint,
    Finding,
    Method,
    Reach,
    falling_finding,
    weak_finding,
)
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.numbers.coefficients import as_fmpq
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.systems.switched_system import Enclosed, SwitchedSystem, with_known_numbers

# ---- what shows itself near the point in many states ---------------------------------------------
#
# Rays along which solutions leave, and linearizations.
#
# *A solution that leaves.* A cone with a linear field that holds an eigenvector of a positive eigenvalue holds a ray
# along which solutions leave: the columns of ``adj(s I - A)`` are eigenvectors at the roots of the characteristic
# polynomial, and the signs of polynomials at such a root are exact.  No certificate states such a ray where it has no
# rational vector and faster solutions leave beside it.  Where the right-hand sides only enclose the field it says
# nothing.
#
# *Linearization.* Where all fields at the point vanish there and have one Jacobian A, the field is ``A x`` up to higher
# order, and Lyapunov's indirect method applies.  Eigenvalues on the imaginary axis are roots of the greatest common
# divisor h of ``chi(s)`` and ``chi(-s)``, whose other roots come with their opposites; those of the other factor of chi
# have real parts that are not zero, which balls show.  Of a linear field with imaginary and stable eigenvalues the
# point is stable iff A is a zero of the polynomial in which the imaginary ones are taken once.


def escaping_rate(system: SwitchedSystem, cells: SignCells) -> Fraction | None:
    """A lower bound of the rate at which solutions leave along a ray in an open cone; None where none is found."""
    if system.only_encloses:
        return None
    near = [(j, form) for j, form in enumerate(cells.forms) if not form.at_origin]
    if any(form.degree != 1 for _, form in near):
        return None
    for cell in adjoining(cells):
        forms = [[as_fmpq(cell.signs[j] * slope) for slope in slopes(form)] for j, form in near]
        for field in cell.velocities:
            if _is_linear(field):
                for root in _rays(system, field, forms):
                    return root.low
    return None


def _is_linear(field: Field) -> bool:
    return all(sum(e) == 1 for part in field for e in part.terms)


def _rays(system: SwitchedSystem, field: Field, forms: Sequence[Sequence[fmpq]]) -> Iterator[RealRoot]:
    """Positive eigenvalues of a linear field with an eigenvector at which all forms are positive."""
    matrix = fmpq_mat([rational_slopes(part) for part in field])
    characteristic, adjugates = _resolvent(matrix)
    for root in positive_roots([system.field(c) for c in characteristic]):
        for column in range(len(field)):
            heights = [_height(system, adjugates, form, column) for form in forms]
            signs = {root.sign_of(height) for height in heights}
            if len(signs) == 1 and 0 not in signs:
                yield root
                break


def _height(system: SwitchedSystem, adjugates: Sequence[fmpq_mat], form: Sequence[fmpq], column: int) -> list[Number]:
    """A form at one column of the adjugate, as a polynomial in the eigenvalue, ascending."""
    values = (sum((f * m[i, column] for i, f in enumerate(form)), fmpq(0)) for m in reversed(adjugates))
    return [system.field(value) for value in values]


def _resolvent(matrix: fmpq_mat) -> tuple[list[fmpq], list[fmpq_mat]]:
    """The characteristic polynomial, ascending, and the coefficients of ``adj(s I - A)``, descending."""
    count = matrix.nrows()
    identity = fmpq_mat([[fmpq(i == j) for j in range(count)] for i in range(count)])
    coefficients, adjugates = matrix.charpoly().coeffs(), [identity]
    for value in coefficients[-2:0:-1]:
        adjugates.append(matrix * adjugates[-1] + identity * value)
    return coefficients, adjugates


PRECISION = 64  # bits with which eigenvalues are enclosed; doubled until the signs of their real parts are seen
DENOMINATORS = (1 << 3, 1 << 6, 1 << 12, 1 << 24)  # of a quadratic V, tried in turn


class Spectrum(StrEnum):
    """What is known of the eigenvalues of A."""

    HURWITZ = "all eigenvalues of the linearization have negative real parts"
    UNSTABLE = "an eigenvalue of the linearization has a positive real part"
    NEUTRAL = (
        "the field is linear; no eigenvalue is right of the imaginary axis, those on it have full sets of eigenvectors"
    )
    GROWING = "the field is linear; a multiple eigenvalue on the imaginary axis has too few eigenvectors"
    UNDECIDED = "the linearization has eigenvalues on the imaginary axis"


@dataclass(frozen=True)
class LinearPart:
    """The linearization at the point.

    Attributes:
        spectrum: what is known of the eigenvalues of A.
        quadratic: P of a V with ``A^T P + P A`` negative definite; None unless A is Hurwitz.
        is_whole: whether the field is ``A x`` in the whole space.
    """

    spectrum: Spectrum
    quadratic: fmpq_mat | None
    is_whole: bool


def linear_part(cells: SignCells) -> LinearPart | None:
    """The linearization; None where the field has none at the point."""
    fields = [field for cell in adjoining(cells) for field in cell.velocities]
    jacobian = common_jacobian(fields)
    if jacobian is None:
        return None
    matrix = fmpq_mat([list(map(as_fmpq, row)) for row in jacobian])
    linear = len(cells.cells) == 1 and all(map(_is_linear, fields))
    spectrum = spectrum_of(matrix, linear=linear)
    quadratic = _short_quadratic(matrix) if spectrum is Spectrum.HURWITZ else None
    return LinearPart(spectrum, quadratic, linear and cells.beyond and not cells.surfaces)


def spectrum_of(matrix: fmpq_mat, *, linear: bool) -> Spectrum:
    """On which sides of the imaginary axis the eigenvalues lie; of a linear field also what those on it do."""
    characteristic = matrix.charpoly()
    axis = axis_factor(characteristic)
    rest, once = characteristic // axis, axis // axis.gcd(axis.derivative())
    if 1 in _sides(rest) or not _has_imaginary_roots_only(once):
        return Spectrum.UNSTABLE
    if not axis.degree():
        return Spectrum.HURWITZ
    if not linear:
        return Spectrum.UNDECIDED
    return Spectrum.GROWING if (rest * once) % matrix.minpoly() else Spectrum.NEUTRAL


def _sides(polynomial: fmpq_poly) -> set[int]:
    """The signs of the real parts of all roots, of which none is zero."""
    precision = PRECISION
    while True:
        with ctx.workprec(precision):
            parts = [root.real for root in complex_roots(polynomial)]
        if not any(part.contains(0) for part in parts):
            return {1 if part > 0 else -1 for part in parts}
        precision *= 2


def _has_imaginary_roots_only(polynomial: fmpq_poly) -> bool:
    """Whether an even or odd polynomial with simple roots has them all on the imaginary axis.

    ``s^k g(s^2)``, with ``g(0)`` not zero, does iff all roots of g are real and negative.
    """
    values = polynomial.coeffs()
    first = next(k for k, c in enumerate(values) if c)
    return all(root.imag == 0 and root.real < 0 for root in complex_roots(fmpq_poly(values[first::2])))


def solve_lyapunov(matrix: fmpq_mat) -> fmpq_mat | None:
    """P with ``A^T P + P A = -I``; None where it is not unique."""
    size = matrix.nrows()
    system, right = fmpq_mat(size * size, size * size), fmpq_mat(size * size, 1)
    for i, j in product(range(size), repeat=2):
        for k in range(size):
            system[i * size + j, k * size + j] += matrix[k, i]
            system[i * size + j, i * size + k] += matrix[k, j]
        right[i * size + j, 0] = -int(i == j)
    try:
        return fmpq_mat(size, size, system.solve(right).entries())
    except ZeroDivisionError:
        return None


def _short_quadratic(matrix: fmpq_mat) -> fmpq_mat | None:
    """A solution of the inequality in short fractions, or the exact solution of the equation."""
    exact = solve_lyapunov(matrix)
    if exact is None:
        return None
    floats = np.array(exact.tolist(), dtype=float)
    floats /= np.abs(floats).max()
    for denominator in DENOMINATORS:
        candidate = fmpq_mat([[simplest(float(value), denominator) for value in row] for row in floats])
        if all(
            is_definite(form.tolist()) for form in (candidate, -(matrix.transpose() * candidate + candidate * matrix))
        ):
            return candidate
    return exact


# ---- the checked point and its strategies --------------------------------------------------------


SHOWN_BY_SPECTRUM = {
    Spectrum.UNSTABLE: Translation.UNSTABLE,
    Spectrum.GROWING: Translation.UNSTABLE,
    Spectrum.HURWITZ: Translation.ASYMPTOTICALLY_STABLE,
    Spectrum.NEUTRAL: Translation.STABLE,
}


class SpacePoint(CheckedPoint):
    """The checked point of a system in three states and more.

    Irrational numbers are enclosed between rational ones: what is found speaks of that system, and so of the stated
    one.
    """

    given: ExaminedLyapunov | None = None

    def __init__(self, system: SwitchedSystem) -> None:
        """Refuse denominators that may vanish.

        Raises:
            SceneError: for these.
        """
        require_denominators(system)
        self.system = with_known_numbers(system)

    @cached_property
    def cells(self) -> SignCells:
        """The cells of the first cube that is looked at.

        Raises:
            BeyondReachError: where none is.
        """
        return first_cells(self.system)

    @property
    def is_covered(self) -> bool:
        """Whether no root of a state is zero at the point: then none is on the cube, where time passes slower alone."""
        at = dict(zip(self.system.stated_states, self.system.check.equilibrium, strict=True))
        return self.system.by_roots is None or all(at[name] for name in self.system.by_roots.roots.rooted)

    @cached_property
    def linear(self) -> LinearPart | None:
        """The linearization."""
        return linear_part(self.cells)

    @property
    def spectrum(self) -> Spectrum | None:
        """What is known of the eigenvalues of the linearization."""
        return None if self.linear is None else self.linear.spectrum

    @cached_property
    def equilibrium(self) -> Equilibrium:
        """Whether 0 is in F: of the stated fields, where roots of states scale them."""
        try:
            if self.system.by_roots is not None:
                return decide_equilibrium(self.system.by_roots.unscaled, first_cells(self.system.by_roots.unscaled))
            return decide_equilibrium(self.system, self.cells)
        except BeyondReachError:
            return Equilibrium.UNDECIDED

    @property
    def open_reason(self) -> str:
        """What is said where nothing decides."""
        try:
            self.cells  # noqa: B018 - whether the system is looked at
        except BeyondReachError as error:
            return str(error)
        return "no Lyapunov function was found, and none that shows instability"

    def examine(self, formula: PiecewiseExpression, radius: Number, effort: Effort) -> ExaminedLyapunov | None:
        """A V with its conditions; None where it is not looked at."""
        try:
            return examine(self.system, formula, radius, effort=effort)
        except BeyondReachError:
            return None

    def reach(self, finding: Finding) -> Reach:
        """Whether every start of the space reaches the point."""
        if finding.verdict is not Translation.ASYMPTOTICALLY_STABLE:
            return Reach()
        try:
            linear = self.linear is not None and self.linear.is_whole
        except BeyondReachError:  # states that were decided by themselves
            linear = False
        forms = finding.function is not None and finding.function.is_homogeneous and self.system.by_roots is None
        return Reach(linear or forms)


def first_cells(scene: SwitchedSystem) -> SignCells:
    """The cells of the checked cube, or of the first smaller one that is looked at.

    Raises:
        BeyondReachError: where none is, with what is said of the checked cube.
    """
    reasons = []
    for scale in SCALES:
        try:
            return build_cells(scene, scene.check.radius * scale)
        except BeyondReachError as error:
            reasons.append(error)
    raise reasons[0]


def decide_equilibrium(scene: SwitchedSystem, cells: SignCells) -> Equilibrium:
    """Whether 0 is a mixture of the velocities at the point.

    Beside curved surfaces a pattern of signs may have no cell: then a mixture may be none of F, and nothing is claimed.
    Nor is it where numbers or unit vectors are enclosed, unless all velocities vanish.
    """
    near = adjoining(cells)
    velocities = {
        tuple(scene.field(part.at_origin) for part in velocity) for cell in near for velocity in cell.velocities
    }
    columns, target = mixtures_to_zero(sorted(velocities, key=str))
    if best_mixture(columns, target, [scene.field.zero] * len(columns)) is None:
        return Equilibrium.FAILS
    at_rest = not any(map(any, velocities))
    is_exact = {Enclosed.NUMBERS, Enclosed.UNITS}.isdisjoint(scene.rewriting.encloses)
    certain = at_rest or (is_exact and all(surface.degree == 1 for surface in cells.surfaces))
    return Equilibrium.HOLDS if certain else Equilibrium.UNDECIDED


# ---- what shows itself near the point --------------------------------------------------------------


def decide_no_equilibrium(point: SpacePoint) -> Finding | None:
    """No mixture of the velocities at the point is zero."""
    if point.equilibrium is not Equilibrium.FAILS:
        return None
    return Finding(Method.EQUILIBRIUM, Translation.UNSTABLE, "0 is not in F there, so every solution leaves it")


def decide_by_escape(point: SpacePoint) -> Finding | None:
    """A ray along which solutions leave."""
    rate = escaping_rate(point.system, point.cells)
    if rate is None:
        return None
    reason = "solutions leave along a ray inside a cone with a linear field"
    return Finding(Method.ESCAPE, Translation.UNSTABLE, reason, proofs=rate)


def decide_by_relay(point: SpacePoint) -> Finding | None:
    """A switching surface that shows instability by its relative degree."""
    relay = high_degree_relay(point.system, point.cells)
    if relay is None:
        return None
    order = f"derivative {relay.degree} of the switching function is the first that depends on its sign"
    reason = f"{order}, and a function of the others never falls"
    return Finding(Method.RELAY, Translation.UNSTABLE, reason, proofs=relay)


def decide_by_linearization(point: SpacePoint) -> Finding | None:
    """The eigenvalues of the linearization; a V may show more of a point that is stable."""
    spectrum = point.spectrum
    verdict = None if spectrum is None else SHOWN_BY_SPECTRUM.get(spectrum)
    if verdict is None:
        return None
    refutes = str(spectrum) if verdict is Translation.STABLE else ""
    reason = f"{NOT_ATTRACTING}{refutes}" if refutes else str(spectrum)
    final = verdict is Translation.UNSTABLE
    return Finding(Method.LINEARIZATION, verdict, reason, proofs=point.linear, refutes=refutes, is_final=final)


# ---- functions -------------------------------------------------------------------------------------


def decide_by_stated_function(point: SpacePoint) -> Finding | None:
    """The V of the scene; the sum of squares that nobody named is asked with little work."""
    return _by_stated_function(point, Effort.HASTY if point.system.check.is_default else Effort.FULL)


def search_function(point: SpacePoint) -> Finding | None:
    """A V that falls, unless that is known to be impossible."""
    if point.known.attraction_is_refuted:
        return None
    function = find_lyapunov(point.system) or _quadratic(point)
    return None if function is None else conclude_function(point, function)


def search_large_function(point: SpacePoint) -> Finding | None:
    """The same in large programs, after all that takes less time."""
    function = None if point.known.attraction_is_refuted else find_lyapunov(point.system, LARGE)
    return None if function is None else conclude_function(point, function)


def decide_by_sum_of_squares(point: SpacePoint) -> Finding | None:
    """The sum of squares that nobody named with all work, where nothing else is found."""
    spectrum, has_function = point.spectrum, point.known.function is not None
    if (
        not point.system.check.is_default
        or spectrum is Spectrum.HURWITZ
        or (spectrum is Spectrum.NEUTRAL and has_function)
    ):
        return None
    hasty = point.given
    finding = _by_stated_function(point, Effort.FULL)
    if finding is None or finding.is_final or point.known.function is None:
        return finding
    point.given = hasty  # which shows the same
    return None


def _by_stated_function(point: SpacePoint, effort: Effort) -> Finding | None:
    check = point.system.check
    point.given = point.examine(check.lyapunov, check.radius, effort) or point.given
    return None if point.given is None else conclude_function(point, point.given)


def _quadratic(point: SpacePoint) -> ExaminedLyapunov | None:
    """The quadratic form of a linearization whose eigenvalues all have negative real parts, on a smaller cube."""
    quadratic = None if point.linear is None else point.linear.quadratic
    if quadratic is None:
        return None
    doubled = (2 * quadratic).tolist()
    formula = parse_piecewise(quadratic_text(doubled, point.system.states), point.system.states)
    for scale in SCALES:
        examined = point.examine(formula, point.system.check.radius * scale, Effort.STRICT)
        if examined is not None and examined.decrease is Decrease.STRICT:
            return examined
    return None


def conclude_function(point: SpacePoint, function: ExaminedLyapunov) -> Finding | None:
    """What a V shows beside what is known; None where its conditions are not shown."""
    standing = point.known.standing
    if function.decrease is Decrease.STRICT:
        return falling_finding(function)
    if function.decrease is not Decrease.WEAK:
        return None
    if standing is not None and not standing.is_weak:
        return replace(standing, function=function)
    return weak_finding(function, KEPT if function.is_kept else "")


def decide_by_invariance(point: SpacePoint) -> Finding | None:
    """Whether solutions leave where the V that shows stability does not fall."""
    function = point.known.function
    entry = None if function is None else function.attraction(point.system)
    if entry is None:
        return None
    reason = f"{function.reason}, and {InvariantMotion.NONE}"
    return Finding(Method.INVARIANCE, Translation.ASYMPTOTICALLY_STABLE, reason, function, entry=entry)
