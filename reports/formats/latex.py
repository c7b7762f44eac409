"""Reports as LaTeX that plain pdflatex compiles: article, amsmath and the standard tools, nothing else.

Figures are PDF files in a folder beside the source; without that folder the source compiles too, and each figure is its
caption with the command that draws it.
"""

from __future__ import annotations

from nonsmooth.reports.output.document import (
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
_LINE, _GAP, _LETTER = 455.0, 12.0, 6.6  # points: a line of 160 mm, twice \\tabcolsep, a letter in bold
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
    shares = _shares(block)
    columns = "".join(
        rf">{{\raggedright\arraybackslash}}p{{\dimexpr {share:.4f}\linewidth-2\tabcolsep\relax}}" for share in shares
    )
    head = " & ".join(rf"\textbf{{{_text(entry)}}}" for entry in block.header)
    lines = [rf"\begin{{longtable}}{{{columns}}}", r"\hline"]
    lines += [rf"{head} \\", r"\hline", r"\endhead"] if block.header else []
    lines += [" & ".join(_text(entry) for entry in row) + r" \\" for row in block.rows]
    return "\n".join([*lines, r"\hline", r"\end{longtable}"])


def _shares(block: Table) -> list[float]:
    """The columns' shares of the line: as the table says, but none narrower than the longest word of its head."""
    words = [
        max((len(word) for word in _plain(entry).split()), default=0)
        for entry in block.header or ((),) * len(block.widths)
    ]
    least = [(_LETTER * letters + _GAP) / _LINE for letters in words]
    shares = [width / sum(block.widths) for width in block.widths]
    narrow = [share < floor for share, floor in zip(shares, least, strict=True)]
    given = sum(floor for floor, held in zip(least, narrow, strict=True) if held)
    free = sum(share for share, held in zip(shares, narrow, strict=True) if not held)
    scale = (1 - given) / free if free and given < 1 else 1.0
    return [floor if held else share * scale for share, floor, held in zip(shares, least, narrow, strict=True)]


def _plain(text: Text) -> str:
    """The words of a text; a formula counts for none, it is short in a head."""
    return "".join(part if isinstance(part, str) else " " for part in text)


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
