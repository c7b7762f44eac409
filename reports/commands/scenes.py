"""``nonsmooth scenes``: what is built in."""

from __future__ import annotations

from nonsmooth.reports.output.console import write_json, write_views
from nonsmooth.reports.output.study_options import Json


def scenes(json: Json = False) -> int:
    """List the built-in scenes: arrays of wheels, then plain switched systems and vehicles."""
    from nonsmooth.symbolic.files.documents import builtin_descriptions
    from nonsmooth.symbolic.files.scene_file import system_descriptions
    from nonsmooth.symbolic.files.vehicle_file import vehicle_descriptions

    kinds = builtin_descriptions(), system_descriptions(), vehicle_descriptions()
    if json:
        from nonsmooth.reports.checks.answers import scenes_record

        write_json(scenes_record({name: text for kind in kinds for name, text in kind.items()}))
    else:
        from nonsmooth.reports.output.terminal import scenes_view

        write_views([scenes_view(kinds)])
    return 0
