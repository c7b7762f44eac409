"""Whether a certificate speaks of a given scene: the same wheels, rule, loads, point and square, exactly.

Both sides are numbers over generators, each the largest root of a monic polynomial over the generators before it.  So
equal polynomials have equal roots, and after renaming the scene's generators to the certificate's, numbers are equal if
they are the same sums of products.  The certificate has been accepted by the checker: its generators are as they should
be and its products are reduced.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any, TypeAlias

from nonsmooth.proofs.certificate import scene_record
from nonsmooth.symbolic.mechanics.contact_set import alone
from nonsmooth.symbolic.mechanics.scene import Scene

Record: TypeAlias = dict[str, Any]
Sum: TypeAlias = dict[tuple[int, ...], Fraction]

UNKNOWN = -1  # a generator of the scene that the certificate does not have


def find_difference(certificate: Record, scene: Scene) -> str:
    """Where an accepted certificate and a scene differ, in words; empty where it speaks of this scene.

    Args:
        certificate: parsed JSON of an array that the checker accepted.
        scene: the array, with the rule, the point and the square that were checked.
    """
    own, subject = scene_record(alone(scene)), certificate["statement"]["subject"]
    names = _renamed_generators(own["field"], subject["field"])
    for key in ("rule", "at", "radius", "loads"):
        if _value(subject[key], None) != _value(own[key], names):
            return key
    if len(subject["wheels"]) != len(own["wheels"]):
        return f"number of wheels ({len(subject['wheels'])} instead of {len(own['wheels'])})"
    for number, (theirs, ours) in enumerate(zip(subject["wheels"], own["wheels"], strict=True), 1):
        if set(theirs) != set(ours):
            return f"axis of wheel {number}"
        for key in ours:
            if _value(theirs[key], None) != _value(ours[key], names):
                return f"{key} of wheel {number}"
    return "" if _has_tolerances(subject.get("tolerances"), own["tolerances"], names) else "tolerance"


def _has_tolerances(theirs: Record | None, own: Record | None, names: list[int]) -> bool:
    """Whether a certificate speaks of a scene's tolerances, or of none."""
    if theirs is None:
        return True
    return own is not None and all(_value(theirs[name], None) == _value(own[name], names) for name in own)


def _renamed_generators(own: list[Record], theirs: list[Record]) -> list[int]:
    """The number of each of the scene's generators in the certificate."""
    polynomials = [_value(entry["polynomial"], None) for entry in theirs]
    names: list[int] = []
    for entry in own:
        polynomial = _value(entry["polynomial"], names)
        names.append(polynomials.index(polynomial) if polynomial in polynomials else UNKNOWN)
    return names


def _value(data: Any, names: list[int] | None) -> Any:
    """Numbers as sums of products, in lists of the same shape; words as they are."""
    if data is None or data in ("nearest", "box", "elastic"):
        return data
    if isinstance(data, str):
        return _sum([[data]], names)
    if data and all(_is_product(item) for item in data):
        return _sum(data, names)
    return [_value(item, names) for item in data]


def _is_product(item: Any) -> bool:
    """Whether an item is ``[rational, generator, ...]``; the items of a vector are texts or lists of these."""
    return isinstance(item, list) and isinstance(item[0], str) and all(isinstance(k, int) for k in item[1:])


def _sum(products: list[list[Any]], names: list[int] | None) -> Sum:
    total: Sum = {}
    for text, *factors in products:
        renamed = factors if names is None else [names[k] for k in factors]
        monomial = tuple(sorted(renamed))
        total[monomial] = total.get(monomial, Fraction(0)) + Fraction(text)
    return {monomial: c for monomial, c in total.items() if c}
