"""Bodies on wheels as a field to follow: which wheels carry, when that changes, and in which words it is told.

A body is carried by the wheels under its outline, and without an outline by all there are, wherever it is.  A *support*
says how it goes on: on carrying wheels, some of which may stay under its edge.  It holds as long as no wheel comes to
the edge, weights that keep wheels under it stay between zero and one, and the centre of mass stays over the hull of the
wheels.  What moves the body is said by :mod:`nonsmooth.analysis.bodies.path` (no mass, the least dissipation) and
:mod:`nonsmooth.analysis.bodies.mass_path` (Newton's law).
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nonsmooth.analysis.bodies.moving_outline import MovingOutline, WholePlane
from nonsmooth.analysis.bodies.set_motion import Wheels
from nonsmooth.analysis.cells.contact_rule import SmoothRule
from nonsmooth.analysis.fields.contact_model import ContactModel, contacts_under
from nonsmooth.analysis.trajectories.follow import DenseStep, GuardsOfStates, HybridField, Mode, Path
from nonsmooth.analysis.trajectories.result import EndReason, EventKind
from nonsmooth.symbolic.mechanics.body import outer_positions, support_polygon
from nonsmooth.symbolic.mechanics.contact_set import whole
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane import Vector, around
from nonsmooth.symbolic.numbers.plane_arrays import Floats, are_finite

LOOKS = 8  # parts of a step at whose ends wheels are looked at
ON_EDGE = 1e-10  # of the body's size: depths below are zero


class StartTipsError(ValueError):
    """A start at which the body does not stand on its wheels."""


@dataclass(frozen=True)
class CarryingWheels:
    """How a body goes on: on carrying wheels, some of which may stay under the edge.

    Attributes:
        carrying: well under the body.
        sliding: stay under the edge, ascending; empty for a motion on ``carrying`` alone.
        unique: whether no other choice goes on too.
    """

    carrying: Wheels
    sliding: tuple[int, ...] = ()
    unique: bool = True

    @property
    def touched(self) -> Wheels:
        """All wheels that carry or slide."""
        return self.carrying.union(self.sliding)


class CarriedBody(HybridField):
    """A body on wheels, with or without an outline.

    Attributes:
        method: what moves it, as a trajectory says it.
    """

    method: str

    def __init__(self, model: ContactModel, scene: Scene | None) -> None:
        """For contacts, and the scene of a body with an outline, all its wheels in ``scene.wheels``.

        Raises:
            ValueError: for a scene without a body.
        """
        if scene is not None and scene.body is None:
            raise ValueError("required a scene with a body")
        self.model, self.scene = model, scene
        self.outline = (
            WholePlane(model.positions)
            if scene is None or scene.body is None
            else MovingOutline(scene.body, model.positions)
        )
        self.edge_depth = ON_EDGE * self.outline.size

    @abstractmethod
    def weights(self, support: CarryingWheels, state: Floats) -> Floats:
        """The weights of the sliding wheels at a state."""

    @abstractmethod
    def margins(self, carrying: Wheels, states: Floats) -> Floats:
        """Distances of the centre of mass from the border of the support polygon, negative outside; states (m, d)."""

    def signals(self, support: CarryingWheels, states: Floats) -> Floats:
        """What is positive as long as a support holds, at states (m, d) that begin with the pose.

        Signed depths, weights of a slide, and the margin of the centre of mass, which ends a slide too: there the body
        could not leave the wheels that slide.
        """
        signs = np.full(self.outline.count, -1.0)
        signs[list(support.carrying)] = 1.0
        signed = signs * self.outline.depths(states[:, :3])
        columns = [signed]
        if support.sliding:
            signed[:, list(support.sliding)] = 1.0
            weights = np.array([self.weights(support, state) for state in states])
            columns += [weights, 1 - weights]
        return np.column_stack([*columns, self.margins(support.carrying, states)])

    def passed(self, step: DenseStep, end: float) -> EndReason | None:
        """Take note of a step up to a time; why the path ends with it, if no event does that."""
        return None

    def tell_changes(
        self, path: Path, before: CarryingWheels, after: CarryingWheels, note: str = "", of_slides: str = ""
    ) -> None:
        """Note which wheels come and go, with something to add to each event, or to those of slides."""
        if self.scene is not None:
            for kind, words in wheel_changes(self.scene, before, after):
                path.tell(kind, words, note=of_slides if kind is EventKind.SLIDE and of_slides else note)

    def refusal(self, error: Exception, pose: Floats) -> Exception:
        """What is said of a start at which the body tips."""
        if self.scene is None:
            return error.__cause__ if isinstance(error.__cause__, Exception) else error
        under = frozenset(np.flatnonzero(self.outline.depths(pose) > self.edge_depth).tolist())
        return tipped_start(self.scene, under, pose)

    def tipped(self, path: Path, carrying: Wheels) -> EndReason:
        """Note that the body tips; without an outline the reason alone says so."""
        if self.scene is not None:
            path.tell(EventKind.TIPS, tipping_edge(self.scene, carrying, np.array(path.pose)))
        return EndReason.TIPS if self.model.load_table is None else EndReason.LOADS


def carried_contacts(rule: SmoothRule, scene: Scene) -> tuple[ContactModel, Scene | None]:
    """The contacts of a body under a rule, and its scene with all wheels; None without an outline."""
    outlined = None if scene.body is None else whole(scene)
    return contacts_under(rule, outlined or scene), outlined


class SupportGuards(GuardsOfStates):
    """The signals of a support, all at once: the last is the margin of the centre of mass, the first are depths."""

    crossed = True

    def __init__(self, body: CarriedBody, support: CarryingWheels) -> None:
        self._body, self._support = body, support
        self.looks = 1 if body.scene is None else LOOKS
        depths = [body.edge_depth] * body.outline.count
        self.slacks = [*depths, *[0.0] * (2 * len(support.sliding) + 1)]

    def values(self, states: Floats) -> Floats:
        """All signals."""
        return self._body.signals(self._support, states)

    @property
    def margin(self) -> int:
        """The number of the last signal."""
        return len(self.slacks) - 1


class SupportMode(Mode):
    """A body on one support.

    Attributes:
        support: the wheels.
    """

    shown = 3  # the pose alone

    def __init__(self, body: CarriedBody, support: CarryingWheels, rate: Any) -> None:
        self.support, self.rate, self._body = support, rate, body
        self.guards: SupportGuards = SupportGuards(body, support)
        self.place, self.cells = body.method, ()
        if body.scene is not None:
            self.cells = tuple(str(body.scene.wheels[k].index) for k in sorted(support.touched))
            self.place = f"wheels {', '.join(self.cells)}"

    def passed(self, step: DenseStep, end: float) -> EndReason | None:
        """What the body says to a step."""
        return self._body.passed(step, end)


def finite_start(start: Sequence[float], until: float) -> Floats:
    """The state at time zero.

    Raises:
        ValueError: for a last time that is not positive, or numbers that are not finite.
    """
    state = np.array(start, float)
    if are_finite(state) and 0 < until < math.inf:
        return state
    raise ValueError(f"required a finite start and a positive last time, received {state.tolist()} and {until}")


def wheel_changes(scene: Scene, before: CarryingWheels, after: CarryingWheels) -> Iterator[tuple[EventKind, str]]:
    """What happens to wheels from one stretch to the next: each kind of change, in words."""
    changes = (
        (EventKind.SLIDE, frozenset(after.sliding) - frozenset(before.sliding), "under the edge"),
        (EventKind.ENTER, after.carrying - before.carrying, "under the body"),
        (EventKind.LEAVE, before.touched - after.touched, "beside the body"),
    )
    for kind, wheels, words in changes:
        if wheels:
            yield kind, f"wheel {', '.join(str(scene.wheels[k].index) for k in sorted(wheels))} {words}"


def tipped_start(scene: Scene, carrying: frozenset[int], pose: Floats) -> StartTipsError:
    """The refusal of a start at which the body tips, which names the edge (:func:`tipping_edge`)."""
    edge = tipping_edge(scene, carrying, pose)
    return StartTipsError(f"required a start where the body stands on its wheels, received one where it tips {edge}")


def tipping_edge(scene: Scene, carrying: frozenset[int], pose: Floats) -> str:
    """The side of the hull of the carrying wheels that the centre of mass is farthest beyond, in words.

    Args:
        scene: the array.
        carrying: places in its list of wheels.
        pose: of the body.
    """
    number = {scene.wheels[k].position: scene.wheels[k].index for k in carrying}
    if not number:
        return "with no wheel under it"
    if len(number) == 1:
        return f"over wheel {min(number.values())}"
    corners = support_polygon(outer_positions(list(number)))
    sides = [(number[a], number[b], _line_distance(a, b, pose)) for a, b in around(corners)]
    first, second, _ = min(sides, key=lambda side: side[2])
    return f"over the line through wheels {first} and {second}"


def _line_distance(a: Vector, b: Vector, pose: Floats) -> float:
    """Distance of the centre of mass from the inner side of the line through two corners; negative beyond it."""
    (ax, ay), (bx, by) = ((float(x), float(y)) for x, y in (a, b))
    along = np.array([bx - ax, by - ay])
    return float((along[0] * (pose[1] - ay) - along[1] * (pose[0] - ax)) / np.hypot(*along))
