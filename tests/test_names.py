"""No name stands for two things: every public class of the product has a name of its own."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator

from tests.sources import PACKAGES, ROOT, sources, summary_of

CHECKER = "proofs/checker/"  # stands alone, to be read beside the specification of certificates
# What scripts and notebooks hold of the class of the same name.
IN_SCRIPTS = {("reports/interface/array.py", "Wheel"), ("reports/interface/vehicle.py", "Vehicle")}


def public_classes() -> Iterator[tuple[str, str]]:
    """Files of the product, without the checker, which stands alone, and the classes in them."""
    for path in (path for package in PACKAGES for path in sources(package)):
        file = path.relative_to(ROOT).as_posix()
        for entry in summary_of(path).definitions if not file.startswith(CHECKER) else ():
            if entry.is_class and entry.is_outermost and not entry.name.startswith("_"):
                yield file, entry.name


def repeated(classes: Iterable[tuple[str, str]]) -> dict[str, list[str]]:
    """Names of several classes, with their files."""
    files = defaultdict(list)
    for file, name in classes:
        files[name].append(file)
    return {name: places for name, places in files.items() if len(places) > 1}


def test_no_two_classes_have_the_same_name() -> None:
    classes = set(public_classes())
    assert classes > IN_SCRIPTS
    assert repeated(classes - IN_SCRIPTS) == {}
    assert sorted(repeated(classes)) == ["Vehicle", "Wheel"]


def test_a_name_of_two_classes_is_told() -> None:
    assert repeated([("a.py", "Step"), ("b.py", "Step"), ("b.py", "Stop")]) == {"Step": ["a.py", "b.py"]}
