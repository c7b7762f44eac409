"""The studies of ``precision`` that follow no path: upper derivative, minimizers of the dissipation, derivation.

Each is a function from a scene to a plan: the reference, the trials (a method at a setting: work to time, and a judge
of its result) and the slopes that theory predicts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from itertools import combinations, islice
from typing import Any, TypeAlias

import numpy as np
import sympy
from flint import arb, arb_mat, ctx

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.contact_rule import CellRule, LimitedForces, rule_of
from nonsmooth.analysis.cells.filippov import cell_derivatives
from nonsmooth.analysis.cells.loads import load_regions, value_at
from nonsmooth.analysis.cells.partition import Partition, RefusalError
from nonsmooth.analysis.fields.contact_model import ContactModel, contact_model
from nonsmooth.analysis.measurements.harness import Assessment, Clock, LeftOut, Order, Study, StudyPlan, Trial
from nonsmooth.analysis.measurements.reference_paths import ball
from nonsmooth.analysis.minimizers.agreement import PointLocator
from nonsmooth.analysis.minimizers.box_minimizers import MAX_WHEELS, BoxEnumeration, BoxHighs
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.minimum import Functional, Minimizer, dissipation, proved
from nonsmooth.symbolic.mechanics.contact_states import ContactState, Row, scene_rows, solve_rows
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import XY
from nonsmooth.symbolic.numbers.plane_arrays import Floats, grid_points, row_products

# ---- the upper derivative ------------------------------------------------------------------------
#
# V* of ``V = |c - c*|^2`` is linear on every closed cell, so its largest value is attained on a face: a vertex
# (codimension 2), an edge (1) or a whole cell (0).  Of n random samples a share proportional to the k-th power of the
# distance comes that near to a face of codimension k, so the nearest one is n^(-1/k) away and its value as much too
# small: slope -1/k.  However many samples there are, the value is too small, so that no number of samples proves
# ``V* <= 0``.  A regular grid keeps half a spacing from a vertex at the centre, slope -1/2 in its number of points; on
# an edge it depends on how the edge lies.

SAMPLES = tuple(round(10**k) for k in (2, 2.5, 3, 3.5, 4, 4.5, 5, 5.5, 6))
SETS = 4  # of random samples: the mean of their errors scatters half as much as one
BLOCK, LARGE_BLOCK = 64, 1 << 15  # points between two looks at the clock; where no minimizer is sought


def build_upper_derivative(scene: Scene) -> StudyPlan:
    """The largest V* on the square: at the vertices of the cells, exactly, and sampled.

    Raises:
        LeftOut: where the rule has no cells, hence no exact V*.
    """
    centred, rule = scene.recentred(), rule_of(scene)
    try:
        partition = build_partition(centred)
    except RefusalError as error:
        raise LeftOut(f"no exact V*: {error}") from None
    if not isinstance(rule, CellRule):
        raise TypeError(f"required a rule with cells, received {rule.name}")
    exact, radius = largest_derivative(partition), scene.check.half_width

    def judge_exactly(found: Number) -> Assessment:  # a difference in floats would hide what is left of it
        same = found.field is exact.field and found == exact
        return Assessment(0.0 if same else abs(float(found) - float(exact)))

    def judge(found: Sequence[float]) -> Assessment:
        return Assessment(float(np.mean(np.abs(np.array(found) - float(exact)))))

    def sampled(sets: Sequence[Callable[[float], Floats]], clock: Clock) -> list[float]:
        return [_largest_sampled(rule, centred, points(radius), clock) for points in sets]

    trials = [Trial("exact cells", lambda clock: largest_derivative(build_partition(centred)), judge_exactly)]
    for count in SAMPLES:
        sets = [partial(_random_points, count, seed) for seed in range(SETS)]
        trials.append(Trial("random samples", partial(sampled, sets), judge, "samples", count, repeats=SETS))
    for count in SAMPLES:
        side = 2 * round(count**0.5 / 2)  # even: the centre itself is no midpoint
        trials.append(Trial("grid of samples", partial(sampled, [partial(_grid, side)]), judge, "samples", side**2))
    reference = f"max V* at the vertices of {len(partition.cells)} closed cells, exact"
    return StudyPlan(reference, tuple(trials), _sample_orders(partition))


def largest_derivative(partition: Partition) -> Number:
    """The largest V* over all closed cells, exactly."""
    return max(derivative.largest[0] for derivative in cell_derivatives(partition))


def codimension_of_largest(partition: Partition) -> int:
    """2 where the largest V* is attained at vertices only, 1 on an edge, 0 on a cell."""
    largest = largest_derivative(partition)
    codimensions = []
    for derivative in cell_derivatives(partition):
        attained = sum(rate == largest for rate in derivative.rates)
        codimensions.append(0 if attained == len(derivative.rates) else 3 - min(attained, 2))
    return min(codimensions)


def _sample_orders(partition: Partition) -> dict[str, Order]:
    codimension = codimension_of_largest(partition)
    if any(len(cell.states) > 1 for cell in partition.cells):
        random = grid = Order(None, "the rule ties: a sample sees one of several motions")
    elif codimension == 0:
        random = grid = Order(None, "the largest V* is attained on a whole cell, which every set of samples meets")
    elif codimension == 1:
        random = Order(-1.0, "the largest V* is attained along an edge only")
        grid = Order(None, "a grid meets an edge, or keeps half a spacing from it, as the edge happens to lie")
    else:
        random = grid = Order(-1 / 2, "the largest V* is attained at vertices only")
    return {"random samples": random, "grid of samples": grid}


def _largest_sampled(rule: CellRule, scene: Scene, points: Floats, clock: Clock) -> float:
    """The largest V* at some points."""
    block, largest = BLOCK if isinstance(rule, LimitedForces) else LARGE_BLOCK, -np.inf
    for start in range(0, len(points), block):
        clock.check()
        part = points[start : start + block]
        largest = max(largest, float(2 * row_products(rule.literal_twists(scene, part)[:, :2], part).max()))
    return largest


def _random_points(count: int, seed: int, radius: float) -> Floats:
    return np.random.default_rng([seed, count]).uniform(-radius, radius, (count, 2))


def _grid(side: int, radius: float) -> Floats:
    """Midpoints of side x side squares."""
    middles = radius * ((2 * np.arange(side) + 1) / side - 1)
    return grid_points(middles, middles)


UPPER_DERIVATIVE = Study(
    "upper-derivative",
    "upper derivative: largest V* on the square",
    "error of max V* [length²/time]",
    build_upper_derivative,
)

# ---- minimizers of the dissipation ---------------------------------------------------------------
#
# Under ``box`` the minimizing twist is exactly that of the cell which holds the point.  Under ``ellipse`` D is smooth
# and convex around its minimizer where no loaded wheel sticks: Newton's method in balls (python-flint) from a float
# answer ends at the only stationary point, and its residual gradient says how many digits hold.  Points where a wheel
# sticks, or where the minimizer is not unique, are left out: there D has a kink, and the twist is no number to compare
# with.  A linear program ends at a vertex: its simplex answer is right to rounding or wrong altogether, whatever
# tolerance it is given.

TWIST_ERROR = "twist error [length/time, rad/time]"
POINTS, FEWEST_POINTS = 12, 4  # at which the minimizers are compared; fewer are no comparison
TRIED = 60  # points from which they are taken
DIGITS = 60
BALL_BITS = 400  # 120 digits, of which the Hessian may cost half
RESIDUAL = arb(10) ** -(DIGITS + 10)  # of the gradient, which is a sum of weights of total one
IDENTITY = arb_mat([[1, 0], [0, 1]])
NEWTON_STEPS = 12  # six double the digits of a float answer beyond the precision
STICKS = 1e-6  # a slip relative to the fastest wheel below which the wheel may stick
SOLVER_TOLERANCES = tuple(10.0**-k for k in (2, 4, 6, 8, 10))  # HiGHS accepts none below 1e-10
VERTEX = Order(None, "the simplex method ends at a vertex: right to rounding, whatever the tolerance")
DIFFERENCES = Order(None, "the tolerance bounds a differenced gradient, which holds no more than eight digits")


@dataclass(frozen=True)
class ReferenceTwist:
    """A point, read exactly from floats, and the minimizing twist there in numbers of the field or in balls."""

    point: XY
    twist: tuple[Any, ...]

    def error(self, found: Floats) -> float:
        """Largest difference of an entry: formed exactly or in balls, then rounded."""
        with ctx.workprec(BALL_BITS):
            values = [arb(float(x)) if isinstance(self.twist[0], arb) else Fraction(float(x)) for x in found]
            return max(float(abs(exact - value)) for exact, value in zip(self.twist, values, strict=True))


def box_references(partition: Partition) -> tuple[ReferenceTwist, ...]:
    """The exact twists of rule ``box`` at points inside cells with one twist."""
    found = []
    for point in _points(partition.scene):
        cells = partition.cells_at(_exactly(partition.scene, point))
        if len(cells) == 1 and len(cells[0].twists) == 1:
            found.append(ReferenceTwist(point, cells[0].twists[0]))
    return tuple(found[:POINTS])


def ellipse_references(scene: Scene) -> tuple[ReferenceTwist, ...]:
    """The twists of rule ``ellipse`` to 60 digits at points where every loaded wheel slips.

    Raises:
        nonsmooth.analysis.cells.loads.LoadError: where the loads do not exist.
    """
    model, points = contact_model(scene), list(_points(scene))
    loads = loads_at(model, points)
    minima, regions = EllipseMinimizer().minimize(model, loads), load_regions(scene)
    slips = np.hypot(*np.moveaxis(model.slips(minima.twists), -1, 0))
    smooth = ((slips > STICKS * np.abs(model.targets).max()) | (loads == 0)).all(axis=1)
    found: list[ReferenceTwist] = []
    for k in np.flatnonzero(smooth & proved(minima)).tolist():
        place = _exactly(scene, points[k])
        region = next(r for r in regions if r.polygon.contains(place))
        with ctx.workprec(BALL_BITS):
            twist = _stationary(scene, [ball(value_at(form, place)) for form in region.forces], minima.twists[k])
        found += [] if twist is None else [ReferenceTwist(points[k], twist)]
        if len(found) == POINTS:
            break
    return tuple(found)


def _points(scene: Scene) -> Iterator[XY]:
    """Points of the checked square at random."""
    (x, y), radius = scene.check.place, scene.check.half_width
    for a, b in (np.random.default_rng(0).integers(-255, 256, (TRIED, 2)) / 256).tolist():
        yield x + radius * a, y + radius * b


def _exactly(scene: Scene, point: XY) -> tuple[Number, Number]:
    return scene.field(Fraction(point[0])), scene.field(Fraction(point[1]))


def _stationary(scene: Scene, loads: Sequence[arb], guess: Floats) -> tuple[arb, ...] | None:
    """Newton's method from a float answer on ``D(xi) = sum_i |A_i xi - b_i|``, two weighted rows for each loaded wheel.

    None where D has no curvature in some direction, as without friction across the rims: it has a kink then.
    """
    rows, groups = scene_rows(scene), []
    for wheel, load, pair in zip(scene.wheels, loads, zip(rows[::2], rows[1::2], strict=True), strict=True):
        if load > 0:
            limits = ball(wheel.friction.roll), ball(wheel.friction.side)
            weights = [load / ball(wheel.grip_length) * mu for mu in limits]
            matrix = [[w * ball(entry) for entry in row.normal] for w, row in zip(weights, pair, strict=True)]
            groups.append((arb_mat(matrix), arb_mat([[w * ball(r.rhs)] for w, r in zip(weights, pair, strict=True)])))
    twist = arb_mat([[arb(float(value))] for value in guess])
    for _ in range(NEWTON_STEPS):
        gradient, hessian = _derivatives(groups, twist)
        if all(abs(entry) < RESIDUAL for entry in gradient.entries()):
            return tuple(twist.entries())
        try:
            step = hessian.solve(gradient)
        except ZeroDivisionError:
            return None
        twist = arb_mat([[entry.mid()] for entry in (twist - step).entries()])
    raise ArithmeticError("required a stationary point of D near the float answer, received none")


def _derivatives(groups: Sequence[tuple[arb_mat, arb_mat]], twist: arb_mat) -> tuple[arb_mat, arb_mat]:
    """Gradient ``sum A^T u`` and Hessian ``sum A^T (1 - u u^T) A/|w|`` with ``w = A xi - b`` and ``u = w/|w|``."""
    gradient, hessian = arb_mat(3, 1), arb_mat(3, 3)
    for matrix, right in groups:
        w = matrix * twist - right
        size = sum((entry * entry for entry in w.entries()), arb(0)).sqrt()
        unit = w * (1 / size)
        gradient += matrix.transpose() * unit
        hessian += matrix.transpose() * (IDENTITY - unit * unit.transpose()) * matrix * (1 / size)
    return gradient, hessian


def build_box_minimizers(scene: Scene) -> StudyPlan:
    """Minimizing twists of rule ``box``, whatever the scene's own rule.

    Raises:
        LeftOut: where the loads do not exist in the square.
    """
    boxed = scene.under("box")
    try:
        partition = build_box_partition(boxed)
    except RefusalError as error:
        raise LeftOut(str(error)) from None
    points, judge = _compared(box_references(partition), "inside a cell with one twist")
    model, built = contact_model(boxed), PointLocator(partition)
    trials = [
        Trial(
            "explicit cells, with building them",
            lambda clock: PointLocator(build_box_partition(boxed)).twists(points),
            judge,
        ),
        Trial("explicit cells, built before", lambda clock: built.twists(points), judge),
    ]
    for tolerance in SOLVER_TOLERANCES:
        work = partial(_minimized, BoxHighs(tolerance), model, points)
        trials.append(Trial("HiGHS", work, judge, "tolerance", tolerance))
    if model.wheels <= MAX_WHEELS:
        trials.append(Trial("enumeration", partial(_minimized, BoxEnumeration(), model, points), judge))
    return StudyPlan(f"exact twist of the cell at {len(points)} points", tuple(trials), {"HiGHS": VERTEX})


def build_ellipse_minimizers(scene: Scene) -> StudyPlan:
    """Minimizing twists of rule ``ellipse``, whatever the scene's own rule.

    Raises:
        LeftOut: where the loads do not exist in the square, or a wheel sticks nearly everywhere.
    """
    try:
        references = ellipse_references(scene)
    except RefusalError as error:
        raise LeftOut(str(error)) from None
    points, judge = _compared(references, "where every loaded wheel slips")
    import scipy.optimize  # noqa: F401  # now, so that no measured time includes it

    model = contact_model(scene)
    trials = [Trial("smoothing", partial(_minimized, EllipseMinimizer(), model, points), judge)]
    for tolerance in SOLVER_TOLERANCES:
        work = partial(_by_bfgs, model, points, tolerance)
        trials.append(Trial("BFGS", work, judge, "tolerance", tolerance))
    reference = f"minimizer by Newton's method to {DIGITS} digits at {len(points)} points"
    return StudyPlan(reference, tuple(trials), {"BFGS": DIFFERENCES})


def _compared(references: Sequence[ReferenceTwist], where: str) -> tuple[Floats, Callable[[Floats], Assessment]]:
    """The points of references, and the judge of twists there."""
    if len(references) < FEWEST_POINTS:
        raise LeftOut(f"required {FEWEST_POINTS} points {where}, received {len(references)}")

    def judge(found: Floats) -> Assessment:
        return Assessment(max(reference.error(twist) for reference, twist in zip(references, found, strict=True)))

    return np.array([reference.point for reference in references]), judge


def _minimized(minimizer: Minimizer, model: ContactModel, points: Floats, clock: Clock) -> Floats:
    return minimizer.minimize(model, loads_at(model, points)).twists


def _by_bfgs(model: ContactModel, points: Floats, tolerance: float, clock: Clock) -> Floats:
    """SciPy's BFGS with differenced gradients, from rest: what one writes down first."""
    from scipy.optimize import minimize

    def minimizer_at(load: Floats) -> Floats:
        def value(twist: Floats) -> float:
            clock.check()
            return float(dissipation(Functional.ELLIPSE, model, load, twist))

        return np.asarray(minimize(value, np.zeros(3), method="BFGS", options={"gtol": tolerance}).x)

    return np.array([minimizer_at(load) for load in loads_at(model, points)])


BOX_MINIMIZERS = Study(
    "minimizers-box", "minimizers of D, rule box: largest error of a twist", TWIST_ERROR, build_box_minimizers
)
ELLIPSE_MINIMIZERS = Study(
    "minimizers-ellipse",
    "minimizers of D, rule ellipse: largest error of a twist",
    TWIST_ERROR,
    build_ellipse_minimizers,
)

# ---- derivation ----------------------------------------------------------------------------------
#
# The program solves three rows by cofactors over the scene's own number field.  Written down naively the same is
# SymPy's ``LUsolve`` with ``simplify``; in ball arithmetic (python-flint) it is a solve at a number of bits, each of
# which halves the radius; in floats it is NumPy's.  Floats and balls cannot tell a singular triple from a nearly
# singular one, so only triples that are known to be regular are solved here.

RowTriple: TypeAlias = tuple[Row, Row, Row]
Twists: TypeAlias = Sequence[Sequence[Any]]  # of floats, balls or SymPy's numbers

TRIPLES = 40  # of an array, evenly spread over all of them: four wheels have no more regular ones
UNIT_BITS = (53, 80, 107, 134, 161)
PRECISION = 320  # bits of the reference, 96 digits
SAME = arb(10) ** -DIGITS  # answers of SymPy are exact or wrong: what agrees to so many digits is called equal
HALVED = Order(1.0, "every bit halves the radius of the balls")


def build_derivation(scene: Scene) -> StudyPlan:
    """Twists of a sample of the array's regular row triples.

    Raises:
        LeftOut: for an array without regular triples.
    """
    sample = _regular_triples(scene)
    if not sample:
        raise LeftOut("no three rows of the array are independent")
    triples, states = zip(*sample, strict=True)
    with ctx.workprec(PRECISION):
        exact = [tuple(map(ball, state.twist)) for state in states]
    judge, by_field = partial(_judge_twists, exact), partial(_judge_residuals, triples)
    trials = [
        Trial("number field, cofactors", lambda clock: [solve_rows(rows) for rows in triples], by_field),
        Trial("SymPy, LUsolve and simplify", partial(_by_sympy, triples), partial(judge, digits=DIGITS)),
        Trial("NumPy, floats", partial(_by_numpy, triples), judge),
    ]
    trials += [Trial("balls", partial(_by_balls, triples, b), judge, "unit roundoff", 2.0**-b) for b in UNIT_BITS]
    reference = f"exact twists of {len(triples)} regular row triples, each put back into its rows"
    return StudyPlan(reference, tuple(trials), {"balls": HALVED}, rounding=10.0**-DIGITS)


def _regular_triples(scene: Scene) -> list[tuple[RowTriple, ContactState]]:
    """Regular triples with their states, evenly spread over all in lexicographic order."""
    rows = scene_rows(scene)
    total = len(rows) * (len(rows) - 1) * (len(rows) - 2) // 6
    every = max(1, total // (3 * TRIPLES // 2))  # a third of them may be singular
    solved = ((triple, solve_rows(triple)) for triple in islice(combinations(rows, 3), 0, None, every))
    return list(islice(((triple, state) for triple, state in solved if state is not None), TRIPLES))


def _by_sympy(triples: Sequence[RowTriple], clock: Clock) -> Twists:
    sympy.core.cache.clear_cache()  # every run pays for itself
    found = []
    for rows in triples:
        clock.check()
        matrix = sympy.Matrix([[entry.to_sympy() for entry in row.normal] for row in rows])
        found.append(sympy.simplify(matrix.LUsolve(sympy.Matrix([row.rhs.to_sympy() for row in rows]))))
    return found


def _by_numpy(triples: Sequence[RowTriple], clock: Clock) -> Twists:
    matrices = np.array([[row.normal for row in rows] for rows in triples], float)
    right = np.array([[float(row.rhs) for row in rows] for rows in triples])
    found: Twists = np.linalg.solve(matrices, right[..., None])[..., 0].tolist()
    return found


def _by_balls(triples: Sequence[RowTriple], bits: int, clock: Clock) -> Twists:
    found = []
    with ctx.workprec(bits):
        for rows in triples:
            matrix = arb_mat([[ball(entry) for entry in row.normal] for row in rows])
            found.append(matrix.solve(arb_mat([[ball(row.rhs)] for row in rows])).entries())
    return found


def _judge_twists(exact: Twists, found: Twists, digits: int | None = None) -> Assessment:
    """Largest distance of an entry (of its middle) from the exact value; 0 where so many digits agree."""

    def middle(value: Any) -> arb:
        if isinstance(value, sympy.Expr):
            return arb(str(value.evalf(DIGITS + 10)))
        return value.mid() if isinstance(value, arb) else arb(value)

    with ctx.workprec(PRECISION):
        pairs = [(a, b) for right, mine in zip(exact, found, strict=True) for a, b in zip(right, mine, strict=True)]
        gaps = [abs(a - middle(b)) for a, b in pairs]
        error = max(0.0 if digits and gap < SAME else float(gap.mid()) for gap in gaps)
    note = f"compared to {digits} digits" if digits else ""
    return Assessment(error, work={"triples": len(found)}, note=note)


def _judge_residuals(triples: Sequence[RowTriple], found: Sequence[ContactState]) -> Assessment:
    """The twists put back into their rows: exactly zero, or wrong."""
    residuals = [
        abs(float(row.residual(state.twist))) for rows, state in zip(triples, found, strict=True) for row in rows
    ]
    return Assessment(max(residuals), work={"triples": len(found)}, note="put back into their rows, exactly")


DERIVATION = Study("derivation", "derivation: largest error of a twist", TWIST_ERROR, build_derivation)
