"""Tables, reports and helpers of camturn around the firmware's cam tables.

From a drawing to the bytes that the firmware plays:

>>> from camtools.skirt.part.part_file import example_part
>>> from camtools.skirt.table.generate import generate
>>> from camtools.table.image import pack, unpack
>>> result = generate(example_part(), tolerance_nm=1.0)
>>> unpack(pack(result.table)).part_name
'example'
"""

from __future__ import annotations

import signal
import sys
import threading


def _end_silently_on_interrupt() -> None:
    """Let Ctrl-C end a tool that is still loading numpy without a traceback of the loading.

    Only of `python -m camtools.TOOL`, which until it found its module calls itself "-m": tests
    and other users of the package keep their handler. run_command installs the tools' own.
    """
    is_tool = sys.argv[:1] == ["-m"] and threading.current_thread() is threading.main_thread()
    if is_tool and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)


_end_silently_on_interrupt()
