"""Processor time of mktables for each part of tools/parts, and the bytes of its table.

The record holds the fewest bytes that a table has had; what makes one larger is a step back.

>>> sorted(parts())[:2]
['16v240zj', 'cam-345']
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RECORD = Path(__file__).with_name("table_bytes.json")
USAGE = 2


def parts() -> dict[str, Path]:
    """Return all part files of the repository by their names."""
    return {path.stem: path for path in sorted((ROOT / "tools" / "parts").glob("*.toml"))}


def recorded() -> dict[str, int]:
    """Return the bytes that the table of each part may have."""
    known: dict[str, int] = json.loads(RECORD.read_text())
    return known


def make(part: Path, folder: Path) -> tuple[int, float]:
    """Return bytes of a part's table and processor time [s], the start of Python included."""
    command = [sys.executable, "-m", "camtools.cli.mktables", str(part), "-o", str(folder)]
    paths = os.environ | {"PYTHONPATH": str(ROOT / "tools")}
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, env=paths)
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        raise RuntimeError(f"{part}: mktables ended with status {child.returncode}")
    [table] = folder.glob("*.camtab")
    return table.stat().st_size, usage.ru_utime + usage.ru_stime


def main(words: list[str]) -> int:
    """Print a line per part; with --record take over parts that are new and bytes that fell."""
    if words not in ([], ["--record"]):
        sys.stderr.write("usage: tests/bench/tables [--record]\n")
        return USAGE
    found = {}
    for name, part in parts().items():
        with tempfile.TemporaryDirectory() as folder:
            found[name], took_s = make(part, Path(folder))
        print(f"{name:<26} {found[name]:>8} bytes {took_s:>7.2f} s", flush=True)
    if words:
        known = recorded()
        found = {name: min(size, known.get(name, size)) for name, size in found.items()}
        RECORD.write_text(json.dumps(found, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
