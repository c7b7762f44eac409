"""A toy kind of scene: a mass on a spring with a damper, read, checked, reported, and held by Python.

Of the product it needs a member of ``SceneKind`` and a branch in four files (:data:`BRANCHES`); its own would be a
scene with its reader, a result, a report subject with its sections, and a class for Python: nine files, ten with the
line in ``nonsmooth.__init__`` that offers the class.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Any, ClassVar, Self

from nonsmooth.proofs.findings import Record
from nonsmooth.reports.checks import check
from nonsmooth.reports.checks.subject import FILIPPOV, Reference, ReportPart, ReportSubject
from nonsmooth.reports.derivations import derivation, parts
from nonsmooth.reports.interface import array as interface_array
from nonsmooth.reports.interface.scene import PythonScene
from nonsmooth.reports.output.document import Block, Section, findings
from nonsmooth.reports.output.prose import paragraph
from nonsmooth.reports.studies.result import DataTable, Result
from nonsmooth.symbolic.files import scene_file
from nonsmooth.symbolic.files.documents import read_document
from nonsmooth.symbolic.messages.scene_error import SceneError

BRANCHES = 4  # files of the product in which :func:`branches` stands for a line or two, beside the member of the kind
OWN = ("scene and reader", "result", "report", "Python")


class ToyKind(StrEnum):
    SPRING = "a spring with a damper"


# ---- the scene and its reader --------------------------------------------------------------------


@dataclass(frozen=True)
class Spring:
    """``x'' = -stiffness x - damping x'``."""

    name: str
    origin: str
    stiffness: int
    damping: int
    kind: ClassVar[ToyKind] = ToyKind.SPRING


def build_spring(document: Mapping[str, Any], file: str, path: Path) -> Spring:
    table = document["spring"]
    for key in ("stiffness", "damping"):
        if not isinstance(table.get(key), int) or table[key] < 0:
            raise SceneError(file, f"spring.{key}", "an integer of at least 0", table.get(key))
    return Spring(document.get("name", path.stem), file, table["stiffness"], table["damping"])


# ---- the result ----------------------------------------------------------------------------------


@dataclass(frozen=True, repr=False)
class SpringResult(Result):
    scene: Spring

    @property
    def verdict(self) -> str:
        if not self.scene.stiffness:
            return "unstable"
        return "asymptotically stable" if self.scene.damping else "stable"

    @property
    def exit_status(self) -> int:
        return int(self.verdict == "unstable")

    def facts(self) -> Record:
        return {"schema": "toy-spring/1", "scene": self.scene.name, "verdict": self.verdict}

    def table(self) -> DataTable:
        return DataTable(("scene", "verdict"), [(self.scene.name, self.verdict)])

    def blocks(self) -> Sequence[Block]:
        return [findings([("at rest", self.verdict)])]

    def summary(self) -> str:
        return f"{self.scene.name}: {self.verdict}"


# ---- the report ----------------------------------------------------------------------------------


class SpringSubject(ReportSubject):
    scene: Spring
    left_out = ()

    @property
    def result(self) -> SpringResult:
        return SpringResult(self.scene)

    @property
    def headline(self) -> str:
        return self.result.verdict

    @property
    def records(self) -> Record:
        return {"check": self.result.facts()}

    @property
    def works(self) -> list[Reference]:
        return [FILIPPOV]


def energy_section(subject: SpringSubject) -> Section:
    return Section(
        "Energy", (paragraph("The energy falls at the rate {}.", f"{subject.scene.damping} times the square of v"),)
    )


SPRING_PARTS = (ReportPart("energy", energy_section),)


# ---- Python --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class PythonSpring(PythonScene):
    document: Mapping[str, Any]

    @property
    def exact(self) -> Spring:
        return build_spring(self.document, *self.origin)

    @property
    def origin(self) -> tuple[str, Path]:
        return str(self.document["name"]), Path(f"{self.document['name']}.toml")

    def with_(self, **changes: Any) -> Self:
        return replace(self, document={**self.document, "spring": {**self.document["spring"], **changes}})

    def check(self, **changes: Any) -> Any:
        return self._studied(check.CHECK, **changes)


# ---- what the product gets -----------------------------------------------------------------------


def branches() -> dict[tuple[Any, str], Callable[..., Any]]:
    """What stands in the product in place of a function, by its module and name: the same with a branch."""
    load_any, check_array, load = scene_file.load_any, check._check_array, interface_array.load
    subject_of, parts_of = parts.subject_of, parts.parts_of

    def any_loaded(source: Any, **changes: Any) -> Any:
        document, file, path = read_document(source)
        return build_spring(document, file, path) if "spring" in document else load_any(source, **changes)

    def checked(scenes: Sequence[Any], options: Any) -> Any:
        return SpringResult(scenes[0]) if scenes[0].kind is ToyKind.SPRING else check_array(scenes, options)

    def subject_named(kind: Any) -> Any:
        return SpringSubject if kind is ToyKind.SPRING else subject_of(kind)

    def parts_named(kind: Any) -> Any:
        return (*SPRING_PARTS, *parts.LAST_PARTS) if kind is ToyKind.SPRING else parts_of(kind)

    def loaded(source: Any) -> Any:
        document, _, path = read_document(source)
        return PythonSpring({"name": path.stem, **document}) if "spring" in document else load(source)

    return {
        (scene_file, "load_any"): any_loaded,
        (check, "_check_array"): checked,
        (parts, "subject_of"): subject_named,
        (derivation, "subject_of"): subject_named,  # imported from there
        (parts, "parts_of"): parts_named,
        (interface_array, "load"): loaded,
    }
