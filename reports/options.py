"""Arguments and options that commands share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nonsmooth.symbolic.rule import CONTACT_RULES

if TYPE_CHECKING:
    pass


def _rule_option(*more: str) -> Any:
    """``--rule``, which takes the name of a registered contact rule or one of the words ``more``."""

    def names(incomplete: str = "") -> list[str]:
        return [name for name in (*CONTACT_RULES, *more) if name.startswith(incomplete)]

    def read(text: str) -> str:
        if text not in names():
            raise typer.BadParameter(f"{text!r} is not one of {', '.join(map(repr, names()))}.")
        return text

    metavar = f"[{'|'.join(names())}]"
    return typer.Option(
        "--rule", help="Contact rule; replaces the scene's.", parser=read, metavar=metavar, autocompletion=names
    )


def complete_scene(incomplete: str) -> list[str]:
    """Built-in names and scene files that begin as typed, for the shell."""
    from nonsmooth.symbolic.files.scene_file import builtin_scenes, builtin_systems

    folder = Path(incomplete).parent if "/" in incomplete else Path()
    files = [str(folder / path.name) for path in sorted(folder.glob("*.toml"))]
    return [name for name in (*builtin_scenes(), *builtin_systems(), *files) if name.startswith(incomplete)]


def complete_vehicle(incomplete: str) -> list[str]:
    """Built-in vehicles and scene files that begin as typed, for the shell."""
    from nonsmooth.symbolic.files.scene_file import builtin_vehicles

    files = [name for name in complete_scene(incomplete) if name.endswith(".toml")]
    return [*(name for name in builtin_vehicles() if name.startswith(incomplete)), *files]


def complete_part(incomplete: str) -> list[str]:
    """Names of report sections, the last of a list with commas, for the shell."""
    from nonsmooth.reports.parts import PART_NAMES

    first, comma, last = incomplete.rpartition(",")
    return [f"{first}{comma}{name}" for name in PART_NAMES if name.startswith(last)]


def complete_study(incomplete: str) -> list[str]:
    """Names of studies, for the shell."""
    from nonsmooth.proofs.measurements import STUDIES, SYSTEM_STUDIES

    return [study.name for study in (*STUDIES, *SYSTEM_STUDIES) if study.name.startswith(incomplete)]


SceneText = Annotated[
    str,
    typer.Argument(metavar="SCENE", help="A scene file (TOML) or a built-in name.", autocompletion=complete_scene),
]
SceneTexts = Annotated[
    list[str],
    typer.Argument(metavar="SCENE...", help="Scene files (TOML) or built-in names.", autocompletion=complete_scene),
]
VehicleText = Annotated[
    str,
    typer.Argument(
        metavar="SCENE", help="A scene file with [vehicle] or a built-in name.", autocompletion=complete_vehicle
    ),
]
RuleOption = Annotated[str | None, _rule_option()]
Radius = Annotated[
    str | None,
    typer.Option("--radius", metavar="R", help="Half-width of the checked square, such as 1/2; replaces the scene's."),
]
Accuracy = Annotated[
    str | None,
    typer.Option(
        "--accuracy", metavar="LENGTH", help="How near a body must come, such as 1/100; replaces the scene's."
    ),
]
At = Annotated[
    str | None, typer.Option("--at", metavar="X,Y", help="The point to check, such as 0,1/4; replaces the scene's.")
]
AllowOutside = Annotated[
    bool,
    typer.Option("--allow-outside", help="Read a table of wheels from outside the scene's folder too (wheels.file)."),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")]
Picture = Annotated[
    str | None,
    typer.Option("-o", "--output", metavar="FILE", help="Draw them, instead of a table: .svg, .png or .pdf."),
]
RowsFile = Annotated[
    str | None, typer.Option("-o", "--output", metavar="FILE", help="Rows: .json or .csv; picture: .svg, .png or .pdf.")
]
ReportFile = Annotated[
    str | None, typer.Option("-o", "--output", metavar="FILE", help="Report: .html, .tex, .md or .json.")
]
