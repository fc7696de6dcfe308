"""The controller's rule of feasibility, `host_sim/api/judge/judge_api.h`, for a table.

>>> Judge(TablePeaks(), 20_000, {}).highest_mrpm()
0
"""

import weakref
from collections.abc import Mapping
from ctypes import (
    POINTER,
    Structure,
    byref,
    c_bool,
    c_char_p,
    c_double,
    c_int64,
    c_size_t,
    c_uint32,
    c_void_p,
)
from typing import NamedTuple

from camtools.base.errors import CamtoolsError
from camtools.base.project import Prototypes, library


class _Demand(Structure):
    """`judge_api_demand_t`."""

    _fields_ = (("name", c_char_p), ("limit", c_int64), ("needed", c_int64))


class TablePeaks(Structure):
    """A part with lobes before its table is made: `judge_api_peaks_t`."""

    _fields_ = (
        ("span_nm", c_uint32),
        ("feed_nm", c_uint32),
        ("change_nm", c_uint32),
        ("u_nm", c_uint32),
        ("u1_peak_nm_per_rad", c_uint32),
        ("u2_peak_nm_per_rad2", c_uint32),
        ("spindle_peak_ppm_per_rad", c_uint32),
        ("ratio_max_q20", c_uint32),
        ("swing_mdeg", c_uint32),
        ("swing1_mdeg_per_rad", c_uint32),
        ("swing2_mdeg_per_rad2", c_uint32),
    )


# Name, result and arguments of every function of the header.
PROTOTYPES: Prototypes = {
    "judge_api_open": (c_void_p, [c_char_p, c_size_t, c_uint32]),
    "judge_api_open_peaks": (c_void_p, [POINTER(TablePeaks), c_uint32]),
    "judge_api_close": (None, [c_void_p]),
    "judge_api_refusal": (c_char_p, [c_void_p]),
    "judge_api_set": (c_bool, [c_void_p, c_char_p, c_double]),
    "judge_api_demands": (POINTER(_Demand), [c_void_p, c_uint32, POINTER(c_size_t)]),
    "judge_api_highest_mrpm": (c_uint32, [c_void_p]),
    "judge_api_largest_feed_nm": (c_uint32, [c_void_p, c_uint32]),
}


class Demand(NamedTuple):
    """One limit and what a cut needs of it, in the unit of the controller."""

    name: str  # of the controller's error
    limit: int
    needed: int


class Judge:
    """A table, or what is known before there is one, on a machine as the controller judges it.

    Parameters of the controller are rounded and limited to their ranges. Raises CamtoolsError: the
    controller refuses the image, or the library is missing.
    """

    def __init__(
        self, table: bytes | TablePeaks, tick_hz: int, parameters: Mapping[str, float]
    ) -> None:
        self._library = library("camjudge", PROTOTYPES, "tools/mktables")
        if isinstance(table, bytes):
            self._handle = self._library.judge_api_open(table, len(table), tick_hz)
        else:
            self._handle = self._library.judge_api_open_peaks(byref(table), tick_hz)
        if not self._handle:
            raise CamtoolsError(["not enough memory for a table; free some"])
        weakref.finalize(self, self._library.judge_api_close, self._handle)
        refusal = self._library.judge_api_refusal(self._handle).decode("ascii")
        if refusal:
            raise CamtoolsError([f"the controller refuses the table: {refusal}"])
        for name, value in parameters.items():
            if not self._library.judge_api_set(self._handle, name.encode("ascii"), value):
                raise KeyError(name)

    def demands(self, mrpm: int) -> list[Demand]:
        """Return every limit and what a cut needs at [r/min / 1000], as the controller reports."""
        n = c_size_t()
        found = self._library.judge_api_demands(self._handle, mrpm, byref(n))
        return [
            Demand(demand.name.decode("ascii"), demand.limit, demand.needed)
            for demand in found[: n.value]
        ]

    def exceeded(self, mrpm: int) -> list[Demand]:
        """Return the limits that a cut exceeds at a mean speed [r/min / 1000]."""
        return [demand for demand in self.demands(mrpm) if demand.needed > demand.limit]

    def highest_mrpm(self) -> int:
        """Return the highest feasible mean speed, 0 when there is none."""
        return int(self._library.judge_api_highest_mrpm(self._handle))

    def largest_feed_nm(self, mrpm: int) -> int:
        """Return the largest feasible feed at a mean speed, 0 when there is none."""
        return int(self._library.judge_api_largest_feed_nm(self._handle, mrpm))
