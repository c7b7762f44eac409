"""The command: ``python -I -S`` this folder and FILE, or ``python -m nonsmooth.proofs.checker FILE``."""

import sys
from pathlib import Path

if __package__:
    from .files import main
else:
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
    from checker.files import main

sys.exit(main(sys.argv[1:]))
