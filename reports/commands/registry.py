"""The commands: what ``nonsmooth --help`` says of each, and where each is written.

This is the registry.  A command on a scene is made of a study, which may stand anywhere in ``reports``; another one is
a function of its own name in the module of its own name beside this file.  Both have one entry here.  Only words are
kept, so that the help knows every command and imports none; the module of a study or function is imported when the
command runs, shows its own help or completes its options.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, MutableMapping
from importlib import import_module
from typing import Any, NamedTuple


class Entry(NamedTuple):
    """One command.

    Attributes:
        summary: the first paragraph of its help; of a function its docstring says it too, and a test compares.
        example: a line that works, without ``nonsmooth``.
        study: what it does with a scene: module in ``reports`` and name there; empty where the command is a function.
        more: of a study, what its help says below the summary, the exit statuses last.
    """

    summary: str
    example: str
    study: str = ""
    more: str = ""


COMMANDS = {  # in the order of the help
    "check": Entry(
        "Check Theorem 4 clause by clause, or the stability of a plain switched system; of many scenes in one table.",
        "check four-wheel --radius 1/4 --json",
        "checks.check.CHECK",
        "Exit status: 0 holds (or stable), 1 fails, hypotheses not met, or tips, 2 bad input, 3 undecided; "
        "of many the worst.",
    ),
    "partition": Entry(
        "List or draw the cells of the plane, each with its contact state and twist, or a sampled field.",
        "partition four-wheel -o cells.svg",
        "commands.partition.PARTITION",
        'Under rule box with loads = "any": where each motion is possible under some load.\n'
        "Of a plain system in two states: its cells, what solutions do on their borders, and with -o its phase "
        "portrait.\n"
        "\n"
        "Exit status: 0 done, 2 bad input.",
    ),
    "equilibria": Entry(
        "Find all places of rest of a plain switched system, on its switching surfaces too, and the stability of each.",
        "equilibria stick-slip",
        "checks.equilibria.EQUILIBRIA",
        "Exit status: 0 done, 2 bad input, 3 where some are not known.",
    ),
    "reduce": Entry(
        "Write a plain system as a smaller one, where it is the same along a line or conserves a sum of its states.",
        "reduce line-of-equilibria",
    ),
    "sweep": Entry(
        "Check many scenes that differ in a few numbers: a table, strips or a map of answers, and where they change.",
        "sweep four-wheel --vary mu_side=0.05:2:40 -o sweep.svg",
        "sweeps.sweep_study.SWEEP",
        "Exit status: 0 done, 2 bad input.",
    ),
    "derive": Entry(
        "Write the derivation report; without -o, as Markdown to standard output.",
        "derive four-wheel -o report.html",
        "derivations.derivation.DERIVE",
        "Of a plain system: its cells, Lyapunov function or leading terms, and solutions; in two states also borders "
        "and phase portrait.\n"
        "\n"
        "Exit status: 0 written, whatever the verdict; 2 bad input.",
    ),
    "simulate": Entry(
        "Follow a Filippov solution or a body with mass, map where many starts end, or find a periodic orbit.",
        "simulate four-wheel --from 0.2,0.4,0 --until 2 -o path.svg",
        "simulations.simulate.SIMULATE",
        "Exit status: 0 done, 2 bad input, 3 where paths contradict what is proved.",
    ),
    "precision": Entry(
        "Measure methods against exact answers: error, time, and how one depends on the other.",
        "precision four-wheel --study trajectories -o precision.svg",
        "checks.precision.PRECISION",
        "Exit status: 0 done, 2 bad input, 130 interrupted (finished rows are kept).",
    ),
    "verify": Entry(
        "Re-check a certificate with the stand-alone checker, which trusts nothing else of this program.",
        "verify four-wheel.json",
    ),
    "audit": Entry(
        "Decide whether somebody's function is a Lyapunov function on the checked square.",
        'audit four-wheel --lyapunov "x**2 + 3*y**2"',
        "checks.audit.AUDIT",
        "Exit status: 0 valid, 1 invalid, 2 bad input, 3 undecided.",
    ),
    "stress": Entry(
        "Stress a scene: extreme scales, ratios, gains and starts, with the error of every result.",
        "stress four-wheel -o stress.svg",
        "checks.precision.STRESS",
        "Exit status: 0 all rows ok, 1 not, 2 bad input, 130 interrupted (finished rows are kept).",
    ),
    "design": Entry(
        "Search for the headings, speeds and positions of the wheels that meet requirements and do best.",
        "design four-wheel --free headings --require position,heading --rule ellipse -o better.toml",
        "designs.design.DESIGN",
        "Exit status: 0 found, 1 nothing found that meets the requirements, 2 bad input.",
    ),
    "export": Entry(
        "Export an array to MuJoCo's MJCF, or a decided plain system to other provers and programs.",
        "export ring-6 -o ring-6.xml",
    ),
    "vehicle": Entry(
        "Predict how a vehicle on its own wheels moves and turns: twist, slips, forces, effective track.",
        "vehicle husky-a200 --spin 1.9",
        "commands.vehicle.VEHICLE",
        "Exit status: 0 done, 2 bad input.",
    ),
    "workbench": Entry(
        "Open the workbench: a local page to drag wheels, turn rims and slide friction, with answers within a blink.",
        "workbench four-wheel",
    ),
    "scenes": Entry(
        "List the built-in scenes: arrays of wheels, then plain switched systems and vehicles.",
        "scenes",
    ),
    "rules": Entry(
        "List the contact rules: what each says, and for which hardware it is a good guess.",
        "rules",
    ),
}


def command_function(name: str) -> Callable[..., Any]:
    """The function of a command; its parameters are the options."""
    entry = COMMANDS[name]
    if not entry.study:
        function: Callable[..., Any] = getattr(import_module(f"{__package__}.{name}"), name)
        return function
    from nonsmooth.reports.studies.study_command import command

    module, _, study = entry.study.rpartition(".")
    made = getattr(import_module(f"nonsmooth.reports.{module}"), study)
    return command(made, name, f"{entry.summary}\n\n{entry.more}")


class CommandsOnDemand(MutableMapping[str, Any]):
    """All commands by name, each made when it is first asked for."""

    def __init__(self, make: Callable[[str], Any]) -> None:
        self._make = make
        self._made: dict[str, Any] = {}

    def __getitem__(self, name: str) -> Any:
        if name not in self._made:
            if name not in COMMANDS:
                raise KeyError(name)
            self._made[name] = self._make(name)
        return self._made[name]

    def __setitem__(self, name: str, command: Any) -> None:
        self._made[name] = command

    def __delitem__(self, name: str) -> None:
        del self._made[name]

    def __iter__(self) -> Iterator[str]:
        return iter(COMMANDS)

    def __len__(self) -> int:
        return len(COMMANDS)
