# SPDX-License-Identifier: Apache-2.0
"""The environment of the processes that the panel starts: Python that finds the project.

>>> child_environment()["OPENBLAS_NUM_THREADS"]
'1'
"""

from __future__ import annotations

import os

from camtools.base.project_paths import ROOT


def child_environment() -> dict[str, str]:
    """Return the environment, with the project found from any working folder."""
    paths = [str(ROOT / "tools"), *filter(None, os.environ.get("PYTHONPATH", "").split(":"))]
    return os.environ | {
        "PYTHONPATH": ":".join(dict.fromkeys(paths)),
        "OPENBLAS_NUM_THREADS": "1",  # as tools/setup.sh has it: last digits depend on it
    }
