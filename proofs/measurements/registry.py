"""All measurements in their order: the studies of ``precision`` and the cases of ``stress``."""

from __future__ import annotations

from nonsmooth.analysis.measurements.cases.feedback_gain import FEEDBACK
from nonsmooth.analysis.measurements.cases.friction_ratio import FRICTION
from nonsmooth.analysis.measurements.cases.near_collinear import COLLINEAR
from nonsmooth.analysis.measurements.cases.near_starts import STARTS
from nonsmooth.analysis.measurements.cases.scales import SCALES
from nonsmooth.analysis.measurements.cases.support_edge import LOADS
from nonsmooth.analysis.measurements.cases.switches import SWITCHES
from nonsmooth.analysis.measurements.harness import Case, Study
from nonsmooth.analysis.measurements.studies.derivation import DERIVATION
from nonsmooth.analysis.measurements.studies.masses import MASS
from nonsmooth.analysis.measurements.studies.minimizers import BOX_MINIMIZERS, ELLIPSE_MINIMIZERS
from nonsmooth.analysis.measurements.studies.system_paths import SYSTEM_PATHS
from nonsmooth.analysis.measurements.studies.trajectories import TRAJECTORIES
from nonsmooth.analysis.measurements.studies.upper_derivative import UPPER_DERIVATIVE
from nonsmooth.proofs.measurements.array_verdicts import ARRAY_VERDICTS
from nonsmooth.proofs.measurements.pruning import PRUNING
from nonsmooth.proofs.measurements.system_verdicts import SYSTEM_VERDICTS

STUDIES: tuple[Study, ...] = (
    TRAJECTORIES,
    UPPER_DERIVATIVE,
    BOX_MINIMIZERS,
    ELLIPSE_MINIMIZERS,
    DERIVATION,
    MASS,
    PRUNING,
)
SYSTEM_STUDIES: tuple[Study, ...] = (SYSTEM_PATHS,)  # of plain systems
CASES: tuple[Case, ...] = (
    ARRAY_VERDICTS,
    SYSTEM_VERDICTS,
    FRICTION,
    LOADS,
    COLLINEAR,
    SCALES,
    STARTS,
    SWITCHES,
    FEEDBACK,
)
