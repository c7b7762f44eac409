"""``make golden``: run the golden matrix and show what it says otherwise than before.

    python -m tests.golden                                  compare all rows
    python -m tests.golden --only "*ring-?*box*"            compare the rows that match; may be given several times
    python -m tests.golden --accept "why" --only "..."      take over what the changed rows among these say now
    python -m tests.golden --fold                           forget the differences of changes that were read

Exit status 0 where nothing differs but what is allowed, 1 otherwise.  ``--accept`` writes the reason and the
differences into ``changes.toml``, which is read with the change; a test holds that no expectation was changed in
another way.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from fnmatch import fnmatchcase

from tests.golden.compare import Difference, differences
from tests.golden.expectations import Change, accept, expectations, fold
from tests.golden.matrix import Record, Row, rows, run_row

WORKERS = 2
SHOWN = 12  # differences of one row
EVERY = 30  # seconds between two lines of progress


def timed(line: str) -> tuple[Record, float]:
    """What a row says, and the processor time that it takes."""
    begin = time.process_time()
    return run_row(line), time.process_time() - begin


def run_all(chosen: Sequence[Row], workers: int) -> dict[Row, tuple[Record, float]]:
    """The records of rows, by processes of their own, with a line of progress from time to time."""
    done: dict[Row, tuple[Record, float]] = {}
    shown = time.monotonic()
    with ProcessPoolExecutor(workers) as pool:
        started = {pool.submit(timed, row.line): row for row in chosen}
        for future in as_completed(started):
            done[started[future]] = future.result()
            if time.monotonic() - shown > EVERY:
                shown = time.monotonic()
                print(f"... {len(done)} of {len(chosen)} rows", file=sys.stderr, flush=True)
    return done


def is_meant(row: Row, patterns: Sequence[str] | None) -> bool:
    """Whether the line or the section of a row is one of the patterns, or matches one; every row without any."""
    names = (row.line, row.section)
    return patterns is None or any(name == own or fnmatchcase(name, own) for own in patterns for name in names)


def show(row: Row, found: Sequence[Difference]) -> None:
    """A row that changed, and where; of a new row its line alone."""
    print(f"\n[{row.section}] {row.line}" if found else f"new: {row.line}")
    for difference in found[:SHOWN]:
        print(f"    {'(allowed) ' if difference.allowed else ''}{difference}")
    if len(found) > SHOWN:
        print(f"    and {len(found) - SHOWN} more")


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare, or accept; the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tests.golden", description="Compare the golden matrix.")
    parser.add_argument("--only", metavar="PATTERN", action="append", help="rows whose line or section matches")
    parser.add_argument("--accept", metavar="REASON", help="take over what changed rows say now, for this reason")
    parser.add_argument("--workers", type=int, default=min(WORKERS, os.cpu_count() or 1))
    parser.add_argument("--slow", type=int, default=0, metavar="N", help="name the N rows that take longest")
    parser.add_argument("--fold", action="store_true", help="keep of accepted changes the reasons and the rows alone")
    given = parser.parse_args(arguments)
    if given.fold:
        fold()
        return 0
    chosen = [row for row in rows() if is_meant(row, given.only)]
    records = run_all(chosen, given.workers)
    expected = expectations()
    changed: list[Change] = []
    counts: Counter[str] = Counter()
    for row in chosen:
        before = expected.get(row)
        found = list(differences(before, records[row][0])) if before is not None else None
        if found == []:
            counts["equal"] += 1
            continue
        is_allowed = found is not None and all(difference.allowed for difference in found)
        counts["new" if found is None else "not weaker" if is_allowed else "different"] += 1
        changed.append(Change(row, records[row][0], [str(difference) for difference in found or ()]))
        show(row, found or ())
    gone = [row for row in expected if row not in set(rows()) and is_meant(row, given.only)]
    for row in gone:
        counts["missing"] += 1
        print(f"\n[{row.section}] {row.line}\n    is no longer in rows.toml")
    for row, (_, seconds) in sorted(records.items(), key=lambda entry: -entry[1][1])[: given.slow]:
        print(f"{seconds:8.2f} s  {row.line}")
    total = sum(seconds for _, seconds in records.values())
    print(f"\n{', '.join(f'{n} {kind}' for kind, n in counts.items())}; {total:.0f} s of processor time")
    if given.accept:
        accept(changed, gone, given.accept)
        return 0
    return 1 if counts.keys() & {"different", "new", "missing"} else 0


if __name__ == "__main__":
    sys.exit(main())
