"""The minimizers of the dissipation behind one interface, and how to choose one.

====================  ==========  =====================================================================
name                  functional  use
====================  ==========  =====================================================================
``EllipseMinimizer``  ellipse     all points at once in NumPy, to rounding: the one to use
``BoxHighs``          box         dual linear program by HiGHS, point by point: the one to use in floats
``BoxEnumeration``    box         every regular triple of rows, the literal definition: small arrays
====================  ==========  =====================================================================

Each returns :class:`~nonsmooth.analysis.minimizers.minimum.Minima`, whose ``check`` proves the result from twists and
forces alone.
"""

from __future__ import annotations

from typing import Protocol

from numpy.typing import ArrayLike

from nonsmooth.analysis.fields.contact_model import ContactRows
from nonsmooth.analysis.minimizers.box_minimizers import BoxEnumeration, BoxHighs
from nonsmooth.analysis.minimizers.dissipation import Functional
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.minimum import Minima


class Minimizer(Protocol):
    """Anything that minimizes one of the two functionals."""

    @property
    def functional(self) -> Functional:
        """What it minimizes."""

    def minimize(self, model: ContactRows, loads: ArrayLike) -> Minima:
        """Minimizers of D for the contact rows under normal forces (m, n), one for each row of loads.

        Raises:
            ValueError: for loads of another shape, negative, or not finite.
        """


MINIMIZERS: tuple[Minimizer, ...] = (EllipseMinimizer(), BoxHighs(), BoxEnumeration())
