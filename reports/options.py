"""Arguments and options that commands share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nonsmooth.reports.refusals import RefusedError
from nonsmooth.symbolic.rule import CONTACT_RULES, MIXED

if TYPE_CHECKING:
    from nonsmooth.symbolic.scene import Scene

ALL_RULES = "all"
AUTO = "auto"  # for --at: the best rest point of the square
THEOREM = "theorem4"
# The questions, and the theorem; tests hold them to the registry.
REQUIRABLE = ("position", "heading", "pose", "tolerances", THEOREM)


def under_all_rules(scene: Scene) -> list[Scene]:
    """All wheels of an array under every contact rule, and the array itself where its wheels have different ones."""
    ruled = [scene.under(name) for name in CONTACT_RULES]
    return [*ruled, scene] if scene.contact.rule == MIXED else ruled


def required_answers(text: str | None) -> tuple[str, ...]:
    """The answers that ``--require`` asks for; the theorem alone unless told.

    Raises:
        RefusedError: for a name that is none.
    """
    names = (THEOREM,) if text is None else tuple(name.strip() for name in text.split(","))
    unknown = next((name for name in names if name not in REQUIRABLE), None)
    if unknown is not None:
        raise RefusedError(f"--require: required names among {', '.join(REQUIRABLE)}, received {unknown[:60]!r}")
    return names


def asks_for_failures(fail: int | None) -> bool:
    """Whether ``--fail`` is given.

    Raises:
        RefusedError: for another number of wheels than one.
    """
    if fail not in (None, 1):
        raise RefusedError(f"--fail: required 1, the number of wheels that fail, received {fail}")
    return fail is not None


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
RuleOption = Annotated[str | None, _rule_option()]
RulesOption = Annotated[str | None, _rule_option(ALL_RULES)]
Radius = Annotated[
    str | None,
    typer.Option("--radius", metavar="R", help="Half-width of the checked square, such as 1/2; replaces the scene's."),
]
At = Annotated[
    str | None, typer.Option("--at", metavar="X,Y", help="The point to check, such as 0,1/4; replaces the scene's.")
]
AtOrAuto = Annotated[
    str | None,
    typer.Option(
        "--at",
        metavar="X,Y|auto",
        help="The point to check, such as 0,1/4; replaces the scene's. auto: the best rest point of the square.",
    ),
]
AllowOutside = Annotated[
    bool,
    typer.Option("--allow-outside", help="Read a table of wheels from outside the scene's folder too (wheels.file)."),
]
NoPrune = Annotated[bool, typer.Option("--no-prune", help="Leave nothing out; the verdicts are the same.")]
CertificateFile = Annotated[
    str | None,
    typer.Option(
        "--certificate",
        metavar="FILE",
        help="Write a certificate for verify: .json (one scene; of an array, rule nearest or box).",
    ),
]
LawFile = Annotated[
    str | None,
    typer.Option(
        "--law",
        metavar="FILE",
        help="Write the certified feedback law: .py a program, .csv a table of regions and speeds (one scene).",
    ),
]
Continuum = Annotated[bool, typer.Option("--continuum", help="Add what a continuous field would do to an object.")]
Headings = Annotated[
    bool,
    typer.Option("--headings", help="Look for headings at which a body rests around the checked point too."),
]
Require = Annotated[
    str | None,
    typer.Option(
        "--require",
        metavar="NAME,...",
        help=f"What exit status 0 means, of {', '.join(REQUIRABLE)}: comes home, keeps, can be held, holds.",
    ),
]
Fail = Annotated[
    int | None,
    typer.Option(
        "--fail",
        metavar="1",
        help="Also with any one wheel failed: stopped (its friction stays) or lifted; the worst is named.",
    ),
]
Evidence = Annotated[
    bool, typer.Option("--evidence", help="Print why, too: each clause, or V and its derivatives, with all numbers.")
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
