"""What is wrong with a keyword of a call, as one line."""

from __future__ import annotations


class ArgumentError(ValueError):
    """``keyword: required ..., received ...``; the command line puts two dashes before it."""
