"""``nonsmooth verify``: a certificate, re-checked by the stand-alone checker, and compared with a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from nonsmooth.reports.output.console import BAD_INPUT, write
from nonsmooth.reports.output.refusals import RefusedError
from nonsmooth.reports.output.study_options import SceneOptions, complete_scene
from nonsmooth.reports.studies.study_command import offered

if TYPE_CHECKING:
    from collections.abc import Iterable

    from nonsmooth.symbolic.mechanics.scene import Scene

ACCEPTED, REJECTED = 0, 1


def verify(
    file: Annotated[str, typer.Argument(metavar="CERTIFICATE", help="A file written by check --certificate.")],
    scene: Annotated[
        str | None,
        typer.Argument(
            metavar="[SCENE]",
            help="What the certificate must be about: a scene file or a built-in name.",
            autocompletion=complete_scene,
        ),
    ] = None,
    rule: Annotated[str | None, offered(SceneOptions, "rule")] = None,
    radius: Annotated[str | None, offered(SceneOptions, "radius")] = None,
    at: Annotated[str | None, offered(SceneOptions, "at")] = None,
) -> int:
    """Re-check a certificate with the stand-alone checker, which trusts nothing else of this program.

    Prints its subject, and what is shown of it. With a scene, the certificate must be about the same wheels, contact
    rule, point and square; a certificate of a plain system is proved anew from its formulas. Exit status: 0 accepted,
    1 rejected, 2 no certificate.
    """
    from nonsmooth.proofs.checker import check_file

    if _is_of_system(file):
        return _verify_system(file, scene, radius, at, rule=rule)
    status, message = check_file(file)
    if status == BAD_INPUT:
        raise RefusedError(f"{file}: required a certificate, received a file that is {message}")
    wanted = _wanted(scene, rule, radius, at)
    if wanted is None or status == REJECTED:
        write(f"{message}\n")
        return status
    difference, aside = _difference(file, wanted)
    another = f"another {difference}" if difference else ""
    return _compared(status, _with_left_out(message, aside), scene, another, "wheels, rule, point and square")


def _compared(status: int, message: str, scene: str | None, difference: str, same: str) -> int:
    """Say whether an accepted certificate is about the scene; the exit status.

    Args:
        status: of the checker.
        message: of the checker.
        scene: as typed.
        difference: what the certificate has instead; empty where it is about the scene.
        same: what was compared.
    """
    if difference:
        write(f"rejected: required a certificate about {scene}, received {difference}\n{message}\n")
        return REJECTED
    write(f"{message}\nabout {scene}: the same {same}\n")
    return status


def _with_left_out(message: str, lines: Iterable[str]) -> str:
    return "\n".join([message, *(f"left out, not shown here: {line}" for line in lines)])


def _is_of_system(file: str) -> bool:
    """Whether a file says that it is a certificate of a plain system."""
    from nonsmooth.proofs.checker.files import read

    try:
        subject = read(file)[0]["statement"]["subject"]
    except (OSError, ValueError, RecursionError, KeyError, TypeError, IndexError):
        return False
    return isinstance(subject, dict) and "states" in subject


def _verify_system(file: str, scene: str | None, radius: str | None, at: str | None, *, rule: object) -> int:
    """The certificate of a plain system, and whether it is about the system that is named."""
    from nonsmooth.proofs.checker.files import check_file, read
    from nonsmooth.proofs.kernel.subject import NoCertificateError
    from nonsmooth.proofs.system_certificates import find_system_difference, left_out
    from nonsmooth.symbolic.files.scene_file import load_system

    if rule is not None:
        raise RefusedError("--rule: required a certificate of an array, received one of a plain system")
    if scene is None:
        _refuse_without_scene(rule, radius, at)
    wanted = None if scene is None else load_system(scene, radius=radius, at=at)
    status, message = check_file(file)
    if status == ACCEPTED:
        message = _with_left_out(message, left_out(read(file)[0]))
    if wanted is None or status == REJECTED:
        write(f"{message}\n")
        return status
    try:
        difference = find_system_difference(file, wanted)
    except NoCertificateError as error:
        raise RefusedError(f"{wanted.origin}: {error}") from None
    other = f"one with {difference}" if difference else ""
    return _compared(status, message, scene, other, "states, formulas and point")


def _wanted(scene: str | None, rule: Any, radius: str | None, at: str | None) -> Scene | None:
    """The scene to compare with; options that would replace something of it need one."""
    from nonsmooth.symbolic.files.scene_file import load_scene
    from nonsmooth.symbolic.mechanics.contact_set import standing

    if scene is not None:
        return standing(load_scene(scene, rule=rule, radius=radius, at=at))
    _refuse_without_scene(rule, radius, at)
    return None


def _refuse_without_scene(rule: Any, radius: str | None, at: str | None) -> None:
    for option, given in (("--rule", rule), ("--radius", radius), ("--at", at)):
        if given is not None:
            raise RefusedError(f"{option}: required a scene to compare the certificate with, received none")


def _difference(file: str, scene: Scene) -> tuple[str, list[str]]:
    """Where a certificate and a scene differ, and what of the scene it leaves aside where they do not."""
    from nonsmooth.proofs.certificate import find_difference, not_followed
    from nonsmooth.proofs.checker.files import read
    from nonsmooth.proofs.kernel.subject import NoCertificateError

    certificate = read(file)[0]
    try:
        difference = find_difference(certificate, scene)
        return difference, [] if difference else list(not_followed(certificate, scene))
    except NoCertificateError as error:
        raise RefusedError(f"{scene.origin}: {error}") from None
