# SPDX-License-Identifier: Apache-2.0
"""Write outside.json anew from the tree at hand: python tests/outside/record.py [GROUP...]."""

from __future__ import annotations

import importlib
import json
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory

HERE = Path(__file__).resolve().parent


def main() -> int:
    """Record all groups of facts, or those that are named."""
    sys.path.insert(0, str(HERE.parents[1]))
    facts = importlib.import_module("tests.outside.facts")
    path = HERE / "outside.json"
    golden = json.loads(path.read_text()) if sys.argv[1:] else {}
    start_s = time.monotonic()
    names = sys.argv[1:] or list(facts.GROUPS)
    with TemporaryDirectory() as folder, ThreadPoolExecutor(3) as pool:
        shop = facts.Shop(Path(folder))
        found = {name: pool.submit(facts.GROUPS[name], shop) for name in names}
        for name in names:
            golden[name] = found[name].result()
            print(f"{time.monotonic() - start_s:6.1f} s  {name}: {len(golden[name])} facts")
    path.write_text(json.dumps(golden, indent=1, ensure_ascii=False) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
