# SPDX-License-Identifier: Apache-2.0
"""The firmware process on a real kernel, against the machine of camsim bus; README.md tells more."""

from __future__ import annotations

from collections.abc import Callable

from kernel import InProcess, Result

Play = Callable[..., Result]


def test_whole_cut(play: Play, in_process: InProcess) -> None:
    """A whole cut."""
    r = play("whole_cut")
    print(r.summary["form_error_um"], in_process.summary["form_error_um"])
    assert r.summary["end"] == "done"
