"""Which point of the checked square is worth checking: where bodies rest, and most of them end."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.loads import load_regions
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.contact_rule import CellRule, rule_of
from nonsmooth.proofs.answers.answer import Position
from nonsmooth.proofs.answers.destinations import Destination, Destinations, destinations_of
from nonsmooth.proofs.clauses.workspace import Workspace
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.proofs.verdicts import Equilibrium
from nonsmooth.symbolic.number_text import place_text
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.plane import Vector
from nonsmooth.symbolic.scene import Scene

_RANK = {Position.COMES_HOME: 0, Position.STAYS_NEAR: 1, None: 1, Position.UNDECIDED: 2, Position.LEAVES: 3}
DENOMINATORS = (1, 10, 100, 1_000)  # of the coordinates that are tried under a rule without cells
_HALVINGS = 6  # of the square about a point near the border of the support polygon


def at_best_point(scene: Scene) -> Scene:
    """The same array, checked at the best rest point of its square.

    Points that bodies come home to go first, then those that they stay near; among equals the one where most starts
    end, sampled.  Of a line or an area of rest the middle is taken.  Where the square about the point would leave what
    the contact rule can judge, it is halved until it does not.

    Under a rule without cells rest points are only sampled: one with simple coordinates is taken where it is proved to
    be an equilibrium.

    Raises:
        RefusalError: where no point is known.
    """
    found = destinations_of(check_theorem4(scene, prune=False))
    if not isinstance(rule_of(scene), CellRule):
        return _at_a_proved_point(scene, found)
    places = [place for place in (() if found is None else found.found) if place.points]
    if not places:
        raise RefusalError("--at auto: required a rest point in the checked square, found none")
    best = min(places, key=lambda place: (_RANK[place.position], -place.share))
    return _in_a_square_that_fits(scene, _middle(scene, best), build_partition)


def _at_a_proved_point(scene: Scene, found: Destinations | None) -> Scene:
    """Sampled places propose simple fractions; the exact motion at the point disposes."""
    places = [place for place in (() if found is None else found.found) if place.points]
    for place in places:
        for largest in DENOMINATORS:
            x, y = (scene.field(Fraction(value).limit_denominator(largest)) for value in place.points[0])
            there = _in_a_square_that_fits(scene, (x, y), _loads_exist)
            if _rests(there):
                return there
    raise RefusalError(_no_exact_point(scene, found))


def _rests(scene: Scene) -> bool:
    try:
        return Workspace(scene).point.equilibrium is Equilibrium.HOLDS
    except RefusalError:
        return False


def _no_exact_point(scene: Scene, found: Destinations | None) -> str:
    """That the rest points are no exact numbers, and where they are about."""
    places = [place_text(point) for place in (() if found is None else found.found) for point in place.points]
    seen = f", with rest at about {', '.join(places)}" if places else ""
    name = scene.contact.rule
    wanted = f"required a rest point with simple coordinates under rule {name}, which has no cells"
    return f"--at auto: {wanted}, found none{seen}"


def _middle(scene: Scene, place: Destination) -> Vector:
    """The mean of the corners, in the numbers of the scene."""
    share = Fraction(1, len(place.points))
    x, y = (_carried_out(scene, [point[k] for point in place.points]) * share for k in (0, 1))
    return x, y


def _carried_out(scene: Scene, values: list[Number | Lazy]) -> Number:
    total = scene.field.zero
    for value in values:
        total += value.exact() if isinstance(value, Lazy) else value
    return total


def _in_a_square_that_fits(scene: Scene, at: Vector, judge: Callable[[Scene], object]) -> Scene:
    """The array checked at a point, in its square or the largest half, quarter, ... of it that is not refused."""
    radius = scene.check.radius
    for halving in range(_HALVINGS):
        there = scene.checked_at(at, radius / 2**halving)
        try:
            judge(there.recentred())
        except RefusalError:
            continue
        return there
    return scene.checked_at(at, radius)


def _loads_exist(centred: Scene) -> None:
    load_regions(centred, centred.check.equilibrium)
