# SPDX-License-Identifier: Apache-2.0
"""Time of a forecast of short cuts and of whole ones, and how well the short ones tell the others.

>>> rank_correlation([1.0, 2.0, 3.0], [2.0, 4.0, 9.0])
1.0
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
from scipy import stats

ROOT = Path(__file__).resolve().parents[2]
PART = ROOT / "tools" / "parts" / "perkins240.toml"
SHORT_TURNS = "10"
RUNS = "1000"


def forecast(part: Path, runs: str, folder: Path, *words: str) -> float:
    """Make a forecast in a folder; return how long it took [s]."""
    begin_s = time.monotonic()
    command = [sys.executable, "-m", "camtools.cli.forecast", str(part), "--runs", runs]
    subprocess.run(
        [*command, "-o", str(folder), *words],
        check=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    return time.monotonic() - begin_s


def rank_correlation(one: Any, other: Any) -> float:  # noqa: ANN401
    """Return Spearman's coefficient of two samples."""
    return float(stats.spearmanr(one, other).statistic)


def report(name: str, runs: str, took_s: float, folder: Path) -> None:
    """Print a line for a forecast."""
    found = json.loads((folder / "forecast.json").read_text())
    quantiles = "  ".join(
        f"{q['percent']:.0f} %: {q['value_um']:.3f}" for q in found["form_error_um"]
    )
    each_ms = 1e3 * took_s / int(runs)
    print(f"{name:<14} {runs} cuts in {took_s:6.1f} s, {each_ms:5.1f} ms each; um {quantiles}")


def main(words: list[str]) -> int:
    """Print times, distributions and the correlation of short and whole cuts."""
    part = Path(words[0]) if words else PART
    runs = words[1] if len(words) > 1 else RUNS
    with tempfile.TemporaryDirectory() as name:
        folders = {"short": Path(name) / "short", "whole": Path(name) / "whole"}
        took_s = forecast(part, runs, folders["short"], "--turns", SHORT_TURNS)
        report(f"{SHORT_TURNS} turns", runs, took_s, folders["short"])
        report("whole cuts", runs, forecast(part, runs, folders["whole"]), folders["whole"])
        errors = [
            np.array(pq.read_table(folder / "runs.parquet")["form_max_um"])
            for folder in folders.values()
        ]
        both = np.isfinite(errors[0]) & np.isfinite(errors[1])
        ratio = np.quantile(errors[1][both] / errors[0][both], (0.05, 0.5, 0.95))
        print(f"whole over short, 5, 50, 95 % of machines: {ratio.round(2).tolist()}")
        print(f"rank correlation: {rank_correlation(errors[0][both], errors[1][both]):.3f}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
