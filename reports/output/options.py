"""Arguments that commands share, and what the shell completes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


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
Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")]
