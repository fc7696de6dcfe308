# SPDX-License-Identifier: Apache-2.0
"""The text of the recording that --record names.

>>> from tempfile import TemporaryDirectory
>>> with TemporaryDirectory() as folder:
...     file = Path(folder) / "scope.csv"
...     _ = file.write_text("time_s,force_n")
...     record_text(file)
'time_s,force_n'
"""

from pathlib import Path

from camtools.base.errors import InputError
from camtools.identify.foreign_record import MAX_BYTES
from camtools.measured.previous_table import read_given


def record_text(csv: Path) -> str:
    """Return the text of a recording.

    Raises
    ------
    CamtoolsError
        It cannot be read, or is not UTF-8.
    """
    try:
        return read_given(csv, "--record", MAX_BYTES).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(str(csv), "", None, "not UTF-8 text", "give a CSV file") from error
