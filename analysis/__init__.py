"""The numeric package: cells, Filippov sets, equilibria, trajectories and error against run time.

It may import `nonsmooth.symbolic`, NumPy and SciPy; CVXPY only inside the call that needs it,
Matplotlib never. Its tolerances are named constants, each with a unit and a reason.
"""

from typing import TYPE_CHECKING

from nonsmooth.symbolic.messages.notebook import on_demand

if TYPE_CHECKING:
    from nonsmooth.analysis.bodies.mass_path import simulate_dynamics as simulate_dynamics
    from nonsmooth.analysis.bodies.mass_study import MassStudy as MassStudy
    from nonsmooth.analysis.bodies.mass_study import mass_ladder as mass_ladder
    from nonsmooth.analysis.bodies.mass_study import mass_study as mass_study
    from nonsmooth.analysis.bodies.newton_euler import DynamicPath as DynamicPath
    from nonsmooth.analysis.bodies.newton_euler import RigidBody as RigidBody
    from nonsmooth.analysis.bodies.newton_euler import disc as disc
    from nonsmooth.analysis.bodies.path import ellipse_path as ellipse_path
    from nonsmooth.analysis.cells.contact_partition import build_partition as build_partition
    from nonsmooth.analysis.cells.equilibria import find_equilibria as find_equilibria
    from nonsmooth.analysis.cells.partition import Partition as Partition
    from nonsmooth.analysis.cells.partition import RefusalError as RefusalError
    from nonsmooth.analysis.fields.constant_field import array_field as array_field
    from nonsmooth.analysis.fields.constant_field import feedback_field as feedback_field
    from nonsmooth.analysis.fields.constant_field import piecewise_constant as piecewise_constant
    from nonsmooth.analysis.fields.contact_model import contact_model as contact_model
    from nonsmooth.analysis.fields.feedback_laws import cascade_law as cascade_law
    from nonsmooth.analysis.fields.feedback_laws import corrected_law as corrected_law
    from nonsmooth.analysis.fields.feedback_laws import gradient_law as gradient_law
    from nonsmooth.analysis.fields.feedback_laws import printed_law as printed_law
    from nonsmooth.analysis.fields.feedback_laws import tangential_law as tangential_law
    from nonsmooth.analysis.fields.kinematics import Kinematics as Kinematics
    from nonsmooth.analysis.minimizers.agreement import compare_rules as compare_rules
    from nonsmooth.analysis.trajectories.hysteresis import simulate_hysteresis as simulate_hysteresis
    from nonsmooth.analysis.trajectories.maps import grid_starts as grid_starts
    from nonsmooth.analysis.trajectories.maps import settle_map as settle_map
    from nonsmooth.analysis.trajectories.result import Trajectory as Trajectory
    from nonsmooth.analysis.trajectories.trajectory import simulate as simulate

__getattr__ = on_demand(
    __name__,
    {
        "ellipse_path": "bodies.path",
        "MassStudy": "bodies.mass_study",
        "mass_ladder": "bodies.mass_study",
        "mass_study": "bodies.mass_study",
        "DynamicPath": "bodies.newton_euler",
        "RigidBody": "bodies.newton_euler",
        "disc": "bodies.newton_euler",
        "simulate_dynamics": "bodies.mass_path",
        "feedback_field": "fields.constant_field",
        "contact_model": "fields.contact_model",
        "corrected_law": "fields.feedback_laws",
        "cascade_law": "fields.feedback_laws",
        "gradient_law": "fields.feedback_laws",
        "tangential_law": "fields.feedback_laws",
        "printed_law": "fields.feedback_laws",
        "Kinematics": "fields.kinematics",
        "array_field": "fields.constant_field",
        "piecewise_constant": "fields.constant_field",
        "compare_rules": "minimizers.agreement",
        "build_partition": "cells.contact_partition",
        "find_equilibria": "cells.equilibria",
        "Partition": "cells.partition",
        "RefusalError": "cells.partition",
        "simulate_hysteresis": "trajectories.hysteresis",
        "grid_starts": "trajectories.maps",
        "settle_map": "trajectories.maps",
        "Trajectory": "trajectories.result",
        "simulate": "trajectories.trajectory",
    },
)
