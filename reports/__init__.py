"""The package for people: the command line, derivation reports and figures.

It may import every other package, and no other package imports it. Matplotlib and Jinja2 are imported
only inside the call that needs them.
"""

from typing import TYPE_CHECKING

from nonsmooth.symbolic.messages.notebook import on_demand

if TYPE_CHECKING:
    from nonsmooth.reports.derivations.derivation import derive_report as derive_report
    from nonsmooth.reports.derivations.derivation import render_report as render_report
    from nonsmooth.reports.figures.cells import cell_map as cell_map
    from nonsmooth.reports.figures.path import trajectory_figure as trajectory_figure

__getattr__ = on_demand(
    __name__,
    {
        "derive_report": "derivations.derivation",
        "render_report": "derivations.derivation",
        "cell_map": "figures.cells",
        "trajectory_figure": "figures.path",
    },
)
