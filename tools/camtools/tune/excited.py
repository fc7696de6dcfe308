# SPDX-License-Identifier: Apache-2.0
"""U of a simulated machine, excited by its set-point while the controller closes its loop.

Modes up to this frequency are found:

>>> HIGHEST_HZ
1600.0
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from camtools.base.project_paths import ROOT
from camtools.identify.excitation_plan import Wishes, plan
from camtools.identify.simulated_drive import SimulatedU
from camtools.pipeline.load import load
from camtools.pipeline.make_table import make
from camtools.sim.machines import machine_bytes
from camtools.table.image import pack
from camtools.tune.plant_fit import PlantFit, fit_record

_PART = ROOT / "tools" / "parts" / "perkins240.toml"
_SIGNALS = ("u_set_q6", "u_actual_nm", "u_force_q6")
HIGHEST_HZ = 1600.0


def fit_machine(machine: str) -> tuple[PlantFit, float]:
    """Return the constants of U of a machine, and the tick rate [Hz].

    Parameters
    ----------
    machine : str
        name or machine file; its U takes forces

    Raises
    ------
    CamtoolsError
        The machine is wrong, or its record is of no use.
    CutShortError
        The excitation began and did not end.
    """
    image = pack(make(load(_PART), _PART).table.table)
    with tempfile.TemporaryDirectory(prefix="tune.") as folder:
        u = SimulatedU(Path(folder), machine_bytes(machine), machine, image)
        believed = u.believed()
        excitation = plan(believed, Wishes(highest_hz=HIGHEST_HZ))
        _, set_q6, actual_nm, force_q6 = u.played(excitation, _SIGNALS)
    signals = (set_q6 / 64e9, force_q6 / 64e3, actual_nm / 1e9)
    return fit_record(believed.tick_hz, *signals, believed.u_scale_nm), believed.tick_hz
