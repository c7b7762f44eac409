"""``nonsmooth simulate``: Filippov solutions, with events and what is not unique about them; maps of their ends."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.reports.choices import LawName, PathMethod
from nonsmooth.reports.console import refuse_given
from nonsmooth.reports.options import AllowOutside, At, Json, Radius, RuleOption, SceneText

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from nonsmooth.reports.simulation_modes import Options, SimulationMode
    from nonsmooth.symbolic.scene import Scene

# Headings of the help: what an option belongs to.
PATH = "One path"
LOOP = "Closed loop of an array"
MAP = "Map of many starts of an array"
ORBIT = "Periodic orbit of a plain system"
BODY = "A body with mass (--method dynamics)"

From = Annotated[
    str | None,
    typer.Option(
        "--from",
        rich_help_panel=PATH,
        metavar="X,Y,THETA",
        help="Start in world coordinates, such as 0.2,sqrt(2)/4,pi/6: one number per state.",
    ),
]
Gain = Annotated[
    float,
    typer.Option("--gain", rich_help_panel=LOOP, metavar="K", help="Gain of the law, with --feedback (1/time)."),
]
GridOption = Annotated[
    int | None,
    typer.Option(
        "--grid",
        rich_help_panel=MAP,
        metavar="N",
        help="Map where N x N starts in the square end, instead of one path.",
    ),
]
Until = Annotated[
    float | None,
    typer.Option("--until", metavar="T", help="Last time; 2 unless given, with --grid until all have ended."),
]
Heading = Annotated[
    float,
    typer.Option(
        "--heading", rich_help_panel=MAP, metavar="THETA", help="Heading of all starts in radians, with --grid."
    ),
]
KinematicsOption = Annotated[
    Kinematics, typer.Option("--kinematics", help="Exact pose, or leading order as in the paper.")
]
MethodOption = Annotated[
    PathMethod,
    typer.Option("--method", rich_help_panel=PATH, help="Events, the paper's hysteresis, smoothing, or full dynamics."),
]
Width = Annotated[
    float,
    typer.Option(
        "--width", rich_help_panel=PATH, help="Width of --method hysteresis or smoothed, in units of the state."
    ),
]
FeedbackOption = Annotated[
    bool,
    typer.Option(
        "--feedback",
        rich_help_panel=LOOP,
        help="Close the loop by the law that check certifies.",
    ),
]
LawOption = Annotated[
    LawName,
    typer.Option(
        "--law",
        rich_help_panel=LOOP,
        help="Another feedback law, with --feedback, certified or not: printed is the paper's, cascade takes theta "
        "first (tangential rims: its length l is the checked radius).",
    ),
]
Mass = Annotated[
    float | None,
    typer.Option(
        "--mass",
        rich_help_panel=BODY,
        metavar="M",
        help="With --method dynamics: mass per weight, 1/g; unless given that of standard gravity in the scene's "
        "[units], and 0.1 without units.",
    ),
]
Inertia = Annotated[
    float | None,
    typer.Option(
        "--inertia",
        rich_help_panel=BODY,
        metavar="I",
        help="With --method dynamics: inertia per weight; unless given that of a plate of the body's outline, or of a "
        "disc as large as the array.",
    ),
]
CompareMasses = Annotated[
    bool,
    typer.Option(
        "--compare-masses",
        rich_help_panel=BODY,
        help="With --method dynamics: its distance from each rule's path, for M, M/10, ..., M/10000.",
    ),
]
OrbitOption = Annotated[
    bool,
    typer.Option(
        "--orbit",
        rich_help_panel=ORBIT,
        help="The periodic orbit near --from, or that its path approaches until --until (100 unless given), or comes "
        "from: period, Floquet multipliers, stability, and whether that is proved.",
    ),
]
Output = Annotated[
    str | None,
    typer.Option(
        "-o",
        "--output",
        metavar="FILE",
        help="Samples: .csv or .json; picture: .svg, .png or .pdf; of one path of an array also the motion itself: "
        ".html (a page with a slider) or .gif.",
    ),
]


def simulate(  # noqa: PLR0913, PLR0917  # one parameter for each option of the command
    context: typer.Context,
    scene: SceneText,
    start: From = None,
    grid: GridOption = None,
    until: Until = None,
    heading: Heading = 0.0,
    kinematics: KinematicsOption = Kinematics.EXACT,
    method: MethodOption = PathMethod.EVENTS,
    width: Width = 1e-3,
    feedback: FeedbackOption = False,
    law: LawOption = LawName.CERTIFIED,
    gain: Gain = 1.0,
    mass: Mass = None,
    inertia: Inertia = None,
    compare_masses: CompareMasses = False,
    orbit: OrbitOption = False,
    output: Output = None,
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    allow_outside: AllowOutside = False,
    json: Json = False,
) -> int:
    """Follow a Filippov solution or a body with mass, map where many starts end, or find a periodic orbit.

    Exit status: 0 done, 2 bad input, 3 where paths contradict what is proved.
    """
    from nonsmooth.reports.animation.output import require_film
    from nonsmooth.reports.shown import show
    from nonsmooth.reports.simulation_modes import Options
    from nonsmooth.symbolic.files.scene_file import load_scene
    from nonsmooth.symbolic.files.system_file import holds_system

    options = Options(
        start=start,
        grid=grid,
        heading=heading,
        until=until,
        kinematics=kinematics,
        method=method,
        width=width,
        law=law if feedback else None,
        gain=gain,
        mass=mass,
        inertia=inertia,
        compare_masses=compare_masses,
        orbit=orbit,
        refuse=partial(refuse_given, context),
    )
    path = None if output is None else _path(output, films=grid is None and not compare_masses)
    options.check()
    plain = holds_system(scene)
    load = partial(load_scene, scene, rule=rule, radius=radius, at=at, allow_outside=allow_outside)
    run = _mode(scene, options, load, plain=plain)
    require_film(path, is_array=not plain)
    shown = run.shown(options)
    show(shown, path, json=json)
    return getattr(shown, "exit_status", 0)


def _path(output: str, *, films: bool) -> Path:
    """Where samples, a picture or a film are written."""
    from nonsmooth.reports.animation.output import FILMS
    from nonsmooth.reports.files import PICTURES, output_path

    return output_path(output, (".csv", ".json", *PICTURES, *(FILMS if films else ())))


def _mode(scene: str, options: Options, load: Callable[[], Scene], *, plain: bool) -> SimulationMode:
    """What runs, for an array or a plain system; options of the other are refused."""
    from nonsmooth.reports.simulation_modes import array_mode
    from nonsmooth.reports.system_simulations import system_mode
    from nonsmooth.symbolic.files.system_file import load_system

    run = system_mode(options, partial(load_system, scene)) if plain else array_mode(options, load)
    run.refuse_others(options)
    return run
