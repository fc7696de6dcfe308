"""Machines drawn at random from the whole range of every key: a cut ends, and tells a number."""

import json
from math import isfinite
from pathlib import Path

import numpy as np
import pytest

from tests.tools.cases.camsim_cases import camsim

RANGES: dict[str, dict[str, tuple[float, float]]] = {
    "u": {
        "bandwidth_hz": (20, 5000),
        "damping": (0.05, 10),
        "delay_us": (0.1, 2000),
        "quantum_nm": (0.1, 10000),
        "command_quantum_nm": (0.1, 1000),
        "friction_m_per_s2": (0.001, 1000),
        "mass_kg": (0.01, 1000),
        "viscous_n_s_per_m": (0.001, 1e4),
        "stiffness_n_per_m": (1, 1e8),
        "force_limit_n": (0.1, 1e6),
        "amplifier_hz": (10, 1e5),
        "mode_hz": (10, 20000),
        "mode_damping": (0.001, 2),
        "mode_share": (0.001, 2),
        "mode_2_hz": (10, 20000),
        "scale_latency_us": (0.1, 1000),
        "scale_error_nm": (0.1, 10000),
        "scale_period_um": (0.1, 10000),
    },
    "cut": {
        "kc_n_per_mm2": (1, 1e5),
        "radial_share": (0.01, 10),
        "tool_stiffness_n_per_um": (0.1, 1e6),
    },
    "spindle": {
        "ripple_2": (1e-6, 0.5),
        "ripple_per_turn_2": (0.01, 1000),
        "runout_um": (0.1, 1000),
    },
    "encoder": {"eccentricity_counts": (0.01, 100), "jitter_counts": (0.01, 10)},
}


def machine(rng: np.random.Generator) -> str:
    """Return a machine file with about a third of the keys, each drawn on a logarithmic scale."""
    lines = []
    for section, keys in RANGES.items():
        lines.append(f"[{section}]")
        for key, (low, high) in keys.items():
            if rng.random() < 0.35:
                lines.append(f"{key} = {np.exp(rng.uniform(np.log(low), np.log(high))):.6g}")
        if section == "u":
            lines += [f'kind = "{rng.choice(["position", "force"])}"', "stroke_mm = 3"]
            lines += [f"mode_on_scale = {rng.integers(2)}"]
        if section == "encoder":
            lines += [f"time_stamps = {rng.integers(2)}"]
    return "\n".join(lines) + "\n"


def numbers(value: object) -> list[float]:
    """Return all numbers of a summary."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        return [number for one in value for number in numbers(one)]
    return [value] if isinstance(value, float) else []


@pytest.mark.long
def test_any_machine_is_cut_on_or_refused(table: Path, tmp_path: Path) -> None:
    """No crash, no number that is none, one line where the machine is refused."""
    rng, ends = np.random.default_rng(15), []
    for _ in range(30):
        path, summary = tmp_path / "m.toml", tmp_path / "s.json"
        path.write_text(machine(rng))
        words: list[str | Path] = ["--machine", path, "--summary", summary, "--turns-limit", "3"]
        done = camsim("run", table, *words, "--max-seconds", "4")
        ends.append(done.returncode)
        assert done.returncode in (0, 1, 2), path.read_text()
        assert len(done.stderr.splitlines()) <= 1, done.stderr
        if done.returncode != 2:
            assert all(isfinite(number) for number in numbers(json.loads(summary.read_text())))
    assert ends.count(2) < 15
