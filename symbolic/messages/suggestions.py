"""What somebody may have meant who misspelt a name, or used one of another tongue."""

from __future__ import annotations

from collections.abc import Collection
from difflib import get_close_matches

SHORTEST = 4  # letters of a name that is taken for misspelt
LIKENESS = 0.7  # of a name to a known one, above which it is taken for misspelt (difflib)
MAX_READ = 60  # characters of what was given
# What others call the contact rules.
RULES = {
    "omni": "roller",
    "omniwheel": "roller",
    "mecanum": "roller",
    "swedish": "roller",
    "rollerbed": "roller",
    "coulomb": "ellipse",
    "isotropic": "ellipse",
    "elliptic": "ellipse",
    "rubber": "ellipse",
    "paper": "nearest",
    "square": "box",
    "rectangle": "box",
}
# What others call keys and columns.
KEYS = {
    "weight": "mass",
    "angle": "heading",
    "direction": "heading",
    "orientation": "heading",
    "rotation": "heading",
    "theta": "heading",
    "yaw": "heading",
    "pos": "position",
    "velocity": "speed",
    "length": "width",
    "center_of_mass": "centre_of_mass",
}


def is_meant(given: object, known: Collection[str]) -> str:
    """`` (is mu_side meant?)``, to stand behind the known names; empty where none is like what was given."""
    if not isinstance(given, str):
        return ""
    plain = given[:MAX_READ].strip().lower()
    likeliest = get_close_matches(plain, [name for name in known if len(name) >= SHORTEST], 1, LIKENESS)
    alias = KEYS.get(plain) or RULES.get(plain.replace("-", "").replace(" ", "").removesuffix("s"), "")
    found = alias if alias in known else likeliest[0] if likeliest else ""
    return f" (is {found} meant?)" if found else ""
