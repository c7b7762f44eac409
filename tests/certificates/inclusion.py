"""What a certificate claims, put to the test in floats: Filippov's inclusion by its definition, apart from all proofs.

F(x) is the hull of the values of the right-hand sides at places near x, so no surface and no cell need be known.  Euler
polygons choose a random member of F(x) at every step.  A claim that holds passes; one that fails clearly does not.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import cache
from operator import itemgetter
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import LSODA
from scipy.optimize import nnls

Array: TypeAlias = NDArray[np.float64]
Record: TypeAlias = dict[str, Any]
Values: TypeAlias = Mapping[str, Array]
Formula: TypeAlias = Callable[[Values], Any]

NEAR = 3  # places near a point at which the right-hand sides are taken
FINENESS = 0.03  # of a step, in distances from the point
STARTS, STEPS = 16, 200
NEARER = 0.1  # of a distance: nearer none comes from outside of a polygon
TIME, LONGEST = 0.02, 5.0  # a step and all of them, where steps are equal
SLOW = 1e18  # of a time: a solution of x' = x**9 that starts at 1/100 is gone by then
MOST_STEPS = 2000
WINDOW = 20  # equal steps, in which a polygon that slides to and fro moves as the solution does
PATIENT = 50  # times as long, where slides lead outward like y**3: none of the other polygons sees that

OPERATIONS: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.divide,
    ast.Pow: np.power,
}
FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sign": np.sign,
    "sgn": np.sign,
    "Abs": np.abs,
    "sqrt": np.sqrt,
    "sin": np.sin,
    "cos": np.cos,
    "tanh": np.tanh,
    "exp": np.exp,
    "atan": np.arctan,
    "relu": lambda v: np.maximum(v, 0.0),
    "sat": lambda v, low, high: np.maximum(low, np.minimum(high, v)),
    "Max": lambda *v: np.maximum.reduce(np.broadcast_arrays(*v)),
    "Min": lambda *v: np.minimum.reduce(np.broadcast_arrays(*v)),
}


@cache
def formula_of(text: str) -> Formula:
    """What a formula says, read once."""
    return formula_at(ast.parse(text.strip(), mode="eval"))


def formula_at(node: ast.AST) -> Formula:
    """Its value by those of its parts, node by node."""
    match node:
        case ast.Expression(body=body):
            return formula_at(body)
        case ast.Constant(value=number):
            found = float(str(number))
            return lambda at: found
        case ast.Name(id=name):
            return itemgetter(name)
        case ast.UnaryOp(op=op, operand=operand):
            own, sign = formula_at(operand), -1.0 if isinstance(op, ast.USub) else 1.0
            return lambda at: sign * own(at)
        case ast.BinOp(left=left, op=op, right=right):
            operation, first, second = OPERATIONS[type(op)], formula_at(left), formula_at(right)
            return lambda at: operation(first(at), second(at))
        case ast.Call(func=ast.Name(id=name), args=arguments):
            function, parts = FUNCTIONS[name], [formula_at(own) for own in arguments]
            return lambda at: function(*(part(at) for part in parts))
    raise ValueError(ast.dump(node))


def number(data: Any, generators: list[Any]) -> float:
    """A rational number, or a sum of products of generators."""
    if isinstance(data, str):
        return float(Fraction(data))
    return sum(float(Fraction(share)) * float(np.prod([generators[k] for k in factors])) for share, *factors in data)


def numbers_of(subject: Record) -> dict[str, Array]:
    """The irrational numbers of a subject by name: of each polynomial the largest real root."""
    found: dict[str, Array] = {}
    for entry in subject.get("numbers", []):
        coefficients = [number(own, list(found.values())) for own in entry["polynomial"]]
        roots = np.roots(coefficients[::-1])
        found[entry["name"]] = np.asarray(max(root.real for root in roots if abs(root.imag) < 1e-6))
    return found


class FloatInclusion:
    """``x' in F(x)`` about a point, in displacements z from it.

    Args:
        subject: of a certificate.
        seed: of the choices.
    """

    def __init__(self, subject: Record, seed: int) -> None:
        self.states, self.count = subject["states"], len(subject["states"])
        self.numbers = numbers_of(subject)
        self.at = np.array([number(own, list(self.numbers.values())) for own in subject["at"]])
        different = dict.fromkeys(map(tuple, subject["rhs"]))
        self.fields = [[formula_of(own) for own in side] for side in different]
        self.leaves_slowly = len(self.fields) > 1 and bool(SLOWLY_OUT.search(str(subject["rhs"])))
        self.random = np.random.default_rng(seed)

    def function(self, formula: str, z: Array) -> Array:
        """A formula in the displacements, at some of them (one per row)."""
        at = {**dict(zip(self.states, z.T, strict=True)), **self.numbers}
        found = formula_of(formula)(at)
        return np.broadcast_to(np.asarray(found, dtype=float), len(z)).copy()

    def corners(self, z: Array, radius: Array) -> Array:
        """Values of all right-hand sides at places near the displacements: shape (values, rows, states)."""
        near = z + radius[:, None] * self.random.uniform(-1, 1, (NEAR, *z.shape)) + self.at
        at = {**{name: near[..., k] for k, name in enumerate(self.states)}, **self.numbers}
        found = np.empty((NEAR, len(self.fields), *z.shape))
        for side, field in enumerate(self.fields):
            for k, own in enumerate(field):
                found[:, side, :, k] = own(at)
        return found.reshape(-1, *z.shape)

    def members(self, z: Array, radius: Array, *, outward: bool = False) -> Array:
        """One member of F at each place: a random one, often nearly a corner, or the one that leads outward most."""
        corners = self.corners(z, radius)
        if outward:
            best = np.argmax(np.einsum("jik,ik->ji", corners, z), axis=0)
            return np.asarray(corners[best, np.arange(len(z))])
        weights = self.random.dirichlet(np.full(len(corners), 0.3), len(z))
        return np.asarray(np.einsum("ij,jik->ik", weights, corners))

    def follow(self, starts: Array, steps: int = STEPS, *, outward: bool = False) -> tuple[Array, Array]:
        """Euler polygons from some displacements: places (times, rows, states) and times of each.

        Args:
            starts: one per row.
            steps: their number, each a share of the distance from the point.
            outward: whether they go outward where they can.
        """
        z, time = starts.copy(), np.zeros(len(starts))
        places, times = [z.copy()], [time.copy()]
        for _ in range(steps):
            size = np.linalg.norm(z, axis=1)
            v = self.members(z, 0.5 * FINENESS * size, outward=outward)
            speed = np.linalg.norm(v, axis=1)
            step = np.where(speed > 1e-60, FINENESS * size / (speed + 1e-300), 0.0)
            z, time = z + step[:, None] * v, time + step
            places.append(z.copy())
            times.append(time.copy())
        return np.stack(places), np.stack(times)

    def drift(self, starts: Array, furthest: float, longest: float = LONGEST) -> Array:
        """Distances along :meth:`slides`."""
        return np.asarray(np.linalg.norm(self.slides(starts, furthest, longest), axis=2))

    def slides(self, starts: Array, furthest: float, longest: float = LONGEST) -> Array:
        """Places along polygons with equal steps of time, which slide on surfaces; frozen beyond a distance.

        By the mean of two velocities (Heun): with the first alone polygons about a centre grow.
        """
        z, found = starts.copy(), [starts]
        first = np.linalg.norm(starts, axis=1)
        near = 0.1 * first
        for _ in range(int(longest / TIME)):
            v = self.members(z, near)
            step = np.minimum(TIME, 0.3 * first / (np.linalg.norm(v, axis=1) + 1e-300))
            step = np.where(np.linalg.norm(z, axis=1) < furthest, step, 0.0)[:, None]
            z = z + step / 2 * (v + self.members(z + step * v, near))
            found.append(z)
        return np.stack(found)

    def stiffly(self, starts: Array, furthest: float) -> float:
        """The largest distance along solutions of one field, by an implicit method: slow motion beside quick."""

        def velocity(_: float, z: Array) -> Array:
            at = dict(zip(self.states, z + self.at, strict=True)) | self.numbers
            return np.array([float(own(at)) for own in self.fields[0]])

        found = 0.0
        for start in starts:
            solver, steps = LSODA(velocity, 0.0, start, SLOW, rtol=1e-8, atol=1e-12), 0
            while solver.status == "running" and found < furthest and steps < MOST_STEPS:
                solver.step()
                found, steps = max(found, float(np.linalg.norm(solver.y))), steps + 1
        return found

    def sphere(self, radius: float) -> Array:
        """Starts at a distance."""
        drawn = self.random.normal(size=(STARTS, self.count))
        return radius * drawn / np.linalg.norm(drawn, axis=1)[:, None]

    def cube(self, half: float) -> Array:
        """Starts in a cube."""
        return self.random.uniform(-half, half, (8 * STARTS, self.count))


# Powers of more than one digit: too slow near the point for floats to see where they lead.
TOO_SLOW = re.compile(r"\*\* *[0-9]{2}")
# Powers above four beside faster motion: polygons in an inclusion that is blown up do not see that they lead outward.
SLOWLY_OUT = re.compile(r"\*\* *[5-9]")


def contradiction(statement: Record, half: float = 1.0, seed: int = 1) -> str:
    """What a statement says that is seen to be false, in one line; empty where nothing is.

    Args:
        statement: of a certificate.
        half: half the side of a cube on which the function that proves it is known.
        seed: of the choices.
    """
    if TOO_SLOW.search(str(statement["subject"]["rhs"])):
        return ""
    for claim in statement["claims"]:
        ((kind, said),) = claim.items()
        with np.errstate(all="ignore"):
            found = JUDGES[kind](FloatInclusion(statement["subject"], seed), said, half)
        if found:
            return f"{kind}: {found}"
    return ""


def half_width(hypotheses: Record) -> float:
    """Half the side of the cube of a theorem, the shortest of a box; one where it is all of the space."""
    known = hypotheses.get("local", hypotheses)
    known = known.get("hypotheses", known)
    within = known.get("cells", known).get("within")
    sides = within if isinstance(within, list) else [within]
    return 1.0 if within is None else min(float(Fraction(side)) for side in sides)


def judge_stability(own: FloatInclusion, said: str, half: float) -> str:
    """Polygons from a small sphere stay in the cube; where the point is unstable, some get farther away."""
    start = half / 10
    slid = own.drift(own.sphere(start), 100 * half).max()
    if said != "unstable":
        return f"a polygon gets from {start:.3g} to {slid:.3g}" if slid > 2 * half else ""
    if own.leaves_slowly:
        return ""
    far = slid
    for outward in (False, True):
        if far <= 2 * start:
            places, _ = own.follow(own.sphere(start), 2 * STEPS, outward=outward)
            far = max(far, float(np.linalg.norm(places, axis=2).max()))
    if far <= 2 * start:
        far = max(far, own.drift(own.sphere(start), 100 * half, PATIENT * LONGEST).max())
    if far <= 2 * start and len(own.fields) == 1:
        far = max(far, own.stiffly(own.sphere(start), 2.5 * start))
    return "" if far > 2 * start else f"no polygon gets farther than {far:.3g} from {start:.3g}"


def judge_equilibrium(own: FloatInclusion, said: bool, half: float) -> str:
    """Zero is no mixture of values near the point."""
    values = own.corners(np.zeros((50, own.count)), np.full(50, 1e-6)).reshape(-1, own.count)
    _, rest = nnls(np.vstack([values.T, np.ones(len(values))]), np.append(np.zeros(own.count), 1.0))
    return "0 is a mixture of the velocities" if rest < 1e-6 and not said else ""


def judge_region(own: FloatInclusion, said: Any, half: float) -> str:
    """Polygons from the region stay in it, and do not rise; from anywhere, where no region is named."""
    if said == "everywhere":
        starts = own.sphere(10.0)
        grown = own.drift(starts, 1e4)[-1].max() / 10
        if grown > 5:  # on the way back from far out, perhaps: its steps are short, those in proportion are not
            grown = np.linalg.norm(own.follow(starts, 4 * STEPS)[0][-1], axis=1).max() / 10
        return f"a polygon ends {grown:.3g} times as far" if grown > 5 else ""
    if "mesh" in said:
        return judge_mesh(own, said)
    half, level = float(Fraction(said["within"])), float(Fraction(said["below"]))
    starts = own.cube(half)
    starts = starts[levels(own, said, starts) < 0.95 * level][:STARTS]
    if not len(starts):
        return ""
    places, _ = own.follow(starts)
    if np.abs(places).max() > 1.05 * half:
        return f"a polygon from below {level} reaches {np.abs(places).max():.3g}"
    high = max(float(levels(own, said, here).max()) for here in places[:: STEPS // 20])
    return f"V gets {high:.3g} from below {level}" if high > 1.05 * level else ""


def judge_approach(own: FloatInclusion, said: Any, half: float) -> str:
    """Most polygons do not go on moving as fast as at first, by what they move in short times."""
    if isinstance(said, dict):
        outside = judge_region(own, said, half)
        if outside:
            return outside
        half = float(Fraction(said["within"]))
        starts = own.cube(half)
        values, level = levels(own, said, starts), float(Fraction(said["below"]))
        starts = starts[(0.5 * level < values) & (values < 0.95 * level)][:STARTS]  # not so small as polygons jitter
        if not len(starts):
            return ""
    else:
        starts = own.sphere(half / 10)
    places = own.slides(starts, 100 * half, 4 * LONGEST)[::WINDOW]
    moves = np.linalg.norm(np.diff(places, axis=0), axis=2)
    part = len(moves) // 3
    early, late = moves[:part].sum(axis=0), moves[-part:].sum(axis=0)
    goes_on = (late > 0.97 * early) & (moves.sum(axis=0) > 10 * np.linalg.norm(starts, axis=1))
    if 2 * goes_on.sum() <= len(starts):
        return ""
    return f"a polygon moves {early[goes_on][0]:.3g} at first, later {late[goes_on][0]:.3g}"


def judge_mesh(own: FloatInclusion, said: Any) -> str:
    """Polygons from simplices of a mesh in which W is below the level go no farther than the mesh, and end nearer."""
    mesh, level = said["mesh"], float(said["below"])
    corners = np.array([own.split(" ") for own in mesh["corners"]], dtype=float)
    corners[:, :-1] *= float(Fraction(mesh["unit"]))
    texts = mesh["triangles" if "triangles" in mesh else "tetrahedra"]
    chosen = np.array([own.split(" ") for own in texts], dtype=int)
    weights = own.random.dirichlet(np.ones(chosen.shape[1]), 8 * STARTS)
    drawn = np.einsum("ij,ijk->ik", weights, corners[own.random.choice(chosen, 8 * STARTS)])
    starts = drawn[drawn[:, -1] < level][:STARTS, :-1]
    if not len(starts):
        return ""
    furthest = float(np.linalg.norm(corners[:, :-1], axis=1).max())
    places, _ = own.follow(starts)
    sizes = np.linalg.norm(places, axis=2)
    if sizes.max() > 1.05 * furthest:
        return f"a polygon from the mesh reaches {sizes.max():.3g}, beyond {furthest:.3g}"
    stays = sizes[-1] > 0.9 * sizes[0]
    return f"a polygon gets from {sizes[0][stays][0]:.3g} to {sizes[-1][stays][0]:.3g}" if stays.any() else ""


def judge_outside(own: FloatInclusion, said: Record, half: float) -> str:
    """Polygons from places just to its right do not come to the point, which is to its left."""
    ring = np.array([place.split(" ") for place in said["corners"]], dtype=float) * float(Fraction(said["unit"]))
    if not np.linalg.norm(ring, axis=1).min() > 0:
        return "a corner at the point"
    chosen = own.random.integers(0, len(ring), 8 * STARTS)
    share = own.random.uniform(0, 1, (8 * STARTS, 1))
    starts = share * ring[chosen] + (1 - share) * ring[(chosen + 1) % len(ring)]
    turns = np.sum(ring[:, 0] * np.roll(ring[:, 1], -1) - ring[:, 1] * np.roll(ring[:, 0], -1)) > 0
    starts = 1.05 * starts if turns else starts + 0.05 * (ring.mean(axis=0) - starts)
    begin = np.linalg.norm(starts, axis=1)
    places, _ = own.follow(starts)
    sizes = np.linalg.norm(places, axis=2)
    least = np.where(np.isfinite(sizes), sizes, np.inf).min(axis=0) / begin
    return f"a polygon from outside comes to {least.min():.3g} of its distance" if least.min() < NEARER else ""


def judge_rate(own: FloatInclusion, said: Record, half: float) -> str:
    """Along polygons V falls as fast as is said, while they stay where it is said."""
    half = half if said["within"] is None else float(Fraction(said["within"]))
    top = float(Fraction(said["below"])) if "below" in said else np.inf
    starts = own.cube(half)
    starts = starts[levels(own, said, starts) < 0.9 * top][:STARTS]
    if not len(starts):
        return ""
    places, times = own.follow(starts, 100)
    stays = np.all(np.abs(places) <= half, axis=(0, 2))
    before, after = levels(own, said, places[0]), levels(own, said, places[-1])
    kappa, time = float(Fraction(said["kappa"])), times[-1]
    bound = before * np.exp(-kappa * time)
    if said["kind"] == "finite":
        bound = np.maximum(before - kappa * time, 0) + 0.1 * before
    if said["kind"] == "algebraic":
        bound = before / (1 + kappa * before * time)
    late = stays & (after > 1.3 * bound)
    return f"V falls to {after[late][0]:.3g} and not to {bound[late][0]:.3g}" if late.any() else ""


def judge_arrival(own: FloatInclusion, said: str, half: float) -> str:
    """Of polygons that come nearer by two tenths the second tenth takes less time than the first."""
    starts = own.sphere(half / 10)
    places, times = own.follow(starts, 4 * STEPS)
    sizes = np.linalg.norm(places, axis=2) / np.linalg.norm(starts, axis=1)
    arrived = sizes.min(axis=0) <= 0.01
    first, second = (times[np.argmax(sizes <= share, axis=0), np.arange(len(starts))] for share in (0.1, 0.01))
    slow = arrived & (second - first > 0.9 * first)
    return f"a polygon takes {first[slow][0]:.3g}, then {(second - first)[slow][0]:.3g}" if slow.any() else ""


def judge_gain(own: FloatInclusion, said: Record, half: float) -> str:
    """At places off all surfaces the derivative of V along ``v + d`` is that of the rate and ``gamma |d|`` at most."""
    half = half if said["within"] is None else float(Fraction(said["within"]))
    top = float(Fraction(said["below"])) if "below" in said else np.inf
    z, unit = own.cube(half), min(half, 1.0)
    before = levels(own, said, z)
    v = own.members(z, np.full(len(z), 1e-9 * unit))
    d = own.random.normal(size=z.shape)
    step = 1e-7 * unit
    slope = (levels(own, said, z + step * (v + d)) - before) / step
    fall = float(Fraction(said["kappa"])) * before ** {"finite": 0, "exponential": 1, "algebraic": 2}[said["kind"]]
    bound = float(Fraction(said["gamma"])) * np.linalg.norm(d, axis=1) - fall
    wrong = (before < top) & (slope > bound + 1e-3 * (1 + np.abs(bound)))
    return f"V rises at {slope[wrong][0]:.3g}, not {bound[wrong][0]:.3g}" if wrong.any() else ""


def levels(own: FloatInclusion, said: Record, z: Array) -> Array:
    """V at some displacements, from one formula or from pieces, each over the denominator where there is one."""
    if said.get("denominator") is not None:
        return levels(own, {**said, "denominator": None}, z) / own.function(said["denominator"], z)
    if isinstance(said["function"], str):
        return own.function(said["function"], z)
    found = np.full(len(z), np.nan)
    sides = np.array([np.sign(own.function(surface, z)) for surface in said["surfaces"]])
    for mark, formula in said["function"]:
        wanted = [(j, 1 if sign == "+" else -1) for j, sign in enumerate(mark) if sign != "."]
        here = np.all([sides[j] * sign >= 0 for j, sign in wanted], axis=0) if wanted else np.full(len(z), True)
        found[here] = own.function(formula, z)[here]
    return np.nan_to_num(found, nan=0.0)


JUDGES: dict[str, Callable[[FloatInclusion, Any, float], str]] = {
    "stability": judge_stability,
    "equilibrium": judge_equilibrium,
    "attracts": judge_region,
    "approaches": judge_approach,
    "outside": judge_outside,
    "rate": judge_rate,
    "arrives": judge_arrival,
    "gain": judge_gain,
}
