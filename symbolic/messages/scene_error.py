"""One error for whatever can be wrong with a scene, on one printable line."""

from __future__ import annotations

from collections.abc import Collection
from difflib import get_close_matches

MAX_SHOWN = 60  # characters of a user's text inside a message
MAX_FILE_SHOWN = 160
_MAX_INTEGER_BITS = 160
_MAX_ITEMS = 4


class StatedFact(str):
    """What was received, in our own words: shown without quotes."""

    __slots__ = ()


class SceneError(ValueError):
    """A scene that cannot be used; ``str(error)`` is one line such as
    ``my.toml: wheel[2].speed: required a finite number, received 'nan'``.

    Attributes:
        file: the scene file or built-in name.
        key: the offending key, list items counted from 1; empty for the file as a whole.
        expected: what the key requires.
        value: what it received; a :class:`StatedFact` where that is no TOML value.
    """

    def __init__(self, file: str, key: str, expected: str, value: object) -> None:
        super().__init__(file, key, expected, value)
        self.file, self.key, self.expected, self.value = file, key, expected, value

    def __str__(self) -> str:
        file = one_line(self.file)
        file = file if len(file) <= MAX_FILE_SHOWN else "..." + file[3 - MAX_FILE_SHOWN :]
        place = f"{file}: {_cut(one_line(self.key))}" if self.key else file
        return f"{place}: required {one_line(self.expected)}, received {shown(self.value)}"


def requirement(error: ValueError) -> str:
    """X of a message ``required X, received Y``."""
    return str(error).removeprefix("required ").split(", received ")[0]


def shown(value: object) -> str:
    """A TOML value on one printable line of at most :data:`MAX_SHOWN` characters."""
    match value:
        case StatedFact():
            return one_line(value)
        case str():
            text = repr(value)
        case bool():
            text = str(value).lower()
        case int() if value.bit_length() > _MAX_INTEGER_BITS:
            text = f"an integer of {value.bit_length()} bits"
        case dict():
            text = "a table"
        case list():
            items = [shown(item) for item in value[:_MAX_ITEMS]] + ["..."] * (len(value) > _MAX_ITEMS)
            text = f"[{', '.join(items)}]"
        case _:
            text = one_line(str(value))
    return _cut(text)


def one_line(text: str) -> str:
    """The text with every unprintable character (newline, control, surrogate) escaped."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def _cut(text: str) -> str:
    return text if len(text) <= MAX_SHOWN else text[: MAX_SHOWN - 3] + "..."


# ---- what somebody may have meant who misspelt a name, or used one of another tongue -------------


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


def is_meant(received: object, names: Collection[str]) -> str:
    """`` (is mu_side meant?)``, to stand behind the names; empty where none is like what was received."""
    if not isinstance(received, str):
        return ""
    plain = received[:MAX_READ].strip().lower()
    likeliest = get_close_matches(plain, [name for name in names if len(name) >= SHORTEST], 1, LIKENESS)
    alias = KEYS.get(plain) or RULES.get(plain.replace("-", "").replace(" ", "").removesuffix("s"), "")
    suggestion = alias if alias in names else likeliest[0] if likeliest else ""
    return f" (is {suggestion} meant?)" if suggestion else ""
