# SPDX-License-Identifier: Apache-2.0
"""Where a result comes from."""

from pathlib import Path

import pytest

from camtools.base import provenance
from camtools.base.errors import CamtoolsError
from camtools.base.project_paths import VERSION
from camtools.base.provenance import command_text, date_text, origin_of, version_text


def test_date_is_that_of_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    """SOURCE_DATE_EPOCH fixes the date, whatever the zone; other words are refused."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    monkeypatch.setenv("TZ", "Asia/Tokyo")
    assert date_text() == "2023-11-14 22:13 UTC"
    for wrong in ("tomorrow", "", "1e9", "9" * 30):
        monkeypatch.setenv("SOURCE_DATE_EPOCH", wrong)
        with pytest.raises(CamtoolsError, match=r"SOURCE_DATE_EPOCH = .*: not a time; give whole"):
            date_text()
    monkeypatch.delenv("SOURCE_DATE_EPOCH")
    assert date_text()[:2] == "20"


def test_version_without_git_is_said(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A project that was copied without its history does not invent a version."""
    monkeypatch.setattr(provenance, "ROOT", tmp_path)
    assert version_text() == VERSION
    (tmp_path / ".git").touch()
    assert version_text() == "unknown (git cannot tell)"
    monkeypatch.setenv("PATH", "")
    assert version_text() == "unknown (git cannot be run)"


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ((), "tools/run"),
        (("a.toml", "-o", "out", "--rpm", "9"), "tools/run a.toml --rpm 9"),
        (("--output=x", "it's.toml"), "tools/run 'it'\"'\"'s.toml'"),
        (("-o", "-o", "a.toml"), "tools/run a.toml"),
        (("-o", "x", "--", "-o", "7"), "tools/run -- -o 7"),
    ],
)
def test_command_is_told_without_the_folder(words: tuple[str, ...], text: str) -> None:
    """Where the results go does not change them, and tells of the computer they were made on."""
    assert command_text("tools/run", words) == text
    assert origin_of("tools/run", words).command == text
