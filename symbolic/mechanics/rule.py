"""The contact rules that a scene may name, and where each is written.

This is the registry.  A contact rule is one class on
:class:`nonsmooth.analysis.cells.contact_rule.ContactRule` and one line here; the commands, their completion,
scene files, comparisons and reports offer whatever stands here, in this order.  Only names are kept, so that
a command line can offer them at once; :func:`nonsmooth.analysis.cells.contact_rule.contact_rule` imports the
class when it is needed.

A rule in ``BY_FRICTION_SET`` gives each wheel a set of forces of its own, so wheels of one array may name different
ones.  Such an array has the rule :data:`MIXED`, which nobody names.
"""

from __future__ import annotations

from nonsmooth.symbolic.messages.scene_error import is_meant

DEFAULT_RULE = "nearest"
MIXED = "mixed"

CONTACT_RULES = {  # name in scenes and on the command line: module and class
    "nearest": "nonsmooth.analysis.contact_rules:NearestRule",
    "box": "nonsmooth.analysis.contact_rules:BoxRule",
    "ellipse": "nonsmooth.analysis.contact_rules:EllipseRule",
    "roller": "nonsmooth.analysis.contact_rules:RollerRule",
}
BY_FRICTION_SET = {"ellipse", "roller"}
CELLS_BY_LOADS = {"box"}  # cells are found apart for each set of wheels that carry
MIXED_RULE = "nonsmooth.analysis.contact_rules:MixedRule"


def read_rule(value: object) -> str:
    """The name of a contact rule.

    Raises:
        ValueError: for anything else.
    """
    if not isinstance(value, str) or value not in CONTACT_RULES:
        raise ValueError(f"required {required_rule()}{is_meant(value, CONTACT_RULES)}")
    return value


def required_rule() -> str:
    """The names in words: ``'nearest', 'box', 'ellipse' or 'roller'``."""
    *others, last = (repr(name) for name in CONTACT_RULES)
    return f"{', '.join(others)} or {last}"
