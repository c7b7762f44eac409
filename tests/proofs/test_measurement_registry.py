"""The registry: every study and case that a chapter defines is listed, once and under its own name."""

from __future__ import annotations

from nonsmooth.analysis.measurements import cases, path_studies, studies
from nonsmooth.analysis.measurements.harness import Case, Study
from nonsmooth.proofs import measurements
from nonsmooth.proofs.measurements import CASES, STUDIES, SYSTEM_STUDIES
from nonsmooth.symbolic.files.scene_file import load_scene


def defined() -> dict[int, Study | Case]:
    """The studies and cases of all chapters, by identity: the registry names those of the others too."""
    values = [value for module in (studies, path_studies, cases, measurements) for value in vars(module).values()]
    return {id(value): value for value in values if isinstance(value, Study | Case)}


def test_every_measurement_is_listed_once() -> None:
    listed = [*STUDIES, *SYSTEM_STUDIES, *CASES]
    assert sorted(defined()) == sorted(map(id, listed))
    for studies_of_a_kind in (STUDIES, SYSTEM_STUDIES):
        assert len({study.name for study in studies_of_a_kind}) == len(studies_of_a_kind)


def test_families_of_one_name_are_about_different_scenes() -> None:
    for about in ("array", "system"):
        names = [case.name for case in CASES if getattr(case, about) is not None]
        assert len(set(names)) == len(names)


def test_a_family_has_no_rows_of_scenes_that_it_is_not_about() -> None:
    scene = load_scene("ring-3")
    assert [list(case.rows(scene)) for case in CASES if case.array is None] == [[]]
