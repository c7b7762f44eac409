"""The certified feedback law as a program: one file of the standard library with one function."""

from __future__ import annotations

from pprint import pformat

from nonsmooth.reports.law_table import LawKind, LawTable
from nonsmooth.symbolic.scene_error import one_line

WIDTH = 100

_HEAD = '''"""The feedback law of {name}, rule {rule}, certified by nonsmooth.

speeds(x, y, theta) returns the speed of every rim, by the number of its wheel, for a body whose centre of mass is
displaced by (x, y) from the checked point {at} and turned by theta (radian).  It needs nothing but Python.
Wheels that are not named in a region do not carry the body there and may run at any speed.
It is certified {certified}.
{notes}The speeds are combinations of: {terms}.
"""

import math

'''

_PLACE = '''

def region_at(x, y):
    """The region that holds the displacement; between two of them, by rounding, the one it is deepest in."""
    def depth(region):
        return min(((a + b * x + c * y) / math.hypot(b, c) for a, b, c in region["sides"]), default=0.0)

    best = max(REGIONS, key=depth)
    if depth(best) < -1e-9 * SIZE:
        raise ValueError(f"required a place in a region of the law, received ({x}, {y})")
    return best
'''

_TERMS = {
    LawKind.GRADIENT: """    X, Y = (1 + E) * x + F * y, F * x + (1 - E) * y
    terms = X, Y, WEIGHT * theta + Y * x - X * y
""",
    LawKind.CASCADE: """    terms = math.hypot(x, y), x, y, theta
""",
    LawKind.SLOW_TURNS: """    ((a, b),) = region["axes"]
    r, s = a * x + b * y, a * y - b * x
    lead = s * s / (2 * r * LENGTH) if r > 0 else 0.0
    turn = s / LENGTH - (theta - lead)
    terms = (1 - turn) * r, turn
""",
}

_LINEAR = '''

def speeds(x, y, theta, k=1.0):
    """Rim speeds by wheel, with gain k (1/time)."""
    region = region_at(x, y)
{terms}    return {result}
'''

_LINEAR_RESULT = '{wheel: k * sum(c * t for c, t in zip(row, terms)) for wheel, row in region["speeds"].items()}'

_DRIVEN = '''

def speeds(x, y, theta, k=1.0):
    """Rim speeds by wheel, with gain k (1/time)."""
    region = region_at(x, y)
    products = [x * a + y * b + WEIGHT * theta * c for a, b, c in region["axes"]]
    chosen = max(range(len(products)), key=lambda index: abs(products[index]))
    return {result}
'''

_DRIVEN_RESULT = '{wheel: -k * products[chosen] * row[chosen] for wheel, row in region["speeds"].items()}'

_WITHIN_LIMITS = '''

def within_limits(speeds):
    """All speeds times one factor, where one of them would exceed its limit: the body takes the same way, later."""
    demand = max([abs(speeds[wheel]) / limit for wheel, limit in LIMITS.items() if wheel in speeds], default=0.0)
    return speeds if demand <= 1 else {wheel: speed / demand for wheel, speed in speeds.items()}
'''

_NAMES = {"e": "E", "f": "F", "w": "WEIGHT", "l": "LENGTH"}


def law_program(law: LawTable, at: str) -> str:
    """The text of the file.

    Args:
        law: the law.
        at: the checked point, in words.
    """
    name = one_line(law.scene.name).replace("\\", "/").replace('"', "'")
    regions: list[dict[str, object]] = [
        {"name": region.name, "sides": region.sides, "speeds": dict(region.speeds), "axes": region.axes}
        for region in law.regions
    ]
    head = _HEAD.format(
        name=name, rule=law.scene.contact.rule, at=at, certified=law.certified, terms=law.kind, notes=_notes(law)
    )
    constants = {_NAMES[key]: value for key, value in law.constants.items()} | {"SIZE": float(law.scene.check.radius)}
    lines = "".join(f"{key} = {value!r}\n" for key, value in constants.items())
    limits = {index: float(limit) for index, limit in law.scene.speed_limits.items()}
    lines += f"LIMITS = {limits!r}\n" if limits else ""
    scaling = _WITHIN_LIMITS if limits else ""
    regions_text = pformat(regions, width=WIDTH, sort_dicts=False)
    return f"{head}{lines}REGIONS = {regions_text}\n{_PLACE}{scaling}{_speeds_function(law.kind, limited=bool(limits))}"


def _notes(law: LawTable) -> str:
    """Lines on the units of the scene, and on how fast wheels run at most; none where these are not known."""
    units = law.scene.units
    notes = [f"Lengths are in {units.length}, speeds in {units.speed}, times in {units.time}."] if units.length else []
    notes += [f"No rim is asked for a speed above {law.effort}."] if law.effort else []
    return "".join(f"{note}\n" for note in notes)


def _speeds_function(kind: LawKind, *, limited: bool) -> str:
    """The function ``speeds`` of the file."""
    result = _DRIVEN_RESULT if kind is LawKind.DRIVEN else _LINEAR_RESULT
    result = f"within_limits({result})" if limited else result
    if kind is LawKind.DRIVEN:
        return _DRIVEN.format(result=result)
    return _LINEAR.format(terms=_TERMS[kind], result=result)
