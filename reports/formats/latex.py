"""Reports as LaTeX that plain pdflatex compiles: article, amsmath and the standard tools, nothing else.

Figures are PDF files in a folder beside the source; without that folder the source compiles too, and each figure is its
caption with the command that draws it.
"""

from __future__ import annotations

from nonsmooth.reports.document import (
    Block,
    Bullets,
    Code,
    Display,
    Document,
    Figure,
    Inline,
    Listing,
    Math,
    Paragraph,
    Section,
    Table,
    Text,
    Verdict,
)

_PREAMBLE = r"""\documentclass[11pt]{article}
\usepackage[a4paper,margin=25mm]{geometry}
\usepackage{amsmath}
\usepackage{array,longtable}
\usepackage{graphicx}
\allowdisplaybreaks
\setlength{\parindent}{0pt}
\setlength{\parskip}{0.6em}
\renewcommand{\arraystretch}{1.3}
\sloppy
"""
_COMMANDS = ("section", "subsection", "subsubsection", "paragraph")
_ESCAPES = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "$": r"\$",
    "&": r"\&",
    "%": r"\%",
    "#": r"\#",
    "_": r"\_",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    "ä": r"\"a",
    '"': "''",  # the straight quotation mark is not in the default font encoding
}
_WESTERN = frozenset("ÀÁÂÃÄÅÆÇÈÉÊËÌÍÎÏÑÒÓÔÕÖØÙÚÛÜÝßàáâãäåæçèéêëìíîïñòóôõöøùúûüýÿ")


def render_latex(document: Document, figures: str = "figures") -> str:
    """The document as a LaTeX source, ending in a newline.

    Args:
        document: the report.
        figures: the folder of the figures, relative to the source.
    """
    parts = [_PREAMBLE + rf"\title{{{_escaped(document.title)}}}", r"\date{}", r"\begin{document}", r"\maketitle"]
    for section in document.sections:
        parts += _section(section, 0, figures)
    return "\n".join([*parts, r"\end{document}"]) + "\n"


def _section(section: Section, level: int, figures: str) -> list[str]:
    command = _COMMANDS[min(level, len(_COMMANDS) - 1)]
    parts = [f"\n\\{command}{{{_escaped(section.title)}}}"]
    parts += [_block(block, figures) for block in section.blocks]
    for subsection in section.subsections:
        parts += _section(subsection, level + 1, figures)
    return parts


def _block(block: Block, figures: str) -> str:
    match block:
        case Paragraph(text):
            return "\n" + _text(text)
        case Display(formula):
            return f"\\begin{{equation*}}\n{formula.latex}\n\\end{{equation*}}"
        case Bullets(items):
            return "\n".join([r"\begin{itemize}", *(rf"\item {_text(item)}" for item in items), r"\end{itemize}"])
        case Table():
            return _table(block)
        case Listing(text):
            return f"{{\\footnotesize\n\\begin{{verbatim}}\n{text}\n\\end{{verbatim}}\n}}"
        case Figure():
            return _figure(block, f"{figures}/{block.key}.pdf")


def _figure(block: Figure, file: str) -> str:
    """The picture where its file is, and its caption."""
    picture = rf"\includegraphics[width=\linewidth,height=0.42\textheight,keepaspectratio]{{\detokenize{{{file}}}}}"
    return "\n".join(
        [
            r"\begin{figure}[!htbp]",
            r"\centering",
            rf"\IfFileExists{{\detokenize{{{file}}}}}{{{picture}}}{{}}",
            rf"\caption{{{_text(block.caption)} Drawn by {_inline(Code(block.command))}.}}",
            r"\end{figure}",
        ]
    )


def _table(block: Table) -> str:
    shares = [width / sum(block.widths) for width in block.widths]
    columns = "".join(
        rf">{{\raggedright\arraybackslash}}p{{\dimexpr {share:.4f}\linewidth-2\tabcolsep\relax}}" for share in shares
    )
    head = " & ".join(rf"\textbf{{{_text(entry)}}}" for entry in block.header)
    lines = [rf"\begin{{longtable}}{{{columns}}}", r"\hline", rf"{head} \\", r"\hline", r"\endhead"]
    lines += [" & ".join(_text(entry) for entry in row) + r" \\" for row in block.rows]
    return "\n".join([*lines, r"\hline", r"\end{longtable}"])


def _text(text: Text) -> str:
    return "".join(_inline(part) for part in text)


def _inline(part: Inline) -> str:
    match part:
        case Math(latex, _):
            return f"${' '.join(latex.split())}$"
        case Code(text):
            return rf"\texttt{{{_escaped(text)}}}"
        case Verdict(text):
            return rf"\textbf{{{_escaped(text)}}}"
        case str():
            return _escaped(part)


def _escaped(text: str) -> str:
    """Literal text; characters that the default fonts do not hold appear by their code point."""
    return "".join(_character(c) for c in text).replace("--", "-{}-")


def _character(c: str) -> str:
    if c in _ESCAPES:
        return _ESCAPES[c]
    if c.isspace():
        return " "
    if (c.isascii() and c.isprintable()) or c in _WESTERN:
        return c
    return f"[U+{ord(c):04X}]"
