"""What is wrong with a sweep, as one line."""

from __future__ import annotations


class SweepError(ValueError):
    """``keyword: required ..., received ...``; the command line puts two dashes before it."""
