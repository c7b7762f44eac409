"""Places of rest of tables drawn within tolerances: a sample, beside what is proved for all of them.

Each number of each wheel is drawn on its own, evenly within its tolerance: positions, the turn of the wheel with its
friction axis, its speed and both coefficients of friction.  The body is one without inertia under the scene's friction
forces, on the wheels that carry it at the checked pose, at the checked heading: the motion turns in the world with the
body only where other wheels come under it.

Its place of rest solves ``c'(c) = 0``, two equations, in which c' is the rate that paths follow
(:class:`nonsmooth.analysis.bodies.set_motion.ContactSets`).  Broyden's method starts at that of the table as drawn,
whose slope A it takes from differences; a place counts as found where the rate is at most :data:`RESTS` of the fastest
rim, and as one that attracts where both eigenvalues of its A have negative real parts.  All of it is floats: nothing
here is proved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

import numpy as np

from nonsmooth.analysis.bodies.set_motion import ContactSets, TippedError
from nonsmooth.analysis.cells.contact_rule import has_cells, smooth_rule_of
from nonsmooth.analysis.fields.contact_model import ContactModel, contacts_under
from nonsmooth.analysis.minimizers.float_loads import FLOATS
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.symbolic.mechanics.contact_set import standing
from nonsmooth.symbolic.mechanics.friction_set import float_sets
from nonsmooth.symbolic.mechanics.scene import Scene, Tolerance
from nonsmooth.symbolic.mechanics.springs import MeasuredTable
from nonsmooth.symbolic.messages.under_way import tell_count
from nonsmooth.symbolic.numbers.plane_arrays import Floats, max_norm, norm, norms, turned

RESTS = 1e-7  # of the fastest rim
STEPS = 40  # of Broyden's method
DIFFERENCE = 1e-5  # of the scene's length: for slopes
SHARES = 10**9  # draws are whole parts of it: friction sets are built of exact numbers


@dataclass(frozen=True)
class SampledTables:
    """Where bodies rest on tables that were drawn.

    Attributes:
        names: the tolerances that were drawn, of :class:`nonsmooth.symbolic.mechanics.scene.Tolerance`.
        places: of rest (m, 2), in the scene's coordinates; not a number where none was found that attracts.
        nominal: that of the table as drawn.
        point: the checked one.
    """

    names: tuple[str, ...]
    places: Floats
    nominal: Floats
    point: Floats

    @cached_property
    def distances(self) -> Floats:
        """Of the places from the checked point (m,); infinite where none was found."""
        return _distances(self.places, self.point)

    @property
    def missing(self) -> int:
        """Tables without a place of rest that was found and attracts."""
        return int(np.isinf(self.distances).sum())

    def within(self, share: float) -> float:
        """The least distance within which at least this share of the tables ends; infinite where too many are missing.

        Raises:
            ValueError: for a share that is not in (0, 1].
        """
        if not 0 < share <= 1:
            raise ValueError(f"required a share in (0, 1], received {share}")
        return _least_within(self.distances, share)

    def moved(self, share: float) -> float:
        """The same of distances from where the table as drawn ends."""
        return _least_within(_distances(self.places, self.nominal), share)


def _distances(places: Floats, point: Floats) -> Floats:
    """Of places (m, 2) from a point, (m,); infinite of what is no number."""
    away = norms(places - point)
    return np.where(np.isfinite(away), away, np.inf)


def _least_within(distances: Floats, share: float) -> float:
    """The least distance within which a share of them lies."""
    return float(np.sort(distances)[int(np.ceil(share * len(distances) - 1e-9)) - 1])


def why_not_sampled(scene: Scene) -> str:
    """Why tables of a scene are not drawn; empty where they are."""
    if scene.tolerances is None:
        return "the scene states no tolerances"
    if has_cells(scene):
        return f"rule {scene.contact.rule}"
    if scene.tolerances.centre_of_mass:
        return "one of the centre of mass, which is not drawn"
    return ""


def nominal_model(scene: Scene) -> ContactModel:
    """The table as drawn."""
    return contacts_under(smooth_rule_of(scene), scene)


def drawn_model(scene: Scene, box: Tolerance, generator: np.random.Generator) -> ContactModel:
    """One table within a box.  Draws of all entries are made whichever of them are zero: equal seeds, equal draws."""
    model, count = nominal_model(scene), len(scene.wheels)
    draws = generator.integers(-SHARES, SHARES, size=(6, count), endpoint=True)
    shares = draws / SHARES
    positions = model.positions + float(box.position) * shares[:2].T
    turns = np.pi * float(box.heading) * shares[2]
    cosines, sines = np.cos(turns)[:, None], np.sin(turns)[:, None]
    axes, rims = (cosines * vectors + sines * turned(vectors) for vectors in (model.axes, model.rims))
    frames = np.stack([axes, turned(axes)], axis=1)
    moments = frames @ turned(positions)[..., None]
    speeds = model.speeds * (1 + float(box.speed) * shares[3])
    rule, sets = smooth_rule_of(scene), []
    for wheel, roll, side in zip(scene.wheels, draws[4].tolist(), draws[5].tolist(), strict=True):
        friction = replace(
            wheel.friction,
            roll=wheel.friction.roll * (1 + box.mu_roll * Fraction(roll, SHARES)),
            side=wheel.friction.side * (1 + box.mu_side * Fraction(side, SHARES)),
        )
        sets.append(rule.friction_set(friction))
    rounded, loads = float_sets(sets), scene.contact.loads
    if isinstance(loads, MeasuredTable) and model.load_table is not None:
        forms = loads.under([(1.0, x, y) for x, y in positions.tolist()], FLOATS)
        model = replace(model, load_table=None if forms is None else np.array(forms))
    return replace(
        model,
        rows=np.concatenate([frames, moments], axis=2).reshape(-1, 3),
        targets=model.targets_of(speeds),
        positions=positions,
        rims=rims,
        friction=np.column_stack([rounded.along, rounded.across]).reshape(-1),
        cuts=rounded.cut,
    )


def sample_tables(scene: Scene, count: int, seed: int, names: Sequence[str] = ()) -> SampledTables:
    """Draw tables, and find where bodies rest on each.

    Args:
        scene: with tolerances, under a rule with friction sets.
        count: how many tables.
        seed: equal seeds draw the same tables.
        names: the tolerances that are drawn, the others being zero; all of them unless given.

    Raises:
        TipsError: where a body with an outline does not stand at the checked pose.
        ValueError: for a scene of which tables are not drawn, and one whose own place of rest is not found.
    """
    refused, box = why_not_sampled(scene), scene.tolerances
    if refused or box is None:
        raise ValueError(refused)
    scene, chosen = standing(scene), tuple(names) or box.names
    for name in box.names:
        box = box if name in chosen else box.without(name)
    point = np.array(scene.check.place)
    length = float(scene.check.length)
    nominal = find_rest(nominal_model(scene), point, length)
    if nominal is None:
        raise ValueError("no place of rest that attracts is found near the checked point of the table as drawn")
    start, slope = nominal
    generator, places = np.random.default_rng(seed), np.full((count, 2), np.nan)
    for k in range(count):
        tell_count(k, count, "tables")
        found = find_rest(drawn_model(scene, box, generator), start, length, slope)
        if found is not None:
            places[k] = found[0]
    return SampledTables(chosen, places, start, point)


def find_rest(
    model: ContactModel, start: Floats, length: float, slope: Floats | None = None
) -> tuple[Floats, Floats] | None:
    """A place of rest that attracts, with its slope A; None where none is found.

    Args:
        model: with its friction sets.
        start: where Broyden's method begins (2,).
        length: the scene's, for differences.
        slope: of a table nearby (2, 2); by differences at the start unless given.
    """
    sets, wheels = ContactSets(model), frozenset(range(model.wheels))
    fastest, step = max_norm(model.speeds), DIFFERENCE * length

    def rate(place: Floats) -> Floats:
        return sets.rate(wheels, np.array([*place, 0.0]))[:2]

    def slope_at(place: Floats) -> Floats:
        return np.column_stack([rate(place + way) - rate(place - way) for way in step * np.eye(2)]) / (2 * step)

    try:
        place, jacobian = start.copy(), slope_at(start) if slope is None else slope.copy()
        value = rate(place)
        for _ in range(STEPS):
            if np.hypot(*value) <= RESTS * fastest:
                found = slope_at(place)
                return (place, found) if (np.linalg.eigvals(found).real < 0).all() else None
            move = -np.linalg.solve(jacobian, value)
            move *= min(1.0, length / (4 * norm(move) or 1.0))
            place = place + move
            after = rate(place)
            jacobian += np.outer(after - value - jacobian @ move, move) / (move @ move)
            value = after
    except (TrajectoryError, TippedError, np.linalg.LinAlgError):
        return None
    return None
