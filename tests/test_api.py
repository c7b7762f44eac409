"""The public names: each exists, is documented and is on the page; results show themselves in a notebook."""

from __future__ import annotations

import ast
import inspect
import pkgutil
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from fractions import Fraction
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from types import FunctionType

import pytest

import nonsmooth
from nonsmooth.analysis import Kinematics, array_field, build_partition, simulate
from nonsmooth.proofs import audit, check_theorem4, decide_system
from nonsmooth.symbolic import governing_equations, load_scene, load_system
from tests.conftest import Arrays
from tests.thorough import keep

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("symbolic", "analysis", "proofs", "reports")
HOSTILE = '<img src=x onerror="alert(1)">'


def typed_names(package: str) -> dict[str, str]:
    """What a type checker sees: name and module, from the block that only it reads."""
    tree = ast.parse((ROOT / package / "__init__.py").read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    imported = [node for node in block.body if isinstance(node, ast.ImportFrom)]
    return {alias.name: str(node.module) for node in imported for alias in node.names}


@pytest.mark.parametrize("package", PACKAGES)
def test_public_names_exist_and_are_documented(package: str) -> None:
    imported = import_module(f"nonsmooth.{package}")
    page = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    section = page.split(f"## `nonsmooth.{package}`")[1].split("\n## ")[0]
    submodules = {inner.name for inner in pkgutil.iter_modules(imported.__path__)}
    assert typed_names(package)
    for name, module in typed_names(package).items():
        value = getattr(imported, name)
        assert value is getattr(import_module(module), name)
        assert value.__doc__
        assert name not in submodules
        assert re.search(rf"`[^`]*\b{name}\b[^`]*`", section), name


@pytest.mark.parametrize("package", PACKAGES)
def test_unknown_names_are_refused(package: str) -> None:
    with pytest.raises(AttributeError, match=rf"module 'nonsmooth.{package}' has no attribute 'nothing'"):
        getattr(import_module(f"nonsmooth.{package}"), "nothing")  # noqa: B009


PAGES = [(ROOT / name).read_text(encoding="utf-8") for name in ("README.md", "docs/api.md", "docs/start.md")]
EXAMPLES = [block.split("```")[0] for page in PAGES for block in page.split("```python\n")[1:]]


@pytest.mark.parametrize("number", keep(1, [1, 0, *range(2, len(EXAMPLES))]))  # the second one says what it prints
def test_every_program_of_the_page_prints_what_it_says(number: int, tmp_path: Path) -> None:
    """In a process of its own, in which every warning is an error."""
    example = EXAMPLES[number]
    command = [sys.executable, "-W", "error", "-c", example]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert len(example.splitlines()) <= 16
    for line in example.splitlines():  # what a comment says is printed
        said = re.fullmatch(r"print\(.*\)  # (.*)", line)
        assert said is None or said[1] in done.stdout.splitlines()


def test_the_front_of_the_package() -> None:
    names = typed_names(".")
    page = (
        (ROOT / "docs" / "api.md").read_text(encoding="utf-8").split("## `nonsmooth`:")[1].split("## The packages")[0]
    )
    assert {*names, *PACKAGES, "__version__"} == set(dir(nonsmooth))
    for name, module in names.items():
        assert getattr(nonsmooth, name) is getattr(import_module(module), name)
        assert getattr(nonsmooth, name).__doc__
        assert re.search(rf"`[^`]*\b{name}\b[^`]*`", page), name
    assert nonsmooth.__version__ == version("nonsmooth")
    with pytest.raises(AttributeError, match="module 'nonsmooth' has no attribute 'nothing'"):
        getattr(nonsmooth, "nothing")  # noqa: B009


def public_functions() -> Iterator[tuple[str, FunctionType]]:
    """Every public function, and every method of a public class, below its dotted name."""
    for package in (".", *PACKAGES):
        for name, module in typed_names(package).items():
            value = getattr(import_module(module), name)
            members = vars(value) if isinstance(value, type) else {"": value}
            for inner, member in members.items():
                function = getattr(member, "__func__", getattr(member, "fget", member))
                if isinstance(function, FunctionType) and not inner.startswith("_"):
                    yield f"{module}.{name}.{inner}".rstrip("."), function


def unsaid(function: Callable[..., object]) -> list[str]:
    """What a docstring does not name: itself, or one of several arguments."""
    said = inspect.getdoc(function) or ""
    named = [name for name in inspect.signature(function).parameters if name not in ("self", "cls")]
    lacking = [name for name in named if not re.search(rf"\b{name}\b", said)] if len(named) > 1 else []
    return lacking if said else ["docstring", *lacking]


def test_every_argument_of_every_public_function_is_documented() -> None:
    found = dict(public_functions())
    assert len(found) > 200
    inherited = {name for name, function in found.items() if not function.__doc__}  # said where it is declared first
    assert {name: unsaid(own) for name, own in found.items() if name not in inherited and unsaid(own)} == {}

    def plain(one: int, another: int) -> int:
        """One is said here."""
        return one + another

    assert unsaid(plain) == ["one", "another"]  # the words count, not their capitals


def test_every_field_of_every_public_class_is_documented() -> None:
    """Options of commands say what they are in their help."""
    lacking: dict[str, list[str]] = {}
    seen = 0
    for package in (".", *PACKAGES):
        for name, module in typed_names(package).items():
            value = getattr(import_module(module), name)
            if not (isinstance(value, type) and is_dataclass(value)):
                continue
            said = "\n".join(base.__doc__ or "" for base in value.__mro__)
            named = [entry.name for entry in fields(value) if entry.name[0] != "_" and "option" not in entry.metadata]
            unsaid_fields = [own for own in named if not re.search(rf"\b{own}\b.*:", said)]
            lacking |= {f"{module}.{name}": unsaid_fields} if unsaid_fields else {}
            seen += len(named)
    assert seen > 100
    assert lacking == {}


def test_importing_the_package_loads_nothing() -> None:
    loaded = "sorted({'numpy', 'sympy', 'flint', 'rich'} & set(sys.modules))"
    code = f"import sys, nonsmooth as ns; dir(ns); print({loaded})"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"


def test_the_package_runs_as_a_module() -> None:
    done = subprocess.run([sys.executable, "-m", "nonsmooth", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"nonsmooth {version('nonsmooth')}\n"


def test_symbolic_stands_alone() -> None:
    code = (
        "import sys; from nonsmooth.symbolic import load_scene, scene_rows, take_census; "
        "take_census(load_scene('ring-5')); "
        "print(sorted({'scipy', 'cvxpy', 'matplotlib', 'jinja2', 'rich', 'typer'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_results_are_tables_in_a_notebook(arrays: Arrays) -> None:
    scene = replace(arrays.four_wheel((1, Fraction(1, 2))), name=HOSTILE)
    partition = build_partition(scene)
    path = simulate(array_field(partition, Kinematics.LEADING), (Fraction(1, 5), Fraction(2, 5), 0), 2)
    system = replace(load_system("eq-4"), name=HOSTILE)
    shown = {
        "asymptotically stable": check_theorem4(scene),
        "R1 S1 R2": partition,
        "slide": path,
        "strong stability": decide_system(system),
        "x**2 + y**2": audit(scene, "x**2 + y**2"),
    }
    for words, result in shown.items():
        html = result._repr_html_()
        assert html.startswith("<table>")
        assert html.endswith("</table>")
        assert words in html
        assert "<img" not in html


def test_formulas_are_formulas_in_a_notebook() -> None:
    state = build_partition(load_scene("four-wheel")).states[0]
    assert r"\begin{aligned}" in governing_equations(state)._repr_latex_()
    assert state.twist.omega._repr_latex_() in (r"$\frac{\sqrt{2}}{2}$", r"$- \frac{\sqrt{2}}{2}$")
