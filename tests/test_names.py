"""No name stands for two things: every public class of the product has a name of its own."""

from __future__ import annotations

import ast
from collections import defaultdict

from tests.sources import PACKAGES, ROOT, sources, statements_in, text_of
from tests.test_lengths import CHECKERS

# What scripts and notebooks hold of the class of the same name.
IN_SCRIPTS = {"reports/interface/wheel.py": "Wheel", "reports/interface/vehicle.py": "Vehicle"}


def test_no_two_public_classes_have_the_same_name() -> None:
    places = defaultdict(list)
    for path in (path for package in PACKAGES for path in sources(package)):
        file = path.relative_to(ROOT).as_posix()
        if file in CHECKERS:  # each stands alone
            continue
        for statement in statements_in(ast.parse(text_of(path))):
            if isinstance(statement, ast.ClassDef) and IN_SCRIPTS.get(file) != statement.name:
                places[statement.name].append(file)
    assert {name: files for name, files in places.items() if len(files) > 1 and not name.startswith("_")} == {}
