"""The store and the workers: killed at any moment, shared, full, read-only, or no store at all."""

from __future__ import annotations

import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import closing
from functools import cache
from multiprocessing import active_children, get_context
from multiprocessing.process import BaseProcess
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest

from nonsmooth.reports.output import processes
from nonsmooth.reports.output.processes import Process
from nonsmooth.reports.output.progress import ProgressCall, silent
from nonsmooth.reports.sweeps import store as store_module
from nonsmooth.reports.sweeps import workers as workers_module
from nonsmooth.reports.sweeps.base import Base, base_of
from nonsmooth.reports.sweeps.outcome import Outcome
from nonsmooth.reports.sweeps.store import Store
from nonsmooth.reports.sweeps.sweep import Means, Runner, run_sweep
from nonsmooth.reports.sweeps.sweep_plan import Entry, SweepError, SweepPlan, read_plan
from nonsmooth.reports.sweeps.sweep_study import SweepResult
from nonsmooth.reports.sweeps.workers import DEATHS, DIED, InProcess, ProcessPool, Task, Work
from nonsmooth.symbolic.files.documents import read_document
from tests.reports.conftest import Invoke
from tests.thorough import keep

COUNT = 16
VARY = {"radius": f"1/10:1:{COUNT}"}  # no scene shares its check with another
COMMAND = [sys.executable, "-m", "nonsmooth", "sweep", "four-wheel", "--vary", f"radius={VARY['radius']}"]


def work() -> Work:
    return Work(base_of(*read_document("four-wheel")), (("friction", "mu_side"),), False)


def rows(store: Path) -> int:
    if not store.exists():
        return 0
    with closing(sqlite3.connect(store, timeout=60)) as database:
        tables = database.execute("SELECT count(*) FROM sqlite_master WHERE name = 'outcomes'").fetchone()[0]
        return int(database.execute("SELECT count(*) FROM outcomes").fetchone()[0]) if tables else 0


def result(means: Means, report: ProgressCall = silent) -> SweepResult:
    base = base_of(*read_document("four-wheel"))
    return SweepResult(run_sweep(base, read_plan(VARY, base.document, base.file), means, report))


@cache
def table() -> bytes:
    with TemporaryDirectory() as folder:
        return result(Means()).to_csv(Path(folder, "undisturbed.csv")).read_bytes()


# ---- killed --------------------------------------------------------------------------------------


SHORT_LEASE = 0.5  # seconds: what a killed sweep had claimed is free again so soon


def sweep_with_a_short_lease(base: Base, plan: SweepPlan, means: Means) -> None:
    """In a process of its own, which knows nothing of what this one has replaced."""
    store_module.LEASE = SHORT_LEASE
    run_sweep(base, plan, means)


def begun(means: Means) -> BaseProcess:
    """A sweep in a process of its own."""
    base = base_of(*read_document("four-wheel"))
    context = get_context("forkserver")
    context.set_forkserver_preload(["nonsmooth.reports.sweeps.sweep"])
    plan = read_plan(VARY, base.document, base.file)
    process = context.Process(target=sweep_with_a_short_lease, args=(base, plan, means))
    process.start()
    return process


@pytest.mark.parametrize("times", keep(1, [2, 5]))
def test_a_sweep_that_is_killed_goes_on_where_it_was(
    times: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Killed at random moments, each time a little further; its table is the undisturbed one.

    Where this process waits for its turn, a sweep may end before it is killed.
    """
    monkeypatch.setattr(store_module, "LEASE", SHORT_LEASE)
    moments, store, done, killed = random.Random(5), tmp_path / "r.sqlite", 0, 0
    for _ in range(times):
        process = begun(Means(store=store))
        target, end = done + moments.randint(1, 3), time.monotonic() + 60
        while rows(store) < target and time.monotonic() < end:
            time.sleep(moments.uniform(0, 0.03))
        process.kill()
        process.join()
        assert process.exitcode in (-signal.SIGKILL, 0)
        killed += process.exitcode != 0
        assert rows(store) >= min(target, COUNT)  # nothing is lost
        done = rows(store)
    assert killed
    assert result(Means(store=store)).to_csv(tmp_path / "r.csv").read_bytes() == table()
    assert rows(store) == COUNT


def test_what_is_in_the_store_is_not_computed(tmp_path: Path) -> None:
    base = base_of(*read_document("four-wheel"))
    few, more = (read_plan({"mu_side": text}, base.document, base.file) for text in ("1/4,1/2", "1/4,1/2,3/4,0.5"))
    means = Means(store=tmp_path / "r.sqlite")
    assert [run_sweep(base, plan, means).checked for plan in (few, few, more)] == [2, 0, 1]
    assert run_sweep(base, few, Means(store=means.store, fail=1)).checked == 2  # another question
    assert run_sweep(base_of(*read_document("four-wheel", rule="box")), few, means).checked == 2


def test_killed_workers_cost_time_only(tmp_path: Path) -> None:
    killed: list[int] = []

    def kill(done: int, total: int, what: str | None = None) -> None:
        if done in (3, 7, 11):
            worker = active_children()[0]
            worker.kill()
            killed.append(done)

    found = result(Means(workers=2), kill)
    assert len(killed) == 3
    assert found.to_csv(tmp_path / "r.csv").read_bytes() == table()


def test_workers_that_cannot_be_started_are_started_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The process that forks workers may be killed while it starts one; it is there again when asked once more."""
    refused = iter((EOFError, ConnectionResetError))

    def start(*given: Any) -> Process:
        error = next(refused, None)
        if error is not None:
            raise error
        return Process(*given)

    monkeypatch.setattr(processes, "Process", start)
    assert result(Means(workers=2)).to_csv(tmp_path / "r.csv").read_bytes() == table()
    assert next(refused, None) is None


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="processes are listed in /proc")
def test_the_command_outlives_its_workers_and_they_end_with_it(tmp_path: Path) -> None:
    """A pipe to a dead worker does not end the command as one to a dead reader does."""
    store, end = tmp_path / "r.sqlite", time.monotonic() + 60
    command = [*COMMAND, "--vary", "mu_roll=1:9:999", "--workers", "2", "--store", str(store)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    try:
        for target in (1, 4, 8):
            while rows(store) < target and process.poll() is None and time.monotonic() < end:
                time.sleep(0.02)
            assert process.poll() is None
            workers = [worker for child in children(process.pid) for worker in children(child)]
            os.kill(workers[0], signal.SIGKILL)
        while rows(store) < 12 and time.monotonic() < end:
            time.sleep(0.02)
        assert process.poll() is None
        family = [*children(process.pid), *(w for child in children(process.pid) for w in children(child))]
    finally:
        process.kill()
        process.wait()
    while any(map(is_running, family)) and time.monotonic() < end:
        time.sleep(0.05)
    assert len(family) >= 3
    assert not any(map(is_running, family))


def children(parent: int) -> list[int]:
    try:
        texts = [file.read_text(encoding="utf-8") for file in Path(f"/proc/{parent}/task").glob("*/children")]
    except OSError:
        return []
    return [int(word) for text in texts for word in text.split()]


def is_running(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


class Deadly(Work):
    """Work of which one scene kills its worker."""

    def outcomes(self, scenes: Sequence[Sequence[Entry]]) -> list[Outcome]:
        """All but the last one of several, which goes back."""
        return [self.checked(entries) for entries in scenes[: max(1, len(scenes) - 1)]]

    def checked(self, entries: Sequence[Entry]) -> Outcome:
        if entries[0] == "deadly":
            with Path(str(entries[1])).open("a", encoding="utf-8") as file:
                file.write("died\n")
            os._exit(1)
        if entries[0] == "faulty":
            raise ArithmeticError("a fault of this scene")
        return {"position": str(entries[0])}


@pytest.mark.parametrize("deaths", keep(1, [2, DEATHS]))
def test_a_scene_that_kills_its_workers_is_refused_and_no_other(
    deaths: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workers_module, "DEATHS", deaths)
    pool = ProcessPool(Deadly(**vars(work())), 2)
    try:
        waiting = [
            Task(f"key {name}", (name, str(tmp_path / "deaths"))) for name in ("a", "b", "c", "deadly", *"defghijk")
        ]
        found: dict[str, tuple[str, bool]] = {}
        end = time.monotonic() + 120
        while len(found) < 12 and time.monotonic() < end:
            some, waiting = waiting[: max(pool.room, 0)], waiting[max(pool.room, 0) :]
            pool.submit(some)
            for done in pool.finished():
                found[done.task.key] = done.outcome["position"], done.lasting
                if not done.lasting:
                    assert done.outcome["why"] == DIED
        assert found == {**{f"key {name}": (name, True) for name in "abcdefghijk"}, "key deadly": ("refused", False)}
        assert (tmp_path / "deaths").read_text(encoding="utf-8").count("died") == deaths
    finally:
        pool.close()
    assert not active_children()


def test_a_fault_of_a_scene_is_raised_with_the_lines_of_its_worker() -> None:
    pool = ProcessPool(Deadly(**vars(work())), 1)

    def wait() -> None:
        while True:
            assert not list(pool.finished())

    pool.submit([Task("key", ("faulty",))])
    try:
        with pytest.raises(ArithmeticError, match="a fault of this scene") as raised:
            wait()
        assert "in checked" in raised.value.__notes__[0]
    finally:
        pool.close()


def test_a_script_without_its_guard_is_told(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    call = 'ns.load("four-wheel").sweep(mu_side="1/2,2", means=ns.Means(workers=2))'
    script.write_text(f"import nonsmooth as ns\n\n{call}\n", encoding="utf-8")
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 1
    assert "SweepError: workers: required processes that start" in done.stderr


# ---- shared --------------------------------------------------------------------------------------


def test_two_sweeps_share_a_store_and_compute_nothing_twice(tmp_path: Path) -> None:
    other = begun(Means(store=tmp_path / "r.sqlite"))
    while not rows(tmp_path / "r.sqlite") and other.is_alive():
        time.sleep(0.005)
    found = result(Means(store=tmp_path / "r.sqlite"))
    other.join(60)
    assert other.exitcode == 0
    assert found.checked < COUNT
    assert found.to_csv(tmp_path / "r.csv").read_bytes() == table()
    assert rows(tmp_path / "r.sqlite") == COUNT


def test_claims_part_the_work_and_lapse(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with closing(Store(tmp_path / "r.sqlite")) as one, closing(Store(tmp_path / "r.sqlite")) as two:
        assert one.claim(["a", "b"]) == {"a", "b"}
        assert two.claim(["b", "c"]) == {"c"}
        one.put("a", {"position": "tips"})
        assert two.known(["a", "b"]) == {"a": {"position": "tips"}}
        assert two.claim(["a"]) == set()  # finished: nothing to do
        now = time.time()
        monkeypatch.setattr(time, "time", lambda: now + 2 * store_module.LEASE)
        assert two.claim(["b"]) == {"b"}  # the other one has been silent for too long
        two.put("b", {"position": "first"})
        one.put("b", {"position": "second"})
        assert two.known(["b"]) == {"b": {"position": "first"}}


def test_a_long_check_keeps_its_claim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its sign of life is renewed while it is busy; by a clock that stands where only what was renewed still counts."""
    monkeypatch.setattr(store_module, "LEASE", 0.3)
    file = tmp_path / "r.sqlite"
    with closing(Store(file)) as one, closing(Store(file)) as two, closing(sqlite3.connect(file)) as database:
        assert one.claim(["a"]) == {"a"}
        claimed = seen = time.time()
        end = time.monotonic() + 60
        while seen < claimed + 0.5 and time.monotonic() < end:
            time.sleep(0.05)
            (seen,) = database.execute("SELECT min(seen) FROM sweeps").fetchone()
        assert seen >= claimed + 0.5
        now = (claimed + seen) / 2 + store_module.LEASE
        monkeypatch.setattr(time, "time", lambda: now)
        assert two.claim(["a"]) == set()


def test_a_scene_of_another_sweep_that_died_is_taken_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store_module, "LEASE", 0.3)
    shared = work()
    key = shared.base.key(shared.paths, ("1/2",), "answers")
    started = time.monotonic()  # before the claim is made, however late the other sweep begins
    dead = Store(tmp_path / "r.sqlite")
    assert dead.claim([key]) == {key}
    dead._heart.stop()  # and is never heard of again
    with closing(Store(tmp_path / "r.sqlite")) as store:
        runner = Runner(shared, InProcess(shared), store)
        (outcome,) = runner.outcomes([("1/2",)], 1)
        assert outcome["position"] == "comes home"
        assert time.monotonic() - started > 0.2
    dead.close()


# ---- files that cannot be used -------------------------------------------------------------------


def test_what_is_no_store_is_refused_and_left_alone(invoke: Invoke, tmp_path: Path) -> None:
    text, other, folder = tmp_path / "text", tmp_path / "other.sqlite", tmp_path / "folder"
    text.write_text("no database at all, but quite a long text" * 50, encoding="utf-8")
    with closing(sqlite3.connect(other)) as database:
        database.execute("CREATE TABLE outcomes (mine TEXT)")
    folder.mkdir()
    for path in (text, other, folder, tmp_path / "missing" / "r.sqlite", Path("/proc/r.sqlite")):
        before = path.read_bytes() if path.is_file() else None
        done = invoke("sweep", "four-wheel", "--vary", "mu_side=0.1:1:2", "--workers", "1", "--store", str(path))
        assert (done.status, done.out, done.err.count("\n")) == (2, "", 1)
        assert f"--store: {path}: required " in done.err
        assert (path.read_bytes() if path.is_file() else None) == before
    assert sorted(file.name for file in tmp_path.iterdir()) == ["folder", "other.sqlite", "text"]


def test_rows_do_not_take_the_place_of_the_store(invoke: Invoke, tmp_path: Path) -> None:
    rows, store = tmp_path / "rows.csv", tmp_path / "folder" / ".." / "rows.csv"
    (tmp_path / "folder").mkdir()
    done = invoke("sweep", "four-wheel", "--vary", "mu_side=0.1:1:2", "-o", str(rows), "--store", str(store))
    assert (done.status, done.out) == (2, "")
    assert done.err == f"nonsmooth: --store: required another file than that of -o, received {str(store)!r}\n"
    assert not rows.exists()


def fill(store: Store, keys: list[str]) -> None:
    while len(keys) < 10_000:
        keys.append(f"key {len(keys)}")
        store.put(keys[-1], {"position": "x" * 500})


def test_a_full_disk_loses_nothing(tmp_path: Path) -> None:
    """SQLite is told that the disk has room for a few pages more."""
    store = Store(tmp_path / "r.sqlite")
    pages = store._database.execute("PRAGMA page_count").fetchone()[0]
    store._database.execute(f"PRAGMA max_page_count = {pages + 3}")
    store._heart.stop()
    keys: list[str] = []
    with pytest.raises(SweepError, match=r"store: .*: required .*, received database or disk is full"):
        fill(store, keys)
    kept = len(keys) - 1  # the last one did not fit
    assert kept
    store.close()
    with closing(Store(tmp_path / "r.sqlite")) as again:
        assert len(again) == kept
        assert set(again.known(keys)) == set(keys[:kept])


def test_a_store_that_fails_in_the_middle_is_one_line(invoke: Invoke, monkeypatch: pytest.MonkeyPatch) -> None:
    put = Store.put

    def full(store: Store, key: str, outcome: Outcome) -> None:
        if len(store) == 2:
            raise sqlite3_full(store)
        put(store, key, outcome)

    def sqlite3_full(store: Store) -> SweepError:
        return SweepError(f"store: {store.path}: required a file that can be written, received a full disk")

    monkeypatch.setattr(Store, "put", full)
    options = ("sweep", "four-wheel", "--vary", "mu_side=0.1:1:4", "--workers", "1", "--store", "r.sqlite")
    done = invoke(*options, "-o", "t.csv")
    assert (done.status, done.out, done.err.count("\n")) == (2, "", 1)
    assert rows(Path("r.sqlite")) == 2
    assert not Path("t.csv").exists()
    monkeypatch.setattr(Store, "put", put)
    assert invoke(*options, "-o", "t.csv").status == 0
    assert rows(Path("r.sqlite")) == 4
