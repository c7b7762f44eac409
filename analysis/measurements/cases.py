"""The cases of ``stress``: stiff and extreme parameters, each row with its error against exact or 60-digit arithmetic.

A case is a function from a scene to rows: a range of parameters, what comes out at each, a reference and a criterion.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from itertools import chain

import numpy as np
from flint import arb_mat

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.loads import LoadError, elastic_loads_at
from nonsmooth.analysis.cells.partition import Partition, RefusalError
from nonsmooth.analysis.fields.constant_field import ConstantField, feedback_field
from nonsmooth.analysis.fields.contact_model import ContactModel, contact_model
from nonsmooth.analysis.fields.feedback_laws import corrected_law, gradient_law
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.loads.spring_loads import RESIDUAL
from nonsmooth.analysis.measurements.harness import EPSILON, Case, ResultRow, Rows, counted, judged, refused
from nonsmooth.analysis.measurements.reference_paths import (
    MeasuredField,
    ReferenceEnd,
    ball,
    follow_series,
    gradient_pieces,
    measured_array,
    measured_system,
    precision,
)
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import elastic_loads, loads_at
from nonsmooth.analysis.minimizers.minimum import GAP, Minimizer, dissipation
from nonsmooth.analysis.trajectories.result import EndReason, EventKind, Trajectory
from nonsmooth.analysis.trajectories.smooth_path import onto
from nonsmooth.analysis.trajectories.trajectory import follow_smooth, simulate
from nonsmooth.symbolic.mechanics.body import support_polygon
from nonsmooth.symbolic.mechanics.contact_states import Row, roll_row, side_row, solve_rows
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.mechanics.similar_scenes import moved, scaled, with_friction_ratio
from nonsmooth.symbolic.messages.scene_kind import SceneKind
from nonsmooth.symbolic.numbers.number_text import power_text
from nonsmooth.symbolic.numbers.plane import Pose
from nonsmooth.symbolic.numbers.plane_arrays import Floats, float_points, max_norm, norms
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem, scaled_system

POWERS = (-9, -6, -3, 3, 6, 9)  # of ten: other units of length or time
OFFSETS = (3, 6, 9)  # powers of ten, in units of length: places far from the origin

# ---- friction ratios -----------------------------------------------------------------------------
#
# Compared is the dissipation with the power of the forces that certify it, which no twist falls below: where friction
# along or across the rims nearly vanishes, the twist is almost free in a direction, and no minimizer can know it better
# than the square root of rounding.

TINY = Fraction(1, 10**12)
RATIOS: dict[str, Fraction] = {  # mu_S/mu_R
    "1e-12": TINY,
    "1e-6": Fraction(1, 10**6),
    "1 - 1e-12": 1 - TINY,
    "1": Fraction(1),
    "1 + 1e-12": 1 + TINY,
    "1e6": Fraction(10**6),
    "1e12": 1 / TINY,
}
MINIMIZERS: tuple[Minimizer, ...] = (BoxHighs(), EllipseMinimizer())
UNPROVEN = "its forces do not certify the minimum: they are so large that their rounding outweighs the gap"


def friction_rows(scene: Scene) -> Rows:
    """The least dissipation of both functionals at every ratio; a refusal where there are no loads."""
    (x, y), radius = scene.check.place, scene.check.half_width
    point = [[x + 0.3171 * radius, y + 0.2443 * radius]]  # a place of no symmetry
    for name, ratio in RATIOS.items():
        model = contact_model(with_friction_ratio(scene, ratio))
        try:
            loads = loads_at(model, point)
        except LoadError as refusal:
            yield refused("friction ratio", name, refusal, expected=True)
            return
        for minimizer in MINIMIZERS:
            case, found = f"friction ratio, {minimizer.functional} minimizer", minimizer.minimize(model, loads)
            rest = float(dissipation(minimizer.functional, model, loads[0], np.zeros(3)))
            if found.check()[0]:
                error, why = abs(float(found.gaps[0])) / (rest or 1.0), "the gap that certifies a minimum, of D at rest"
                yield judged(case, name, "certified by its forces", error, GAP, why=why)
            else:
                outweighed = float(max(ratio, 1 / ratio)) * EPSILON * rest > GAP * float(found.values[0])
                yield refused(case, name, UNPROVEN, expected=outweighed)


FRICTION = Case("minimizers", array=friction_rows)

# ---- loads ---------------------------------------------------------------------------------------
#
# Elastic loads where some of them go to zero, at centres of mass that approach the edge of the support polygon, against
# exact ones at the same float point.  Beyond the edge the body tips, and loads must be refused.

EDGE = "loads at the support edge"
DEPTHS = (1e-1, 1e-3, 1e-6, 1e-9, 1e-12)  # shares of the way from the edge to the middle of the wheels
BEYOND = (1e-9, 1e-3)  # shares of that way outside
ALONG = 0.3719  # share of the edge: a place of no symmetry


def support_rows(scene: Scene) -> Rows:
    """Loads towards the longest edge and beyond it; a refusal for wheels on one line."""
    model = contact_model(scene)
    middle = model.positions.mean(axis=0)
    hull = float_points(support_polygon(scene.positions))
    if len(hull) < 3:
        yield from _tipping(model, middle, "wheels on one line")
        return
    following = np.roll(hull, -1, axis=0)
    k = int(np.argmax(norms(following - hull)))
    edge = hull[k] + ALONG * (following[k] - hull[k])
    for depth in DEPTHS:
        yield _load_row(EDGE, power_text(depth), scene, edge + depth * (middle - edge))
    for depth in BEYOND:
        yield from _tipping(model, edge - depth * (middle - edge), f"{power_text(depth)} outside")


def _tipping(model: ContactModel, point: Floats, parameter: str) -> Rows:
    """Loads that must be refused."""
    try:
        loads = elastic_loads(model, point)
    except LoadError as refusal:
        yield refused(EDGE, parameter, refusal, expected=True)
    else:
        yield ResultRow(EDGE, parameter, f"loads {loads[0]}", ok=False, note="required a refusal")


def load_scale_rows(scene: Scene) -> Rows:
    """Loads in other units of length."""
    if len(support_polygon(scene.positions)) < 3:
        return
    for power in POWERS:
        larger = scaled(scene, Fraction(10) ** power)
        places = contact_model(larger).positions
        middle = places.mean(axis=0)
        point = middle + 0.2171 * (places[0] - middle) + 0.1443 * (places[1] - middle)
        yield _load_row("loads, geometry scale", f"1e{power}", larger, point)


def _load_row(case: str, parameter: str, scene: Scene, point: Floats) -> ResultRow:
    """Loads at a point; the condition is that of the moments of the loaded wheels, in units of the array's size."""
    model = contact_model(scene)
    try:
        x, y = (scene.field(Fraction(value)) for value in point.tolist())
        truth = elastic_loads_at(scene, (x, y))
    except LoadError as refusal:  # rounding has put the point outside
        return refused(case, parameter, refusal, expected=False)
    loads = elastic_loads(model, point)[0]
    error = max(abs(float(exact - Fraction(float(load)))) for exact, load in zip(truth, loads, strict=True))
    arms = model.positions - model.positions.mean(axis=0)
    moments = np.column_stack([np.ones(len(arms)), arms / np.abs(arms).max()])[loads > 0]
    condition = float(np.linalg.cond(moments)) if len(moments) > 2 else 1.0
    verdict = f"{int((loads > 0).sum())} wheels loaded, smallest load {loads[loads > 0].min():.2g}"
    bound = RESIDUAL + 16 * EPSILON * condition  # roundings of a sum of loads
    return judged(case, parameter, verdict, error, bound, condition=condition, why="stated residual, rounding")


LOADS = Case("loads", array=lambda scene: chain(support_rows(scene), load_scale_rows(scene)))

# ---- contact states close to singular ------------------------------------------------------------
#
# With both rows of wheel i and the roll row of wheel j the determinant is ``d_j . J(p_j - p_i)``: zero where the rim
# line of j passes through i, as with inward rims and wheels in line with the equilibrium.  Speeds grow like its
# inverse, and float elimination loses as many digits as the determinant has zeros; the exact solution, rounded once,
# loses none.

DETERMINANTS = (3, 6, 9, 12, 14)  # minus powers of ten, relative to the distance of the wheels


def nearly_in_line(scene: Scene, power: int) -> Scene:
    """The first two wheels on different places, the rim of the second turned to a determinant of ``10**-power``."""
    first, second = _two_wheels(scene)
    x, y = (a - b for a, b in zip(second.position, first.position, strict=True))
    t = Fraction(1, 2 * 10**power)
    cosine, sine = (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)  # rational: no new square roots
    turned = replace(second, direction=(x * cosine - y * sine, x * sine + y * cosine), given_speed=second.speed)
    return replace(scene, wheels=tuple(turned if wheel is second else wheel for wheel in scene.wheels))


def _two_wheels(scene: Scene) -> tuple[Wheel, Wheel]:
    first = scene.wheels[0]
    return first, next(wheel for wheel in scene.wheels if wheel.position != first.position)


def collinear_rows(scene: Scene) -> Rows:
    """The twist of the state of the two wheels, against elimination at 60 digits."""
    for power in DETERMINANTS:
        first, second = _two_wheels(nearly_in_line(scene, power))
        rows = (roll_row(first), side_row(first), roll_row(second))
        state = solve_rows(rows)
        if state is None:
            raise ValueError("required independent rows, received dependent ones")
        truth, condition = _by_elimination(rows)
        found = np.array(state.twist, float)
        error = max_norm(found - truth) / (max_norm(truth) or 1.0)
        said, why = f"omega = {found[2]:.6g}", "exact and rounded once, whatever the condition"
        case, bound = "wheels nearly in line, twist", 4 * EPSILON
        yield judged(case, f"1e-{power}", said, error, bound, condition=condition, why=why)


def _by_elimination(rows: Sequence[Row]) -> tuple[Floats, float]:
    """Twist at 60 digits, and the condition of the rows of unit length."""
    with precision():
        lengths = [ball(row.wheel.grip_length) for row in rows]
        matrix = [[ball(a) / length for a in row.normal] for row, length in zip(rows, lengths, strict=True)]
        right = [[ball(row.rhs) / length] for row, length in zip(rows, lengths, strict=True)]
        twist = np.array([float(x.mid()) for x in arb_mat(matrix).solve(arb_mat(right)).entries()])
        entries = np.array([[float(entry.mid()) for entry in row] for row in matrix])
    scale = np.abs(entries).max(axis=0)
    return twist, float(np.linalg.cond(entries / np.where(scale > 0, scale, 1.0)))


COLLINEAR = Case("contact states", array=collinear_rows)

# ---- paths ---------------------------------------------------------------------------------------

START = (0.6171, 0.3443)  # in units of the square's half-width: a place of no symmetry
ROUNDINGS = 64  # along a path


@lru_cache(maxsize=1)
def cells_of(scene: Scene) -> Partition | RefusalError:
    """The cells of an array, or why there are none; several cases ask for them one after the other."""
    try:
        return build_partition(scene)
    except RefusalError as refusal:
        return refusal


def measured_fields(scene: Scene | SwitchedSystem, kinematics: Kinematics) -> list[MeasuredField]:
    """The field of a scene; none where a contact rule has no cells, which the case of scales says once."""
    if scene.kind is SceneKind.SYSTEM:
        return [measured_system(scene)]
    cells = cells_of(scene)
    return [] if isinstance(cells, RefusalError) else [measured_array(cells, kinematics)]


def _amplification(measured: MeasuredField, start: Sequence[float], until: float, probe: float) -> float:
    """Largest growth, at least one, of a displacement of the start by ``probe`` (length) along an axis."""
    here = simulate(measured.field, start, until).end.state
    growth = [1.0]
    for move in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)):
        displaced = [x + probe * m for x, m in zip(start, move, strict=False)]
        try:
            there = simulate(measured.field, displaced, until).end.state
        except ValueError:  # beyond the border of the domain
            continue
        growth.append(measured.distance(here, there) * measured.radius / probe)
    return max(growth)


def _path_row(
    measured: MeasuredField,
    case: str,
    parameter: str,
    start: Sequence[float],
    probe: float,
    why: str,
    offset: float = 1.0,
) -> tuple[ResultRow, float, Trajectory]:
    """A path against its reference, with the bound on its error: rounding and slack grow by its amplification.

    Coordinates far from the origin share digits, which are lost; ``offset`` is how many half-widths away they are.
    """
    reached = measured.reached(start, measured.span)
    until, truth = (reached.time, reached.state) if reached.time > 0 else (measured.span, tuple(start))
    path = simulate(measured.field, start, until)
    condition = offset * _amplification(measured, start, until, probe)
    slack = measured.slack / measured.radius / offset
    bound = 2 * condition * (ROUNDINGS * EPSILON + slack) + measured.step_error
    error = measured.distance(path.end.state, truth)
    row = judged(case, parameter, str(path.end.reason), error, bound, condition=condition, why=why)
    return row, bound, path


# Other units and far from the origin: a scaled field has scaled paths, so the error in half-widths must not depend on
# the scale.


def array_scale_rows(scene: Scene) -> Rows:
    """An array in other units of length, and far from the origin; one refusal for all paths without cells."""
    cells = cells_of(scene)
    if isinstance(cells, RefusalError):
        yield refused("paths", f"rule {scene.contact.rule}", cells, expected=True)
        return
    similar = [("geometry scale, path", power, scaled(scene, Fraction(10) ** power)) for power in POWERS]
    similar += [("far from the origin, path", n, moved(scene, Fraction(10) ** n, Fraction(0))) for n in OFFSETS]
    for case, power, other in similar:
        yield _scale_row(case, power, measured_array(build_partition(other), Kinematics.LEADING))


def system_scale_rows(scene: SwitchedSystem) -> Rows:
    """A plain system in other units of length and of time."""
    for power in POWERS:
        larger = scaled_system(scene, length=Fraction(10) ** power)
        yield _scale_row("state scale, path", power, measured_system(larger))
    for power in POWERS:
        faster = scaled_system(scene, speed=Fraction(10) ** power)
        yield _scale_row("time scale, path", power, measured_system(faster))


def _scale_row(case: str, power: int, measured: MeasuredField) -> ResultRow:
    offset = max(abs(x) for x in measured.centre) / measured.radius + 1
    probe, why = max(measured.slack, 1e-7 * measured.radius), "rounding and slack times amplification"
    return _path_row(measured, case, f"1e{power}", measured.place(*START), probe, why, offset)[0]


SCALES = Case("scales", array=array_scale_rows, system=system_scale_rows)

# Starts next to a switching surface and next to the checked point: one closer than the slack is moved onto the surface.
# Beside a repelling surface that is another solution: then the path has to say that it is not unique.

DISTANCES = (1e-9, 1e-12)  # in half-widths
ANGLES = (0.3, 1.9, 3.7, 5.1)  # directions from the checked point, radians
MOST_SURFACES = 6  # surfaces beside which paths start
RESOLVED = 1e-3  # in half-widths: a larger bound asks nothing
SAID = "the start counts as on a surface, and the path says at once that others leave it"


def start_rows(measured: MeasuredField, case: str) -> Rows:
    """Paths from beside every surface (some of them) and from beside the checked point."""
    for number, (point, normal) in enumerate(beside_surfaces(measured), 1):
        side = 1 if number % 2 else -1
        for distance in DISTANCES:
            parameter = f"surface {number}, {power_text(distance)}"
            yield _start_row(measured, case, parameter, point, distance * (side * normal))
    for angle in ANGLES:
        move = DISTANCES[-1] * np.array([math.cos(angle), math.sin(angle)])
        parameter = f"{power_text(DISTANCES[-1])} at {angle} rad"
        yield _start_row(measured, case, parameter, np.array(measured.centre), move)


def _start_row(measured: MeasuredField, case: str, parameter: str, point: Floats, move: Floats) -> ResultRow:
    start = (*(point + measured.radius * move).tolist(), *measured.place(0, 0)[2:])
    why = "slack and rounding times amplification"
    row, bound, path = _path_row(measured, case, parameter, start, measured.slack, why)
    if (row.ok and bound <= RESOLVED) or not any(
        event.kind is EventKind.NONUNIQUE and not event.t for event in path.events
    ):
        return row
    ok = row.error is not None and math.isfinite(row.error)
    return replace(row, outcome="not unique, as it says", ok=ok, note=SAID)


def beside_surfaces(measured: MeasuredField) -> list[tuple[Floats, Floats]]:
    """Points on surfaces with unit normals: middles of edges, or points of plain systems' surfaces."""
    field = measured.field
    found = list(_edge_middles(field) if isinstance(field, ConstantField) else _surface_points(measured, field))
    return found[:: max(1, len(found) // MOST_SURFACES)][:MOST_SURFACES]


def _edge_middles(field: ConstantField) -> Iterator[tuple[Floats, Floats]]:
    for number, edge in enumerate(field.cells.edges):
        if edge.left is not None and edge.right is not None:
            a, b = field.cells.direction(number)
            start, end = (np.array(field.cells.points[k]) for k in (edge.start, edge.end))
            yield 0.55 * start + 0.45 * end, np.array([-b, a])


def _surface_points(measured: MeasuredField, field: SignField) -> Iterator[tuple[Floats, Floats]]:
    for surface in field.surfaces:
        for seed in (START, (-0.5317, 0.4129)):
            point = onto(np.array(measured.place(*seed)), [surface], measured.radius)
            if max_norm(point) <= measured.radius:
                gradient = surface.gradient(point)
                yield point, gradient / np.hypot(*gradient)
                break


def _array_start_rows(scene: Scene) -> Rows:
    for kinematics, case in ((Kinematics.LEADING, "start, leading order"), (Kinematics.EXACT, "start, exact pose")):
        for measured in measured_fields(scene, kinematics):
            yield from start_rows(measured, case)


STARTS = Case("starts", _array_start_rows, lambda scene: start_rows(measured_system(scene), "start"))

# Paths followed for very long: a million crossings of the square, or as long as there are events left.

SPANS, SMOOTH_SPANS = 1e6, 1e2  # duration, in times that it takes to cross the square; the second by integration


def long_rows(scene: Scene | SwitchedSystem) -> Rows:
    """The scene's own path; one that ends with the largest number of events says so, and ends in finite numbers."""
    return map(_long_row, measured_fields(scene, Kinematics.LEADING))


def _long_row(measured: MeasuredField) -> ResultRow:
    spans = SPANS if isinstance(measured.field, ConstantField) else SMOOTH_SPANS
    start, until = measured.place(*START), spans * measured.span
    path = simulate(measured.field, start, until)
    case, parameter = "path followed for long", f"{power_text(spans)} crossings"
    verdict = f"{path.end.reason}, {counted(len(path.events), 'event')}"
    if path.end.reason is EndReason.EVENTS:
        ok = all(math.isfinite(float(value)) for value in path.end.state)
        return ResultRow(case, parameter, verdict, ok=ok, note="a clear end: no endless loop, no invented limit")
    reached, why = ReferenceEnd(float(path.end.t), path.end.state), "it ends"
    if measured.exact is not None:
        reached = measured.reached(start, min(until, reached.time))
        why = "rounding of the time times the speed"
    growth = max(1.0, reached.time / measured.span)
    bound = ROUNDINGS * EPSILON * growth + measured.slack / measured.radius + measured.step_error
    error = measured.distance(path.at(reached.time), reached.state)
    return judged(case, parameter, verdict, error, bound, condition=growth, why=why)


SWITCHES = Case("switches", array=long_rows, system=long_rows)

# ---- feedback of extreme gain --------------------------------------------------------------------
#
# The closed loop of gain k is that of gain one in a time k times as short.  The gradient law is linear on every cell
# (leading-order kinematics), so its path is known at 60 digits over its first crossings.  The corrected law is followed
# over the same span of time whatever the gain: at high gain it is stiff, the integrator turns implicit, and the pose
# must be where gain one takes it after k times as long.

GAINS = (1e-6, 1e-3, 1.0, 1e3, 1e6, 1e8)
UNTIL = 2.0  # the same for all gains
PLACE = (0.4171, 0.2443, 0.3)  # start in half-widths, and theta
COMPARISONS = 25  # moments
TURNS = 1.0  # duration in times 1/k over which the linear loop is compared
COMPARED = 6.0  # durations 1/k over which the corrected law is compared with gain one
MOST_EVENTS = 400  # after which a loop that keeps switching ends, as it says
ACCURACY = 1e-10  # relative to the start: a hundred steps of 1e-12


def feedback_rows(partition: Partition) -> Rows:
    """Both laws at every gain; one refusal where the rule leaves no two inputs."""
    try:
        slow = _corrected(partition, 1.0, COMPARED)
    except ValueError as refusal:
        yield refused("feedback gain, corrected law", "any", refusal, expected=True)
        return
    for gain in GAINS:
        yield _gradient_row(partition, gain)
        yield _corrected_row(partition, gain, slow)


def _feedback_start(partition: Partition) -> Pose:
    (x, y), radius = partition.scene.check.place, partition.scene.check.half_width
    return x + PLACE[0] * radius, y + PLACE[1] * radius, PLACE[2]


def _gradient_row(partition: Partition, gain: float) -> ResultRow:
    start, weight = _feedback_start(partition), partition.scene.check.length**2
    reference = follow_series(gradient_pieces(partition, gain, weight), start, TURNS / gain)
    law = gradient_law(gain, weight=float(weight))
    path = simulate(feedback_field(partition, law, Kinematics.LEADING), start, reference.time)
    gaps = [abs(float(a) - b) for a, b in zip(path.end.state, reference.state, strict=True)]
    verdict = f"{counted(reference.crossings, 'crossing')}: {path.end.reason}"
    error, why = max(gaps) / max(map(abs, start)), "a hundred steps of the integrator"
    return judged("feedback gain, gradient law", power_text(gain), verdict, error, ACCURACY, why=why)


def _corrected(partition: Partition, gain: float, until: float) -> Trajectory:
    law = corrected_law(gain, float(partition.scene.check.length))
    field = feedback_field(partition, law, Kinematics.EXACT)
    return follow_smooth(field, _feedback_start(partition), until, max_events=MOST_EVENTS)


def _corrected_row(partition: Partition, gain: float, slow: Trajectory) -> ResultRow:
    """Compared as long as both last; later the pose must not have grown."""
    path = _corrected(partition, gain, UNTIL)
    verdict = f"{counted(len(path.times), 'step')}, {path.method}: {path.end.reason}"
    common = np.linspace(0, min(float(slow.end.t), gain * float(path.end.t)), COMPARISONS)
    error = max_norm(path.sample(common / gain) - slow.sample(common))
    if path.end.reason is EndReason.TIME and slow.end.reason is EndReason.TIME and gain * UNTIL > COMPARED:
        x, y = partition.scene.check.place
        last, before = (np.hypot(*(np.array(p.end.state[:2]) - (x, y))) + abs(p.end.state[2]) for p in (path, slow))
        error = max(error, float(last - before))
    error /= max(map(abs, _feedback_start(partition)))
    why = "gain one, k times as long"
    return judged("feedback gain, corrected law", power_text(gain), verdict, error, ACCURACY, why=why)


def _array_feedback_rows(scene: Scene) -> Rows:
    cells = cells_of(scene.recentred())  # the laws lead to the origin, which is to be the checked point
    if isinstance(cells, RefusalError):
        yield refused("feedback gain", f"rule {scene.contact.rule}", cells, expected=True)
    else:
        yield from feedback_rows(cells)


FEEDBACK = Case("feedback", array=_array_feedback_rows)
