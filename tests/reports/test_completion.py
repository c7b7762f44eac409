"""What the shell completes: sections, studies, rules and scenes."""

from __future__ import annotations

from nonsmooth.reports.derivations.derivation import complete_part
from nonsmooth.reports.output.study_options import complete_scene, complete_study


def test_sections_are_completed_after_a_comma() -> None:
    assert complete_part("verd") == ["verdict"]
    assert complete_part("verdict,cel") == ["verdict,cells"]
    assert complete_part("nothing") == []


def test_studies_and_scenes_are_completed() -> None:
    assert "derivation" in complete_study("der")
    assert complete_study("nothing") == []
    assert complete_scene("four-wheel") == ["four-wheel", "four-wheel-side"]
