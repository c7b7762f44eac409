"""What can be asked of an array and of a plain system alike."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

from nonsmooth.reports.output.study_options import options_of
from nonsmooth.symbolic.messages.scene_error import shown

if TYPE_CHECKING:
    from nonsmooth.reports.checks.measurements import Precision, Stress
    from nonsmooth.reports.checks.system_results import AuditedFunction
    from nonsmooth.reports.derivations.derivation import ReportResult
    from nonsmooth.reports.studies.study import SceneStudy
    from nonsmooth.reports.sweeps.sweep import Means
    from nonsmooth.reports.sweeps.sweep_study import SweepResult
    from nonsmooth.symbolic.messages.scene_kind import SceneKind


class PythonScene(ABC):
    """A scene by its document, as Python describes it.

    Attributes:
        document: the tables of a scene file.
    """

    document: Mapping[str, Any]

    _nameless: ClassVar[str]  # what messages call it where the document names none

    @property
    @abstractmethod
    def exact(self) -> Any:
        """The exact scene."""

    @property
    def kind(self) -> SceneKind:
        """What it is."""
        kind: SceneKind = self.exact.kind
        return kind

    @property
    def origin(self) -> tuple[str, Path]:
        """Its name in messages, and the scene file that it would have."""
        name = self.document.get("name")
        label = name if isinstance(name, str) and name.strip() else self._nameless
        return label, Path(f"{label}.toml")

    @abstractmethod
    def with_(self, **changes: Any) -> Self:
        """Another scene in which some keys are changed."""

    def _studied(self, study: SceneStudy[Any], **keywords: Any) -> Any:
        """What a study finds; keywords that are none of its options change the scene."""
        from nonsmooth.reports.output.refusals import beyond_floats_named

        known = options_of(study.options)
        changes = {name: value for name, value in keywords.items() if name not in known}
        scene = (self.with_(**changes) if changes else self).exact
        with beyond_floats_named(scene) as has_such_numbers:
            found = study.of(scene, **{name: value for name, value in keywords.items() if name in known})
            if has_such_numbers:  # what results compute when they are asked fails here, where the number is named
                found.facts()
        return found

    def _simulated(self, **keywords: Any) -> Any:
        """What the command ``simulate`` finds."""
        from nonsmooth.reports.simulations.simulate import SIMULATE

        return self._studied(SIMULATE, **keywords)

    def sweep(
        self,
        values: Mapping[str, Any] | None = None,
        *,
        random: int | None = None,
        seed: int = 0,
        means: Means | None = None,
        **more: Any,
    ) -> SweepResult:
        """Check many scenes that differ from this one in a few numbers.

        Args:
            values: by key path or parameter, such as ``{"wheel.1.heading": "40:50:11"}`` or ``{"k": "0:5:40"}``: a
                range ``start:stop:count``, a list ``a,b,c``, or numbers one by one.  Several give every combination.
            random: how many random draws within ranges ``start:stop``, instead of a grid.
            seed: of the draws.
            means: how it is run: workers, store, borders, fail (:class:`nonsmooth.Means`).  More than one worker
                is a process each: a script then needs ``if __name__ == "__main__":`` around what it does.
            **more: values of parameters, and of numbers that only one table has, such as ``mu_side="0.05:1:40"``.

        Raises:
            SceneError: for a key path that names no number of the scene.
            ValueError: for values and means that cannot be used.
        """
        from nonsmooth.reports.sweeps.base import base_of
        from nonsmooth.reports.sweeps.sweep import Means
        from nonsmooth.reports.sweeps.sweep_study import swept

        for name, given, kind in (("values", values, Mapping), ("means", means, Means)):
            if not isinstance(given, kind | None):
                raise ValueError(f"{name}: required a {kind.__name__}, received {shown(given)}")
        base = base_of(self.document, *self.origin)
        return swept(base, {**(values or {}), **more}, means or Means(), draws=random, seed=seed)

    def derive(
        self,
        *,
        only: str | Sequence[str] | None = None,
        without: str | Sequence[str] | None = None,
        brief: bool = False,
    ) -> ReportResult:
        """The derivation report, to be read as text or saved.

        Args:
            only: names of the sections to write, such as ``"verdict,cells"``; all unless given.
            without: names of sections to leave out.
            brief: of an array, two pages for somebody who decides, in place of the sections.

        Raises:
            ValueError: for a name that is none, where the error lists all, and for ``brief`` of a plain system.
            RefusalError: where the motion is not determined.
        """
        from nonsmooth.reports.derivations.derivation import DERIVE, NamedScene

        asked = {"only": only, "without": without, "brief": brief or None}
        given = {name: value for name, value in asked.items() if value is not None}
        result: ReportResult = DERIVE.of(NamedScene(self.exact), **given)
        return result

    def audit(self, lyapunov: str | None = None) -> AuditedFunction:
        """Whether somebody's V is a Lyapunov function on the checked square or cube, decided exactly.

        Args:
            lyapunov: V in the displacement from the checked point, as a formula; the scene's own unless given.

        Raises:
            ValueError: where neither is given.
            SceneError: for text that is no formula of the states.
        """
        from nonsmooth.reports.checks.audit import AUDIT

        result: AuditedFunction = AUDIT.of(self.exact, lyapunov=lyapunov)
        return result

    def precision(
        self, study: str | Sequence[str] | None = None, *, runs: int = 3, time_limit: float = 5.0
    ) -> Precision:
        """Error against run time: every method against an exact or 60-digit answer.

        Args:
            study: the name of a study, or several; all unless given.
            runs: of which the shortest counts.
            time_limit: seconds for one method at one setting.

        Raises:
            ValueError: for studies that there are not, and numbers that measure nothing.
            SceneError: for a plain system that is not in two states.
        """
        from nonsmooth.reports.checks.precision import PRECISION

        named = None if study is None else [study] if isinstance(study, str) else list(study)
        result: Precision = PRECISION.of(self.exact, study=named, runs=runs, time_limit=time_limit)
        return result

    def stress(self) -> Stress:
        """Stiff and extreme cases, each measured against exact or 60-digit arithmetic.

        Raises:
            SceneError: for a plain system that is not in two states.
        """
        from nonsmooth.reports.checks.precision import STRESS

        result: Stress = STRESS.of(self.exact)
        return result

    def report(
        self,
        file: str | Path,
        *,
        only: str | Sequence[str] | None = None,
        without: str | Sequence[str] | None = None,
    ) -> Path:
        """Write the derivation report: .html, .tex (with its figures in a folder beside it), .md or .json.

        Raises:
            ValueError: for a section that is none.
            OutputError: for a file that cannot be written.
            RefusalError: where the motion is not determined.
        """
        from nonsmooth.reports.derivations.derivation import REPORT_FORMATS
        from nonsmooth.reports.output.files import output_path

        path = output_path(str(file), REPORT_FORMATS)  # refused before the work
        return self.derive(only=only, without=without).save(path)
