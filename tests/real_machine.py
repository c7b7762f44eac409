"""The table of a real machine: what the commands say of random arrays beside a physics engine (`body_engine`).

Every function takes a seed, writes a scene file, asks the command line, and asks the engine.
"""

from __future__ import annotations

import runpy
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.body import Body, Disc
from nonsmooth.symbolic.mechanics.contact_set import contact_set, standing
from nonsmooth.symbolic.mechanics.scene import Contact, Scene
from tests.body_engine import (
    BRISK,
    FALLING,
    SETTLING,
    SLOW,
    THICK,
    TIME_CONSTANT,
    TIMESTEP,
    PlateEngine,
    inward_grid,
    plate_engine,
    random_grid,
    with_random_body,
)
from tests.conftest import Arrays, WheelData
from tests.engine_commands import (
    CommandError,
    command,
    relative,
    scene_document,
    start_text,
    twist_of_command,
    write_scene,
)
from tests.oracles.wheels_in_floats import places_of
from tests.roller_engine import random_array as random_rollers
from tests.roller_engine import settled_twist

Floats: TypeAlias = NDArray[np.float64]
Speeds: TypeAlias = Callable[..., Mapping[int, float]]

LEAST_LOAD = 0.05  # share of the weight, of every wheel of a random array
WAYS_HOME = 6  # e-foldings of the distance from the point
REST, RESTING, RETURN = 2.0, 1e-4, 1.5  # time until rest, change of a pose at rest, time until a heading is back
HELD, SAMPLES = 1600, 40  # times that a law acts, and that its error is looked at
COVER = 5  # radius of a disc that covers every wheel

# ---- outlines ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class OutlinePose:
    """A random body on a random grid, at one pose.

    Attributes:
        tips, fell: for the command, and in the engine.
        margin: distance of the nearest wheel from the edge.
        error: of the twist, relative to the largest entry of the engine's.
        without: the same for the scene without ``[body]``, all of whose wheels carry.
    """

    tips: bool
    fell: bool
    margin: float = 0.0
    error: float = 0.0
    without: float = 0.0


def outline_pose(seed: int, reach: float, folder: Path) -> OutlinePose:
    """One pose of a body of 4 to 9 wheels, its centre of mass up to ``reach`` from the middle of the grid."""
    rng = np.random.default_rng(seed)
    scene = with_random_body(random_grid(rng), rng, reach)
    x, y = (float(entry) for entry in scene.check.equilibrium)
    plate = plate_engine(scene, (x, y, 0.0), SLOW)
    plate.step(SETTLING)
    file = write_scene(folder / "outlined.toml", scene_document(scene))
    try:
        twist = twist_of_command(file, plate.pose)
    except CommandError as error:
        if "received one where it tips" not in str(error):
            raise
        plate.step(FALLING)
        return OutlinePose(tips=True, fell=plate.has_fallen)
    bare = write_scene(folder / "bare.toml", scene_document(replace(scene, body=None)))
    margin = contact_set(standing(scene)).margin
    assert margin is not None
    errors = [relative(SLOW * found, plate.twist) for found in (twist, twist_of_command(bare, plate.pose))]
    return OutlinePose(False, plate.has_fallen, float(margin), *errors)


# ---- heights -------------------------------------------------------------------------------------


def random_array(seed: int) -> Scene:
    """Four to nine wheels anywhere with rims in any direction, and a disc over all of them that loads every one."""
    rng = np.random.default_rng(seed)
    count, side = int(rng.integers(4, 10)), Fraction(int(rng.integers(2, 21)), 20)
    while True:
        places, angles = rng.integers(-150, 151, (count, 2)), rng.uniform(0, 2 * np.pi, count)
        centre = np.round(rng.dirichlet(np.full(count, 3.0)) @ places)
        moments = np.vstack([np.ones(count), places.T / 100])
        if (np.linalg.pinv(moments) @ [1, *centre / 100]).min() > LEAST_LOAD:
            break
    wheels = [
        WheelData(
            (Fraction(int(x), 100), Fraction(int(y), 100)),
            (Fraction(round(100 * np.cos(angle)), 100), Fraction(round(100 * np.sin(angle)), 100)),
            Fraction(int(rng.integers(30, 101)), 100),
        )
        for (x, y), angle in zip(places, angles, strict=True)
    ]
    at = Fraction(int(centre[0]), 100), Fraction(int(centre[1]), 100)
    return covered(replace(Arrays().scene(wheels, (1, side), at=at), contact=Contact("ellipse")))


def covered(scene: Scene) -> Scene:
    """With a disc over all wheels."""
    zero, one = scene.field.zero, scene.field.one
    return replace(scene, body=Body(Disc(scene.field(COVER) * scene.check.length), (zero, zero), (one, zero)))


def deflection(scene: Scene, *, time_constant: float = 0.01) -> float:
    """Mean sinking of the plate on wheels of equal height: loads times the weight over the common stiffness."""
    x, y = (float(entry) for entry in scene.check.equilibrium)
    plate = plate_engine(scene, (x, y, 0.0), SLOW, time_constant=time_constant)
    plate.step(SETTLING)
    places = places_of(scene)
    lean = plate.data.qpos[4:6] * 2  # of a small tilt: about x and about y
    sinks = THICK - plate.data.qpos[2] + lean[1] * (places[:, 0] - x) - lean[0] * (places[:, 1] - y)
    return float(np.mean(sinks))


def height_errors(seed: int, share: float, folder: Path) -> tuple[float, float]:
    """Errors of the twist on wheels whose heights are scattered by a share of the mean deflection.

    With the loads of level springs, and with the engine's own, given as measured; wheels that hang in the air are left
    out there.
    """
    scene = random_array(seed)
    x, y = (float(entry) for entry in scene.check.equilibrium)
    lowered = share * deflection(scene) * np.random.default_rng(seed).uniform(-1, 1, len(scene.wheels))
    plate = plate_engine(scene, (x, y, 0.0), SLOW, lowered=lowered)
    plate.step(SETTLING)
    loads = plate.loads()
    pressed = replace(scene, wheels=tuple(w for w, load in zip(scene.wheels, loads, strict=True) if load > 0))
    measured = {"kind": "measured", "values": [repr(float(load)) for load in loads if load > 0]}
    errors = []
    for document in (scene_document(scene), scene_document(pressed, measured)):
        file = write_scene(folder / "heights.toml", document)
        errors.append(relative(SLOW * twist_of_command(file, plate.pose), plate.twist))
    return errors[0], errors[1]


# ---- rollers -------------------------------------------------------------------------------------


def roller_errors(seed: int, folder: Path) -> tuple[float, Floats]:
    """The bearing friction of an array of real rollers, and the errors of the rules roller, ellipse and box."""
    wheels, start = random_rollers(seed)
    twist, centre = settled_twist(wheels, start)
    unit = float(np.abs(wheels.speeds).max())
    tables = [
        {
            "position": [repr(float(x)) for x in position],
            "heading": f"{float(np.arctan2(rim[1], rim[0]))!r} rad",
            "speed": repr(float(speed / unit)),
            "mu_roll": repr(float(roll)),
            "mu_side": repr(float(side)),
        }
        for position, rim, speed, roll, side in zip(
            wheels.positions, wheels.rims, wheels.speeds, wheels.mu_roll, wheels.mu_side, strict=True
        )
    ]
    check = {"equilibrium": [repr(float(x)) for x in centre], "radius": "1e-4"}
    file = write_scene(folder / "rollers.toml", {"name": "rollers", "wheel": tables, "check": check})
    pose = np.array([*centre, 0.0])
    rules = ("roller", "ellipse", "box")
    errors = [relative(unit * twist_of_command(file, pose, "--rule", rule), twist) for rule in rules]
    return float(wheels.mu_side[0]), np.array(errors)


# ---- closed loops --------------------------------------------------------------------------------


@dataclass(frozen=True)
class Loop:
    """A certified closed loop in the engine.

    Attributes:
        rate: certified kappa.
        times: of the samples, times the gain.
        errors: sqrt(V) at these times.
        largest: the largest share of its limit that a rim used.
    """

    rate: float
    times: Floats
    errors: Floats
    largest: float

    @property
    def late(self) -> float:
        """The largest ``sqrt(V)`` over what is certified of it."""
        return float((self.errors / (self.errors[0] * np.exp(-self.rate * self.times))).max())


@dataclass(frozen=True)
class Machine:
    """A plate in the engine under a law that the command line wrote.

    Attributes:
        scene: measured from the point, with a body over all wheels.
        speeds: the function of the exported file.
        feedback: what the check says of it.
        rate: certified kappa: the error falls at least like ``exp(-kappa k t)``.
        speed: at which sqrt(V) falls where a wheel is at its limit; infinite without limits.
    """

    scene: Scene
    speeds: Speeds
    feedback: Mapping[str, Any]
    rate: float
    speed: float

    def lyapunov(self, pose: Floats) -> float:
        """``sqrt(V)``."""
        shape, weight = np.array(self.feedback["lyapunov"]["P"]), self.feedback["lyapunov"]["w"]
        return float(np.sqrt(pose[:2] @ shape @ pose[:2] + weight * pose[2] ** 2))

    def drive(self, start: Floats, gain: float, until: float, lowered: Floats | None = None) -> Loop:
        """Hold the speeds of the law over short times; ``until`` is measured in 1/gain."""
        x, y, theta = start.tolist()
        plate = plate_engine(self.scene, (x, y, theta), SLOW, TIMESTEP, TIME_CONSTANT, lowered)
        self._act(plate, gain)
        plate.step(SETTLING)
        times, errors, largest = [0.0], [self.lyapunov(plate.pose)], 0.0
        began, hold = plate.data.time, until / gain / HELD
        for step in range(1, HELD + 1):
            largest = max(largest, self._act(plate, gain))
            plate.step(hold)
            if step % (HELD // SAMPLES) == 0:
                times.append((plate.data.time - began) * gain)
                errors.append(self.lyapunov(plate.pose))
        return Loop(self.rate, np.array(times), np.array(errors), largest)

    def _act(self, plate: PlateEngine, gain: float) -> float:
        """Give the wheels their speeds; the largest share of a limit."""
        wanted = self.speeds(*plate.pose.tolist(), k=gain)
        for k, wheel in enumerate(self.scene.wheels):
            plate.velocities[k] = wanted[wheel.index] * plate.rims[k]
        limits = self.scene.speed_limits
        return max((abs(wanted[index]) / float(limit) for index, limit in limits.items()), default=0.0)


def machine(source: Path, folder: Path, height: Fraction = Fraction(0)) -> Machine:
    """The array of a scene file under rule ``ellipse``, with the law that is certified for it.

    With a height the law is certified for wheels that are higher or lower by up to that share of the mean deflection.
    """
    program, file = folder / "law.py", folder / "uneven.toml"
    text = source.read_text(encoding="utf-8")
    loads = f'rule = "ellipse"\nloads = {{ kind = "elastic", height = "{height}" }}\n'
    contact = '[contact]\nrule = "nearest"\n'
    file.write_text(text.replace(contact, f"[contact]\n{loads}") if contact in text else f"{text}\n[contact]\n{loads}")
    record = command("check", str(file), "--law", str(program))
    scene = covered(load_scene(source, rule="ellipse").recentred())
    pose, speeds = record["answers"]["pose"], runpy.run_path(str(program))["speeds"]
    return Machine(scene, speeds, record["feedback"], pose["rate"], pose["speed"] or np.inf)


# ---- headings on wheels of unequal height --------------------------------------------------------


@dataclass(frozen=True)
class Scattered:
    """An array whose heading keeps on level wheels, on wheels of unequal height.

    Attributes:
        level, scattered: verdicts of position and heading with level springs, and for every load of the scatter.
        beside: distance from the point at which the plate stays in the engine, as a share of the scene's length.
        turning: rate at which it turns there, over that of a rim at that length.
    """

    level: tuple[str, str]
    scattered: tuple[str, str]
    beside: float
    turning: float


def scattered_heading(source: Path, seed: int, share: Fraction, folder: Path) -> Scattered | None:
    """The array of a scene file, its wheels raised and lowered by up to a share of the mean deflection.

    None where the heading is not kept on level wheels.
    """
    level = command("check", str(source), "--rule", "ellipse")["answers"]
    if (level["position"]["verdict"], level["heading"]["verdict"]) != ("comes home", "keeps"):
        return None
    loads = f'\n[contact]\nrule = "ellipse"\nloads = {{ kind = "elastic", height = "{share}" }}\n'
    file = folder / "scattered.toml"
    file.write_text(source.read_text(encoding="utf-8") + loads, encoding="utf-8")
    unknown = command("check", str(file))["answers"]
    scene = covered(load_scene(source, rule="ellipse").recentred())
    lowered = float(share) * deflection(scene) * np.random.default_rng(seed).uniform(-1, 1, len(scene.wheels))
    place, turning = standstill(scene, lowered, WAYS_HOME / level["position"]["rate"])
    length, speed = float(scene.check.length), max(abs(float(wheel.speed)) for wheel in scene.wheels)
    verdicts = [(found["position"]["verdict"], found["heading"]["verdict"]) for found in (level, unknown)]
    return Scattered(verdicts[0], verdicts[1], float(np.hypot(*place)) / length, turning * length / speed)


def standstill(scene: Scene, lowered: Floats, until: float) -> tuple[Floats, float]:
    """Where the centre of mass of the plate stays in the engine, and how fast the plate turns there.

    The end of a path along the engine's settled velocities from the checked point; wheels run at the scene's speeds.
    """

    def motion(place: Floats) -> Floats:
        plate = plate_engine(scene, (float(place[0]), float(place[1]), 0.0), SLOW, lowered=lowered)
        plate.step(SETTLING)
        (x, y, _), (vx, vy, omega) = plate.pose, plate.twist / SLOW
        return np.array([vx - omega * y, vy + omega * x, omega])

    found = solve_ivp(lambda t, place: motion(place)[:2], (0, until), np.zeros(2), method="RK23", rtol=0.05, atol=1e-4)
    place = found.y[:, -1]
    return np.asarray(place), float(motion(place)[2])


# ---- headings of rest ----------------------------------------------------------------------------

SWIRL = """name = "swirl"
[grid]
rows = 4
columns = 5
[field]
kind = "expression"
x = "-x - 8/7*y + x*x*y/4"
y = "-x - y/2 - y*y*x/28 - 3/28*x*x*x"
[body]
shape = "rectangle"
width = "21/10"
height = "17/10"
[friction]
mu_roll = 1
mu_side = 1
[contact]
rule = "ellipse"
[check]
radius = 0.1
length = 1
"""


def engine_heading(scene: Scene, start: Floats, until: float) -> float:
    """Where a plate points that has run from a pose; ``until`` at the scene's speeds."""
    plate = plate_engine(scene, (float(start[0]), float(start[1]), float(start[2])), BRISK, TIMESTEP, TIME_CONSTANT)
    plate.step(SETTLING + until / BRISK)
    return float(plate.pose[2])


def returning_heading(offset: float, folder: Path) -> tuple[float, float]:
    """The nearest heading that ``check`` sees a body turn to, and where a plate in the engine, put beside it, ends."""
    file = folder / "swirl.toml"
    file.write_text(SWIRL, encoding="utf-8")
    found = command("check", str(file), "--rule", "ellipse")["answers"]["equilibrium_headings"]["found"]
    heading = min((each["heading"] for each in found if "turns to it" in (each["reason"] or "")), key=abs)
    return heading, engine_heading(load_scene(file), np.array([0.01, -0.01, heading + offset]), RETURN)


def resting_heading(seed: int, folder: Path) -> tuple[float, float] | None:
    """The last heading of a path on inward rims that `simulate` follows to rest, and the engine's from its start.

    None where the body does not come to rest in time.
    """
    rng = np.random.default_rng(seed)
    scene = with_random_body(inward_grid(Fraction(1, 2)), rng, 0.5)
    start = np.array([*(float(entry) for entry in scene.check.equilibrium), 0.0])
    file = write_scene(folder / "resting.toml", scene_document(scene))
    try:
        path = command("simulate", file, f"--from={start_text(start)}", "--until", repr(REST))
    except CommandError:
        return None
    earlier = [state for t, state in zip(path["t"], path["state"], strict=True) if t < 0.8 * REST]
    end = path["end"]["state"]
    if path["end"]["t"] < REST or not earlier or np.abs(np.subtract(earlier[-1], end)).max() > RESTING:
        return None
    return float(end[2]), engine_heading(scene, start, REST)
