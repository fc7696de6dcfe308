# SPDX-License-Identifier: Apache-2.0
"""Parameters of a controller over CAN are set all or none, whatever their order."""

import pytest

from camtools.identify.can_drive import ConnectedU
from camtools.identify.excitation_plan import Wishes, plan
from camtools.link.controller import Link
from camtools.link.messages import Refused
from tests.tools.cases.camctl_bench import Bench, ready

WIDE = {"x_trim_limit_nm": 90_000, "x_trim_nm": 80_000}
# One by one the limit would be refused, because the trim before is beyond it.
NARROW = {"x_trim_limit_nm": 50_000, "x_trim_nm": 40_000}


def test_parameters_that_bound_each_other_are_set_together(bench: Bench, link: Link) -> None:
    """They are in force and read back; a set with a wrong one changes nothing, and names it."""
    u = ConnectedU(link)
    for pair in (WIDE, NARROW):
        ready(bench)
        u.apply(pair)
        assert u.values(pair) == pair
    ready(bench)
    before = u.values(["k1_ns"])
    with pytest.raises(Refused, match=r"nothing is set: .*x_trim_limit") as refused:
        u.apply({"k1_ns": 7} | NARROW | {"x_trim_nm": 50_001})
    assert "\n" not in str(refused.value)
    assert u.values(NARROW) == NARROW
    assert u.values(before) == before


def test_a_value_that_reads_another_is_refused(
    bench: Bench, link: Link, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Somebody else sets it at the same time."""
    ready(bench)
    u = ConnectedU(link)
    monkeypatch.setattr("camtools.identify.can_drive.set_all", lambda *_: {})
    with pytest.raises(Refused, match=r"servo_mass_g = 777: reads 1500; .*apply again"):
        u.apply({"servo_mass_g": 777})


def test_a_fault_ends_the_excitation_with_its_name(
    bench: Bench, link: Link, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The remedy stands in the same line, and command is given back."""
    ready(bench)
    u = ConnectedU(link)
    excitation = plan(u.believed(), Wishes())

    def fault(link: Link, _timeout_s: float) -> str:
        bench.estop(is_pressed=True)
        assert link.wait(lambda: link.status.state == "fault", 5.0)
        return "fault"

    monkeypatch.setattr("camtools.link.excitation._follow", fault)
    with pytest.raises(Refused, match=r"cut short: fault: estop; see status, then reset"):
        u.played(excitation.play, ("u_set_q6", "u_actual_nm"))
    assert link.rights.session == 0
