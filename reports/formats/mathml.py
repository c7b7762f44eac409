"""Formulas of the document model as MathML, which browsers set without a script or a font of ours.

latex2mathml translates; here its gaps are bridged (``aligned``, bars and named operators are written as what it
knows) and its output is checked: anything but known elements and attributes, or a command it passed on unread, is an
error and not a report.  A formula is cut where its LaTeX says that a line may break, since browsers break no line
inside MathML.
"""

from __future__ import annotations

import re
from functools import lru_cache
from xml.etree import ElementTree as ET

NAMESPACE = "http://www.w3.org/1998/Math/MathML"
ELEMENTS = frozenset({
    "math", "mrow", "mi", "mn", "mo", "mtext", "mspace", "mfrac", "msqrt", "msup", "msub", "msubsup", "mover", "munder",
    "munderover", "mtable", "mtr", "mtd", "mstyle",
})  # fmt: skip
ATTRIBUTES = frozenset({
    "display", "displaystyle", "width", "linebreak", "stretchy", "fence", "form", "columnalign", "columnspacing",
    "rowspacing",
})  # fmt: skip
_KNOWN = (
    (r"{aligned}", r"{split}"),
    (r"\tfrac", r"\frac"),
    (r"\lvert", r"\left|"),  # fences, so that bars are set like brackets
    (r"\rvert", r"\right|"),
)
_OPERATOR = re.compile(r"\\operatorname\{(\w+)\}\s*(?=(\(|\\left|\\\{)?)")
_TOKENS = re.compile(r"\\allowbreak\\ |\\qquad\s?|\\(?:begin|end|left|right)(?![a-z])|\\.|[{}]|[^\\{}]+", re.DOTALL)
_OPENING, _CLOSING = (r"\begin", r"\left", "{"), (r"\end", r"\right", "}")


def inline_mathml(latex: str) -> list[str]:
    r"""A formula of running text as ``<math>`` elements, between which a line may break (at ``\allowbreak``)."""
    return [_mathml(part, "inline") for part in _parts(latex, r"\allowbreak\ ")]


def display_mathml(latex: str) -> list[str]:
    r"""A displayed formula as ``<math>`` elements that stand beside each other where there is room (at ``\qquad``)."""
    return [_mathml(part, "block") for part in _parts(latex, r"\qquad")]


def _parts(latex: str, separator: str) -> list[str]:
    """The formula cut at separators outside all braces and environments."""
    parts, depth = [""], 0
    for token in _TOKENS.findall(latex):
        depth += (token in _OPENING) - (token in _CLOSING)
        if token.strip() == separator.strip() and not depth:
            parts.append("")
        else:
            parts[-1] += token
    return [part.strip() for part in parts if part.strip()]


@lru_cache(maxsize=4096)
def _mathml(latex: str, mode: str) -> str:
    from latex2mathml.converter import convert

    source = _OPERATOR.sub(_operator, latex.replace(r"\allowbreak", ""))
    for ours, theirs in _KNOWN:
        source = source.replace(ours, theirs)
    markup = convert(source, display=mode)
    _require_mathml(latex, markup)
    return markup.replace(f' xmlns="{NAMESPACE}"', "").replace(' display="inline"', "")


def _operator(match: re.Match[str]) -> str:
    """A named operator as text, with a thin space before an argument without brackets."""
    return rf"\text{{{match.group(1)}}}" + ("" if match.group(2) else r"\, ")


def _require_mathml(latex: str, markup: str) -> None:
    try:
        elements = list(ET.fromstring(markup).iter())
    except ET.ParseError:
        elements = []
    strange = {element.tag.removeprefix(f"{{{NAMESPACE}}}") for element in elements} - ELEMENTS
    strange |= {name for element in elements for name in element.attrib} - ATTRIBUTES
    unread = any(c in (element.text or "") for element in elements for c in "\\&")
    if not elements or strange or unread:
        raise ValueError(f"required LaTeX that becomes MathML, received {latex!r}")
