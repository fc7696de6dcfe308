# SPDX-License-Identifier: Apache-2.0
r"""The parts of camturn.dbc that lists and enumerations of the C sources give.

>>> enumerators("typedef enum {\n    cam_x_a, ///< a, b\n    cam_x_b = 3,\n} cam_x_t;", "cam_x_t")
{0: 'a', 3: 'b'}
>>> items("#define LIST(X) \\\n    X(one, -3) \\\n    X(two, -4)\n\n", "LIST")
['one', 'two']
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from camtools.base.errors import CamtoolsError
from camtools.base.project_paths import ROOT

DBC = "firmware/remote/can/camturn.dbc"
# The names of a signal's values, or a table of values, from a C enumeration or a list.
_TYPES = {
    "VAL_ 448 state": "cam_state_t",
    "VAL_ 576 state": "cam_state_t",
    "VAL_ 448 reset_reason": "hal_reset_t",
    "VAL_ 1216 learn_phase": "cam_ilc_phase_t",
    "VAL_ 1216 learn_reason": "cam_ilc_reason_t",
    "VAL_ 1216 recorder_use": "cam_scope_use_t",
    "VAL_ 1216 recorder_phase": "cam_scope_phase_t",
    "VAL_ 1216 params_kept": "cam_kept_t",
    "VAL_ 1216 level": "cam_level_t",
    "VAL_ 1216 hand_phase": "cam_jog_phase_t",
    "VAL_ 1216 hand_end": "cam_jog_end_t",
    "VAL_TABLE_ scope_phase": "cam_scope_phase_t",
    "VAL_TABLE_ scope_end": "cam_scope_end_t",
    "VAL_TABLE_ scope_use": "cam_scope_use_t",
    "VAL_TABLE_ trigger": "cam_trigger_kind_t",
    "VAL_TABLE_ refusal_field": "cam_refusal_field_t",
    "VAL_TABLE_ excited": "cam_excited_t",
}
_LISTS = {
    "VAL_ 1600 parameter": "CAM_PARAMS",
    "VAL_ 1472 parameter": "CAM_PARAMS",
    "VAL_TABLE_ scope_signal": "CAM_SCOPE_SIGNALS",
    "VAL_TABLE_ scope_field": "CAM_SCOPE_FIELDS",
}


def headers() -> str:
    """Return the text of all headers of the firmware, and of the contract with ports."""
    found = [*ROOT.glob("firmware/*/*.h"), ROOT / "hal" / "include" / "hal" / "hal.h"]
    return "\n".join(path.read_text("utf-8") for path in found)


def enumerators(text: str, type_name: str) -> dict[int, str]:
    """Return the names of a C enumeration by their numbers, without prefix and count."""
    body = text.split(f"}} {type_name};")[0].rpartition("typedef enum {")[2]
    rows = re.findall(r"(\w+)(?: = (-?\d+))?\s*(?:,|$)", re.sub(r"//[^\n]*", "", body))
    rows = [row for row in rows if not re.search("_n(_|$)", row[0])]
    starts = (type_name[:end] for end in range(len(type_name), 0, -1))
    prefix = next(start for start in starts if all(name.startswith(start) for name, _ in rows))
    number, found = -1, {}
    for name, value in rows:
        number = int(value) if value else number + 1
        found[number] = name.removeprefix(prefix)
    return found


def _body(text: str, macro: str) -> str:
    return text.split(f"#define {macro}(X)")[1].split("\n\n")[0]


def items(text: str, macro: str) -> list[str]:
    """Return the first words of the items of an X-macro."""
    return re.findall(r"^ +X\((\w+)", _body(text, macro), re.MULTILINE)


def errors(text: str) -> list[tuple[str, str, str]]:
    """Return number, name and text of every error."""
    rows = re.findall(r'X\((\w+), +(-\d+), +"([^"]*)"', _body(text, "CAM_ERRORS"))
    return [(number, name, what) for name, number, what in rows]


def _values(start: str, names: Mapping[int, str]) -> tuple[str, str]:
    pairs = " ".join(f'{number} "{name}"' for number, name in names.items())
    return rf"(?<=^{start} )[^\n]*", f"{pairs} ;"


def dbc_text(text: str) -> str:
    """Return the text of camturn.dbc with the names and faults of the sources.

    Raises
    ------
    CamtoolsError
        The file has no place for some of them.
    """
    results = {0: "done"} | {int(number): name for number, name, _ in errors(text)}
    faults = re.findall(r'X\((\w+), "([^"]*)"', _body(text, "CAM_FAULTS"))
    bits = "".join(
        f' SG_ fault_{name} : {32 + bit}|1@1+ (1,0) [0|1] "" TOOL\n'
        for bit, (name, _) in enumerate(faults)
    )
    clauses = "".join(
        f'CM_ SG_ 448 fault_{name} "{what[0].upper()}{what[1:]}.";\n' for name, what in faults
    )
    parts = [
        *(_values(start, enumerators(text, name)) for start, name in _TYPES.items()),
        *(_values(start, dict(enumerate(items(text, name)))) for start, name in _LISTS.items()),
        *(_values(f"VAL_ {signal}", results) for signal in ("1472 result", "448 table_result")),
        (r"(?:^ SG_ fault_[^\n]*\n)+", bits),
        (r"(?:^CM_ SG_ 448 fault_[^\n]*\n)+", clauses),
    ]
    dbc = (ROOT / DBC).read_text("utf-8")
    for pattern, new in parts:
        places = list(re.finditer(pattern, dbc, re.MULTILINE))
        if len(places) != 1:
            raise CamtoolsError([f"{DBC}: {len(places)} places for {new[:40]}; there must be one"])
        dbc = dbc[: places[0].start()] + new + dbc[places[0].end() :]
    return dbc
