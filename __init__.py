"""A nonsmooth stability analysis workbench for arrays of driven wheels and switched systems.

    import nonsmooth as ns

    array = ns.Array.ring(4, radius=0.2, phase="pi/4", mu_roll=1, mu_side="1/2")
    result = array.check()
    print(result)

Names are looked up when they are first used, so that the import costs nothing; ``dir(nonsmooth)`` lists them.
"""

from typing import TYPE_CHECKING, Any

from nonsmooth.symbolic.messages.notebook import on_demand
from nonsmooth.symbolic.messages.removed import NAMES

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.partition import RefusalError as RefusalError
    from nonsmooth.proofs.answers.answer import Heading as Heading
    from nonsmooth.proofs.answers.answer import Pose as Pose
    from nonsmooth.proofs.answers.answer import Position as Position
    from nonsmooth.reports.checks.agreement import ComparisonResult as ComparisonResult
    from nonsmooth.reports.checks.cells import CellsResult as CellsResult
    from nonsmooth.reports.checks.cells import FieldResult as FieldResult
    from nonsmooth.reports.checks.check_results import CheckResult as CheckResult
    from nonsmooth.reports.checks.system_results import SystemCheckResult as SystemCheckResult
    from nonsmooth.reports.checks.vehicles import VehicleResult as VehicleResult
    from nonsmooth.reports.derivations.derivation import ReportResult as ReportResult
    from nonsmooth.reports.designs.design import DesignResult as DesignResult
    from nonsmooth.reports.interface.array import Array as Array
    from nonsmooth.reports.interface.array import Wheel as Wheel
    from nonsmooth.reports.interface.array import load as load
    from nonsmooth.reports.interface.filippov_set import FilippovSet as FilippovSet
    from nonsmooth.reports.interface.system import System as System
    from nonsmooth.reports.interface.vehicle import Vehicle as Vehicle
    from nonsmooth.reports.laws.law_languages import LawResult as LawResult
    from nonsmooth.reports.simulations.maps import MapResult as MapResult
    from nonsmooth.reports.simulations.masses import MassResult as MassResult
    from nonsmooth.reports.simulations.orbits import OrbitResult as OrbitResult
    from nonsmooth.reports.simulations.paths import PathResult as PathResult
    from nonsmooth.reports.sweeps.sweep import Means as Means
    from nonsmooth.reports.sweeps.sweep_study import SweepResult as SweepResult
    from nonsmooth.reports.workbench.widget import widget as widget
    from nonsmooth.symbolic.files.documents import builtin_scenes as builtin_scenes
    from nonsmooth.symbolic.files.documents import builtin_vehicles as builtin_vehicles
    from nonsmooth.symbolic.messages.scene_error import SceneError as SceneError

_MODULES = {
    "Array": "reports.interface.array",
    "CellsResult": "reports.checks.cells",
    "CheckResult": "reports.checks.check_results",
    "ComparisonResult": "reports.checks.agreement",
    "DesignResult": "reports.designs.design",
    "FieldResult": "reports.checks.cells",
    "FilippovSet": "reports.interface.filippov_set",
    "Heading": "proofs.answers.answer",
    "LawResult": "reports.laws.law_languages",
    "MapResult": "reports.simulations.maps",
    "MassResult": "reports.simulations.masses",
    "Means": "reports.sweeps.sweep",
    "OrbitResult": "reports.simulations.orbits",
    "PathResult": "reports.simulations.paths",
    "Pose": "proofs.answers.answer",
    "Position": "proofs.answers.answer",
    "RefusalError": "analysis.cells.partition",
    "ReportResult": "reports.derivations.derivation",
    "SceneError": "symbolic.messages.scene_error",
    "SweepResult": "reports.sweeps.sweep_study",
    "System": "reports.interface.system",
    "SystemCheckResult": "reports.checks.system_results",
    "Vehicle": "reports.interface.vehicle",
    "VehicleResult": "reports.checks.vehicles",
    "Wheel": "reports.interface.array",
    "builtin_scenes": "symbolic.files.documents",
    "builtin_vehicles": "symbolic.files.documents",
    "load": "reports.interface.array",
    "widget": "reports.workbench.widget",
}
_PACKAGES = ("analysis", "proofs", "reports", "symbolic")
_look_up = on_demand(__name__, _MODULES)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("nonsmooth")
    if name in NAMES:
        raise AttributeError(f"{name} was removed: {NAMES[name]}")
    return _look_up(name)


def __dir__() -> list[str]:
    return sorted([*_MODULES, *_PACKAGES, "__version__"])
