# SPDX-License-Identifier: Apache-2.0
"""One line of tests/bench/plan_period: ripple of a summary, error of the swing of a trace."""

import csv
import json
import math
import subprocess
import sys
from pathlib import Path

TICK_S = 50e-6
LAG_S = 100e-6 + 2 * 0.7 / (2 * math.pi * 200) + TICK_S / 2  # of the default drive of the swing


def swing_errors_deg(camsim: str, folder: Path) -> list[float]:
    """Return set-point minus table in every tick of the cut, at 60 r/min."""
    with (folder / "t.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["state"] == "cutting"]
    points = "".join(f"{float(row['turn']) + LAG_S:.12f},{row['z_mm']}\n" for row in rows)
    command = [camsim, "eval", str(folder / "cam.camtab")]
    done = subprocess.run(
        command, input="turn,z_mm\n" + points, text=True, capture_output=True, check=True
    )
    wanted = csv.DictReader(done.stdout.splitlines())
    pairs = zip(rows, wanted, strict=True)
    return [float(row["swing_set_deg"]) - float(one["swing_deg"]) for row, one in pairs]


def main(period_us: str, camsim: str, folder: str) -> None:
    """Print the line."""
    summary = json.loads((Path(folder) / "s.json").read_text())
    ripple = summary["removal"]["rate_ripple"]
    errors = swing_errors_deg(camsim, Path(folder))
    rms = math.sqrt(sum(error**2 for error in errors) / len(errors))
    print(
        f"{period_us} us: ripple {100 * ripple['max']:.2f} % at most, {100 * ripple['mean']:.2f} % "
        f"on average; swing {max(map(abs, errors)):.5f} degrees at most, rms {rms:.5f}"
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
