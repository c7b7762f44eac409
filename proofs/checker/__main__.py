"""The command: ``python -I -S`` this folder and FILE, or ``python -m nonsmooth.proofs.checker FILE``."""

import sys
from pathlib import Path

if not __package__:  # run as a folder: its modules are found as a package of its name
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
    __package__ = Path(__file__).resolve().parent.name

from importlib import import_module

sys.exit(import_module(".files", __package__).main(sys.argv[1:]))
