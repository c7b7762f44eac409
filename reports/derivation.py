"""The derivation report of one scene: from the wheels to the verdict, every step with its formulas.

The report is built once as a :class:`nonsmooth.reports.document.Document`; the renderers only write it down.  It holds
no times and no dates, so equal input gives equal bytes.
"""

from __future__ import annotations

import platform
from dataclasses import dataclass
from importlib.metadata import version

from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.proofs.theorem4_result import CellCheck
from nonsmooth.proofs.verified import verified
from nonsmooth.reports.audit.paper import audit_section, is_paper_array
from nonsmooth.reports.console import json_text, own_version
from nonsmooth.reports.document import Bullets, Code, Document, Entry, Math, Section, Text, number, point, table
from nonsmooth.reports.formats.json import derivation_record
from nonsmooth.reports.formats.latex import render_latex
from nonsmooth.reports.formats.markdown import render_markdown
from nonsmooth.reports.prose import paragraph, prose
from nonsmooth.reports.records import Check, Record, check_record, partition_record, states_record
from nonsmooth.reports.sections.contact import (
    cells_section,
    constraints_section,
    contact_states_section,
    held_wheels,
)
from nonsmooth.reports.sections.continuum import continuum_section
from nonsmooth.reports.sections.ellipse import ellipse_derivative_section, situation_section
from nonsmooth.reports.sections.stability import (
    equilibria_section,
    filippov_section,
    lyapunov_section,
    theorem_section,
)
from nonsmooth.symbolic.rule import Rule
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import one_line

REPORT_FORMATS = (".md", ".tex", ".json")
LIBRARIES = ("python-flint", "sympy", "numpy")


@dataclass(frozen=True)
class Report:
    """The document of a scene and the result it reports."""

    document: Document
    result: Check


def derive_report(scene: Scene, command: str) -> Report:
    """Check the scene and write the derivation down.

    Args:
        scene: the array.
        command: the command that reproduces the report, for its last section.

    Raises:
        RefusalError: where the motion is not determined.
        RuntimeError: if the evidence of a verdict does not verify.
    """
    result = verified(check_theorem4(scene))
    sections = [_verdict_section(result), _array_section(scene), _conventions_section(scene)]
    if isinstance(result, CellCheck):
        sections += [
            constraints_section(held_wheels(result)),
            contact_states_section(result),
            cells_section(result),
            filippov_section(result),
            equilibria_section(result),
            lyapunov_section(result),
        ]
    else:
        sections += [
            constraints_section(scene.recentred().wheels),
            situation_section(result.equilibrium.point),
            ellipse_derivative_section(result.translation),
        ]
    beside = continuum_section(result)
    sections += [theorem_section(result), *([] if beside is None else [beside]), _left_out_section(result)]
    if is_paper_array(scene) and scene.contact.rule is Rule.NEAREST:
        sections.append(audit_section())
    sections.append(_reproduction_section(command))
    return Report(Document(f"Derivation report: {one_line(scene.name)}", tuple(sections)), result)


def render_report(report: Report, suffix: str) -> str:
    """The report in one of REPORT_FORMATS."""
    match suffix:
        case ".md":
            return render_markdown(report.document)
        case ".tex":
            return render_latex(report.document)
        case _:
            check = {key: value for key, value in check_record(report.result).items() if key != "seconds"}
            records: Record = {"check": check, "partition": None, "contact_states": None}
            if isinstance(report.result, CellCheck):
                records["partition"] = partition_record(report.result.partition)
                records["contact_states"] = states_record(report.result.partition)
            return json_text(derivation_record(report.document, records))


def _verdict_section(result: Check) -> Section:
    clauses = (
        ("equilibrium", result.equilibrium),
        ("translation", result.translation),
        ("rotation", result.rotation),
        ("feedback", result.feedback),
        ("Theorem 4", result),
    )
    rows = [(name, str(clause.verdict), clause.reason) for name, clause in clauses]
    return Section("Verdict", (table(("clause", "verdict", "because"), rows, (2, 3, 8)),))


def _array_section(scene: Scene) -> Section:
    header: list[Entry] = ["wheel", *(prose(f"`{name}`") for name in ("p_i", "d_i", "u_i", "mu_R", "mu_S"))]
    rows = [
        (
            str(wheel.index),
            point(wheel.position),
            point(wheel.unit_direction),
            number(wheel.speed),
            number(wheel.friction.roll),
            number(wheel.friction.side),
        )
        for wheel in scene.wheels
    ]
    intro = paragraph(
        "{} wheels: position `p_i`, rim direction `d_i`, surface speed `u_i` along the rim, friction "
        "coefficients `mu_R` along and `mu_S` across it.",
        str(len(scene.wheels)),
    )
    return Section("The array", (intro, table(header, rows, (1.7, 4, 5, 2, 1.6, 1.6))))


def _conventions_section(scene: Scene) -> Section:
    centre, radius = point(scene.check.equilibrium), number(scene.check.radius)
    square = Math(
        rf"\lvert x - x^* \rvert, \lvert y - y^* \rvert \le {radius.latex}", f"|x - x*|, |y - y*| <= {radius.plain}"
    )
    items = [
        prose(
            "World frame; lengths and times in the units of the scene; `J = [[0, -1], [1, 0]]` turns by a quarter "
            "counterclockwise."
        ),
        prose("Reference point of the body: its centre of mass `c = (x, y)`; orientation `theta`."),
        prose(
            "Spatial twist `xi = (v, omega)`: the body point now at p moves with `v + omega J p`. Pose rate: "
            "`c' = v + omega J c, theta' = omega`."
        ),
        prose(
            "Contact rule: {}. Checked point {}, checked square {}.",
            str(scene.contact.rule),
            Math(f"c^* = {centre.latex}", f"c* = {centre.plain}"),
            square,
        ),
        prose("R1 is the roll row of wheel 1, S1 its side row."),
    ]
    if scene.contact.rule is not Rule.NEAREST:
        model = "elastic (identical springs, no tension)" if scene.contact.loads is None else "a table, affine in c"
        items.append(prose("Normal forces: {}.", model))
    if any(scene.check.equilibrium):
        items.append(prose("From the constraints on, positions and twists are measured from the checked point."))
    return Section("Conventions", (Bullets(tuple(items)),))


def _left_out_section(result: Check) -> Section:
    items: list[Text] = [(f"{skipped.what} ({skipped.count}): {skipped.why}.",) for skipped in result.skipped]
    if isinstance(result, CellCheck):
        count, possible = len(result.partition.states), result.census.possible
        words = f"Equations are written for the {count} contact states that own a cell, out of {possible} row triples."
        items.insert(0, (words,))
    if not items:
        return Section("What was left out, and why", (paragraph("Nothing."),))
    return Section("What was left out, and why", (Bullets(tuple(items)),))


def _reproduction_section(command: str) -> Section:
    libraries = ", ".join(f"{name} {version(name)}" for name in LIBRARIES)
    words = "nonsmooth {}, Python {}, {}. This report is written by {}."
    versions = paragraph(words, own_version(), platform.python_version(), libraries, Code(command))
    return Section("Versions and reproduction", (versions,))
