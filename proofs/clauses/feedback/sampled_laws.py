"""Two laws of the field in closed loop, sampled beside an undecided clause: they decide nothing."""

from __future__ import annotations

import math
from dataclasses import replace

from nonsmooth.analysis.cells.contact_rule import rule_of
from nonsmooth.analysis.fields.contact_model import contacts_under
from nonsmooth.analysis.minimizers.dissipation import functional_of
from nonsmooth.analysis.minimizers.minimum import free_motions
from nonsmooth.analysis.minimizers.sampling import LoopSample, SampledLaw, sample_closed_loop
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.similar_scenes import in_own_length

# Random states per law, each one minimization (a linear program of a millisecond under rule box); the search adds
# a few hundred.
STATES = {"box": 100, "ellipse": 1_000}


def with_samples(feedback: DrivenFeedback, scene: Scene) -> DrivenFeedback:
    """The feedback with two laws of the field sampled in the checked square of the centred scene."""
    rule = rule_of(scene)
    functional = functional_of(rule)
    if functional is None:
        raise TypeError(f"required a rule that minimizes the dissipation, received {scene.contact.rule}")
    own = in_own_length(scene)
    model = contacts_under(rule, own)
    radius, states = float(own.check.radius), STATES[functional]
    free = free_motions(scene)
    if free:
        return replace(feedback, samples=tuple(LoopSample(law, 0, None, None, free) for law in SampledLaw))
    length = float(scene.check.length)
    samples = [sample_closed_loop(model, functional, law, radius, states).in_unit(length) for law in SampledLaw]
    return replace(feedback, samples=tuple(sorted(samples, key=_worst_rate)))


def _worst_rate(sample: LoopSample) -> float:
    """The rate by which laws are ordered; one without any comes last."""
    return math.inf if sample.worst_rate is None else sample.worst_rate
