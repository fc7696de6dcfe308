# SPDX-License-Identifier: Apache-2.0
"""How late the ticks of the Linux port are.

tests/linux/run tests/linux/bench_real_time.py -s -k real_time prints it.
"""

from collections.abc import Callable

import numpy as np

from tests.linux.kernel import Result

pytest_plugins = ["tests.linux.linux_fixtures"]


def test_ticks_in_real_time(play: Callable[..., Result]) -> None:
    """A thousand a second for ten seconds; lateness is printed, not judged: others use the host."""
    result = play("real_time", is_virtual=False)
    late_us = np.array(result.seen["late_ns"]) / 1000
    assert result.seen["controller_status"] == 0 and len(late_us) > 1000
    median, p99, last = np.percentile(late_us, (50, 99, 100))
    left_out = result.seen["wanted"] - len(late_us)
    print(f"real time: {len(late_us)} ticks in 10 s, {left_out} left out;")
    print(f"  late by {median:.0f} us (median), {p99:.0f} us (99 %), {last:.0f} us (largest)")
