"""``nonsmooth rules``: the contact rules, and for which machines each is a good guess."""

from __future__ import annotations

from nonsmooth.reports.console import write_json, write_views
from nonsmooth.reports.options import Json


def rules(json: Json = False) -> int:
    """List the contact rules: what each says, and for which hardware it is a good guess."""
    from nonsmooth.reports.contact_rules import rules_record, rules_view

    if json:
        write_json(rules_record())
    else:
        write_views([rules_view()])
    return 0
