"""``python -m tests.evidence.heavy_tables --tables 100 --engine``: what is said of bodies with inertia, tested.

Random tables of 5 to 10 omniwheels or rubber wheels in millimetres, headings in whole degrees and off by some, at 50,
250 and 1,000 mm/s.  What ``check`` says of a body with inertia is compared with the few lines of
:mod:`tests.oracles.heavy_bodies`, or with the physics engine (:mod:`tests.pressed_engine`): whether it comes to rest,
is on a limit cycle or thrown off, where it ends (within 1 mm and 1 %), when it settles (within 20 %).

With ``--rows FILE`` every table is one line of JSON there as soon as it is compared, and those that are there are not
compared again.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from nonsmooth.analysis.bodies.settling import Settling, SettlingResult
from nonsmooth.proofs.answers.answer import Inertia
from nonsmooth.proofs.answers.inertia import NearRest, Simulated, near_rest, simulated
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.oracles.floats import Floats
from tests.oracles.heavy_bodies import HeavyTable
from tests.pressed_engine import EngineTable

SPEEDS = (50, 250, 1000)  # mm/s
GRAVITY = 9806.65  # mm/s^2
SETTLES = 0.2  # relative error of a time
BESIDE = (
    0.01  # of the array's size: a start from which a body leaves an unstable place of rest, or comes to a stable one
)


@dataclass(frozen=True)
class Drawn:
    """A random table."""

    seed: int
    speed: int

    @cached_property
    def numbers(self) -> tuple[Floats, Floats, Floats, tuple[float, float], float]:
        rng = np.random.default_rng([self.seed, self.speed])
        count = int(rng.integers(5, 11))
        angles = 2 * np.pi * (np.arange(count) + rng.uniform(-0.2, 0.2, count)) / count
        radii = rng.uniform(80, 200, count)
        corners = np.column_stack([radii * np.cos(angles), radii * np.sin(angles)])
        places = np.asarray(np.round(corners), np.float64)
        off = rng.choice([0.0, 2.0, 10.0, 30.0])
        inward = np.degrees(np.arctan2(-places[:, 1], -places[:, 0]))
        headings = np.asarray(np.round(inward + off + rng.normal(0, 1, count)), np.float64)
        speeds = np.round(self.speed * rng.uniform(0.98, 1.02, count), 1)
        friction = [(0.6, 0.6), (0.6, 0.3), (0.5, 0.05)][int(rng.integers(3))]
        return places, headings, speeds, friction, float(np.round(rng.uniform(3e3, 2e4)))

    @property
    def table(self) -> HeavyTable:
        places, headings, speeds, friction, radius = self.numbers
        return HeavyTable(places, np.radians(headings), speeds, np.tile(friction, (len(places), 1)), GRAVITY, radius)

    def text(self, mass: float = 2.0) -> str:
        places, headings, speeds, (roll, side), radius = self.numbers
        lines = ['[units]\nlength = "mm"\nangle = "deg"', f"[friction]\nmu_roll = {roll}\nmu_side = {side}"]
        lines += ['[contact]\nrule = "ellipse"', f"[body]\nmass = {mass}\ninertia = {mass * radius}"]
        for (x, y), heading, speed in zip(places, headings, speeds, strict=True):
            lines.append(f"[[wheel]]\nposition = [{x}, {y}]\nheading = {heading}\nspeed = {speed}")
        return "\n".join(lines) + "\n"

    def scene(self, mass: float = 2.0) -> Scene:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "table.toml"
            file.write_text(self.text(mass), encoding="utf-8")
            return load_scene(file)


class Follower(Protocol):
    """What follows bodies on a table without anything of the product."""

    def follow(self, starts: Floats, until: float) -> tuple[Floats, Floats]:
        """Times (k,) and states (k, m, ...), pose first, from rest at poses (m, 3); nan once thrown off."""
        ...


@dataclass(frozen=True)
class Comparison:
    """What is said of one table, and what is wrong with it."""

    near: NearRest
    found: Simulated
    wrong: tuple[str, ...]


def compared(drawn: Drawn, follower: Follower | None = None) -> Comparison:
    """Ask, and follow the same bodies by Newton's law unless told otherwise."""
    scene, table = drawn.scene(), drawn.table
    follower = follower or table
    near = near_rest(scene)
    found = simulated(scene, near)
    settled = max((body.settles_after or 0.0 for body in found.bodies), default=0.0)
    longest = 4 * settled + 0.5
    ends = [1.02 * body.until if body.settles_after is None else min(body.until, longest) for body in found.bodies]
    times, states = follower.follow(np.array([body.start for body in found.bodies]), max(ends))
    wrong: list[str] = []
    for k, (body, end) in enumerate(zip(found.bodies, ends, strict=True)):
        seen = times <= end
        is_over = end >= min(body.until, 4 / _slowest(near))
        wrong += _wrong_of(table, body, float(scene.accuracy), times[seen], states[seen, k, :2], is_over=is_over)
    return Comparison(near, found, (*wrong, *_wrong_near(table, follower, near)))


def _slowest(near: NearRest) -> float:
    """The least rate at which what is near the place of rest fades, or grows; zero rates count as small ones."""
    return max(min((abs(value.real) for value in near.eigenvalues), default=0.0), 1e-9)


def _wrong_of(
    table: HeavyTable, body: SettlingResult, accuracy: float, times: Floats, places: Floats, *, is_over: bool
) -> list[str]:
    """What a body does that is not what is said; where it is near at once, swings may still fade when it is left."""
    if body.kind is Settling.OPEN:
        return []
    thrown = bool(np.isnan(places).any())
    if thrown or body.kind is Settling.THROWN_OFF:
        return [] if thrown == (body.kind is Settling.THROWN_OFF) else [f"{body.kind}, thrown off {thrown}"]
    late = places[times > 0.8 * times[-1]]
    middle = (late.max(axis=0) + late.min(axis=0)) / 2
    size = float(np.hypot(*(late - middle).T).max())
    if body.kind is Settling.LIMIT_CYCLE:
        told = body.amplitude or 0.0
        return [] if abs(size - told) <= 0.1 * told + 1 else [f"limit cycle {told}, swings {size}"]
    off = float(np.hypot(*(middle - body.end[:2])))
    room = 1 + 0.01 * float(np.abs(table.places).max()) if is_over else accuracy
    wrong = [] if off <= room else [f"ends {off} away"]
    distances = np.hypot(*(places - middle).T)
    # a swing that only just grazes the accuracy counts or does not
    early, last = (_last_beyond(times, distances, share * accuracy) for share in (1.03, 0.97))
    told = body.settles_after or 0.0
    is_right = (1 - SETTLES) * early - 0.01 <= told <= (1 + SETTLES) * last + 0.01
    return wrong if is_right else [*wrong, f"settles after {told}, {early} to {last}"]


def _last_beyond(times: Floats, distances: Floats, reach: float) -> float:
    outside = np.flatnonzero(distances > reach)
    return float(times[outside[-1]]) if outside.size else 0.0


def _wrong_near(table: HeavyTable, follower: Follower, near: NearRest) -> list[str]:
    """Whether a body close by comes nearer where that is said, and goes away where the contrary is."""
    if near.verdict is Inertia.UNDECIDED or near.place is None:
        return []
    slow = _slowest(near)
    start = np.array([[near.place[0] + BESIDE * np.abs(table.places).max(), near.place[1], 0.0]])
    until = min(4 / slow, 10.0)
    times, states = follower.follow(start, until)
    distances = np.hypot(*(states[:, 0, :2] - near.place).T)
    late = np.nanmax(distances[times > 0.8 * times[-1]], initial=0.0) if not np.isnan(distances).any() else np.inf
    if (
        near.verdict is Inertia.STABLE
    ):  # a swing that fades in minutes may look like one that grows, by steps of a follower
        fades = late <= distances[0] or 4 / slow > until
        return [] if fades else [f"said stable, {distances[0]} to {late}"]
    fading = late < distances[0] / 4 and 4 / slow <= until
    return ["said unstable, comes nearer"] if fading else []


Row = dict[str, Any]


def row_of(drawn: Drawn, follower: Follower | None) -> Row:
    """What was said of a table, and what is wrong with it."""
    found = compared(drawn, follower)
    return {
        "table": drawn.seed,
        "speed": drawn.speed,
        "verdict": str(found.near.verdict),
        "bodies": [str(body.kind) for body in found.found.bodies],
        "massless_holds_to": found.found.massless_holds_to,
        "wrong": list(found.wrong),
    }


def summary(rows: list[Row]) -> Counter[str]:
    """How many tables and bodies of each kind there are at each speed."""
    counted: Counter[str] = Counter()
    for row in rows:
        speed = f"{row['speed']} mm/s"
        counted[f"{speed}: {row['verdict']}"] += 1
        counted.update(f"{speed}: {kind}" for kind in row["bodies"])
        counted[f"{speed}: massless up to {row['massless_holds_to']}"] += 1
        counted["wrong"] += len(row["wrong"])
    return counted


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tables", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="table, for several processes")
    parser.add_argument("--engine", action="store_true", help="beside MuJoCo instead of Newton's law")
    parser.add_argument("--rows", type=Path, help="lines of JSON, which are continued")
    options = parser.parse_args()
    file = options.rows
    rows: list[Row] = []
    if file is not None and file.exists():
        rows = [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]
    known = {(row["table"], row["speed"]) for row in rows}
    for seed in range(options.first, options.first + options.tables):
        for speed in SPEEDS:
            if (seed, speed) in known:
                continue
            drawn = Drawn(seed, speed)
            row = row_of(drawn, EngineTable(drawn.table) if options.engine else None)
            rows.append(row)
            for line in row["wrong"]:
                print(f"table {seed} at {speed} mm/s: {line}", flush=True)
            if file is not None:
                with file.open("a", encoding="utf-8") as lines:
                    lines.write(json.dumps(row) + "\n")
    counted = summary(rows)
    for name, count in sorted(counted.items()):
        print(f"{count:5} {name}")
    return int(bool(counted["wrong"]))


if __name__ == "__main__":
    raise SystemExit(main())
