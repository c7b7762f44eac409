"""The documents: their commands run as typed and print what is shown, their links and names resolve.

Blocks marked ``sh`` hold commands, blocks marked ``console`` commands after ``$ `` with what they print; a line ``...``
stands for any lines, ``...`` inside a line for any text.  A command must end with the exit status that the document
states: by ``# exit status N``, by a following ``echo $?`` or by ``|| test $? -eq N``, and with 0 where it states none.
"""

from __future__ import annotations

import io
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from contextlib import redirect_stdout
from dataclasses import is_dataclass
from importlib import import_module
from importlib.util import find_spec
from itertools import zip_longest
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from typer.core import TyperGroup
from typer.main import get_command

from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import BAD_INPUT, run
from tests.thorough import keep

ROOT = Path(__file__).resolve().parents[1]
WITH_COMMANDS = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
LONGEST = ("choose.md", "stress.md", "theory.md")  # their commands run in `make bench`
LONG_COMMANDS = re.compile(
    r"nonsmooth (derive .*\.html|design|precision|stress|simulate .*--(grid|tables)|simulate \S+\.toml .*--until 3"
    r"|simulate table\.toml .*--fail|sweep .*\.svg|sweep .*--borders|check twist\.toml"
    r"|check table\.toml$|check table\.toml .*--law"
    r"|check relay-chain|check \S+\.toml .*--json > \S+"
    r"|check \S+\.toml --(at auto|require (pose|tolerances))|check \S+\.toml .*--rule ellipse)(\b|$)"
)  # and these, of which tests/reports has smaller ones
WRITTEN = re.compile(r" (?:-o|--law|>) (\S+)")
NAMED = re.compile(r"[\w./-]+")
SHORTER = [path for path in WITH_COMMANDS if path.name not in LONGEST]
DOCUMENTS = [*WITH_COMMANDS, ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"]

PACKAGES = ("symbolic", "analysis", "proofs", "reports")

FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
HERE_DOCUMENT = re.compile(r"cat > (\S+) <<'(\w+)'")
STATED = re.compile(r"#.*exit status (\d+)")
ALLOWED = re.compile(r"(.*) \|\| test \$\? -eq (\d+)")
NOT_RUN = {"make", "git", "pip", "pipx", "uv", "."}  # they install, build or change the shell
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
CODE_NAME = re.compile(r"`((?:symbolic|analysis|proofs|reports)(?:\.\w+)+)`")
SOURCE = re.compile(r"([A-Z][^\W\d_]+)(?: and others)? \(?((?:18|19|20)\d\d)\b")  # Filippov 1988, Paden (1994)
CODE_PATH = re.compile(r"`((?:symbolic|analysis|proofs|reports|tests|docs)/[\w./-]*)`")
REGISTRIES = re.compile(r"pypi\.org|pythonhosted\.org|anaconda\.org|npmjs\.|crates\.io|rubygems\.org", re.IGNORECASE)

every_document = pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)


class Command(NamedTuple):
    """One command of a document."""

    line: int
    text: str
    body: str  # of a here-document
    shown: list[str] | None  # what the document prints below it

    @property
    def stated(self) -> int | None:
        """The exit status in its comment."""
        match = STATED.search(self.text)
        return int(match.group(1)) if match else None


# ---- reading -------------------------------------------------------------------------------------


def commands(text: str) -> list[Command]:
    """All commands of a document, in order."""
    found: list[Command] = []
    for match in FENCE.finditer(text):
        first = text[: match.start()].count("\n") + 2
        lines = list(enumerate(match.group(2).splitlines(), first))
        if match.group(1) == "sh":
            found += shell_commands(iter(lines))
        elif match.group(1) == "console":
            found += console_commands(lines)
    return found


def shell_commands(lines: Iterator[tuple[int, str]]) -> Iterator[Command]:
    for number, line in lines:
        if not line.strip() or line.startswith("#"):
            continue
        here = HERE_DOCUMENT.fullmatch(line)
        body = []
        if here:
            for _, inner in lines:
                if inner == here.group(2):
                    break
                body.append(inner + "\n")
        yield Command(number, line, "".join(body), None)


def console_commands(lines: list[tuple[int, str]]) -> Iterator[Command]:
    starts = [k for k, (_, line) in enumerate(lines) if line.startswith("$ ")]
    assert starts[:1] == [0], f"line {lines[0][0]}: required a command after '$ '"
    for start, end in zip(starts, [*starts[1:], len(lines)], strict=True):
        number, line = lines[start]
        yield Command(number, line[2:], "", [shown for _, shown in lines[start + 1 : end]])


# ---- running -------------------------------------------------------------------------------------


class Shell:
    """What a reader's shell does with the commands of a document."""

    def __init__(self) -> None:
        self.status = 0

    def run(self, command: Command) -> str | None:
        """Standard output; None where the command is not run here."""
        here = HERE_DOCUMENT.fullmatch(command.text)
        if here:
            Path(here.group(1)).write_text(command.body, encoding="utf-8")
            self.status = 0
            return ""
        if command.text == "echo $?":
            return f"{self.status}\n"
        allowed = ALLOWED.fullmatch(command.text)
        words = shlex.split(allowed.group(1) if allowed else command.text, comments=True)
        if words[0] in NOT_RUN:
            return None
        target = words[-1] if ">" in words else None
        self.status, printed = self._process(words[: words.index(">")] if target else words)
        if allowed and self.status == int(allowed.group(2)):
            self.status = 0
        if target:
            Path(target).write_text(printed, encoding="utf-8")
            return ""
        return printed

    def _process(self, words: list[str]) -> tuple[int, str]:
        program, *arguments = words
        if program == "nonsmooth":
            stream = io.StringIO()
            with redirect_stdout(stream):
                status = run(app, arguments)
            return status, stream.getvalue()
        if program == "cat":
            return 0, "".join(Path(name).read_text(encoding="utf-8") for name in arguments)
        assert program == "python", f"required nonsmooth, python, cat or echo, received {program!r}"
        ended = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, timeout=60, check=False)
        assert not ended.returncode, ended.stderr
        return ended.returncode, ended.stdout


def stated_status(command: Command, following: Command | None) -> int:
    """The exit status that the document promises."""
    if command.stated is not None:
        return command.stated
    if following is not None and following.text == "echo $?" and following.shown:
        return int(following.shown[0])
    return 0


def lost_line(shown: list[str], printed: list[str]) -> str | None:
    """The shown line at which the printed lines part from the shown ones; None where they do not."""
    positions = {0}  # how many printed lines the shown ones may have used up
    for line in shown:
        if line.strip() == "...":
            positions = set(range(min(positions), len(printed) + 1))
        else:
            positions = {p + 1 for p in positions if p < len(printed) and same(line, printed[p])}
        if not positions:
            return line
    return None if len(printed) in positions else "(the end)"


def same(shown: str, printed: str) -> bool:
    pattern = ".*".join(re.escape(part) for part in shown.rstrip().split("..."))
    return re.fullmatch(pattern, printed.rstrip()) is not None


def named(path: Path) -> str:
    return path.name


def shorter(found: list[Command]) -> list[Command]:
    """The commands whose output is shown, without long ones and those that need what others write: for ``make test``.

    What asks for the exit status of a command goes with it. Of the others it asks whether they are commands at all:
    test_commands_have_such_arguments.
    """
    kept, absent = [], set[str]()
    last_is_kept = True
    for command in found:
        if command.text == "echo $?" and not last_is_kept:
            continue
        shows_nothing = command.shown is None and command.text.startswith("nonsmooth ") and ">" not in command.text
        is_left_out = shows_nothing or LONG_COMMANDS.match(command.text) is not None
        last_is_kept = not is_left_out and not absent.intersection(NAMED.findall(command.text + command.body))
        if last_is_kept:
            kept.append(command)
        else:
            absent.update(WRITTEN.findall(command.text))
    return kept


@pytest.mark.parametrize("path", keep(len(SHORTER), [*SHORTER, *(ROOT / "docs" / name for name in LONGEST)]), ids=named)
@pytest.mark.parametrize("extent", keep(1, ["short", "all"]))
def test_commands_run_as_typed(path: Path, extent: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    shell, found = Shell(), commands(path.read_text(encoding="utf-8"))
    if extent == "short":
        found = shorter(found)
    for command, following in zip_longest(found, found[1:]):
        where = f"{path.name}:{command.line}: {command.text}"
        printed = shell.run(command)
        if printed is None or command.text == "echo $?":
            continue
        expected = stated_status(command, following)
        assert expected != BAD_INPUT, f"{where}: a document does not show bad input as something to type"
        assert shell.status == expected, f"{where}: exit status {shell.status}, the document says {expected}"
        lost = None if command.shown is None else lost_line(command.shown, printed.splitlines())
        assert lost is None, f"{where}: required the line\n{lost}\nreceived\n{printed}"


@pytest.mark.parametrize("path", WITH_COMMANDS, ids=named)
def test_commands_have_such_arguments(path: Path) -> None:
    """Every command of every document is read as the command line reads it, and not run."""
    group = get_command(app)
    assert isinstance(group, TyperGroup)
    for command in commands(path.read_text(encoding="utf-8")):
        if not command.text.startswith("nonsmooth "):
            continue
        allowed = ALLOWED.fullmatch(command.text)
        words = shlex.split(allowed.group(1) if allowed else command.text, comments=True)[1:]
        if ">" in words:
            words = words[: words.index(">")]
        with group.make_context("nonsmooth", words) as context:
            name, own, arguments = group.resolve_command(context, words)
            assert own is not None
            own.make_context(name, arguments, parent=context)


def test_what_is_shown_is_compared() -> None:
    printed = ["a", "b 1", "c", "d"]
    for shown in (printed, ["a", "..."], ["...", "d"], ["a", "...", "c", "d"], ["...", "b ...", "..."], ["..."]):
        assert lost_line(shown, printed) is None
    for wrong in (["a"], ["b 1", "..."], ["...", "c"], ["a", "c", "..."], ["...", "c", "...", "b 1", "..."], ["x"]):
        assert lost_line(wrong, printed) is not None


def test_documents_hold_commands() -> None:
    counts = {path.name: len(commands(path.read_text(encoding="utf-8"))) for path in WITH_COMMANDS}
    assert {name for name, count in counts.items() if count >= 5} >= {"README.md", "choose.md", "tutorial.md"}


# ---- links and names -----------------------------------------------------------------------------


def prose(path: Path) -> str:
    """A document without its blocks of code."""
    return FENCE.sub("", path.read_text(encoding="utf-8"))


def anchors(path: Path) -> set[str]:
    """The names of a document's headings, as links spell them."""
    titles = re.findall(r"^#+ (.*)$", prose(path), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@every_document
def test_relative_links_resolve(path: Path) -> None:
    for target in LINK.findall(re.sub(r"`[^`]*`", "", prose(path))):
        assert "://" not in target, f"{path.name}: required a relative link, received {target}"
        name, _, anchor = target.partition("#")
        file = path.parent / name if name else path
        assert file.is_file(), f"{path.name} links to {target}"
        assert not anchor or anchor in anchors(file), f"{path.name} links to {target}"


def test_the_readme_links_every_document() -> None:
    linked = {(ROOT / target).resolve() for target in LINK.findall(prose(ROOT / "README.md"))}
    assert {path for path in DOCUMENTS if path.name != "README.md"} <= linked


@every_document
def test_nothing_outside_the_project_is_named(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert "../shared" not in text
    assert REGISTRIES.search(text) is None


@every_document
def test_names_of_code_exist(path: Path) -> None:
    lost = [name for name in CODE_NAME.findall(prose(path)) if not resolves(name)]
    lost += [name for name in CODE_PATH.findall(prose(path)) if not (ROOT / name).exists()]
    assert lost == []


def resolves(name: str) -> bool:
    """Whether ``package.module.thing`` names a module, a thing in it, or a field or member of a class in it."""
    package, *rest = name.split(".")
    value: Any = import_module(f"nonsmooth.{package}")
    while rest and find_spec(f"{value.__name__}.{rest[0]}") is not None:
        value = import_module(f"{value.__name__}.{rest.pop(0)}")
        if not hasattr(value, "__path__"):
            break
    for part in rest:
        if not hasattr(value, part):
            return is_dataclass(value) and part == rest[-1] and part in value.__dataclass_fields__
        value = getattr(value, part)
    return True


# ---- sources -------------------------------------------------------------------------------------


def cited(text: str) -> set[tuple[str, str]]:
    """Last author and year of every source that a text names."""
    return set(SOURCE.findall(" ".join(text.split())))


def test_every_cited_source_is_in_the_references() -> None:
    theory, references = (ROOT / "docs" / "theory.md").read_text(encoding="utf-8").split("## References")
    entries = [" ".join(entry.split()) for entry in references.split("\n- ")]
    texts = {path: path.read_text(encoding="utf-8") for package in PACKAGES for path in (ROOT / package).rglob("*.py")}
    found = {(source, path.name) for path, text in texts.items() for source in cited(text)}
    found |= {(source, "theory.md") for source in cited(theory)}
    assert {("Filippov", "1988"), ("Paden", "1994")} <= {source for source, _ in found}
    lost = [(name, year, where) for (name, year), where in found if not in_references(entries, name, year)]
    assert lost == []


def in_references(entries: list[str], name: str, year: str) -> bool:
    return any(name in entry and year in entry for entry in entries)


def test_the_specification_names_the_tests_of_each_claim() -> None:
    """Every claim's row names tests, and these exist."""
    text = (ROOT / "docs" / "specification.md").read_text(encoding="utf-8")
    existing = set[str]()
    for path in (ROOT / "tests" / "proofs").rglob("test_*.py"):
        existing |= set(re.findall(r"^def (test_\w+)", path.read_text(encoding="utf-8"), re.MULTILINE))
    rows = [line for line in text.splitlines() if line.startswith("| ") and "`test_" in line]
    assert len(rows) == 40
    named = re.findall(r"`(test_\w+)`", text)
    assert set(named) <= existing
