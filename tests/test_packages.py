"""The rules of the packages: what is packaged, who may import whom, and what the exact packages may not contain."""

import ast
import re
import sys
import tokenize
import tomllib
import unicodedata
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import pytest

from tests.sources import PACKAGES, ROOT, Import, sources, summary_of, text_of, tokens

NEVER_IMPORTED = {"symbolic": {"scipy"}, "analysis": {"matplotlib"}}
LAZILY_IMPORTED = {"cvxpy", "matplotlib", "jinja2"}
IMPORTED_AS = {"python-flint": "flint", "mujoco-core": "mujoco", "z3-solver": "z3", "pillow": "PIL"}
RUN_AS_COMMANDS = {"pytest-xdist", "ipykernel"}  # for the tests, but imported by none
STANDS_ALONE = "proofs/checker/"  # runs without the package, so its modules name each other by relative imports
EVALUATES_TEXT = {"eval", "exec", "sympify", "parse_expr"}
TOLERANCE_NAMES = {"isclose", "allclose", "tol", "atol", "rtol", "tolerance"}
LOOKS_LIKE_IMPORT = re.compile(r"^\s*(?:import|from)\s+(\w+)", re.MULTILINE)  # each statement has a line of its own
TOLERANCE_NUMBER = re.compile(r"\b\d*\.?\d*e-\d+", re.IGNORECASE)


def place(path: Path, line: int) -> str:
    return f"{path.relative_to(ROOT)}:{line}"


@cache
def imports(package: str) -> list[tuple[str, Import]]:
    """Every import of a package and where it stands, also those inside functions."""
    return [(place(path, found.line), found) for path in sources(package) for found in summary_of(path).imports]


def listed_packages() -> list[str]:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    listed: list[str] = project["tool"]["setuptools"]["packages"]
    return listed


def test_listed_packages_are_those_on_disk() -> None:
    folders = {path.parent for package in PACKAGES for path in sources(package)}
    on_disk = sorted(".".join(("nonsmooth", *folder.relative_to(ROOT).parts)) for folder in {ROOT, *folders})
    assert sorted(listed_packages()) == on_disk


@pytest.mark.parametrize("package", listed_packages())
@pytest.mark.parametrize("file", ["__init__.py", "py.typed"])
def test_package_has(package: str, file: str) -> None:
    assert ROOT.joinpath(*package.split(".")[1:], file).is_file()


@pytest.mark.parametrize("package", PACKAGES)
def test_imports_flow_one_way(package: str) -> None:
    downstream = set(PACKAGES[PACKAGES.index(package) + 1 :])
    found = [
        f"{where} imports {module}"
        for where, statement in imports(package)
        for module in statement.modules
        if module.startswith("nonsmooth.") and module.split(".")[1] in downstream
    ]
    assert found == []


@pytest.mark.parametrize("package", PACKAGES)
def test_imports_are_absolute_and_through_nonsmooth(package: str) -> None:
    found = [
        where
        for where, statement in imports(package)
        if not where.startswith(STANDS_ALONE)
        if statement.is_relative or any(module.split(".")[0] in PACKAGES for module in statement.modules)
    ]
    assert found == []


@pytest.mark.parametrize("package", NEVER_IMPORTED)
def test_package_does_not_import(package: str) -> None:
    found = [
        f"{where} imports {module}"
        for where, statement in imports(package)
        for module in statement.modules
        if module.split(".")[0] in NEVER_IMPORTED[package]
    ]
    assert found == []


@pytest.mark.parametrize("package", PACKAGES)
def test_heavy_libraries_are_imported_by_the_call_that_needs_them(package: str) -> None:
    found = [
        f"{where} imports {module}"
        for where, statement in imports(package)
        if not (statement.in_function or statement.for_types)
        for module in statement.modules
        if module.split(".")[0] in LAZILY_IMPORTED
    ]
    assert found == []


def mentions(path: Path, names: Iterable[str]) -> bool:
    """Whether a name stands anywhere in a file, as Python reads names: files that do not mention it need no parser."""
    text = unicodedata.normalize("NFKC", text_of(path))
    return re.search(rf"\b(?:{'|'.join(names)})\b", text) is not None


@pytest.mark.parametrize("package", PACKAGES)
def test_text_is_never_evaluated(package: str) -> None:
    found = []
    for path in sources(package):
        if not mentions(path, EVALUATES_TEXT):
            continue
        for node in ast.walk(ast.parse(text_of(path))):
            if isinstance(node, ast.Call):
                name = ast.unparse(node.func).rsplit(".", maxsplit=1)[-1]
            elif isinstance(node, ast.alias):
                name = node.name
            else:
                continue
            if name in EVALUATES_TEXT:
                found.append(f"{place(path, node.lineno)} {name}")
    assert found == []


@pytest.mark.parametrize("package", ["symbolic", "analysis/cells", "proofs"])
def test_exact_packages_have_no_tolerance(package: str) -> None:
    found = []
    for path in sources(package):
        if not (mentions(path, TOLERANCE_NAMES) or TOLERANCE_NUMBER.search(text_of(path))):
            continue
        for token in tokens(text_of(path)):
            small_number = token.type == tokenize.NUMBER and TOLERANCE_NUMBER.search(token.string)
            if small_number or (token.type == tokenize.NAME and token.string in TOLERANCE_NAMES):
                found.append(f"{place(path, token.start[0])} {token.string}")
    assert found == []


def declared(key: str) -> set[str]:
    """Libraries that pyproject.toml names under a key of [project], as they are imported."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        project = tomllib.load(file)["project"]
    listed = project["dependencies"] if key == "dependencies" else project["optional-dependencies"][key]
    names = {re.split(r"[ >=;]", line)[0] for line in listed}
    return {IMPORTED_AS.get(name, name) for name in names}


def imported_libraries(folders: tuple[str, ...]) -> set[str]:
    """Third-party libraries that the folders import anywhere.

    Files are parsed that have a line which looks as if it imported a library that no file before them does.
    """
    found: set[str] = set()
    for path in (path for folder in folders for path in sources(folder)):
        if third_party(LOOKS_LIKE_IMPORT.findall(text_of(path))) - found:
            own = (statement for statement in summary_of(path).imports if not statement.is_relative)
            found |= third_party(module for statement in own for module in statement.modules)
    return found


def third_party(modules: Iterable[str]) -> set[str]:
    """The names of libraries among those of modules."""
    return {name.partition(".")[0] for name in modules} - set(sys.stdlib_module_names) - {"nonsmooth", "tests"}


def test_dependencies_are_those_that_are_imported() -> None:
    extras = declared("workbench") | declared("notebook")
    assert imported_libraries(PACKAGES) - extras == declared("dependencies")
    for_tests = imported_libraries(("tests",)) - declared("dependencies")
    assert for_tests - declared("bench") <= declared("test")
    assert declared("test") - for_tests == RUN_AS_COMMANDS | extras


def test_only_the_workbench_imports_its_server_and_its_widget() -> None:
    extras = declared("workbench") | declared("notebook")
    found = [
        where
        for package in PACKAGES
        for where, statement in imports(package)
        if not where.startswith("reports/workbench/")
        and extras & {module.partition(".")[0] for module in statement.modules}
    ]
    assert found == []


@pytest.mark.parametrize("file", ["constraints.txt", "constraints-lowest.txt"])
def test_constraints_are_names_and_versions_only(file: str) -> None:
    text = (ROOT / file).read_text(encoding="utf-8")
    pins = [line for line in text.splitlines() if not line.startswith("#")]
    assert pins
    assert [line for line in pins if not re.fullmatch(r"[A-Za-z0-9._-]+==[A-Za-z0-9.!+]+", line)] == []
    assert "://" not in text


def test_lower_bounds_are_the_versions_that_are_tested() -> None:
    with (ROOT / "pyproject.toml").open("rb") as file:
        bounds = dict(line.lower().split(" >= ") for line in tomllib.load(file)["project"]["dependencies"])
    text = (ROOT / "constraints-lowest.txt").read_text(encoding="utf-8").lower()
    pins = dict(line.split("==") for line in text.splitlines() if not line.startswith("#"))
    assert {name: pins[name].removesuffix(".0") for name in bounds} == bounds


@pytest.mark.parametrize("package", ["symbolic", "proofs"])
def test_verdicts_take_exact_signs(package: str) -> None:
    """Slacks are for paths in floats: what decides around a point is told of none."""
    slacks = {"Signs", "signs_of"}
    found = []
    for path in sources(package):
        for token in tokens(text_of(path)) if mentions(path, slacks) else ():
            if token.type == tokenize.NAME and token.string in slacks:
                found.append(place(path, token.start[0]))
    assert found == []
