"""What earlier versions read and this one does not: each is refused in one line that names the way to do without.

Whoever removes a command, an option, a table of scene files or an ending of files adds a line here, and a case to
``tests/test_removed.py``.  A line ends a sentence: "--front was removed: ...".
"""

from __future__ import annotations

COMMANDS: dict[str, str] = {
    "validate": "run `make evidence` in a checkout of the repository, or read its page docs/evidence.md",
}
"""By the name of the command."""

OPTIONS: dict[tuple[str, str], str] = {
    ("simulate", "--mode"): "follow each mode as a [system] of its own",
    ("vehicle", "--allow-outside"): "vehicles name no other files",
    ("design", "--front"): "use --maximize rate, then --maximize tolerance",
}
"""By the names of the command and of the option, such as ``("design", "--front")``."""

TABLES: dict[str, str] = {
    "mode": "let one [system] rhs switch by the signs of formulas, or follow each mode as a [system] of its own",
    "network": "write its functions as formulas with relu in [system] rhs",
    "vehicle.urdf": "place the wheels by track and wheel_base, or one by one in [[wheel]]",
}
"""By the key of a table in a scene file, such as ``mode``, or of an entry, such as ``vehicle.urdf``."""

ENDINGS: dict[str, str] = {
    ".mp4": "a film is a .gif, or an .html page with a slider",
}
"""By the ending of a file that was read or written, such as ``.mp4``."""

NAMES: dict[str, str] = {
    "validate": "run `make evidence` in a checkout of the repository, or read its page docs/evidence.md",
    "EvidenceResult": "run `make evidence` in a checkout of the repository",
    "PushedBody": "it is a part of the evidence, tests/evidence/pushed_body.py in a checkout of the repository",
    "VehiclesResult": "ask Vehicle.motion() of each; `make evidence` in a checkout compares all with measurements",
    "Modes": "follow each mode as a System of its own",
}
"""By the name that ``import nonsmooth`` offered."""

ARGUMENTS: dict[str, str] = {
    "vehicle": "one scene: run it for each; `make evidence` in a checkout compares all with measurements",
}
"""By the name of a command that takes one scene and took any number of them."""
