"""Sweeps on a Dask cluster, where the optional package is installed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

import pytest

from nonsmooth.reports.sweeps import workers
from nonsmooth.reports.sweeps.store import Store
from tests.reports.conftest import Invoke

needs_dask = pytest.mark.skipif(find_spec("distributed") is None, reason="the extra cluster is optional")
SWEEP = ("sweep", "four-wheel", "--vary", "mu_side=1/10:2:40", "--store", "r.sqlite", "-o", "t.csv")


@contextmanager
def running(*words: str) -> Iterator[subprocess.Popen[bytes]]:
    """A program of Dask, ended in the end."""
    command = [sys.executable, "-m", "distributed.cli." + words[0], *words[1:], "--no-dashboard"]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


@contextmanager
def scheduler(folder: Path) -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    file = folder / "scheduler.json"
    with running("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file)) as process:
        end = time.monotonic() + 60
        while not file.exists() and time.monotonic() < end:
            time.sleep(0.05)
        time.sleep(0.2)
        yield next(w for w in file.read_text(encoding="utf-8").split('"') if w.startswith("tcp://")), process


@contextmanager
def worker(address: str) -> Iterator[subprocess.Popen[bytes]]:
    with running("dask_worker", address, "--nthreads", "1", "--no-nanny") as process:
        yield process


@needs_dask
@pytest.mark.filterwarnings("ignore")  # of the optional package
def test_a_cluster_gives_the_same_table_though_a_worker_is_killed(invoke: Invoke, tmp_path: Path) -> None:
    assert invoke(*SWEEP, "--workers", "1").status == 0
    wanted = (tmp_path / "t.csv").read_bytes()
    for name in ("t.csv", "r.sqlite"):
        (tmp_path / name).unlink()
    with scheduler(tmp_path) as (address, _), worker(address) as first, worker(address):
        command = [sys.executable, "-m", "nonsmooth", *SWEEP, "--scheduler", address]
        sweep = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        while count(tmp_path / "r.sqlite") < 5 and sweep.poll() is None:
            time.sleep(0.05)
        os.kill(first.pid, signal.SIGKILL)
        _, said = sweep.communicate(timeout=120)
        assert (sweep.returncode, said) == (0, "")
    assert (tmp_path / "t.csv").read_bytes() == wanted


@needs_dask
@pytest.mark.filterwarnings("ignore")
def test_a_lost_scheduler_is_one_line_and_loses_nothing(tmp_path: Path) -> None:
    with scheduler(tmp_path) as (address, process), worker(address):
        command = [sys.executable, "-m", "nonsmooth", *SWEEP, "--vary", "mu_roll=1:2:99", "--scheduler", address]
        sweep = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        while count(tmp_path / "r.sqlite") < 5 and sweep.poll() is None:
            time.sleep(0.05)
        process.kill()
        _, said = sweep.communicate(timeout=60)
        assert sweep.returncode == 2
        assert (
            said == f"nonsmooth: --scheduler: {address}: required a scheduler that stays, received a lost connection\n"
        )
    assert count(tmp_path / "r.sqlite") >= 5
    assert not (tmp_path / "t.csv").exists()


@needs_dask
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense://x"])
def test_a_scheduler_that_is_not_there_is_one_line_in_time(invoke: Invoke, address: str) -> None:
    started = time.monotonic()
    done = invoke(*SWEEP, "--scheduler", address)
    assert time.monotonic() - started < 10
    required = f"required a Dask scheduler that answers within {workers.ANSWER} s, received none"
    assert (done.status, done.out, done.err) == (2, "", f"nonsmooth: --scheduler: {address}: {required}\n")


def test_without_the_package_the_extra_is_named(invoke: Invoke, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    done = invoke(*SWEEP, "--scheduler", "tcp://127.0.0.1:1")
    assert (done.status, done.out, done.err.count("\n")) == (2, "", 1)
    assert "required the package distributed (pip install nonsmooth[cluster])" in done.err


def count(path: Path) -> int:
    if not path.exists():
        return 0
    store = Store(path)
    try:
        return len(store)
    finally:
        store.close()
