# SPDX-License-Identifier: Apache-2.0
r"""Prints the part of requirements.lock that some lists of packages need: locked.py LIST...

>>> needed("a==1\n    # via -r one.in\nb==2\n    # via\n    #   a\nc==3\n    # via c\n", ["one"])
'a==1\n    # via -r one.in\nb==2\n    # via\n    #   a\n'
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from pathlib import Path


def needed(lock: str, lists: Iterable[str]) -> str:
    """Return the packages of the lists and, all the way down, those that they require.

    pip-compile notes under each package which lists and packages ask for it.
    """
    pinned = {text.split("==")[0]: text for text in re.split(r"^(?=\w)", lock, flags=re.M)[1:]}
    askers = {
        name: set(re.findall(r"^    #(?: via)? +(\S.*)$", text, re.M))
        for name, text in pinned.items()
    }
    wanted = {f"-r {name}.in" for name in lists}
    found: set[str] = set()
    while more := {name for name in pinned if askers[name] & wanted} - found:
        found |= more
        wanted |= more
    return "".join(text for name, text in pinned.items() if name in found)


if __name__ == "__main__":
    text = Path(__file__).with_name("requirements.lock").read_text(encoding="ascii")
    sys.stdout.write(needed(text, sys.argv[1:]))
