"""Requests of the page: JSON whose numbers keep their decimals, refused where it is too deep, too long or no table."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from decimal import Decimal
from typing import Any

MAX_DEPTH = 12  # of nested lists and tables; a scene has six
MAX_VALUES = 20_000  # numbers, texts, lists and tables of one request
MAX_TEXT = 4_000  # characters of one text; formulas have narrower limits of their own


class RequestError(ValueError):
    """A request that cannot be used; ``str(error)`` is one line.

    Attributes:
        key: the offending key, None for the request as a whole.
    """

    def __init__(self, message: str, key: str | None = None) -> None:
        super().__init__(message)
        self.key = key


def read_request(body: bytes, *, longest: int = MAX_TEXT) -> dict[str, Any]:
    """The table of a request; decimals are kept as written.

    Args:
        body: JSON.
        longest: how many characters one text may have.

    Raises:
        RequestError: for anything but a table of moderate depth and length.
    """
    try:
        request = json.loads(body, parse_float=Decimal, parse_constant=_refuse_constant)
    except RecursionError:
        raise RequestError("request: required fewer nested brackets") from None
    except RequestError:
        raise
    except (ValueError, ArithmeticError):
        raise RequestError("request: required JSON with numbers of moderate length") from None
    if not isinstance(request, dict):
        raise RequestError("request: required a table")
    _require_moderate(request, longest)
    return request


def _refuse_constant(name: str) -> Any:
    raise RequestError(f"request: required finite numbers, received {name}")


def _require_moderate(request: Mapping[str, Any], longest: int) -> None:
    for count, (depth, value) in enumerate(_values(request)):
        if depth > MAX_DEPTH or count >= MAX_VALUES:
            raise RequestError(f"request: required at most {MAX_VALUES} values, nested {MAX_DEPTH} deep")
        if isinstance(value, str) and len(value) > longest:
            raise RequestError(f"request: required texts of at most {longest} characters, received {len(value)}")


def _values(value: object) -> Iterator[tuple[int, object]]:
    """Every value inside with its depth, without recursion."""
    waiting = [(0, value)]
    while waiting:
        depth, here = waiting.pop()
        yield depth, here
        inside = [*here, *here.values()] if isinstance(here, dict) else here if isinstance(here, list) else []
        waiting += [(depth + 1, part) for part in inside]
