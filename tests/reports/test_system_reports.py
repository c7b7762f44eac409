"""The derivation report of plain systems: in every format, by name of section, and its sliding velocities."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs.systems.border_motion import BorderKind, sliding_velocity
from nonsmooth.reports.checks.phase_portrait import PhasePortrait
from nonsmooth.reports.derivations.derivation import derive_report, render_report
from nonsmooth.reports.derivations.parts import names_of
from nonsmooth.reports.output.console import BAD_INPUT
from nonsmooth.symbolic.files.system_file import load_system
from nonsmooth.symbolic.messages.scene_kind import SceneKind
from tests.reports.conftest import Invoke

RELAYS = ns.System(["x_1", "omega"], ["-sign(x_1) + omega/4", "-sign(omega) - x_1/4"], radius="1/2")
SEVERAL = ns.System(["x", "y"], [["-x", "-y"], ["-x + y/4", "-y"]])


def test_every_section_is_written_or_named_as_left_out() -> None:
    report = RELAYS.derive()
    text = report.text(".md")
    left_out = text.split("## What was left out, and why")[1].split("##")[0]
    assert len(report.sections) == len(names_of(SceneKind.SYSTEM)) - 1
    assert "Section leading-terms: " in left_out
    assert report.verdict == "asymptotically stable"
    with pytest.raises(AttributeError, match="plain system"):
        _ = report.theorem4


def test_words_and_greek_letters_are_names_of_states() -> None:
    text = RELAYS.derive(only="cells").text(".tex")
    assert r"\tfrac{1}{4} \omega" in text or r"\frac{1}{4} \omega" in text
    assert "x_{1}" in text


def test_under_arbitrary_switching_the_rest_is_written() -> None:
    report = SEVERAL.derive(without="versions,references")
    text = report.text(".md")
    assert "Section borders: the field may switch at any time" in text
    assert json.loads(report.text(".json"))["phase_portrait"] is None
    assert "Phase portrait" not in report.sections


def test_leading_terms_stand_where_they_decide() -> None:
    report = derive_report(load_system("flower"), parts=("verdict", "leading-terms"))
    text = render_report(report, ".md")
    assert "## Leading terms" in text
    assert report.subject.headline == "asymptotically stable"


def test_sliding_velocities_are_limits_of_small_steps() -> None:
    """Euler steps that take the field of the side they are on chatter along the border with Filippov's velocity."""
    system = ns.System(["x", "y"], ["1 + y/2 - x", "-2*sign(y) + 1/3 + x/4"], radius=1).system
    sliding = [part for part in PhasePortrait(system).borders if part.kind is BorderKind.SLIDING]
    assert sliding
    step, count = 1e-5, 4_000
    for part in sliding:
        middle = tuple((a + b) / 2 for a, b in zip(part.start, part.end, strict=True))
        predicted = [float(v) for v in sliding_velocity(part, middle)]
        x, y = start = [float(v) for v in middle]
        for _ in range(count):
            x, y = x + step * (1 + y / 2 - x), y + step * (-2 * np.sign(y or 1e-12) + 1 / 3 + x / 4)
        walked = (np.array([x, y]) - start) / (step * count)
        assert walked == pytest.approx(predicted, abs=0.04)  # the field changes along the way


def test_the_command_writes_and_refuses(invoke: Invoke, tmp_path: Path) -> None:
    page = tmp_path / "eq-4.html"
    outcome = invoke("derive", "eq-4", "--only", "verdict,portrait", "-o", str(page))
    assert (outcome.status, outcome.out) == (0, f"{page}: asymptotically stable\n")
    assert "<svg" in page.read_text(encoding="utf-8")
    rule, section = ("--rule", "box"), ("--only", "wheels")
    for options, named in [(rule, "required no contact rule"), (section, "required names among verdict")]:
        refused = invoke("derive", "eq-4", *options)
        assert refused.status == BAD_INPUT
        assert named in refused.err
