"""What the command line says of an array that stands in a physics engine: scenes as files, twists from `simulate`."""

from __future__ import annotations

import contextlib
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from nonsmooth.reports.output.entries import toml_text
from nonsmooth.symbolic.mechanics.body import Body, Disc
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.oracles.floats import Floats

Document: TypeAlias = dict[str, Any]

SHORT = 1e-5  # last time of a path whose mean rate stands for the rate at its start, at wheels of speed one


class CommandError(ValueError):
    """A command that does not end in status 0; ``str(error)`` is what it printed on standard error."""


def command(*arguments: str) -> Document:
    """The JSON that a command prints.

    Raises:
        CommandError: where the status is neither 0, 1 nor 3.
    """
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = run(app, (*arguments, "--json"))
    if status not in {0, 1, 3}:
        raise CommandError(err.getvalue())
    record: Document = json.loads(out.getvalue())
    return record


def scene_document(scene: Scene, loads: object = None) -> Document:
    """The tables of a scene file with the wheels, the rule and the body of a scene of rational numbers."""
    wheels = [
        {
            "position": [str(x) for x in wheel.position],
            "heading": [str(x) for x in wheel.direction],
            "speed": str(wheel.speed),
            "mu_roll": str(wheel.friction.roll),
            "mu_side": str(wheel.friction.side),
        }
        for wheel in scene.wheels
    ]
    contact: Document = {"rule": scene.contact.rule} | ({} if loads is None else {"loads": loads})
    check = {"equilibrium": [str(x) for x in scene.check.equilibrium]}
    body = {} if scene.body is None else {"body": _body_table(scene.body)}
    return {"name": scene.name, "wheel": wheels, "contact": contact, "check": check} | body


def _body_table(body: Body) -> Document:
    """Its outline, with the centre of mass in a frame whose origin is the centroid."""
    c, s = (float(x) for x in body.heading)
    common = {"centre_of_mass": [str(-x) for x in body.centre], "heading": f"{float(np.arctan2(s, c))!r} rad"}
    if isinstance(body.outline, Disc):
        return {"shape": "disc", "radius": str(body.outline.radius)} | common
    vertices = [[str(x) for x in vertex] for vertex in body.outline.vertices]
    return {"shape": "polygon", "vertices": vertices} | common


def write_scene(file: Path, document: Mapping[str, Any]) -> str:
    """The document as a file; its name."""
    file.write_text(toml_text(document), encoding="utf-8")
    return str(file)


def start_text(pose: Sequence[float] | Floats) -> str:
    """A pose for ``--from``."""
    return ",".join(f"{float(x)!r}" for x in pose)


def twist_of_command(file: str, pose: Floats, *options: str) -> Floats:
    """Spatial twist ``(v, omega)`` at the start of the path that ``nonsmooth simulate`` follows.

    Raises:
        CommandError: where it refuses the scene or the start.
    """
    start = f"--from={start_text(pose)}"
    path = command("simulate", file, start, "--until", repr(SHORT), *options)
    wx, wy, omega = np.subtract(path["end"]["state"], path["state"][0]) / path["end"]["t"]
    return np.array([wx + omega * pose[1], wy - omega * pose[0], omega])


def relative(found: Floats, measured: Floats) -> float:
    """Difference of twists over the largest entry of the measured one."""
    return float(np.abs(found - measured).max() / np.abs(measured).max())
