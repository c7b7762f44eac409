"""``nonsmooth reduce``: a plain system without translations and conserved sums, as a scene file."""

from __future__ import annotations

from typing import Annotated

import typer

from nonsmooth.reports.output.console import write
from nonsmooth.reports.output.study_options import SceneOptions, SceneText
from nonsmooth.reports.studies.study_command import offered


def reduce(
    scene: SceneText,
    output: Annotated[
        str | None, typer.Option("-o", "--output", metavar="FILE", help="A .toml; standard output without.")
    ] = None,
    radius: Annotated[str | None, offered(SceneOptions, "radius")] = None,
    at: Annotated[str | None, offered(SceneOptions, "at")] = None,
) -> int:
    """Write a plain system as a smaller one, where it is the same along a line or conserves a sum of its states.

    Equilibria on lines become points: check, simulate and equilibria then tell of differences, such as those of agents
    that agree.  On the plane of a conserved sum one state follows from the others.  A V that the scene names is left
    out.

    Exit status: 0 done, 2 bad input, or nothing to leave out.
    """
    from nonsmooth.reports.output.entries import toml_text
    from nonsmooth.reports.output.files import output_path, write_whole
    from nonsmooth.symbolic.files.documents import deep_nesting_refused
    from nonsmooth.symbolic.files.scene_file import load_system
    from nonsmooth.symbolic.systems.reduction import reduce_system

    path = None if output is None else output_path(output, (".toml",))
    with deep_nesting_refused(scene):
        system = load_system(scene, radius=radius, at=at)
        reduced = reduce_system(system)
    text = toml_text(reduced.document(f"{system.name}-reduced", system.check.radius))
    if path is None:
        write(text)
        return 0
    write_whole(path, text.encode())
    write(f"{path}: {'; '.join(reduced.meaning)}\n")
    return 0
