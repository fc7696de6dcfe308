"""Where a result comes from: its date, the version of the program, the command that repeats it.

>>> from unittest.mock import patch
>>> with patch.dict(os.environ, {"SOURCE_DATE_EPOCH": "86400"}):
...     origin_of("tools/run", ["a part.toml", "-o", "out"])._replace(version="")
Origin(date='1970-01-02 00:00 UTC', version='', command="tools/run 'a part.toml'")
"""

from __future__ import annotations

import os
import shlex
import subprocess
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import NamedTuple

from camtools.base.errors import CamtoolsError
from camtools.base.project_paths import ROOT, VERSION, with_names

_OUTPUT = ("-o", "--output")


class Origin(NamedTuple):
    """What a person needs to repeat a result."""

    date: str
    version: str
    command: str  # without the folder of the results, which changes nothing


def date_text() -> str:
    """Return now, or the time of SOURCE_DATE_EPOCH, to the minute.

    Raises
    ------
    CamtoolsError
        The variable is no number of seconds.
    """
    given = os.environ.get("SOURCE_DATE_EPOCH")
    try:
        when = datetime.now(UTC) if given is None else datetime.fromtimestamp(int(given), UTC)
    except (ValueError, OverflowError, OSError) as error:
        problem = f"SOURCE_DATE_EPOCH = {given}: not a time"
        raise CamtoolsError([f"{problem}; give whole seconds since 1970, or unset it"]) from error
    return when.strftime("%Y-%m-%d %H:%M UTC")


def version_text() -> str:
    """Return what git calls this state of the project, without a clone its version."""
    if not (ROOT / ".git").exists():
        return VERSION
    words = ["git", "-C", str(ROOT), "describe", "--always", "--dirty", "--tags"]
    try:
        done = subprocess.run(words, capture_output=True, text=True, timeout=10, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return "unknown (git cannot be run)"
    return done.stdout.strip() or "unknown (git cannot tell)"


def command_text(program: str, words: Sequence[str]) -> str:
    """Return a command line without the folder of its results, as a shell takes it."""
    kept: list[str] = []
    skips, is_ours = False, True
    for word in words:
        is_ours = is_ours and word != "--"
        is_output = is_ours and (word in _OUTPUT or word.startswith("--output="))
        if not skips and not is_output:
            kept.append(word)
        skips = is_output and word in _OUTPUT and not skips
    return shlex.join([program, *kept])


def origin_of(program: str, words: Sequence[str]) -> Origin:
    """Return where a result comes from that a command makes now."""
    return Origin(date_text(), version_text(), command_text(with_names(program), words))
