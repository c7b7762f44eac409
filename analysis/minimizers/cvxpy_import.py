"""Importing CVXPY without the optional solvers that an environment may hold.

While it is imported, CVXPY imports every solver that it knows, to see which are there.  Some of them print a licence
text on standard output as soon as they are imported, past ``sys.stdout`` too, and none is used here.  So whatever
CVXPY's own modules ask for then is as good as not installed, unless CVXPY requires it.
"""

from __future__ import annotations

import builtins
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import ModuleType
from typing import Any

# What CVXPY 1.9 requires, by the names that its modules import.
_REQUIRED = frozenset(
    ["cvxpy", "_cvxcore", "numpy", "scipy", "clarabel", "scs", "osqp", "qdldl", "highspy", "sparsediffpy"]
)
_LOCK = threading.Lock()


def load_cvxpy() -> None:
    """Import CVXPY for the first time, without a look at its optional solvers; before every ``import cvxpy``."""
    with _LOCK:
        if "cvxpy" not in sys.modules:
            with _optional_solvers_hidden():
                import cvxpy  # noqa: F401


@contextmanager
def _optional_solvers_hidden() -> Iterator[None]:
    """Let modules of CVXPY import only what CVXPY requires; imports of all other modules stay as they are."""
    plain_import = builtins.__import__

    def guarded_import(
        name: str,
        globals: Mapping[str, object] | None = None,
        locals: Mapping[str, object] | None = None,
        fromlist: Sequence[str] | None = (),
        level: int = 0,
    ) -> ModuleType:
        if level == 0 and _package(_importer(globals)) == "cvxpy" and not _is_required(_package(name)):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
        return plain_import(name, globals, locals, fromlist or (), level)

    builtins.__import__ = guarded_import
    try:
        yield
    finally:
        builtins.__import__ = plain_import


def _importer(globals_: Mapping[str, Any] | None) -> str:
    return str((globals_ or {}).get("__name__", ""))


def _package(module: str) -> str:
    return module.partition(".")[0]


def _is_required(package: str) -> bool:
    return package in _REQUIRED or package in sys.stdlib_module_names
