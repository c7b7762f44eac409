"""Commands are invoked as in the tests of the command line."""

from tests.reports.conftest import Invoke, invoke

__all__ = ["Invoke", "invoke"]
