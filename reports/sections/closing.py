"""The last sections of the derivation report: the works that it rests on, versions and reproduction."""

from __future__ import annotations

import platform
from importlib.metadata import version

from nonsmooth.reports.console import own_version
from nonsmooth.reports.document import Bullets, Code, Listing, Section
from nonsmooth.reports.prose import paragraph
from nonsmooth.reports.references import how_to_cite
from nonsmooth.reports.subject import Subject

LIBRARIES = ("python-flint", "sympy", "numpy", "scipy", "matplotlib")


def references_section(subject: Subject) -> Section:
    """The works that this report rests on, and how to cite the program."""
    works = sorted(subject.works, key=lambda work: work.authors.split()[-1])
    listed = Bullets(tuple((work.text,) for work in works))
    return Section("References", (listed, paragraph("To cite this program:"), Listing(how_to_cite())))


def reproduction_section(subject: Subject) -> Section:
    """Versions and the command that writes this report."""
    libraries = ", ".join(f"{name} {version(name)}" for name in LIBRARIES)
    words = "nonsmooth {}, Python {}, {}. This report is written by {}."
    command = Code(subject.invocation.derive)
    versions = paragraph(words, own_version(), platform.python_version(), libraries, command)
    return Section("Versions and reproduction", (versions,))
