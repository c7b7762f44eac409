"""The stages of the view of a plain system: its phase portrait at once, then its verdict with level sets of V."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.system_decision import StabilityResult
from nonsmooth.reports.checks.phase_portrait import PhasePortrait, sampled_potential, sampled_rates
from nonsmooth.reports.interface.system import System
from nonsmooth.reports.workbench.shapes import path_records, point
from nonsmooth.symbolic.numbers.number_text import brief_text

if TYPE_CHECKING:
    from nonsmooth.reports.checks.system_results import SystemCheckResult
    from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

Stage: TypeAlias = Record

FIELD = 21  # arrows in a row
LEVELS = 6  # of V
BORDERS = {
    "sliding": "sliding",
    "repelling": "escaping",
    "crossing": "crossing",
    "touched": "touched",
    "undecided": "undecided",
}
TONES = {"asymptotically stable": "good", "stable": "fair", "unstable": "bad"}


def system_stages(system: System, request: Record, announce: Callable[[str], None]) -> Iterator[Stage]:
    """Everything that the request wants, one stage after the other."""
    began = time.perf_counter()
    yield {"stage": "fast", "kind": "system", **_portrait(system.system), "time": time.perf_counter() - began}
    announce("paths")
    if request.get("starts"):
        yield {"stage": "paths", "paths": path_records(system, request, announce)}
    announce("stability")
    yield {"stage": "exact", "kind": "system", **_verdict(system.check()), "time": time.perf_counter() - began}


def is_planar(system: SwitchedSystem) -> bool:
    """Whether it has a phase portrait: two states, one field."""
    return len(system.states) == 2 and system.has_one_field


def _portrait(system: SwitchedSystem) -> Record:
    """Field, borders and cells about the checked point, in the system's own coordinates."""
    centre, radius = point(system.check.equilibrium), system.check.half_width
    square = {"radius": radius, "exact": {"radius": brief_text(system.check.radius)}}
    record: Record = {"states": list(system.states), "centre": centre, "square": square}
    if is_planar(system):
        portrait = PhasePortrait(system)
        record |= {"field": _arrows(portrait, centre, radius), "edges": _borders(portrait, centre)}
        record["cells"] = len(portrait.cells)
    return {"system": record}


def _arrows(portrait: PhasePortrait, centre: list[float], radius: float) -> list[list[float]]:
    line = np.linspace(-radius, radius, FIELD)
    xs, ys = np.meshgrid(line, line)
    first, second = sampled_rates(portrait.cells, portrait.fields, xs, ys)
    columns = (xs + centre[0], ys + centre[1], first, second)
    rows: list[list[float]] = np.column_stack([column.ravel() for column in columns]).tolist()
    return rows


def _borders(portrait: PhasePortrait, centre: list[float]) -> list[Record]:
    x, y = centre
    return [
        {
            "from": [float(part.start[0]) + x, float(part.start[1]) + y],
            "to": [float(part.end[0]) + x, float(part.end[1]) + y],
            "kind": BORDERS[str(part.kind)],
        }
        for part in portrait.borders
    ]


def _verdict(result: SystemCheckResult) -> Record:
    """What ``nonsmooth check`` says, as one answer; level sets of the V that proves it."""
    evidence, verdict = result.evidence, result.verdict
    answer = {
        "key": "stability",
        "question": "Does the point attract?",
        "answer": verdict,
        "tone": TONES.get(verdict, "open"),
        "sentence": result.reason,
    }
    facts = [{"label": row["what"], "text": row["found"]} for row in result.rows()]
    shown: Record = {"V": result.lyapunov, "level_sets": [], "region": []}
    if is_planar(evidence.scene):
        shown |= _level_sets(evidence)
    return {
        "answers": [answer],
        "clauses": [
            {"key": "stability", "title": "stability", "verdict": verdict, "reason": result.reason, "facts": facts}
        ],
        "verdict": verdict,
        "reason": result.reason,
        "system": {"states": list(evidence.scene.states), **shown},
    }


def _level_sets(result: StabilityResult) -> Record:
    """Curves of constant V on the square where it is proved, and the border of the certified region; in floats."""
    from matplotlib.figure import Figure

    function, region, system = result.function, result.reach.region, result.scene
    if function is None:
        return {}
    x, y = point(system.check.equilibrium)
    line, potential = sampled_potential(system, function)
    axes = Figure().subplots()

    def curves(levels: Sequence[float]) -> list[Any]:
        drawn = axes.contour(line + x, line + y, potential, levels=levels)
        return [np.asarray(curve).tolist() for curves in drawn.allsegs for curve in curves if len(curve)]

    found: Record = {"level_sets": curves(np.linspace(0, float(potential.max()), LEVELS + 2)[1:-1].tolist())}
    if region is not None and region.falls:
        found["region"] = curves([float(region.level)])
    return found
