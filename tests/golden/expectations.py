"""What the rows said before: one file of records for each section of the table, one line for each row.

A digest of every record stands in ``frozen.txt``, as the matrix was first recorded, or with a reason in
``changes.toml``, where it has changed since.  So an expectation that was edited by hand, or taken over without a
reason, is found by a test.  A change stands there with its differences until they are folded away (:func:`fold`):
nothing compares with them, they are read with the change, and git keeps them.
"""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.golden.matrix import HERE, Record, Row, rows

REMOVED = "removed"
LONGEST = 10  # differences of a row that changes.toml keeps


@dataclass(frozen=True)
class Change:
    """A row that says something else now, or says something for the first time.

    Attributes:
        row: which.
        record: what it says now.
        differences: from what it said before, as text; empty for a new row.
    """

    row: Row
    record: Record
    differences: Sequence[str]


def expectations(folder: Path = HERE) -> dict[Row, Record]:
    """The record of every row that has one, also of rows that the table no longer has."""
    known = {(row.section, row.line): row for row in rows()}
    found = {}
    for file in sorted((folder / "expected").glob("*.jsonl")):
        for text in file.read_text(encoding="utf-8").splitlines():
            entry = json.loads(text)
            key = (file.stem, entry["row"])
            found[known.get(key, Row(*key, tested=False))] = entry["record"]
    return found


def digest(record: Record) -> str:
    """Of a record as it is stored."""
    return hashlib.sha256(_text(record).encode()).hexdigest()[:12]


def _text(value: object) -> str:
    """As JSON, which for texts and lists of texts is TOML, too."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def accounted(folder: Path = HERE) -> dict[str, str]:
    """By the line of each row the digest of its record that was frozen, or accepted last for a reason."""
    lines = (folder / "frozen.txt").read_text(encoding="utf-8").splitlines()
    found = {row: frozen for frozen, row in (line.split(" ", 1) for line in lines)}
    for change in changes(folder):
        found |= {entry["row"]: entry["digest"] for entry in change["rows"]}
    return found


def changes(folder: Path = HERE) -> list[dict[str, Any]]:
    """The entries of ``changes.toml``, the oldest first: a reason, and its rows, the newest with their differences."""
    file = folder / "changes.toml"
    return tomllib.loads(file.read_text(encoding="utf-8")).get("change", []) if file.exists() else []


def accept(changed: Sequence[Change], gone: Sequence[Row], reason: str, folder: Path = HERE) -> None:
    """Store new records, forget those of rows that the table no longer has, and say why.

    The first time, when nothing is frozen yet, the digests go to ``frozen.txt``.
    """
    records = expectations(folder) | {change.row: change.record for change in changed}
    (folder / "expected").mkdir(exist_ok=True)
    for section in sorted({row.section for row in (*records, *gone)}):
        kept = [row for row in rows() if row.section == section and row in records]
        lines = [_text({"row": row.line, "record": records[row]}) + "\n" for row in kept]
        file = folder / "expected" / f"{section}.jsonl"
        if lines:
            file.write_text("".join(lines), encoding="utf-8")
        else:
            file.unlink(missing_ok=True)
    frozen = folder / "frozen.txt"
    if not frozen.exists():
        frozen.write_text("".join(f"{digest(c.record)} {c.row.line}\n" for c in changed), encoding="utf-8")
        return
    entries = [(c.row.line, digest(c.record), list(c.differences) or ["a new row"]) for c in changed]
    entries += [(row.line, REMOVED, ["the row is gone"]) for row in gone]
    if not entries:
        return
    with (folder / "changes.toml").open("a", encoding="utf-8") as log:
        log.write(f"\n[[change]]\nreason = {_text(reason)}\n")
        for line, mark, found in entries:
            more = [f"and {len(found) - LONGEST} more"] if len(found) > LONGEST else []
            shown = "".join(f"    {_text(difference)},\n" for difference in (*found[:LONGEST], *more))
            log.write(f"\n[[change.rows]]\nrow = {_text(line)}\ndigest = {_text(mark)}\ndifferences = [\n{shown}]\n")


def fold(folder: Path = HERE) -> None:
    """Keep of every change its reason and its rows with their digests, one line each."""
    entries = []
    for change in changes(folder):
        lines = [f"    {{ row = {_text(row['row'])}, digest = {_text(row['digest'])} }},\n" for row in change["rows"]]
        entries.append(f"[[change]]\nreason = {_text(change['reason'])}\nrows = [\n{''.join(lines)}]\n")
    (folder / "changes.toml").write_text("\n".join(entries), encoding="utf-8")
