"""Output files appear whole or not at all, and nothing else appears."""

from __future__ import annotations

from pathlib import Path

import pytest

from plannercheck.common.atomic_files import write_atomically


def test_a_first_file_needs_no_other_name(tmp_path, monkeypatch):
    """Found by a run of kills: a process that was killed between two names left the first one behind."""

    def never(self: Path, target: Path) -> None:
        raise AssertionError(f"{self} was to be renamed")

    if not Path("/proc/self/fd").is_dir():
        pytest.skip("this system has no files without a name")
    monkeypatch.setattr(Path, "replace", never)
    write_atomically(tmp_path / "out.csv", lambda file: file.write_text("first"))
    assert [file.name for file in tmp_path.iterdir()] == ["out.csv"]


@pytest.mark.parametrize("before", ["file", "link", "broken link"])
def test_what_is_there_already_is_replaced(tmp_path, before):
    out, target = tmp_path / "out.csv", tmp_path / "target"
    if before == "file":
        out.write_text("before")
    else:
        out.symlink_to(target)
    if before == "link":
        target.write_text("before")
    write_atomically(out, lambda file: file.write_text("after"))
    assert out.read_text() == "after"
    assert not out.is_symlink()
    kept = {"target": "before"} if before == "link" else {}
    assert {file.name: file.read_text() for file in tmp_path.iterdir()} == {"out.csv": "after", **kept}
