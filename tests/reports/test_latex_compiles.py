"""The LaTeX report compiles with plain pdflatex, for every built-in scene and for hostile text, and fits its page."""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from nonsmooth.reports.checks.subject import Invocation
from nonsmooth.reports.derivations.derivation import derive_report, render_report
from nonsmooth.reports.derivations.parts import PART_NAMES
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.reports.derived import derived
from tests.thorough import few, keep

WIDEST = 5.0  # points by which a box may stick out: below a character, unseen on paper
HOSTILE = "a_b*c|d $x$ 50% #1 {e} \\f ^g ~h <i> `j` & [k](l) -- \u4e2d"

pytestmark = pytest.mark.skipif(
    shutil.which("pdflatex") is None,
    reason="pdflatex is not installed (Debian: texlive-latex-base, texlive-latex-extra; `make tools` tries)",
)


def compiled(folder: Path, source: str) -> str:
    """What pdflatex says while it compiles a report."""
    (folder / "r.tex").write_text(source, encoding="utf-8")
    line = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "r.tex"]
    done = subprocess.run(line, cwd=folder, capture_output=True, timeout=120, check=False)
    said = done.stdout.decode("latin-1")
    assert done.returncode == 0, said[-2000:]
    assert (folder / "r.pdf").stat().st_size > 10_000
    return said


def overfull(said: str) -> list[float]:
    """By how many points boxes stick out."""
    return [float(points) for points in re.findall(r"Overfull \\[hv]box \(([\d.]+)pt", said)]


KINDS = ("four-wheel", "elliptic", "carton-on-6x6", "ring-3")  # small, spiral, with an outline, odd


@few(1)
@pytest.mark.parametrize("name", keep(2, dict.fromkeys((*KINDS, *builtin_scenes()))))
def test_every_built_in_scene_compiles_and_fits(tmp_path: Path, name: str) -> None:
    said = compiled(tmp_path, render_report(derived(name), ".tex"))
    assert max(overfull(said), default=0.0) <= WIDEST


@few(1)
@pytest.mark.parametrize("rule", ["box", "ellipse"])
def test_the_other_rules_compile_and_fit(tmp_path: Path, rule: str) -> None:
    assert max(overfull(compiled(tmp_path, render_report(derived("four-wheel", rule), ".tex"))), default=0.0) <= WIDEST


@pytest.mark.parametrize("extent", keep(1, ["short", "all"]))
def test_figures_lie_in_a_folder_beside_the_source(tmp_path: Path, extent: str) -> None:
    parts = ("array", "cells") if extent == "short" else PART_NAMES
    report = derive_report(load_scene("four-wheel"), parts=parts)
    report.save(tmp_path / "report.tex")
    files = {file.name for file in (tmp_path / "report-figures").iterdir()}
    assert files == {f"{figure.key}.pdf" for figure in report.document.figures}
    assert len(files) >= 2
    said = compiled(tmp_path, (tmp_path / "report.tex").read_text(encoding="utf-8"))
    unbroken = said.replace("\n", "")  # pdflatex breaks its lines at 79 characters
    assert all(f"report-figures/{name}" in unbroken for name in files)


# The sections that write the scene's name, or a command that names it, without the long trajectories and precision.
NAMING = ("answers", "array", "cells", "derivative", "rules", "stress", "versions")


@pytest.mark.parametrize(
    ("name", "parts"), keep(1, [("four-wheel-side", NAMING), ("four-wheel-side", PART_NAMES), ("ring-3", PART_NAMES)])
)
def test_hostile_names_compile(tmp_path: Path, name: str, parts: tuple[str, ...]) -> None:
    scene = replace(load_scene(name), name=HOSTILE)
    source = render_report(derive_report(scene, Invocation(HOSTILE), parts), ".tex")
    assert source.count("U+4E2D") > 2
    compiled(tmp_path, source)
