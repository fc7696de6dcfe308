"""Runs under LinuxCNC's own Python: stands in for PyVCP without a screen, with the pins of a panel.

usage: panel_pins.py PANEL.xml
"""

import sys
import time
import xml.etree.ElementTree as ET
from importlib import import_module
from typing import Any

INPUTS = {"number": "HAL_FLOAT", "u32": "HAL_U32", "led": "HAL_BIT"}
OUTPUTS = {"button": "HAL_BIT", "checkbutton": "HAL_BIT"}


def main(panel: str) -> None:
    """Export the pins, and stay until LinuxCNC ends this program."""
    hal: Any = import_module("hal")
    component = hal.component("pyvcp")
    for widget in ET.parse(panel).iter():
        name = widget.findtext("halpin", "").strip('"')
        for kinds, direction in ((INPUTS, hal.HAL_IN), (OUTPUTS, hal.HAL_OUT)):
            if widget.tag in kinds:
                component.newpin(name, getattr(hal, kinds[widget.tag]), direction)
    component.ready()
    while True:
        time.sleep(1)


if __name__ == "__main__":
    main(sys.argv[1])
