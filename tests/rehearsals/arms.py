"""A toy section with a toy figure: how far the wheels are from the checked point."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.reports.figures.style import drawn
from nonsmooth.reports.output.document import Figure, Section
from nonsmooth.reports.output.prose import paragraph

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Picture

    from nonsmooth.reports.checks.subject import ArraySubject
    from nonsmooth.symbolic.mechanics.scene import Scene


def arms_section(subject: ArraySubject) -> Section:
    count = str(len(subject.scene.wheels))
    draw = drawn(arms_figure, subject.scene)
    command = subject.invocation.line("partition", "--json")
    caption = "Arms of the wheels."
    return Section("Arms", (paragraph("There are {} arms.", count), Figure("arms", (caption,), caption, command, draw)))


def arms_figure(scene: Scene) -> Picture:
    from matplotlib.figure import Figure as Picture

    figure = Picture(layout="constrained")
    lengths = [float(x) ** 2 + float(y) ** 2 for x, y in (wheel.position for wheel in scene.wheels)]
    figure.add_subplot().bar([str(wheel.index) for wheel in scene.wheels], lengths)
    return figure


def without_arms(subject: ArraySubject) -> str:
    return "" if len(subject.scene.wheels) < 6 else "six arms are too many"
