# SPDX-License-Identifier: Apache-2.0
"""Each fault of the firmware has a title, a cause and a remedy for people."""

import re

from camtools.base.project_paths import ROOT
from camtools.link.faults import FAULTS
from camtools.link.messages import FAULT_TEXTS

LIST = ROOT / "firmware" / "base" / "cam_state.h"


def test_every_fault_of_the_firmware_has_cause_and_remedy() -> None:
    """The list is that of the C source, not of the DBC from which the tools read it."""
    text = LIST.read_text("utf-8")
    body = text[text.index("#define CAM_FAULTS(X)") :].split("\n\n")[0]
    names = re.findall(r"X\((\w+), \"", body)
    assert len(names) > 10
    assert list(FAULTS) == names == list(FAULT_TEXTS)
    for fault in FAULTS.values():
        assert fault.title and not fault.title.endswith(".")
        for text in (fault.cause, fault.remedy):
            assert len(text) > 15 and text.endswith(".") and text[0].isupper()
            assert not re.search(r"[`\[\]]", text), "marks of Markdown are gone"
