"""The command that checks a file: exit status, and what is printed.

Exit status: 0 valid, 1 rejected, 2 not readable or of an earlier version.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from .descriptions import describe
from .statements import VERSION, is_of_array, refusal
from .work import MALFORMED, MAX_BYTES, limit, take_once

EARLIER = {  # versions that are written no more, with what the subject of one is called on the command line
    "nonsmooth-certificate/1": "ARRAY",
    "nonsmooth-system-certificate/1": "SYSTEM",
    "nonsmooth-scalar-certificate/1": "SYSTEM",
    "nonsmooth-fan-certificate/1": "SYSTEM",
    "nonsmooth-many-state-certificate/1": "SYSTEM",
}


def check_file(path: str) -> tuple[int, str]:
    """Exit status and what to print of a file."""
    try:
        data, size = read(path)
    except (OSError, *MALFORMED) as error:
        return 2, f"unreadable: {error}"
    schema = data.get("schema") if type(data) is dict else None
    if type(schema) is str and schema in EARLIER:
        again = f"nonsmooth check {EARLIER[schema]} --certificate {path}"
        return 2, f"of an earlier version: {again} writes it anew, as {VERSION}"
    reason = refusal(data, size)
    if reason:
        return 1, f"rejected: required {reason}"
    valid = "valid: all claims hold" if is_of_array(data["statement"]["subject"]) else "valid"
    return 0, "\n".join([valid, *describe(data["statement"], data.get("notes"))])


def read(path: str) -> tuple[Any, int]:
    """The JSON document of a file, and its length in bytes.

    Raises:
        OSError, ValueError, RecursionError: where it cannot be read, is no JSON document, or names a key twice.
    """
    with open(path, "rb") as file:
        return parse(file.read(MAX_BYTES + 1))


def parse(content: bytes) -> tuple[Any, int]:
    """The JSON document that some bytes hold, and their number.

    Raises:
        ValueError, RecursionError: where they are too many, are no JSON document, or name a key twice.
    """
    limit(len(content) <= MAX_BYTES, f"at most {MAX_BYTES} bytes")
    # Numbers are texts in a certificate: floats are kept as texts, and are no exponents of anything.
    return json.loads(content, parse_float=str, parse_constant=str, object_pairs_hook=take_once), len(content)


def main(arguments: Sequence[str]) -> int:
    """Check one file."""
    if len(arguments) != 1:
        print("usage: python -I -S checker FILE")
        return 2
    status, line = check_file(arguments[0])
    print(line)
    return status
