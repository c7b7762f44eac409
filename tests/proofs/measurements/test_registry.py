"""The registry: every study and case that a file of the measurements defines is listed, once and under its own name."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

import nonsmooth.proofs.measurements as verdicts
from nonsmooth.analysis.measurements import cases, studies
from nonsmooth.analysis.measurements.harness import Case, Measurement, Study
from nonsmooth.proofs.measurements.registry import CASES, STUDIES, SYSTEM_STUDIES
from nonsmooth.symbolic.files.scene_file import load_scene


def defined() -> list[Measurement]:
    """The studies and cases of all files, the registry's own names aside."""
    found: list[Measurement] = []
    for package in (studies, cases, verdicts):
        for module in iter_modules(package.__path__):
            if module.name != "registry":
                values = vars(import_module(f"{package.__name__}.{module.name}")).values()
                found += [value for value in values if isinstance(value, Study | Case)]
    return found


def test_every_measurement_is_listed_once() -> None:
    listed = [*STUDIES, *SYSTEM_STUDIES, *CASES]
    assert sorted(map(id, defined())) == sorted(map(id, listed))
    for studies_of_a_kind in (STUDIES, SYSTEM_STUDIES):
        assert len({study.name for study in studies_of_a_kind}) == len(studies_of_a_kind)


def test_families_of_one_name_are_about_different_scenes() -> None:
    for about in ("array", "system"):
        names = [case.name for case in CASES if getattr(case, about) is not None]
        assert len(set(names)) == len(names)


def test_a_family_has_no_rows_of_scenes_that_it_is_not_about() -> None:
    scene = load_scene("ring-3")
    assert [list(case.rows(scene)) for case in CASES if case.array is None] == [[]]
