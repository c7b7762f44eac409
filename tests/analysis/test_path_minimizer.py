"""Minimizers from the last one along a path, beside contacts that stick, against minimizers from nothing."""

from __future__ import annotations

import numpy as np
import pytest

from nonsmooth.analysis.fields.contact_model import ContactModel
from nonsmooth.analysis.minimizers import ellipse_minimizer
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer, PathMinimizer
from nonsmooth.analysis.minimizers.sum_of_supports import by_smoothing
from tests.thorough import few, keep

SAME = 1e-9  # of twists of order one
STICKS = 1e-12  # slip of a contact that sticks


def model_of(seed: int, alike: int) -> ContactModel:
    """Seven wheels; some of them run alike, so that contacts stick, two at once where they lie on a line."""
    rng = np.random.default_rng(seed)
    places, angles, speeds = rng.uniform(-1, 1, (7, 2)), rng.uniform(-1, 1, 7), rng.uniform(0.5, 1, 7)
    places[:alike] = np.linspace(-0.5, 0.5, alike)[:, None] * [1.0, 0.3]
    angles[:alike], speeds[:alike] = 0.1, 0.8
    rims = np.column_stack([np.cos(angles), np.sin(angles)])
    return ContactModel.build(places, rims, speeds, (1.0, 0.5))


@few(1)
@pytest.mark.parametrize("models", keep(1, [2, 8]))
@pytest.mark.parametrize("alike", [2, 0, 1, 3])
def test_twists_are_those_from_nothing(alike: int, models: int, monkeypatch: pytest.MonkeyPatch) -> None:
    begun: list[bool] = []

    def counted(*problem: object) -> object:
        begun.append(True)
        return by_smoothing(*problem)  # type: ignore[arg-type]  # handed on as it comes

    stuck = 0
    for seed in range(models):
        model, rng = model_of(seed, alike), np.random.default_rng(seed + 100)
        ends, path = rng.dirichlet(np.ones(7), 2), PathMinimizer(model)
        for share in np.linspace(0, 1, 21):
            loads = (1 - share) * ends[0] + share * ends[1]
            (expected,) = EllipseMinimizer().minimize(model, loads[None]).twists
            with monkeypatch.context() as patch:
                patch.setattr(ellipse_minimizer, "by_smoothing", counted)
                twist = path.twist(loads)
            assert twist is not None
            stuck += int((np.hypot(*model.slips(twist).T) < STICKS).any())
            assert np.abs(twist - expected).max() < SAME
    assert stuck > 2.5 * models
    assert len(begun) <= 5 * models


def test_a_motion_that_nothing_resists_is_no_minimizer() -> None:
    """Loads on one wheel leave turns about its contact free."""
    path = PathMinimizer(model_of(0, 0))
    assert path.twist(np.eye(7)[0]) is None
    assert path.twist(np.full(7, 1 / 7)) is not None
