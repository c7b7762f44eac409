"""Items of the audit on the functional itself: do the chosen rows minimize it, is the minimum unique, which holds?"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np

from nonsmooth.analysis.cells.box import build_box_partition, rest_cells
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.fields.contact_model import ContactModel
from nonsmooth.analysis.minimizers.agreement import shared_area
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseInterior
from nonsmooth.analysis.minimizers.minimum import Minimum
from nonsmooth.proofs.theorem4 import check_cells, check_smooth
from nonsmooth.proofs.verdicts import Theorem4
from nonsmooth.reports.document import Block, Entry, display, number, table
from nonsmooth.reports.papers.murphey_burdick_2001.finding import ClaimOutcome, Finding
from nonsmooth.reports.prose import paragraph, prose
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.scene import Contact, Friction, Scene

RATIOS = (2, Fraction(1, 2), Fraction(1, 5), Fraction(1, 10), Fraction(1, 100))
COUNTEREXAMPLES = ("off-center", "outward", "saddle", "differential-drive")
WEIGHTS, SPEEDS = (3, 2, 2), (0, 1, 1)  # one scalar motion, three contacts: the largest weight loses


def audit_largest_weights() -> Finding:
    """Item 4: the constraints with the three largest weights need not minimize D."""
    losses = {x: sum(w * abs(x - u) for w, u in zip(WEIGHTS, SPEEDS, strict=True)) for x in sorted(set(SPEEDS))}
    best = min(losses, key=lambda x: losses[x])
    scene = load_scene("four-wheel")
    rows = [_share_row(scene, ratio) for ratio in RATIOS]
    computed: tuple[Block, ...] = (
        paragraph(
            "One scalar motion x and three contacts with weights {} and speeds {}: D is {} at x = {} and {} at x = {}. "
            "The minimizer {} violates the constraint with the largest weight.",
            *(str(list(values)) for values in (WEIGHTS, SPEEDS)),
            *(str(entry) for x in losses for entry in (losses[x], x)),
            str(best),
        ),
        paragraph("The four-wheel array with elastic loads on the square of half-width 1/2, areas exact:"),
        table(
            ("mu_S/mu_R", "cells of the minimizer", "area on which the rule's twist minimizes D", "area at rest"),
            rows,
            (0.2, 0.25, 0.35, 0.2),
        ),
    )
    return Finding(
        4,
        "The three largest weights",
        ClaimOutcome.REFUTED if losses[best] < losses[SPEEDS[0]] else ClaimOutcome.CONFIRMED,
        prose("the minimum of D satisfies the three constraints with the largest weights, so those nearest to c."),
        computed,
        prose(
            "with elastic loads the rule of sec. 3.1 gives the minimizer on a part of the square that grows as "
            "mu_S/mu_R tends to 0, and the origin lies in a rest area. "
            "The rule is the limit of loads that fall off very fast."
        ),
    )


def _share_row(scene: Scene, ratio: Fraction | int) -> tuple[Entry, ...]:
    """Ratio, number of cells, exact share of agreement, exact rest area."""
    field = scene.field
    friction = Friction(field.one, field.rational(ratio))
    wheels = tuple(replace(wheel, friction=friction) for wheel in scene.wheels)
    near = replace(scene, wheels=wheels, contact=Contact("nearest"))
    box = build_box_partition(replace(near, contact=Contact("box")))
    shared = shared_area(build_nearest_partition(near), box)
    rest: Number = sum((cell.polygon.area for cell in rest_cells(box)), field.zero)
    return number(field.rational(ratio)), str(len(box.cells)), number(shared.share), number(rest)


def audit_every_array() -> Finding:
    """Item 7: the theorem does not hold for every planar array."""
    results = [check_cells(load_scene(name)) for name in COUNTEREXAMPLES]
    refuted = [r for r in results if r.verdict in (Theorem4.FAILS, Theorem4.HYPOTHESES_NOT_MET)]
    rows = [(r.scene.name, str(r.verdict), r.reason) for r in results]
    return Finding(
        7,
        "Theorem 4 for every planar array",
        ClaimOutcome.REFUTED if refuted else ClaimOutcome.CONFIRMED,
        prose("for a discrete planar array the motion is stable in (x, y) and unstable in theta."),
        (table(("array", "Theorem 4", "witness"), rows, (0.2, 0.2, 0.6)),),
        prose(
            f"{len(refuted)} of these {len(results)} arrays are counterexamples: the point need not be an equilibrium, "
            "fields that push outward break the first clause, and no feedback moves a unicycle along its axle. "
            "The theorem needs hypotheses on the array."
        ),
    )


def audit_uniqueness() -> Finding:
    """Item 8: where the minimizer is not unique."""
    scene = load_scene("four-wheel")
    equal = Friction(scene.field.one, scene.field.one)
    tied = build_nearest_partition(replace(scene, wheels=tuple(replace(w, friction=equal) for w in scene.wheels)))
    unequal, alike = (_two_isotropic_wheels(weights) for weights in ((1.0, 2.0), (1.0, 1.0)))
    computed: tuple[Block, ...] = (
        paragraph(
            "Rule of sec. 3.1 with mu_S = mu_R: {} of {} cells hold two contact states, which differ in the third row.",
            str(_tied_cells(tied)),
            str(len(tied.cells)),
        ),
        paragraph(
            "Two isotropic wheels at (0, 0) and (2, 1), surface velocities (1, 0.3) and (-0.2, 0.5). Weights 1 and 2: "
            "D = {}, omega = {}, {}. Equal weights: {}.",
            f"{unequal.value:.5f}",
            f"{unequal.twist[2]:.3f}",
            _face_text(unequal),
            _face_text(alike),
        ),
    )
    circle_is_unique = unequal.face is None and alike.face is not None
    return Finding(
        8,
        "Uniqueness and isotropic friction",
        ClaimOutcome.CORRECTED if circle_is_unique and _tied_cells(tied) else ClaimOutcome.CONFIRMED,
        prose("the minimum is non-unique only when the friction ellipse is a circle (mu_S = mu_R)."),
        computed,
        prose(
            "equal friction leaves the third row of the rule open. The circle functional itself is strictly convex "
            "unless slips are parallel, so isotropic friction alone does not make it non-unique."
        ),
    )


def _tied_cells(partition: Partition) -> int:
    return sum(len(cell.states) > 1 for cell in partition.cells)


def _two_isotropic_wheels(weights: tuple[float, float]) -> Minimum:
    model = ContactModel.build(
        positions=[[0.0, 0.0], [2.0, 1.0]],
        rims=[[1.0, 0.0], [1.0, 0.0]],
        surface=[[1.0, 0.3], [-0.2, 0.5]],
        friction=[1.0, 1.0],
    )
    return EllipseInterior().minimize(model, np.array([weights]))[0]


def _face_text(minimum: Minimum) -> str:
    return "one minimizer" if minimum.face is None else f"a segment between {len(minimum.face)} twists minimizes D"


def audit_friction_ellipse() -> Finding:
    """Item 9: the theorem under the functional of the paper's own Fig. 3."""
    result = check_smooth(load_scene("four-wheel", rule="ellipse"))
    linear = result.translation.point.linearization
    if linear is None:
        raise ValueError("required a smooth equilibrium of the four-wheel array")
    (a, b), (c, d) = linear.translation
    formula = display(
        rf"\dot c = \begin{{pmatrix}} {number(a).latex} & {number(b).latex} \\ {number(c).latex} & {number(d).latex} "
        r"\end{pmatrix} c + O(\lvert c \rvert^2)",
        f"c' = [{a}, {b}; {c}, {d}] c + O(|c|^2)",
    )
    return Finding(
        9,
        "The friction ellipse of Fig. 3",
        ClaimOutcome.REFUTED if result.verdict is Theorem4.FAILS else ClaimOutcome.CONFIRMED,
        prose("friction may vary smoothly with direction, as in Fig. 3, and theta is unstable."),
        (paragraph("Minimizer of the ellipse functional near the origin, elastic loads, exactly:"), formula),
        prose(
            f"the field is smooth there: translation is {result.translation.verdict}, "
            f"theta is {result.rotation.verdict}, nothing rests and nothing slides. "
            "Theorem 4 is a statement about the rule of sec. 3.1."
        ),
    )
