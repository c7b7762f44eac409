"""The paper, audited: each printed claim against what this program computes from the four-wheel array.

The numbers of the findings are those of the project's list; every finding is computed when the report is written,
none is a stored sentence about a result.
"""

from __future__ import annotations

from functools import cache

from nonsmooth.proofs.theorem4 import check_cells
from nonsmooth.reports.document import Bullets, Section, Text
from nonsmooth.reports.papers.murphey_burdick_2001.feedback import audit_feedback
from nonsmooth.reports.papers.murphey_burdick_2001.finding import Finding
from nonsmooth.reports.papers.murphey_burdick_2001.functional import (
    audit_every_array,
    audit_friction_ellipse,
    audit_largest_weights,
    audit_uniqueness,
)
from nonsmooth.reports.papers.murphey_burdick_2001.kinematics import audit_equations_3_and_4, audit_theorem_4_displays
from nonsmooth.reports.papers.murphey_burdick_2001.stability import audit_rotation, audit_translation
from nonsmooth.reports.prose import paragraph
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.plane import cross, dot
from nonsmooth.symbolic.scene import Scene

PAPER = "Murphey and Burdick, On the Stability and Design of Distributed Manipulation Control Systems (2001)"


def audit_paper() -> tuple[Finding, ...]:
    """All findings, from the built-in scenes ``four-wheel`` (mu_S < mu_R) and ``four-wheel-side`` (mu_S > mu_R)."""
    roll, side = (check_cells(load_scene(name)) for name in ("four-wheel", "four-wheel-side"))
    return (
        audit_equations_3_and_4(roll, side),
        audit_translation(roll, side),
        audit_rotation(roll, side),
        audit_largest_weights(),
        audit_feedback(roll),
        audit_theorem_4_displays(),
        audit_every_array(),
        audit_uniqueness(),
        audit_friction_ellipse(),
    )


@cache
def audit_section() -> Section:
    """The findings as a part of a report: the same in every report, so computed once."""
    findings = audit_paper()
    summary: tuple[Text, ...] = tuple((f"{finding.title}: {finding.outcome}.",) for finding in findings)
    intro = paragraph("This is the array of {}. What the paper prints about it, against the computation:", PAPER)
    return Section("The paper, audited", (intro, Bullets(summary)), tuple(finding.section() for finding in findings))


def is_paper_array(scene: Scene) -> bool:
    """Whether the array is the paper's: four wheels at (+-1, +-1), rims to the origin, unit speeds."""
    corners = {(x, y) for x in (1, -1) for y in (1, -1)}
    places = {(_sign_of_one(wheel.position[0]), _sign_of_one(wheel.position[1])) for wheel in scene.wheels}
    return (
        len(scene.wheels) == 4
        and places == corners
        and all(wheel.speed == 1 for wheel in scene.wheels)
        and all(not cross(w.position, w.direction) and dot(w.position, w.direction).sign() < 0 for w in scene.wheels)
    )


def _sign_of_one(value: Number) -> int:
    """1 or -1 for these numbers, 0 for any other."""
    return value.sign() if abs(value) == 1 else 0
