"""The exact package: scenes, number fields, constraints Omega_i, contact states and governing equations.

Every number is an element of one real field per scene, every sign is certified, and no float or tolerance decides
anything.  It may import python-flint, pydantic and SymPy (SymPy only inside the call that needs it: numbers and
contact states do without), never SciPy, CVXPY or another package.  Text from a user goes through the whitelist of
`expression`, never through an evaluator.
"""

from typing import TYPE_CHECKING

from nonsmooth.symbolic.messages.notebook import on_demand

if TYPE_CHECKING:
    from nonsmooth.symbolic.files.documents import builtin_scenes as builtin_scenes
    from nonsmooth.symbolic.files.scene_file import load_any as load_any
    from nonsmooth.symbolic.files.scene_file import load_scene as load_scene
    from nonsmooth.symbolic.files.scene_file import load_system as load_system
    from nonsmooth.symbolic.mechanics.contact_states import ContactState as ContactState
    from nonsmooth.symbolic.mechanics.contact_states import Row as Row
    from nonsmooth.symbolic.mechanics.contact_states import Twist as Twist
    from nonsmooth.symbolic.mechanics.contact_states import constraint_matrix as constraint_matrix
    from nonsmooth.symbolic.mechanics.contact_states import scene_rows as scene_rows
    from nonsmooth.symbolic.mechanics.contact_states import take_census as take_census
    from nonsmooth.symbolic.mechanics.equations import Coordinates as Coordinates
    from nonsmooth.symbolic.mechanics.equations import annihilator as annihilator
    from nonsmooth.symbolic.mechanics.equations import governing_equations as governing_equations
    from nonsmooth.symbolic.mechanics.equations import stacked_constraints as stacked_constraints
    from nonsmooth.symbolic.mechanics.equations import wheel_constraints as wheel_constraints
    from nonsmooth.symbolic.mechanics.scene import Scene as Scene
    from nonsmooth.symbolic.messages.scene_error import SceneError as SceneError
    from nonsmooth.symbolic.numbers.number import Number as Number
    from nonsmooth.symbolic.numbers.number_field import NumberField as NumberField
    from nonsmooth.symbolic.systems.switched_system import SwitchedSystem as SwitchedSystem

__getattr__ = on_demand(
    __name__,
    {
        "ContactState": "mechanics.contact_states",
        "take_census": "mechanics.contact_states",
        "Row": "mechanics.contact_states",
        "Twist": "mechanics.contact_states",
        "constraint_matrix": "mechanics.contact_states",
        "scene_rows": "mechanics.contact_states",
        "Coordinates": "mechanics.equations",
        "annihilator": "mechanics.equations",
        "governing_equations": "mechanics.equations",
        "stacked_constraints": "mechanics.equations",
        "wheel_constraints": "mechanics.equations",
        "builtin_scenes": "files.documents",
        "load_scene": "files.scene_file",
        "load_any": "files.scene_file",
        "load_system": "files.scene_file",
        "Number": "numbers.number",
        "NumberField": "numbers.number_field",
        "Scene": "mechanics.scene",
        "SceneError": "messages.scene_error",
        "SwitchedSystem": "systems.switched_system",
    },
)
