"""The feedback clause in the derivation report: the law, why it works, and the sign it needs in every cell."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import SupportsFloat

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.clauses.authority import Authority
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult, InputMargin
from nonsmooth.proofs.clauses.feedback.cascade_law import CascadeLaw, Descent
from nonsmooth.proofs.clauses.feedback.clause import AnyFeedback
from nonsmooth.proofs.clauses.feedback.control_fields import ControlLyapunov, InputCell
from nonsmooth.proofs.clauses.feedback.driven_law import LawCone, in_scene, rim_speeds
from nonsmooth.proofs.clauses.feedback.gradient_law import LevelRegion, LimitedRate
from nonsmooth.reports.output.document import (
    Block,
    Entry,
    Math,
    Paragraph,
    Table,
    cell_mark,
    display,
    matrix,
    number,
    point,
    table,
)
from nonsmooth.reports.output.prose import listed, paragraph, prose
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.similar_scenes import in_own_length
from nonsmooth.symbolic.numbers.number_text import brief_text, decimal_latex, float_text, lower_text
from nonsmooth.symbolic.numbers.plane import dot

_SIGNS = {1: Math("+", "+"), -1: Math("-", "-"), 0: Math("0", "0")}


def feedback_blocks(feedback: AnyFeedback, authority: Authority, scene: Scene) -> tuple[Block, ...]:
    """Law, witness, table of cells or twists, samples, and torque authority, as far as there are any."""
    blocks: list[Block] = []
    feedback = feedback.holding
    if isinstance(feedback, FeedbackResult) and feedback.law is not None:
        blocks += [*law_formulas(feedback), *_law_reasons(feedback), *region_blocks(feedback)]
    if feedback.witness is not None:
        words = "Witness: `c` = {} and `theta` = {} ({})."
        witness = feedback.witness
        blocks.append(paragraph(words, point(witness.point), number(witness.value), witness.meaning))
    if isinstance(feedback, DrivenFeedback):
        blocks += [*_driven_blocks(feedback, scene.recentred()), *_sample_blocks(feedback)]
    else:
        blocks += _sign_blocks(feedback)
    missing = listed([point(twist) for twist in authority.missing])
    shown = (
        prose("twist tracking can ask for every twist")
        if not missing
        else (*prose("missing twists `xi = (v, omega)`: "), *missing)
    )
    rank = prose("Torque authority: the roll rows have rank {} of 3 at the checked point; ", str(authority.rank))
    return (*blocks, Paragraph((*rank, *shown, ".")))


def _sign_blocks(feedback: FeedbackResult) -> list[Block]:
    blocks: list[Block] = []
    if feedback.rate is not None:
        kappa = feedback.rate.kappa
        bound = f"-{lower_text(2 * kappa, 4)}"
        formula = Math(rf"\dot V \le {bound}\, k V", f"V' <= {bound} k V")
        blocks.append(paragraph("Certified on every closed cone at the equilibrium: {}.", formula))
    if feedback.limited is not None:
        blocks += _limited_blocks(feedback.limited, gains_below_one=feedback.lyapunov.length is not None)
    if feedback.margin is not None:
        blocks += _margin_blocks(feedback.margin)
    if feedback.cells:
        blocks.append(_cell_table(feedback))
    failing = ", ".join(str(index) for index in feedback.printed_sign_fails)
    if failing:
        blocks.append(paragraph("The paper's `u_j = -k theta` (sec. 3.3) has the wrong sign in the cells {}.", failing))
    return blocks


def _limited_blocks(limited: LimitedRate, *, gains_below_one: bool) -> list[Block]:
    """What limits of speed leave of the rate."""
    free, held, speed, level = (
        lower_text(value, 4) for value in (limited.free, limited.held, limited.speed, limited.level)
    )
    gain = "" if gains_below_one else " (for a gain of at least one)"
    scaled = (
        "Where an input would exceed the largest speed of its wheel, all inputs of the cell are scaled by one factor: "
        "every velocity keeps its direction, so the paths are those without limits, more slowly."
    )
    inside = "Certified where {}: no wheel is at its limit while {}{}, and the rate holds while {}; beyond that {}."
    falls = Math(rf"\frac{{d}}{{dt}} \sqrt{{V}} \le -{decimal_latex(speed)}", f"d/dt sqrt(V) <= -{speed}")
    shown = [
        Math(rf"{left} {sign} {decimal_latex(value)}", f"{plain} {plain_sign} {value}")
        for left, sign, value, plain, plain_sign in (
            ("V", "<", level, "V", "<"),
            ("k^2 V", r"\le", free, "k^2 V", "<="),
            ("k^2 V", r"\le", held, "k^2 V", "<="),
        )
    ]
    return [paragraph(scaled), paragraph(inside, shown[0], shown[1], gain, shown[2], falls)]


def _margin_blocks(margin: InputMargin) -> list[Block]:
    """Side by side, up to which error in c one input serves both cells."""
    header = ("side of the cells", "one input serves both within this part of the distance")
    rows = [(f"{side.cells[0]}, {side.cells[1]}", float_text(float(side.squared) ** 0.5, 4)) for side in margin.sides]
    return [paragraph("{}.", str(margin).capitalize()), table(header, rows, (2, 4))]


def _driven_blocks(feedback: DrivenFeedback, scene: Scene) -> list[Block]:
    """The law of the rules ``box`` and ``ellipse``: its formula, rate, and twists with the speeds that impose them."""
    if feedback.certified_kappa is None:
        return []
    plain = feedback.length == 1
    latex_weight, weight = ("", "") if plain else ("w\\, ", "w ")
    law = display(
        rf"\xi = -k\, (g \cdot \xi_l)\, \xi_l, \qquad g = (c, {latex_weight}\theta), \qquad "
        r"\lvert g \cdot \xi_l \rvert \ge \lvert g \cdot \xi_m \rvert",
        f"xi = -k (g . xi_l) xi_l, g = (c, {weight}theta), |g . xi_l| >= |g . xi_m|",
    )
    bound = f"-{lower_text(2 * feedback.certified_kappa, 4)}"
    rate = display(
        rf"V = \lvert c \rvert^2 + {latex_weight}\theta^2, \qquad \tfrac12 \dot V = g \cdot \xi, \qquad \dot V \le "
        + rf"{bound}\, k V",
        f"V = |c|^2 + {weight}theta^2, V'/2 = g . xi, V' <= {bound} k V",
    )
    reach = feedback.reach
    where = "near c*" if reach is None else f"where |x - x*|, |y - y*| < {lower_text(reach, 4)}, for every theta"
    words = paragraph("The rate is certified {}. The factor `-k (g . xi_l)` multiplies the speeds too:", where)
    header = ("directions of c", prose("`xi_l`"), prose("speeds `u_i` that impose `xi_l`"))
    rows = [row for cone in feedback.cones for row in _twist_rows(cone, in_own_length(scene), feedback)]
    shown: list[Block] = [law, rate, words, table(header, rows, (3, 4, 5))]
    return shown if plain else [_weight_block(feedback, scene), *shown]


def _weight_block(feedback: DrivenFeedback, scene: Scene) -> Block:
    """The weight w of the heading, by the length l."""
    length, weight = scene.field(feedback.length), scene.field(feedback.lyapunov.weight)
    return paragraph("With `w` = {}, the square of the length {}:", number(weight), number(length))


def _twist_rows(cone: LawCone, scaled: Scene, feedback: DrivenFeedback) -> list[tuple[Entry, ...]]:
    directions = "all"
    if cone.rays is not None:
        start, end = (_degrees(ray) for ray in cone.rays)
        directions = f"{float_text(start, 4)} to {float_text(end if end > start else end + 360, 4)} degrees"
    return [
        (directions, _decimals(in_scene(imposed.twist, feedback.length)), _decimals(rim_speeds(scaled, imposed)))
        for imposed in cone.twists
    ]


def _degrees(ray: Point) -> float:
    """Angle from the x axis, in [0, 360)."""
    return math.degrees(math.atan2(float(ray[1]), float(ray[0]))) % 360


def _decimals(values: Sequence[SupportsFloat]) -> Entry:
    return listed([Math(x, x) for x in (float_text(float(value) + 0, 4) for value in values)])


def _sample_blocks(feedback: DrivenFeedback) -> list[Block]:
    if not feedback.samples:
        return []
    rows: list[tuple[Entry, ...]] = []
    for sample in feedback.samples:
        if sample.worst_rate is None or sample.worst_state is None:
            continue
        state = listed([Math(x, x) for x in (float_text(value, 4) for value in sample.worst_state)])
        rate = float_text(sample.worst_rate, 4)
        rows.append((str(sample.law), str(sample.states), Math(f"{rate}\\, k", f"{rate} k"), state))
    header = ("law", "states", prose("largest `V'/V` found"), "at (x, y, theta)")
    shown: list[Block] = []
    if rows:
        shown = [paragraph("Sampled, not proved, with gain `k`:"), table(header, rows, (3, 1.5, 3, 4))]
    words = "Law {}, sampled: the largest `V'/V` is not certified: {}."
    missing = [paragraph(words, str(s.law), s.not_certified) for s in feedback.samples if s.not_certified]
    return [*shown, *missing]


def law_formulas(feedback: FeedbackResult) -> list[Block]:
    """The certified law of rule ``nearest``, in formulas."""
    if feedback.cascade is not None:
        return _cascade_formulas(feedback.cascade)
    shaped = feedback.lyapunov.length is None
    return _shaped_formulas(feedback) if shaped else _gradient_formulas(feedback)


def region_blocks(feedback: FeedbackResult) -> list[Block]:
    """The starts from which the law is certified to bring the body home."""
    region = feedback.region
    if region is None:
        return [paragraph("The law is certified near `c*`; how near is not known.")]
    level = lower_text(region.level, 4)
    if isinstance(region, LevelRegion):
        inside = Math(f"V < {decimal_latex(level)}", f"V < {level}")
        words = "Certified region: V falls along every solution from a start with {}, and the body comes home."
        return [paragraph(words, inside)]
    weight, top, length = (float_text(value) for value in (region.weight, region.top, region.length))
    function = display(
        rf"W = \left(\frac{{r}}{{l}} + \frac{{r^2}}{{l^2}} \chi\right)^2 + {decimal_latex(weight)}\, \Theta^2, \qquad"
        r" \chi' = z^2 - m, \quad z = s/r",
        f"W = (r/l + (r/l)^2 chi)^2 + {weight} Theta^2, chi' = z^2 - m, z = s/r",
    )
    inside = Math(
        rf"W < {decimal_latex(level)},\ r < {decimal_latex(top)}\, l,\ l = {decimal_latex(length)}",
        f"W < {level}, r < {top} l, l = {length}",
    )
    words = "Certified region: W falls along every solution from a start with {}, and the body comes home. Here m is "
    return [paragraph(words + "the mean of {} over a turn.", inside, Math("z^2", "z^2")), function]


def _law_reasons(feedback: FeedbackResult) -> list[Block]:
    """Why the law serves."""
    if feedback.cascade is not None:
        return _cascade_reasons(feedback.cascade)
    if feedback.lyapunov.length is not None:
        words = "The two coefficients vanish together only where `c . d_i = 0`; the table shows that this product has "
        return [paragraph(words + "one strict sign on each closed cell at the equilibrium.")]
    words = "The two coefficients vanish together only where `c^T P d_i = 0`, and no closed cell at the equilibrium "
    return [paragraph(words + "holds such a point; for `P = I` some cell does.")]


def _gradient_formulas(feedback: FeedbackResult) -> list[Block]:
    length = feedback.lyapunov.length
    if length is None:
        raise ValueError(f"required |c|^2 + l^2 theta^2, received {feedback.lyapunov}")
    weight = "" if length == 1 else "l^2 "
    law = display(
        rf"u_i = -k a, \qquad u_j = -k b, \qquad b = \frac{{{weight}\theta - c \cdot J p_i}}"
        r"{d_j \cdot J(p_j - p_i)}, \qquad a = c \cdot d_i - (d_i \cdot d_j)\, b",
        f"u_i = -k a, u_j = -k b, b = ({weight}theta - c . J p_i)/(d_j . J(p_j - p_i)), a = c . d_i - (d_i . d_j) b",
    )
    rate = display(
        rf"V = \lvert c \rvert^2 + {weight}\theta^2, \qquad \tfrac12 \dot V = a u_i + b u_j = -k (a^2 + b^2)",
        f"V = |c|^2 + {weight}theta^2, V'/2 = a u_i + b u_j = -k (a^2 + b^2)",
    )
    if not weight:
        return [law, rate]
    exact = feedback.cells[0].cell.twists[0].omega.field
    return [paragraph("With `l` = {}:", number(exact(length))), law, rate]


def _cascade_formulas(cascade: CascadeLaw) -> list[Block]:
    """The law that takes theta first."""
    if cascade.descent is Descent.SLOW_TURNS:
        law = display(
            r"v = (k - \omega)\, r\, J p_i/\lvert p_i \rvert, \qquad \omega = k (s/l - \Theta)",
            "v = (k - omega) r J p_i/|p_i|, omega = k (s/l - Theta)",
        )
        where = display(
            r"\Theta = \theta - s^2/(2 r l), \qquad (r, s) = (c \cdot p_i, c \cdot J p_i)/\lvert p_i \rvert",
            "Theta = theta - s^2/(2 r l), (r, s) = (c . p_i, c . J p_i)/|p_i|",
        )
        return [law, where, _imposed_speeds()]
    law = display(
        r"\omega = -k \theta, \qquad v = \pm k \lvert c \rvert\, d_i - (n_i \cdot J p_i)\, \omega\, n_i",
        "omega = -k theta, v = +-k |c| d_i - (n_i . J p_i) omega n_i",
    )
    return [law, _imposed_speeds()]


def _cascade_reasons(cascade: CascadeLaw) -> list[Block]:
    """How c comes home, with the sign of the translation along each nearest rim."""
    if cascade.descent is Descent.SLOW_TURNS:
        words = "Here i is the nearest wheel and l any length. Every rim is tangential, so to first order each input "
        return [paragraph(words + "keeps r; turning to and fro makes it fall, like 1/t, where kinematics are exact.")]
    rows = [
        (str(wheel.index), _SIGNS[sign], point(cone.start), point(cone.end))
        for wheel, sign, cone in zip(cascade.wheels, cascade.signs, cascade.fan.cones, strict=True)
    ]
    header = ("nearest wheel", "sign", "from the ray", "to the ray")
    why = paragraph(
        "Theta decays by itself; what is left is a planar field of constant directions on cones, in which c comes home "
        "by {}{}:",
        str(cascade.descent),
        "".join(f", which multiply |c| by {brief_text(gain)}" for gain in cascade.fan.gains.values()),
    )
    return [why, table(header, rows, (1.5, 1, 3, 3))]


def _imposed_speeds() -> Block:
    """The inputs that impose a motion which the nearest wheel's side row allows."""
    return display(
        r"u_w = d_w \cdot (v + \omega J p_w), \qquad w = i, j",
        "u_w = d_w . (v + omega J p_w), w = i, j",
    )


def _shaped_formulas(feedback: FeedbackResult) -> list[Block]:
    (e, f), w = feedback.lyapunov.shape, feedback.lyapunov.weight
    exact = feedback.cells[0].cell.twists[0].omega.field
    law = display(
        r"\begin{gathered} u_i = -k a, \qquad u_j = -k b, \\ b = \frac{w \theta - P c \cdot J (p_i - c)}"
        r"{d_j \cdot J(p_j - p_i)}, \qquad a = P c \cdot d_i - (d_i \cdot d_j)\, b \end{gathered}",
        "u_i = -k a, u_j = -k b, b = (w theta - P c . J(p_i - c))/(d_j . J(p_j - p_i)), a = P c . d_i - (d_i . d_j) b",
    )
    rate = display(
        r"V = c^T P c + w \theta^2, \qquad \tfrac12 \dot V = a u_i + b u_j = -k (a^2 + b^2)",
        "V = c^T P c + w theta^2, V'/2 = a u_i + b u_j = -k (a^2 + b^2)",
    )
    shape = matrix([[exact(1 + e), exact(f)], [exact(f), exact(1 - e)]])
    values = paragraph("With `P` = {} and `w` = {}:", shape, number(exact(w)))
    return [values, law, rate]


def _cell_table(feedback: FeedbackResult) -> Table:
    squares = feedback.lyapunov.length is not None
    header = (
        "cell",
        prose("`i`"),
        prose("`j`"),
        prose("sign of `u_j` that turns `theta > 0` back"),
        prose("signs of `c . d_i` at the vertices" if squares else "signs of `c^T P d_i` at the vertices"),
    )
    marks = [(cell_mark(data.cell.index),) for data in feedback.cells]
    rows = [_cell_row(data, feedback.lyapunov) for data in feedback.cells]
    return table(header, rows, (1.2, 1, 1, 4, 4), marks)


def _cell_row(data: InputCell, lyapunov: ControlLyapunov) -> tuple[Entry, ...]:
    needed = _SIGNS[-data.torque_sign] if data.torque_sign else "none: side row"
    slopes = [dot(lyapunov.slope(vertex), data.nearest.direction) for vertex in data.cell.polygon.vertices]
    signs = listed([_SIGNS[slope.sign()] for slope in slopes])
    return str(data.cell.index), str(data.nearest.index), str(data.second.index), needed, signs
