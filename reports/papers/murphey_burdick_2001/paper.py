"""Whether an array is the paper's, and the law that the paper takes for it; its audit is in a file of its own."""

from __future__ import annotations

from nonsmooth.reports.output.document import Block, Code, display
from nonsmooth.reports.output.prose import paragraph
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane import cross, dot


def is_paper_array(scene: Scene) -> bool:
    """Whether the array is the paper's: four wheels at (+-1, +-1), rims to the origin, unit speeds."""
    corners = {tuple(coordinate.sign() for coordinate in wheel.position) for wheel in scene.wheels}
    return len(scene.wheels) == len(corners) == 4 and all(
        all(abs(coordinate) == 1 for coordinate in wheel.position)
        and wheel.speed == 1
        and not cross(wheel.position, wheel.direction)
        and dot(wheel.position, wheel.direction).sign() < 0
        for wheel in scene.wheels
    )


def law_of_section_3_3() -> list[Block]:
    """For the section on feedback laws: the law of sec. 3.3 with the signs that its own proof needs."""
    law = display(
        r"u_j = -\operatorname{sgn}(\Delta)\, k \theta, \qquad u_i = \lvert u_j \rvert + k \lvert (x, y) \rvert,"
        r" \qquad \Delta = d_j \cdot J(p_j - p_i)",
        "u_j = -sgn(Delta) k theta, u_i = |u_j| + k |(x, y)|, Delta = d_j . J(p_j - p_i)",
    )
    words = paragraph(
        "The paper (sec. 3.3) takes another law for this array. There `theta' = u_j/Delta`, so the sign of `u_j` must "
        "follow that of `Delta`; with it, {} follows the law, which the audit below proves for this array:",
        Code("nonsmooth simulate --feedback --law corrected"),
    )
    return [words, law]
