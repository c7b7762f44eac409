"""Running text of reports, written in plain notation: ``prose("`V*` is negative in cell {}", cell)``.

A formula stands between backquotes in plain notation and is looked up in NOTATION for its LaTeX, so every formula
of the prose is written once, and a misspelt one is an error.  ``{}`` takes the next value, which may be any text.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache

from nonsmooth.reports.output.document import Inline, Math, Paragraph, Text

_PARTS = re.compile(r"`([^`]*)`|(\{\})")
_ROOT = r"(-?)(\d+\*)?sqrt\((\d+)\)(?:/(\d+))?"  # such as -3*sqrt(2)/4
_FRACTION = r"(-?\d+)/(\d+)"
_GREEK = frozenset({"theta", "omega", "xi", "kappa", "Delta"})

_NOTATION = {
    "theta": r"\theta",
    "omega": r"\omega",
    "-omega": r"-\omega",
    "theta > 0": r"\theta > 0",
    "theta = 0": r"\theta = 0",
    "v": "v",
    "i": "i",
    "j": "j",
    "y": "y",
    "V": "V",
    "V'": r"\dot V",
    "V/2": "V/2",
    "V*": r"\dot V^*",
    "V* > 0": r"\dot V^* > 0",
    "|c|": r"\lvert c \rvert",
    "|c_0|": r"\lvert c_0 \rvert",
    "V = |c|^2": r"V = \lvert c \rvert^2",
    "|omega| <= K |v|": r"\lvert \omega \rvert \le K \lvert v \rvert",
    "u = -k (a, b)": r"u = -k\,(a, b)",
    "c' = A c": r"\dot c = A c",
    "0 in F": r"0 \in F",
    "|c|^2 + theta^2": r"\lvert c \rvert^2 + \theta^2",
    "|c|^2 + l^2 theta^2": r"\lvert c \rvert^2 + l^2 \theta^2",
    "c^T P c + w theta^2": r"c^T P c + w \theta^2",
    "m . xi = 0": r"m \cdot \xi = 0",
    "omega = 0": r"\omega = 0",
    "V* < 0": r"\dot V^* < 0",
    "V* <= 0": r"\dot V^* \le 0",
    "V* = 0": r"\dot V^* = 0",
    "V*/|c|": r"\dot V^* / \lvert c \rvert",
    "V = |c - c*|^2": r"V = \lvert c - c^* \rvert^2",
    "V = x^2 + y^2 + theta^2": r"V = x^2 + y^2 + \theta^2",
    "|c|^2": r"\lvert c \rvert^2",
    "F(c*)": "F(c^*)",
    "c*": "c^*",
    "p_i": "p_i",
    "d_i": "d_i",
    "u_i": "u_i",
    "u_j": "u_j",
    "d_j": "d_j",
    "n_j": "n_j",
    "mu_R": r"\mu_R",
    "mu_S": r"\mu_S",
    "mu_S > mu_R": r"\mu_S > \mu_R",
    "mu_S < mu_R": r"\mu_S < \mu_R",
    "c": "c",
    "c = 0": "c = 0",
    "xi": r"\xi",
    "xi_l": r"\xi_l",
    "-k (g . xi_l)": r"-k\, (g \cdot \xi_l)",
    "N_i": "N_i",
    "P": "P",
    "P = I": "P = I",
    "w": "w",
    "l": "l",
    "c^T P d_i": r"c^T P d_i",
    "c^T P d_i = 0": r"c^T P d_i = 0",
    "V'/V": r"\dot V / V",
    "k": "k",
    "c = (x, y)": "c = (x, y)",
    "p_i - c": "p_i - c",
    "J = [[0, -1], [1, 0]]": r"J = \begin{pmatrix} 0 & -1 \\ 1 & 0 \end{pmatrix}",
    "xi = (v, omega)": r"\xi = (v, \omega)",
    "v + omega J p": r"v + \omega J p",
    "c' = v + omega J c, theta' = omega": r"\dot c = v + \omega J c,\ \dot\theta = \omega",
    "omega J c": r"\omega J c",
    "c . J c = 0": r"c \cdot J c = 0",
    "c . d_i": r"c \cdot d_i",
    "c . d_i = 0": r"c \cdot d_i = 0",
    "d_i . d_j = 0": r"d_i \cdot d_j = 0",
    "a_i": "a_i",
    "a_j": "a_j",
    "u_j a_j . d_j": r"u_j\, a_j \cdot d_j",
    "y . (v, 1) >= omega": r"y \cdot (v, 1) \ge \omega",
    "sgn x": r"\operatorname{sgn} x",
    "sgn y": r"\operatorname{sgn} y",
    "sgn(y^2 - x^2)": r"\operatorname{sgn}(y^2 - x^2)",
    "u_j = -k theta": r"u_j = -k \theta",
    "u_j = -sgn(Delta) k theta": r"u_j = -\operatorname{sgn}(\Delta)\, k \theta",
    "u_i = |u_j| + k |(x, y)|": r"u_i = \lvert u_j \rvert + k \lvert (x, y) \rvert",
    "Delta": r"\Delta",
    "theta' = u_j/Delta": r"\dot\theta = u_j / \Delta",
    "theta' < 0": r"\dot\theta < 0",
    "theta' > 0": r"\dot\theta > 0",
    "Delta = d_j . J(p_j - p_i)": r"\Delta = d_j \cdot J(p_j - p_i)",
    "kappa": r"\kappa",
    "m >= kappa |c|": r"m \ge \kappa \lvert c \rvert",
    "m >= |w|": r"m \ge \lvert w \rvert",
    "1/|Delta| >= kappa": r"1 / \lvert \Delta \rvert \ge \kappa",
    "V' <= -sqrt(2) k V": r"\dot V \le -\sqrt{2}\, k V",
    "|p_2|": r"\lvert p_2 \rvert",
    "u_i = -k a": r"u_i = -k a",
    "u_j = -k b": r"u_j = -k b",
    "sqrt(|v|^2 + (R omega)^2)": r"\sqrt{\lvert v \rvert^2 + (R \omega)^2}",
}


def prose(text: str, *values: Inline) -> Text:
    """Running text with its formulas.

    Args:
        text: words, with formulas in backquotes and ``{}`` where a value goes.
        values: formulas, code or literal text for the ``{}``.

    Raises:
        ValueError: for a formula outside the notation, or a number of values that does not fit.
    """
    waiting = list(values)

    def part(match: re.Match[str]) -> Inline:
        plain = match.group(1)
        if not match.group(2):
            if plain not in _NOTATION:
                raise ValueError(f"required a formula of the notation, received {plain!r}")
            return Math(_NOTATION[plain], plain)
        if not waiting:
            raise ValueError(f"required a value for every {{}} of {text!r}, received {len(values)}")
        return waiting.pop(0)

    found = _with_parts(text, _PARTS, part)
    if waiting:
        raise ValueError(f"required a {{}} for every value of {text!r}, received {len(values)} values")
    return found


def _with_parts(text: str, pattern: re.Pattern[str], part: Callable[[re.Match[str]], Inline]) -> Text:
    """A text with what stands for each match in its place."""
    parts: list[Inline] = []
    end = 0
    for match in pattern.finditer(text):
        parts += [text[end : match.start()]] * (match.start() > end)
        parts.append(part(match))
        end = match.end()
    return (*parts, text[end:]) if text[end:] else tuple(parts)


def with_formulas(text: str) -> Text:
    """A sentence of the program in plain notation, with the formulas and exact numbers in it set as such."""
    return _with_parts(text, _in_sentences(), _number_or_formula) or (text,)


@cache
def _in_sentences() -> re.Pattern[str]:
    """The notation but for single letters and words, longest first, then exact numbers with roots, then fractions."""
    names = [name for name in _NOTATION if not name.isalpha() or name in _GREEK]
    notation = "|".join(re.escape(name) for name in sorted(names, key=len, reverse=True))
    return re.compile(rf"(?<![\w.|^~])(?<!\*\*)(?:({notation})|{_ROOT}|{_FRACTION})(?![\w*'|^(/]|[.]\d)")


def _number_or_formula(match: re.Match[str]) -> Math:
    name, sign, factor, root, below, over, under = match.groups()
    if name:
        return Math(_NOTATION[name], name)
    if over:
        return Math(rf"{'-' * over.startswith('-')}\tfrac{{{over.lstrip('-')}}}{{{under}}}", match.group())
    top = rf"{(factor or '').rstrip('*')}\sqrt{{{root}}}"
    return Math(sign + (rf"\tfrac{{{top}}}{{{below}}}" if below else top), match.group())


def paragraph(text: str, *values: Inline) -> Paragraph:
    """A paragraph of :func:`prose`."""
    return Paragraph(prose(text, *values))


def listed(values: list[Math]) -> Text:
    """``a, b, c``."""
    text: list[Inline] = []
    for value in values:
        text += [", ", value] if text else [value]
    return tuple(text)
