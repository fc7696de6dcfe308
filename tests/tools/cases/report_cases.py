"""Cuts made up for the tests of reports: a trace, a surface, a summary."""

import re
from typing import Any

import numpy as np

from camtools.base.quantities import Floats
from camtools.sim.results import CUTTING, FAULT, STATES, CutTrace, GaugedSurface
from camtools.skirt.geometry.skirt_geometry import Geometry

TICK_S = 50e-6
TURNS_PER_TICK = 2500 / 60 * TICK_S
FIRST_CUT, LAST_CUT = 1000, 9000  # ticks


def made_up_trace(geometry: Geometry, *, fault_at: int | None = None) -> CutTrace:
    """Return a short cut: homing, engaging, cutting, then disengaging or a fault."""
    tick = np.arange(10_000, dtype=np.float64)
    turn: Floats = tick * TURNS_PER_TICK
    state = np.full(tick.size, float(STATES.index("homing")))
    state[500:] = STATES.index("engaging")
    state[FIRST_CUT:] = CUTTING
    state[LAST_CUT:] = STATES.index("disengaging")
    z_mm = np.interp(tick, [FIRST_CUT, LAST_CUT], [geometry.z_first_mm, geometry.z_last_mm])
    u_nm = geometry.delta(2 * np.pi * turn, z_mm).delta * 1e6
    error_nm = 30 * np.sin(4 * np.pi * turn)
    if fault_at is not None:
        state[fault_at:] = FAULT
        error_nm[fault_at:] = (tick[fault_at:] - fault_at) * 1e4
    speed = np.full(tick.size, TURNS_PER_TICK)
    x_nm = geometry.radius_mm(z_mm) * 1e6
    return CutTrace(tick * TICK_S, turn, z_mm, u_nm, u_nm + 20, state, u_nm, error_nm, x_nm, speed)


def made_up_surface(geometry: Geometry) -> GaugedSurface:
    """Return a surface in the simulator's cells with four lobes of 40 nm."""
    z_mm, turn = np.meshgrid(np.linspace(0, 62, 256), (np.arange(720) + 0.5) / 720, indexing="ij")
    z, phi = z_mm.ravel(), turn.ravel()
    error_um = 0.04 * np.sin(8 * np.pi * phi)
    exact_mm = geometry.radius_mm(z) - geometry.delta(2 * np.pi * phi, z).delta
    return GaugedSurface(phi, z, exact_mm + error_um * 1e-3, error_um)


def made_up_summary(**changes: Any) -> dict[str, Any]:  # noqa: ANN401
    """Return what camsim tells of a good cut, with some keys changed."""
    one = {"needed": 39.3, "limit": 400.0, "margin": 10.2}
    keys = ("u_speed_mm_s", "u_acceleration_mm_s2", "u_stroke_mm", "spindle_rpm")
    return {
        "machine": "default",
        "seed": 1,
        "gauge": {"reference": "design"},
        "end": "done",
        "is_good": True,
        "faults": [],
        "form_error_um": {"max": 0.04, "rms": 0.028, "tolerance": 5.0},
        "following_error_um": {"max": 0.02, "rms": 0.02},
        "cut": {"spindle_rpm": 2500.0, "feed_mm": 0.1, "planned_turns": 622.0, "turns": 622.0},
        "feasibility": {"highest_rpm": 3000.0} | dict.fromkeys(keys, one),
        "table_bytes": 3456,
        "machine_time_s": 15.7,
        "wall_time_s": 0.3,
        "tick_hz": 20000.0,
        "injected": [],
    } | changes


def without_scripts(page: str) -> str:
    """Return a page without what its script elements hold; plotly.js names addresses, of maps."""
    return re.sub(r"(<script\b[^>]*>).*?</script>", r"\1</script>", page, flags=re.DOTALL)
