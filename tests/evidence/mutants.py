"""Attack the checker with mutants of certificates, as many as are asked for.

``python -m tests.evidence.mutants --theorem "theorem 4" --number 10000 --seed 3``
"""

from __future__ import annotations

import argparse
import sys
import time

from tests.oracles.mutants import run
from tests.proofs.attacks import ATTACKS


def main() -> int:
    """A line for each attack, with seconds of processor time, and false claims; of these the exit status tells."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--theorem", choices=[*ATTACKS, "all"], default="all", help="what is attacked")
    parser.add_argument("--number", type=int, default=10_000, help="mutants of each")
    parser.add_argument("--seed", type=int, default=1, help="of all choices")
    asked = parser.parse_args()
    status = 0
    for name in ATTACKS if asked.theorem == "all" else [asked.theorem]:
        start = time.process_time()
        found = run(ATTACKS[name], asked.number, asked.seed)
        seconds = time.process_time() - start
        print(f"{name}, {asked.number} mutants by seed {asked.seed}: {found}; {seconds:.0f} s", flush=True)
        for line in found.false:
            print(f"  FALSE {line}")
            status = 1
    return status


if __name__ == "__main__":
    sys.exit(main())
