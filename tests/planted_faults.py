"""Plant faults in a copy of the product, one after the other: do the tests that should find them fail?

    python -m tests.planted_faults                  all of planted_faults.toml: some ten minutes of processor time
    python -m tests.planted_faults "reports/*"      those in files that match

A fault is a text of a file and what stands there instead: another comparison, sign, constant or branch.  It names the
rows of the golden matrix and the tests that are there to find it; without a fault all of these must pass.  Exit status
0 where every fault is found.  Who deletes or rewrites a test runs this before and after; it is no part of `make test`.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NOT_COPIED = shutil.ignore_patterns(".*", "__pycache__", "*.egg-info")
ROW = "tests/test_golden_matrix.py::test_a_row_says_what_it_said[{}]"
FOUND, NOT_FOUND = 1, 0  # exit statuses of pytest: a test fails, none does
LONGEST = 120  # seconds; work that does not end is found too


@dataclass(frozen=True)
class Fault:
    """A place of the product and what is wrong there.

    Attributes:
        file: from the root of the repository.
        text: what stands there, once.
        wrong: what is planted instead.
        rows: lines of the golden matrix that say something else then.
        tests: files or names of tests of which one fails then.
    """

    file: str
    text: str
    wrong: str
    rows: tuple[str, ...] = ()
    tests: tuple[str, ...] = ()

    @property
    def found_by(self) -> list[str]:
        """As pytest takes them."""
        return [*map(ROW.format, self.rows), *self.tests]


def faults() -> list[Fault]:
    """The list."""
    entries = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))["fault"]
    return [
        Fault(own["file"], own["text"], own["wrong"], tuple(own.get("rows", ())), tuple(own.get("tests", ())))
        for own in entries
    ]


def places(fault: Fault, root: Path = ROOT) -> int:
    """How often the text of a fault stands in its file; once, where the list is up to date."""
    return (root / fault.file).read_text(encoding="utf-8").count(fault.text)


@contextmanager
def planted(fault: Fault, copy: Path) -> Iterator[None]:
    """The copy with a fault in it."""
    file = copy / fault.file
    right, times = file.read_text(encoding="utf-8"), file.stat()
    file.write_text(right.replace(fault.text, fault.wrong), encoding="utf-8")
    try:
        yield
    finally:
        file.write_text(right, encoding="utf-8")
        os.utime(file, ns=(times.st_atime_ns, times.st_mtime_ns))


def status_of(tests: Sequence[str], copy: Path, longest: float | None = LONGEST) -> int:
    """How tests end in the copy, whose folder is the package, within so many seconds."""
    line = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-m", "not thorough", *tests]
    environment = {**os.environ, "PYTHONPATH": str(copy.parent)}
    try:
        done = subprocess.run(line, cwd=copy, env=environment, capture_output=True, check=False, timeout=longest)
    except subprocess.TimeoutExpired:
        return FOUND
    return done.returncode


def main(patterns: Sequence[str]) -> int:
    """Plant them all; the exit status."""
    chosen = [fault for fault in faults() if not patterns or any(fnmatchcase(fault.file, own) for own in patterns)]
    words = {FOUND: "found", NOT_FOUND: "NOT FOUND"}
    count = 0
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder, "nonsmooth")
        shutil.copytree(ROOT, copy, ignore=NOT_COPIED)
        every = list(dict.fromkeys(test for fault in chosen for test in fault.found_by))
        status = status_of(every, copy, None)
        if status:  # a test that fails without a fault finds none, nor does a Python without pytest
            print(f"required tests that pass without a fault, pytest ended with status {status}")
            return 1
        for fault in chosen:
            with planted(fault, copy):
                status = status_of(fault.found_by, copy)
            count += status == FOUND
            said = words.get(status, f"pytest ended with status {status}")
            print(f"{said}: {fault.file}: {fault.text.strip().splitlines()[0]}", flush=True)
    print(f"{count} of {len(chosen)} faults are found")
    return 0 if count == len(chosen) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
