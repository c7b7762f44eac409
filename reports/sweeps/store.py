"""A store of outcomes: one SQLite file that several sweeps may share, in which nothing is lost or computed twice.

A result is committed as it comes, in write-ahead mode: what a killed sweep had finished is there for the next one.  The
key is a hash of all that the outcome follows from, so a store may hold many scenes, rules and versions.  A sweep claims
the scenes it works on; another one takes others meanwhile.  Claims of a sweep whose sign of life is older than
``LEASE`` are void, so a killed sweep delays nobody for longer.
"""

from __future__ import annotations

import json
import secrets
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, suppress
from pathlib import Path
from typing import TypeVar

from nonsmooth.reports.sweeps.outcome import Outcome
from nonsmooth.reports.sweeps.sweep_plan import SweepError

FORMAT = 0x6E736D31  # "nsm1" in the header of the file: a store of this program, format 1
PATIENCE = 60.0  # seconds to wait for another sweep that writes
LEASE = 10.0  # seconds after which a silent sweep counts as killed
AT_ONCE = 500  # keys of one query
_TABLES = """
CREATE TABLE IF NOT EXISTS outcomes (key TEXT PRIMARY KEY, outcome TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS claims (key TEXT PRIMARY KEY, owner TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS sweeps (owner TEXT PRIMARY KEY, seen REAL NOT NULL) WITHOUT ROWID;
"""

Result = TypeVar("Result")


class Store:
    """An open store.  Not for several threads."""

    def __init__(self, path: Path) -> None:
        """Open a store, or begin one.

        Raises:
            SweepError: for a file that is no store, and a path that cannot be written.
        """
        self.path = path
        self._owner = secrets.token_hex(8)
        self._database = self._sound(self._open)
        self._heart = Heartbeat(path, self._owner)
        self._sound(lambda: self._heart.beat(self._database))
        self._heart.start()

    def close(self) -> None:
        """Give back what is claimed, and close the file."""
        self._heart.stop()
        try:
            with self._database:
                self._database.execute("DELETE FROM claims WHERE owner = ?", (self._owner,))
                self._database.execute("DELETE FROM sweeps WHERE owner = ?", (self._owner,))
        except sqlite3.Error:
            pass  # what is claimed lapses by itself, and every outcome is committed
        self._database.close()

    def known(self, keys: Sequence[str]) -> dict[str, Outcome]:
        """The outcomes that are there, by key.

        Raises:
            SweepError: where the file cannot be read.
        """
        return self._sound(lambda: dict(self._read(keys)))

    def claim(self, keys: Sequence[str]) -> set[str]:
        """Those of the keys that nobody else works on; they are ours until they are put, or given back.

        Raises:
            SweepError: where the file cannot be written.
        """
        return self._sound(lambda: self._claimed(keys))

    def put(self, key: str, outcome: Outcome) -> None:
        """Keep an outcome; the first one stays.

        Raises:
            SweepError: where the file cannot be written, as on a full disk; what it held, it holds.
        """
        text = json.dumps(outcome, allow_nan=False)

        def write() -> None:
            with self._database:
                self._database.execute("INSERT OR IGNORE INTO outcomes VALUES (?, ?)", (key, text))
                self._database.execute("DELETE FROM claims WHERE key = ? AND owner = ?", (key, self._owner))

        self._sound(write)

    def __len__(self) -> int:
        """How many outcomes there are."""
        count: int = self._sound(lambda: self._database.execute("SELECT count(*) FROM outcomes").fetchone()[0])
        return count

    # ---- the file --------------------------------------------------------------------------------

    def _open(self) -> sqlite3.Connection:
        """The file, with its tables."""
        database = sqlite3.connect(self.path, timeout=PATIENCE)
        try:
            (stamp,) = database.execute("PRAGMA application_id").fetchone()
            (tables,) = database.execute("SELECT count(*) FROM sqlite_master").fetchone()
            if stamp != FORMAT and (stamp or tables):
                raise self._error("a store of this program, or a new file", "another database")
            database.execute("PRAGMA journal_mode = WAL")
            database.execute("PRAGMA synchronous = NORMAL")
            database.execute(f"PRAGMA application_id = {FORMAT}")
            database.executescript(_TABLES)
        except BaseException:
            database.close()
            raise
        return database

    def _read(self, keys: Sequence[str]) -> Iterator[tuple[str, Outcome]]:
        for first in range(0, len(keys), AT_ONCE):  # as many as one query can hold
            some = keys[first : first + AT_ONCE]
            marks = ",".join("?" * len(some))
            rows = self._database.execute(f"SELECT key, outcome FROM outcomes WHERE key IN ({marks})", some)
            yield from ((key, json.loads(text)) for key, text in rows)

    def _claimed(self, keys: Sequence[str]) -> set[str]:
        with self._database:
            self._database.execute(
                "BEGIN IMMEDIATE"
            )  # the right to write from here on: two sweeps never claim one scene
            dead = "owner NOT IN (SELECT owner FROM sweeps WHERE seen > ?)"
            self._database.execute(f"DELETE FROM claims WHERE {dead}", (time.time() - LEASE,))
            finished = set(dict(self._read(keys)))
            wanted = [(key, self._owner) for key in keys if key not in finished]
            self._database.executemany("INSERT OR IGNORE INTO claims VALUES (?, ?)", wanted)
            owners = [
                self._database.execute("SELECT owner FROM claims WHERE key = ?", (key,)).fetchone() for key, _ in wanted
            ]
        return {key for (key, _), owner in zip(wanted, owners, strict=True) if owner == (self._owner,)}

    def _sound(self, work: Callable[[], Result]) -> Result:
        """The result of work on the file.

        Raises:
            SweepError: in place of SQLite's errors.
        """
        try:
            return work()
        except sqlite3.DatabaseError as error:
            raise self._error("a file that can be read and written as a store", str(error)) from None

    def _error(self, required: str, received: str) -> SweepError:
        return SweepError(f"store: {self.path}: required {required}, received {received}")


class Heartbeat:
    """A thread that renews the claims of a sweep, whatever the sweep is busy with."""

    def __init__(self, path: Path, owner: str) -> None:
        self._path, self._owner = path, owner
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def stop(self) -> None:
        """End; the claims lapse, or are given back."""
        self._ended.set()
        self._thread.join()

    def beat(self, database: sqlite3.Connection) -> None:
        """One sign of life."""
        with database:
            database.execute("INSERT OR REPLACE INTO sweeps VALUES (?, ?)", (self._owner, time.time()))

    def _run(self) -> None:
        """A sign of life again and again, over a connection of its own; what is wrong shows where outcomes are put."""
        while not self._ended.wait(LEASE / 5):
            with suppress(sqlite3.Error), closing(sqlite3.connect(self._path, timeout=LEASE)) as database:
                self.beat(database)
