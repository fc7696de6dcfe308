r"""Prints the part of requirements.lock that some groups of packages need: locked.py GROUP...

A group is "base", an extra of pyproject.toml, or the middle of a name requirements-GROUP.in.

>>> project = {"dependencies": ["C~=1.0"], "optional-dependencies": {"one": ["a"]}}
>>> needed("a==1\n    # via camturn\nb==2\n    # via\n    #   a\nc==3\n", project, ["one"])
'a==1\n    # via camturn\nb==2\n    # via\n    #   a\n'
"""

from __future__ import annotations

import re
import sys
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any


def needed(lock: str, project: Mapping[str, Any], groups: Iterable[str]) -> str:
    """Return the packages of the groups and, all the way down, those that they require.

    pip-compile notes under each package which packages and lists ask for it.
    """
    pinned = {text.split("==")[0]: text for text in re.split(r"^(?=\w)", lock, flags=re.M)[1:]}
    askers = {
        name: {name, *re.findall(r"^    #(?: via)? +(\S.*)$", text, re.M)}
        for name, text in pinned.items()
    }
    ours = {"base": project["dependencies"], **project["optional-dependencies"]}
    wanted: set[str] = set()
    for group in groups:
        wanted.add(f"-r requirements-{group}.in")
        wanted |= {re.split(r"[^\w-]", one)[0].lower() for one in ours.get(group, ())}
    found: set[str] = set()
    while more := {name for name in pinned if askers[name] & wanted} - found:
        found |= more
        wanted |= more
    return "".join(text for name, text in pinned.items() if name in found)


if __name__ == "__main__":
    lock, project = (
        Path(__file__).with_name(name).read_text(encoding="utf-8")
        for name in ("requirements.lock", "pyproject.toml")
    )
    sys.stdout.write(needed(lock, tomllib.loads(project)["project"], sys.argv[1:]))
