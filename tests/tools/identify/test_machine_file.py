# SPDX-License-Identifier: Apache-2.0
"""Machine files with other numbers for the controller."""

import tomllib

import pytest

from camtools.base.errors import CamtoolsError
from camtools.identify.machine_file import with_keys
from camtools.sim.machines import machine_bytes, names


@pytest.mark.parametrize("name", names())
def test_nothing_else_changes(name: str) -> None:
    """Every machine of the simulator, twice over: the last numbers count."""
    text = machine_bytes(name).decode()
    once = with_keys(text, "controller", {"k1_ns": 1, "lead_ns": 2})
    twice = with_keys(once, "controller", {"k1_ns": 3, "k2_us2": 4})
    wanted = tomllib.loads(text)
    wanted.setdefault("controller", {}).update({"k1_ns": 3, "lead_ns": 2, "k2_us2": 4})
    assert tomllib.loads(twice) == wanted
    assert [line for line in text.splitlines() if "#" in line] == [
        line for line in twice.splitlines() if "#" in line
    ]


def test_sub_tables() -> None:
    """[believed.u] is a table of its own."""
    text = "[believed.u]\ndamping = 0.5 # old\nmode_hz = 1\n[cut]\nkc_n_per_mm2 = 2\n"
    changed = with_keys(text, "believed.u", {"damping": 0.7})
    assert tomllib.loads(changed)["believed"]["u"] == {"damping": 0.7, "mode_hz": 1}


def test_what_cannot_be_changed_is_refused() -> None:
    """A table within a line."""
    with pytest.raises(CamtoolsError, match="its keys cannot be replaced; write it as"):
        with_keys("controller = {k1_ns = 3}\n", "controller", {"k1_ns": 4})
