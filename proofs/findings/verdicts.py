"""The closed set of answers, each with what it means and what to do next."""

from __future__ import annotations

from enum import StrEnum


class Equilibrium(StrEnum):
    """Whether ``0`` belongs to the translation part of F at the requested point."""

    HOLDS = "holds"
    FAILS = "fails"
    UNDECIDED = "undecided"


class Certainty(StrEnum):
    """Whether a statement about every array within tolerances is proved."""

    CERTIFIED = "certified"
    UNDECIDED = "undecided"


class Translation(StrEnum):
    """Stability of (x, y), strong: of every Filippov solution."""

    ASYMPTOTICALLY_STABLE = "asymptotically stable"
    STABLE = "stable"
    UNSTABLE = "unstable"
    UNDECIDED = "undecided"


class Rotation(StrEnum):
    """Stability of theta; ``theta = 0`` is never attractive, because no twist depends on theta."""

    UNSTABLE = "unstable"
    NEUTRAL = "stable, not attractive"
    UNDECIDED = "undecided"


class Feedback(StrEnum):
    """Whether the discontinuous law of the feedback clause makes V decrease."""

    STABILIZABLE = "stabilizable"
    NO_CERTIFICATE = "no certificate"
    UNDECIDED = "undecided"
    NOT_APPLICABLE = "not applicable"


class Theorem4(StrEnum):
    """The four clauses together."""

    HOLDS = "holds"
    FAILS = "fails"
    HYPOTHESES_NOT_MET = "hypotheses not met"
    UNDECIDED = "undecided"

    @property
    def exit_status(self) -> int:
        """0 holds, 1 does not hold, 3 undecided."""
        return {"holds": 0, "undecided": 3}.get(self.value, 1)
