"""Builders of wheel arrays, handed to the tests as the fixture ``arrays``; all numbers are exact."""

from __future__ import annotations

import gc
from collections.abc import Generator, Iterable
from dataclasses import replace
from fractions import Fraction
from functools import partial
from itertools import product
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np
import pytest
from hypothesis import settings

from nonsmooth.analysis.cells.polygon import Point, Polygon
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.findings import Feedback
from nonsmooth.proofs.systems.findings import Reach
from nonsmooth.symbolic.mechanics.scene import CheckedSquare, Contact, Friction, Scene, Wheel
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField, base_order
from tests.four_wheel import CORNERS, ROLL, SIDE
from tests.thorough import SOME, mark_further

Rational: TypeAlias = int | Fraction
Pair: TypeAlias = tuple[Rational, Rational]
Entry: TypeAlias = Rational | Number

settings.load_profile(SOME)  # unless pytest is asked for another: `make bench` is for ALL

HALF = Fraction(1, 2)
DESTINATIONS = "nonsmooth.proofs.answers.answers._destinations_of"
OTHERS = "nonsmooth.proofs.answers.answers.other_rules"
LAW = "nonsmooth.proofs.clauses.feedback.clause._driven"
REACH = "nonsmooth.proofs.system_decision.reach_of"
FRICTIONS: dict[str, Pair] = {"side<roll": ROLL, "side>roll": SIDE, "side=roll": (1, 1)}


class WheelData(NamedTuple):
    """A wheel in rational numbers; speed None means ``|direction|``, friction None the array's."""

    position: Pair
    direction: Pair
    speed: Rational | None = 1
    friction: Pair | None = None


class Arrays:
    """Wheel arrays by construction: the same arguments give the same array."""

    def scene(
        self,
        wheels: Iterable[WheelData],
        friction: Pair = (1, HALF),
        radius: Rational = HALF,
        at: Pair = (0, 0),
    ) -> Scene:
        """Any rational array."""
        field = NumberField()
        built = []
        for index, (position, direction, speed, own) in enumerate(wheels, 1):
            roll, side = own or friction
            built.append(
                Wheel(
                    index,
                    (field(position[0]), field(position[1])),
                    (field(direction[0]), field(direction[1])),
                    None if speed is None else field(speed),
                    Friction(field(roll), field(side)),
                )
            )
        check = CheckedSquare((field(at[0]), field(at[1])), field(radius))
        return Scene("test", field, tuple(built), Contact("nearest"), check)

    def inward(self, positions: Iterable[Pair], turn: Pair = (1, 0), speed: Rational | None = 1) -> list[WheelData]:
        """Rims ``-R p`` with the rotation R of cosine and sine ``turn``."""
        c, s = turn
        return [WheelData((x, y), (s * y - c * x, -s * x - c * y), speed) for x, y in positions]

    def four_wheel(self, friction: Pair = (1, HALF), turn: Pair = (1, 0), radius: Rational = HALF) -> Scene:
        """The paper's array: wheels at (+-1, +-1), rims to the origin (turned by ``turn``)."""
        return self.scene(self.inward(CORNERS, turn), friction, radius)

    def pushed(self, x: Rational, y: Rational) -> Scene:
        """Wheels at the corners with rims along ``(x p_x, y p_y)``: (1, 1) outward, (1, -1) a saddle."""
        wheels = [w._replace(direction=(x * w.position[0], y * w.position[1])) for w in self.inward(CORNERS)]
        return self.scene(wheels)

    def axle(self, *others: WheelData, radius: Rational = HALF) -> Scene:
        """Two wheels on one axle that spin about its middle: an input in each, but neither along the axle."""
        return self.scene([WheelData((0, 1), (1, 0), 1), WheelData((0, -1), (1, 0), -1), *others], radius=radius)

    def differential_drive(self) -> Scene:
        """The axle with two slippery tangential wheels before and behind, which support but cannot push across."""
        slippery = (Fraction(1, 100), Fraction(1, 1000))
        ends = [WheelData((x, 0), (0, 1), -x, slippery) for x in (2, -2)]
        return self.axle(*ends)

    def grid(self, rows: int, columns: int, friction: Pair = (1, HALF), radius: Rational = HALF) -> Scene:
        """Unit pitch, centred on the origin, rims inward; a wheel at the origin points along x."""
        xs = [k - Fraction(columns - 1, 2) for k in range(columns)]
        ys = [k - Fraction(rows - 1, 2) for k in range(rows)]
        wheels = [WheelData((x, y), (-x, -y) if x or y else (1, 0)) for y, x in product(ys, xs)]
        return self.scene(wheels, friction, radius)

    def ring(self, count: int, friction: Pair = (1, HALF), radius: Rational = 1) -> Scene:
        """Wheels at ``e(2 pi k/count)``, k = 0, 1, ..., rims inward, unit speeds, in their algebraic field."""
        field = NumberField(base_order([Fraction(1, count)]))
        slip = Friction(field(friction[0]), field(friction[1]))
        wheels = []
        for k in range(count):
            turn = Fraction(2 * k, count)
            x, y = field.cos_pi(turn), field.sin_pi(turn)
            wheels.append(Wheel(k + 1, (x, y), (-x, -y), field.one, slip))
        check = CheckedSquare((field.zero, field.zero), field(radius))
        return Scene(f"ring-{count}", field, tuple(wheels), Contact("nearest"), check)

    def circle_point(self, t: Rational) -> Pair:
        """The rational point ``(1 - t^2, 2 t)/(1 + t^2)`` of the unit circle."""
        t = Fraction(t)
        return (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)

    def random(self, seed: int, count: int) -> Scene:
        """Positions, rims, speeds and frictions at random; the checked point is seldom an equilibrium."""
        rng = np.random.default_rng(seed)
        positions: dict[Pair, None] = {}
        while len(positions) < count:
            x, y = rng.integers(-12, 13, 2).tolist()
            positions[Fraction(x, 8), Fraction(y, 8)] = None
        frictions = list(FRICTIONS.values())
        speeds = (1, 1, HALF, -1, None)
        wheels = []
        for position in positions:
            a, b = rng.integers(-5, 6, 2).tolist()
            direction = (a, b) if a or b else (1, 0)
            speed = speeds[rng.integers(len(speeds))]
            wheels.append(WheelData(position, direction, speed, frictions[rng.integers(len(frictions))]))
        at = (Fraction(int(rng.integers(-4, 5)), 16), Fraction(int(rng.integers(-4, 5)), 16))
        return self.scene(wheels, radius=Fraction(int(rng.integers(1, 5)), 2), at=at)

    def cocircular(self, seed: int, friction: Pair | None = None) -> Scene:
        """Random wheels on the unit circle, opposite ones alike, so that the origin is an equilibrium.

        Rims point inward, turned by one random angle; some arrays have more wheels outside the circle.
        """
        rng = np.random.default_rng(seed)
        half: dict[Pair, None] = {}
        for _ in range(int(rng.integers(2, 5))):
            point = self.circle_point(Fraction(int(rng.integers(-8, 9)), int(rng.integers(1, 6))))
            if (-point[0], -point[1]) not in half:
                half[point] = None
        turn = self.circle_point(Fraction((0, 0, 0, 1, -1, 2)[rng.integers(6)], (2, 3, 5)[rng.integers(3)]))
        speeds = (1, 1, Fraction(3, 2), None)
        wheels = []
        for point in half or {(1, 0): None}:
            opposite = (-point[0], -point[1])
            speed = speeds[rng.integers(len(speeds))]
            wheels += self.inward([point, opposite], turn, speed)
        if rng.random() < 0.5:
            a, b = rng.integers(1, 6, 2).tolist()
            corners = product((-3 * HALF, 3 * HALF), repeat=2)
            wheels += [WheelData((x, y), (a * x, b * y)) for x, y in corners]
        chosen = friction or list(FRICTIONS.values())[rng.integers(3)]
        return self.scene(wheels, chosen, radius=Fraction(int(rng.integers(1, 4)), 2))

    def with_friction(self, scene: Scene, friction: Pair) -> Scene:
        """The same array with the same friction at every wheel."""
        slip = Friction(scene.field(friction[0]), scene.field(friction[1]))
        return replace(scene, wheels=tuple(replace(wheel, friction=slip) for wheel in scene.wheels))

    def interior_point(self, polygon: Polygon, rng: np.random.Generator) -> Point:
        """A convex combination of all vertices with random positive weights."""
        weights = rng.integers(1, 100, len(polygon.vertices)).tolist()
        x, y = (sum(w * v[axis] for w, v in zip(weights, polygon.vertices, strict=True)) for axis in (0, 1))
        return x / sum(weights), y / sum(weights)


DOCUMENTS = Path(__file__).with_name("test_documents.py")  # its tests run the commands of documents, the longest ones
# Builders of tests/reports/derived.py, whose reports several files read: each is derived once in a process.
SHARED = {"derived", "derived_afresh"}
# Fixtures that start other programs: Chromium, and the workbench with its workers.
PROGRAMS = {"browser", "server"}


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark further cases as thorough, before pytest selects by marks, and sort the tests.

    The longest single tests come first, so that no worker is left alone with one of them at the end; next the files
    that share what is costly to build or to start, together: mostly one worker then does it once.
    """
    mark_further(items)
    items.sort(key=lambda item: (place(item), item.path))


def place(item: pytest.Item) -> int:
    """Whether a test comes early: lower numbers first."""
    if item.path == DOCUMENTS:
        return 0
    if not isinstance(item, pytest.Function):
        return 2
    return 1 if SHARED & vars(item.module).keys() or PROGRAMS & set(item.fixturenames) else 2


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(
    collector: pytest.Collector,
) -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """Let every second worker collect the files of a folder from the last to the first.

    Files that were never run are compiled where they are first met, and kept: of two workers each does half of them.
    """
    report = yield
    worker = getattr(collector.config, "workerinput", {}).get("workerid", "gw0")
    if isinstance(collector, pytest.Directory) and int(worker.removeprefix("gw")) % 2:
        report.result = report.result[::-1]
    return report


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Look for no garbage while modules are imported and tests collected, which all stay: a tenth of that time."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()


def pytest_collection_finish() -> None:
    """Look for garbage more seldom, and not among modules and collected tests: a tenth of the run time."""
    gc.freeze()
    gc.set_threshold(500_000, 2, 50)


@pytest.fixture(scope="session")
def arrays() -> Arrays:
    """Builders of test arrays."""
    return Arrays()


@pytest.fixture
def without_paths(monkeypatch: pytest.MonkeyPatch) -> None:
    """Checks without the paths that count where bodies go: they are sampled, and take seconds."""
    monkeypatch.setattr(DESTINATIONS, lambda check: None)


@pytest.fixture
def few_paths(monkeypatch: pytest.MonkeyPatch) -> None:
    """Checks that follow a quarter of the paths that count where bodies go, without cells a tenth."""
    monkeypatch.setattr("nonsmooth.proofs.answers.destinations.STARTS", 15)
    monkeypatch.setattr("nonsmooth.proofs.answers.destinations.FEW_STARTS", 3)


@pytest.fixture
def without_reach(monkeypatch: pytest.MonkeyPatch) -> None:
    """Verdicts on plain systems without how far and how fast they hold, which is searched after them."""
    monkeypatch.setattr(REACH, lambda point, found: Reach())


@pytest.fixture
def without_law(monkeypatch: pytest.MonkeyPatch) -> None:
    """Checks without the law by imposed twists that holds a pose, whose forces are searched from hundreds of starts."""
    undecided = partial(DrivenFeedback, Feedback.UNDECIDED, "not asked")
    monkeypatch.setattr(LAW, lambda work: undecided(work.scene))


@pytest.fixture
def without_other_rules(monkeypatch: pytest.MonkeyPatch) -> None:
    """Checks without what the other rules say, which takes seconds where bodies leave the checked point."""
    monkeypatch.setattr(OTHERS, lambda scene: ())
