"""What a contact rule must offer.

A contact rule turns an array of driven wheels under a body into the body's motion.  To add one, write a class on
:class:`CellRule` (the plane falls into cells with constant twists) or :class:`SmoothRule` (a set of forces for each
wheel) in ``analysis/contact_rules``, and list it in :data:`nonsmooth.symbolic.mechanics.rule.CONTACT_RULES`.
Whoever uses a rule asks for its capabilities, never for its name.  Rules hold no data, and import what
they compute with inside their methods, because commands list them before anything is computed.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, ClassVar, TypeAlias

from nonsmooth.symbolic.mechanics.rule import CONTACT_RULES, MIXED, MIXED_RULE
from nonsmooth.symbolic.numbers.number_text import numbers_text

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.analysis.cells.polygon import Polygon
    from nonsmooth.symbolic.mechanics.friction_set import FrictionSet
    from nonsmooth.symbolic.mechanics.scene import Friction, Scene, Wheel
    from nonsmooth.symbolic.numbers.plane_arrays import Floats


class ContactRule(ABC):
    """How contacts become motion.

    Attributes:
        name: in scene files and on the command line.
        summary: one line for people, which completes "rule <name>: ...".
        hardware: the machines for which it is a good guess, in a few words.
        needs_loads: whether the motion depends on the normal forces.  Such a rule refuses squares in which
            they do not exist (the body tips); the regions of any other rule are cut at the support polygon.
        keeps_rows: whether the motion satisfies the rows of its contact state exactly, so that inputs act through the
            control vector fields of that state (feedback clause).
        sees_order_of_friction: whether all that the motion follows from of a wheel's friction is which of mu_R and mu_S
            are zero, and which is larger.
        is_massless_limit: whether paths under full dynamics tend to those of the rule as the mass goes to zero, in
            scenes whose own rule has cells and states no friction forces (:func:`massless_rule`).
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    hardware: ClassVar[str] = ""
    needs_loads: ClassVar[bool] = False
    keeps_rows: ClassVar[bool] = False
    sees_order_of_friction: ClassVar[bool] = False
    is_massless_limit: ClassVar[bool] = False

    def remark(self, scene: Scene) -> str:
        """Why the friction of a scene makes the rule a poor model of it, in one sentence; empty where it does not."""
        return ""


class LimitedForces(ContactRule):
    """A rule under which friction can carry forces in a set for each wheel, and losses are least.

    ``D = sum_i N_i h_i``, h_i the support function of the set of wheel i.
    """

    needs_loads = True

    @abstractmethod
    def friction_set(self, friction: Friction) -> FrictionSet:
        """The forces that a wheel of this friction can carry, per unit of its normal force."""


class CellRule(ContactRule):
    """A rule under which the checked square falls into polygons with a constant twist each."""

    @abstractmethod
    def build_partition(self, scene: Scene, *, prune: bool = True, domain: Polygon | None = None) -> Partition:
        """Exact cells that cover the checked square, or another convex domain, in the scene's coordinates.

        Args:
            scene: the array.
            prune: leave out wheels that cannot matter; without, the cells are the same.
            domain: in place of the square.

        Raises:
            RefusalError: where the motion is not determined.
        """

    def partition_like(self, scene: Scene, known: Partition) -> Partition | None:
        """The cells by those of another scene with the same polygons; None where the rule knows of no such scene."""
        return None

    def build_standing_partition(self, scene: Scene) -> Partition:
        """Exact cells wherever a body stands on all wheels of a scene: in their hull, or a square that holds it.

        Raises:
            RefusalError: where the motion is not determined.
        """
        from nonsmooth.symbolic.mechanics.similar_scenes import covering

        return self.build_partition(covering(scene))

    @abstractmethod
    def literal_twists(self, scene: Scene, points: Floats) -> Floats:
        """Twists at points (m, 2) of a centred scene, shape (m, 3), by the words of the rule, knowing nothing of cells.

        Slow, in floats: the oracle of the cells in tests and measurements; no verdict uses it.
        """

    def build_rest_partition(self, scene: Scene) -> Partition | None:
        """The cells at the centred equilibrium alone, where the body rests in all of them; None where it may not."""
        return None

    def wheels_that_matter(self, scene: Scene) -> tuple[Wheel, ...]:
        """The wheels that have a say somewhere in the checked square, where that is cheaply known; else all."""
        return scene.wheels


class SmoothRule(LimitedForces):
    """A rule without cells: forces in a set for each wheel, and the motion that dissipates the least against them.

    A new one says which forces a wheel can carry, an ellipse that a strip may cut, and how it is called.  Minimizers
    with proofs (:func:`nonsmooth.analysis.minimizers.ellipse_minimizer.minima_under`), exact linearization, feedback
    and paths (:func:`nonsmooth.analysis.bodies.path.smooth_path`) follow from the sets.
    """


Rule: TypeAlias = CellRule | SmoothRule  # every rule has cells or has none


@cache
def _imported(location: str) -> Rule:
    module, name = location.split(":")
    rule: Rule = getattr(import_module(module), name)()
    return rule


def contact_rule(name: str) -> Rule:
    """The rule of a name.

    Raises:
        KeyError: for a name that is not registered.
    """
    return _imported(MIXED_RULE if name == MIXED else CONTACT_RULES[name])


def rule_of(scene: Scene) -> Rule:
    """The contact rule of a scene."""
    return contact_rule(scene.contact.rule)


def has_cells(scene: Scene) -> bool:
    """Whether the contact rule of a scene has cells; else it is a :class:`SmoothRule`."""
    return isinstance(rule_of(scene), CellRule)


def rule_notes(scene: Scene) -> list[str]:
    """What a reader must know of a scene's contact rule: which wheels name one, and where it is a poor model."""
    named: dict[str, list[int]] = {}
    for wheel in scene.wheels:
        if "contact" in wheel.named:
            named.setdefault(scene.rule_of_wheel(wheel), []).append(wheel.index)
    others = {scene.rule_of_wheel(wheel) for wheel in scene.wheels if "contact" not in wheel.named}
    parts = [f"of wheels {numbers_text(tuple(numbers))} {rule}" for rule, numbers in named.items()]
    said = f"own contact rules: {'; '.join([*parts, *(f'of all others {rule}' for rule in others)])}"
    is_news = named and others != set(named)  # not where they name the rule of all others
    return [*([said] if is_news else []), *filter(None, [rule_of(scene).remark(scene)])]


def all_rules(scene: Scene | None = None) -> tuple[Rule, ...]:
    """Every registered rule, in the order of the registry; last that of a scene whose wheels have different ones."""
    mixed = (MIXED,) if scene is not None and scene.contact.rule == MIXED else ()
    return tuple(contact_rule(name) for name in (*CONTACT_RULES, *mixed))


def cell_rules() -> tuple[CellRule, ...]:
    """Every registered rule with cells."""
    return tuple(rule for rule in all_rules() if isinstance(rule, CellRule))


def smooth_rules() -> tuple[SmoothRule, ...]:
    """Every registered rule without cells."""
    return tuple(rule for rule in all_rules() if isinstance(rule, SmoothRule))


def smooth_rule_of(scene: Scene) -> SmoothRule:
    """The contact rule of a scene, which has no cells.

    Raises:
        TypeError: for a rule with cells.
    """
    rule = rule_of(scene)
    if not isinstance(rule, SmoothRule):
        raise TypeError(f"required a rule without cells, received {rule.name}")
    return rule


def massless_rule(scene: Scene) -> SmoothRule:
    """The rule whose friction forces move a body with mass, and whose paths are the limit as the mass goes to zero.

    That is the scene's own rule where it has friction sets (rollers that turn, wheels of several kinds), else friction
    ellipses.
    """
    stated = rule_of(scene)
    return stated if isinstance(stated, SmoothRule) else next(rule for rule in smooth_rules() if rule.is_massless_limit)


def friction_sets(scene: Scene) -> list[FrictionSet]:
    """The friction sets of all wheels of a scene, all of one shape.

    Raises:
        TypeError: under a rule without friction sets.
    """
    rule = rule_of(scene)
    if not isinstance(rule, LimitedForces):
        raise TypeError(f"required a rule with friction sets, received {rule.name}")
    return [rule.friction_set(wheel.friction) for wheel in scene.wheels]
