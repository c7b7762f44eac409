"""``python -m tests.evidence.rounded_rings``: how often rounding decides, on rings turned off inward by whole degrees.

Rings of three to twelve wheels, turned by 1, 5, ..., 89 degrees, under every rule and in three notations
(``tests/rounded_rings.py``).  It ends with status 1 where something said is wrong, and takes about half an hour;
``--counts 3,4,5`` takes some of the rings.
"""

from __future__ import annotations

import argparse
import tempfile
from collections import Counter
from pathlib import Path

from tests.rounded_rings import RULES, contradiction, said_of_ring

TURNS = range(1, 90, 4)  # degrees
NOTATIONS = ("field", "wheels", "table")


def study(counts: list[int]) -> int:
    """Print a line for each rule and the number of wheels; how much of what is said is wrong."""
    wrong = 0
    print("rule      wheels  " + "".join(f"{name:>10}" for name in NOTATIONS) + "   positions said")
    for rule in RULES:
        for count in counts:
            open_by_rounding, positions = Counter[str](), Counter[str]()
            for turn in TURNS:
                with tempfile.TemporaryDirectory() as folder:
                    said = said_of_ring(Path(folder), count, turn, rule)
                reason = contradiction(said)
                if reason:
                    wrong += 1
                    print(f"WRONG: {count} wheels, {turn} degrees, rule {rule}: {reason}")
                open_by_rounding.update(n for n, one in zip(NOTATIONS, said, strict=True) if one.by_rounding)
                positions.update(one.position for one in said)
            shares = "".join(f"{f'{open_by_rounding[name]}/{len(TURNS)}':>10}" for name in NOTATIONS)
            kinds = ", ".join(f"{verdict} {number}" for verdict, number in sorted(positions.items()))
            print(f"{rule:8}  {count:6}  {shares}   {kinds}", flush=True)
    return wrong


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--counts", default="3,4,5,6,7,8,9,10,11,12")
    raise SystemExit(1 if study([int(count) for count in parser.parse_args().counts.split(",")]) else 0)
