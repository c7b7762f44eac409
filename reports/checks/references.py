"""The works that a report rests on, and how to cite this program."""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.reports.output.console import own_version


@dataclass(frozen=True)
class Reference:
    """One work."""

    authors: str
    title: str
    where: str

    @property
    def text(self) -> str:
        """As a list of references shows it."""
        return f"{self.authors}: {self.title}. {self.where}."


PAPER = Reference(
    "T. D. Murphey, J. W. Burdick",
    "On the Stability and Design of Distributed Manipulation Control Systems",
    "IEEE International Conference on Robotics and Automation, 2001",
)
FILIPPOV = Reference("A. F. Filippov", "Differential Equations with Discontinuous Righthand Sides", "Kluwer, 1988")
SHEVITZ_PADEN = Reference(
    "D. Shevitz, B. Paden",
    "Lyapunov stability theory of nonsmooth systems",
    "IEEE Transactions on Automatic Control 39, 1994",
)
BACCIOTTI_CERAGIOLI = Reference(
    "A. Bacciotti, F. Ceragioli",
    "Stability and stabilization of discontinuous systems and nonsmooth Lyapunov functions",
    "ESAIM: Control, Optimisation and Calculus of Variations 4, 1999",
)
BROCKETT = Reference(
    "R. W. Brockett",
    "Asymptotic stability and feedback stabilization",
    "In: Differential Geometric Control Theory, Birkhäuser, 1983",
)
RYAN = Reference(
    "E. P. Ryan",
    "On Brockett's condition for smooth stabilizability and its necessity in a context of nonsmooth feedback",
    "SIAM Journal on Control and Optimization 32, 1994",
)
JURDJEVIC_QUINN = Reference(
    "V. Jurdjevic, J. P. Quinn", "Controllability and stability", "Journal of Differential Equations 28, 1978"
)
HOMOGENEITY = Reference(
    "E. Bernuau, D. Efimov, W. Perruquetti, A. Polyakov",
    "On homogeneity and its application in sliding mode control",
    "Journal of the Franklin Institute 351, 2014",
)


def how_to_cite() -> str:
    """BibTeX of this program and of the paper whose method it implements."""
    return f"""@software{{nonsmooth,
  title   = {{nonsmooth: a nonsmooth stability analysis workbench}},
  author  = {{{{The nonsmooth developers}}}},
  version = {{{own_version()}}},
  license = {{Apache-2.0}}
}}
@inproceedings{{MurpheyBurdick2001,
  author    = {{Murphey, Todd D. and Burdick, Joel W.}},
  title     = {{On the Stability and Design of Distributed Manipulation
               Control Systems}},
  booktitle = {{IEEE International Conference on Robotics and Automation}},
  year      = {{2001}}
}}"""
