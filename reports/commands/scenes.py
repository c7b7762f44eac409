"""``nonsmooth scenes``: what is built in."""

from __future__ import annotations

from nonsmooth.reports.output.console import write_json, write_views
from nonsmooth.reports.output.study_options import Json


def scenes(json: Json = False) -> int:
    """List the built-in scenes: arrays of wheels, then plain switched systems and vehicles."""
    from nonsmooth.symbolic.files.documents import builtin_descriptions
    from nonsmooth.symbolic.files.system_file import system_descriptions
    from nonsmooth.symbolic.files.vehicle_file import vehicle_descriptions

    descriptions = {
        **builtin_descriptions(),
        **system_descriptions(),
        **vehicle_descriptions(),
    }
    if json:
        from nonsmooth.reports.checks.records import scenes_record

        write_json(scenes_record(descriptions))
    else:
        from nonsmooth.reports.output.terminal import scenes_view

        write_views([scenes_view(descriptions)])
    return 0
