"""Output files: a temporary file that nobody can foresee, never through a link."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from nonsmooth.reports.output.files import OutputError, write_whole


def test_a_planted_link_is_not_followed(tmp_path: Path) -> None:
    """The name was foreseeable: a link planted there made the program overwrite its target."""
    victim = tmp_path / "victim"
    victim.write_text("untouched", encoding="utf-8")
    (tmp_path / f".nonsmooth-{os.getpid()}.tmp").symlink_to(victim)
    write_whole(tmp_path / "out.json", b"{}")
    assert victim.read_text(encoding="utf-8") == "untouched"
    assert (tmp_path / "out.json").read_bytes() == b"{}"


@pytest.mark.parametrize("dangling", [True, False])
def test_a_link_at_the_very_name_is_not_followed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, dangling: bool
) -> None:
    victim = tmp_path / "victim"
    if not dangling:
        victim.write_text("untouched", encoding="utf-8")
    names = iter(["taken", "free"])
    monkeypatch.setattr("secrets.token_hex", lambda _: next(names))
    (tmp_path / ".nonsmooth-taken.tmp").symlink_to(victim)
    write_whole(tmp_path / "out.json", b"{}")
    assert victim.exists() is not dangling
    assert dangling or victim.read_text(encoding="utf-8") == "untouched"
    assert (tmp_path / "out.json").read_bytes() == b"{}"
    assert (tmp_path / ".nonsmooth-taken.tmp").is_symlink()


def test_names_that_are_all_taken_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("secrets.token_hex", lambda _: "taken")
    (tmp_path / ".nonsmooth-taken.tmp").write_text("somebody else's", encoding="utf-8")
    with pytest.raises(OutputError, match="required a file that can be written"):
        write_whole(tmp_path / "out.json", b"{}")
    assert (tmp_path / ".nonsmooth-taken.tmp").read_text(encoding="utf-8") == "somebody else's"
    assert not (tmp_path / "out.json").exists()


def test_new_files_follow_the_umask_and_old_ones_keep_their_mode(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        write_whole(tmp_path / "new", b"1")
        (tmp_path / "old").write_bytes(b"0")
        (tmp_path / "old").chmod(0o604)
        write_whole(tmp_path / "old", b"1")
    finally:
        os.umask(before)
    assert (tmp_path / "new").stat().st_mode & 0o777 == 0o640
    assert (tmp_path / "old").stat().st_mode & 0o777 == 0o604
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["new", "old"]
