"""Which wheels carry the body, and how far the answers hold: only while no wheel enters or leaves."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from nonsmooth.proofs.answers.answer import angle_at_least, at_least
from nonsmooth.proofs.findings.verdicts import Fact, Quantity, Rotation
from nonsmooth.symbolic.mechanics.contact_set import contact_set
from nonsmooth.symbolic.mechanics.free_rollers import free_text, free_twists
from nonsmooth.symbolic.numbers.number_text import numbers_text

if TYPE_CHECKING:
    from nonsmooth.proofs.theorem4_result import Theorem4Result
    from nonsmooth.symbolic.mechanics.scene import Scene

ALL_CARRY = "all wheels carry the body, at every pose: the scene names no [body]"
WITHOUT_SHAPE = "all wheels carry the body, at every pose: the scene states no shape of it"


def contact_facts(check: Theorem4Result) -> tuple[Fact, ...]:
    """The contact set of a check under its keys, and the twists that its rows leave ``free``, about the point."""
    free = free_twists(check.scene.recentred())
    words = f"free: {free_text(free)}, so D is the same all along" if free else ""
    return *_facts(check), Fact("free", Quantity(free), words)


def how_far(scene: Scene, place: str = "here", heading: str = "this heading") -> str:
    """How far a body with an outline may move and turn for certain on the same wheels; empty without one."""
    found = contact_set(scene)
    if found.margin is None:
        return ""
    words = f"within {at_least(found.margin)}{scene.units.after_length} of {place}"
    if found.angle is None:
        return words
    return f"{words}, or {angle_at_least(found.angle, scene.units)} of {heading} (of both: shares that add up to 1)"


def _facts(check: Theorem4Result) -> Iterator[Fact]:
    scene = check.scene
    found, unit = contact_set(scene), scene.units.after_length
    if scene.body is None or found.margin is None:
        names_body = scene.inertia is not None and scene.inertia.is_stated
        yield Fact("wheels", list(found.wheels), WITHOUT_SHAPE if names_body else ALL_CARRY)
        yield from (Fact(key, Quantity(None)) for key in ("margin", "angle", "keeps_wheels_within"))
        return
    count = len(scene.wheels) + len(scene.idle)
    words = f"{scene.body.words}: wheels {numbers_text(found.wheels)} of {count} carry it"
    if not scene.idle:
        words = f"{scene.body.words}: all {count} wheels carry it"
    yield Fact("wheels", list(found.wheels), words)
    words = f"the answers hold while no wheel enters or leaves: for certain {how_far(scene)}"
    yield Fact("margin", Quantity(found.margin), words)
    yield Fact("angle", Quantity(found.angle))
    turn = check.rotation.rotation_per_distance if check.rotation.verdict is Rotation.NEUTRAL else None
    keeps = None if turn is None else found.start_that_keeps(turn)
    said = "" if keeps is None else f"from within {at_least(keeps)}{unit} it keeps its wheels all the way home"
    yield Fact("keeps_wheels_within", Quantity(keeps), said)
