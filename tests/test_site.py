"""The site: every document is in its navigation, every public name has a page; built strictly where MkDocs is there."""

from __future__ import annotations

import os
import re
import runpy
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

import nonsmooth
from tests.test_api import typed_names

ROOT = Path(__file__).resolve().parents[1]
LOADED = re.compile(r"<(?:script|link|img|iframe|source)\b[^>]*\b(?:src|href)=\"(https?:)?//", re.IGNORECASE)


def hooks() -> dict[str, Any]:
    pytest.importorskip("mkdocs", reason="MkDocs is installed by `make site` only")
    return runpy.run_path(str(ROOT / "docs" / "site" / "hooks.py"))


def test_every_document_is_in_the_navigation() -> None:
    listed = set(re.findall(r"([\w/-]+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), re.MULTILINE))
    assert {path.name for path in (ROOT / "docs").glob("*.md")} <= listed
    assert listed - {path.name for path in (ROOT / "docs").glob("*.md")} <= {
        "reference/index.md",
        "contributing.md",
        "changelog.md",
        "security.md",
        "conduct.md",
    }


def test_every_public_name_has_a_page_and_formulas_become_mathml() -> None:
    made = hooks()
    pages = dict(made["reference_pages"]())
    for name in nonsmooth._MODULES:
        assert f"reference/{name}.md" in pages
        assert f"({name}.md)" in pages["reference/index.md"]
    for package in ("symbolic", "analysis", "proofs", "reports"):
        names = typed_names(package)
        assert names
        assert all(f"::: {module}.{name}\n" in pages[f"reference/{package}.md"] for name, module in names.items())
    formula = "```math\nx^2 < \\frac{1}{2}\n```"
    drawn = made["on_page_markdown"](f"Text:\n- one\n- two\n\n{formula}\n\n```\nkept\n- so\n```\n")
    assert "<math" in drawn
    assert "&lt; \\frac" in drawn  # the label that is read aloud
    assert "Text:\n\n- one\n- two\n" in drawn
    assert "kept\n- so\n" in drawn


def test_the_conda_recipe_has_the_dependencies_of_the_package() -> None:
    with (ROOT / "pyproject.toml").open("rb") as file:
        project = tomllib.load(file)["project"]
    recipe = (ROOT / "docs" / "packaging" / "meta.yaml").read_text(encoding="utf-8")
    run = recipe.partition("  run:\n")[2].partition("\ntest:")[0]
    listed = {line.strip(" -").replace("matplotlib-base", "matplotlib") for line in run.splitlines() if line.strip()}
    wanted = {dependency.replace(">= ", ">=") for dependency in project["dependencies"]}
    assert listed == {*wanted, f"python {project['requires-python'].replace(' ', '')}"}
    assert f'version: "{project["version"]}"' in recipe


@pytest.mark.thorough
def test_the_site_is_built_without_a_warning_and_loads_nothing_from_elsewhere(tmp_path: Path) -> None:
    pytest.importorskip("mkdocs", reason="MkDocs is installed by `make site` only")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(tmp_path)]
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    pages = sorted(tmp_path.rglob("*.html"))
    assert len(pages) > len(nonsmooth._MODULES)
    for page in pages:
        assert LOADED.search(page.read_text(encoding="utf-8")) is None, page
