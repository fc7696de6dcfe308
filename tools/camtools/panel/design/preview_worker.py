# SPDX-License-Identifier: Apache-2.0
"""The process that computes previews: a request in a line of JSON, answers in lines of JSON.

It is kept ready with everything imported. SIGUSR1 drops what it computes, for a newer change;
what was made on the way is remembered. It can write no file, and has a limit of memory.

>>> request = {"id": 1, "do": "preview", "text": "[part]", "folder": "."}
>>> [answer["stage"] for answer in answers_to(request, Memory(8))]
['form', 'problems']
"""

from __future__ import annotations

import json
import os
import resource
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from types import FrameType
from typing import Any

from camtools.base.cache import Memory, recall, remembering
from camtools.base.errors import CamtoolsError
from camtools.panel.design.document import edited, problems_of
from camtools.panel.design.preview_values import (
    Judged,
    Shown,
    curves_of,
    limits_of,
    verdict_of_table,
)
from camtools.part.file import MAX_FILE_BYTES, files_named, read_tree
from camtools.pipeline.load import Loaded, parse
from camtools.pipeline.registry import kind_of, kinds

FILE = "part.toml"  # what messages call the text; it is left out where they are shown
_REMEMBERED = 64
_DONE = "done"


class SupersededError(BaseException):
    """A newer change makes this one idle; no `except Exception` may stop it."""


class _Switch:
    """Whether a signal may break off what goes on."""

    is_on = False


def _problems(error: CamtoolsError, text: str) -> Shown:
    found = problems_of(error.lines, text, FILE)
    return {"stage": "problems", "problems": [one._asdict() for one in found]}


def _loaded(text: str, folder: str) -> Loaded:
    data = text.encode("utf-8", "surrogatepass")
    if len(data) > MAX_FILE_BYTES:
        problem = f"has {len(data)} bytes, at most {MAX_FILE_BYTES} are read"
        raise CamtoolsError([f"{problem}; put long lists into a CSV file"])
    return parse(data, FILE, Path(folder), is_confined=True)


def _preview(request: Shown) -> Iterator[Shown]:
    text, folder = str(request["text"]), str(request["folder"])
    z_mm = request.get("height_mm")
    try:
        tree = read_tree(text.encode("utf-8", "replace")[:MAX_FILE_BYTES], FILE)
        yield {"stage": "form", "kind": kind_of(tree).name, "tree": tree}
        loaded = _loaded(text, folder)
        key = loaded.kind.name, loaded.part.model_dump_json(), _state_of(tree, folder)
        exact = loaded.kind.exact(loaded.part)
        limits = loaded.part.machine.limits
        asked_rpm = loaded.part.process.spindle_rpm
        curves = curves_of(exact, asked_rpm, z_mm)
        yield {"stage": "curves", "limits": limits_of(limits), "kind": loaded.kind.name} | curves
        judged = recall(("judged", key), lambda: Judged(loaded))
        if judged.speed is not None or judged.rpm != asked_rpm:
            curves = curves_of(exact, judged.rpm, z_mm, judged.speed)
            yield {"stage": "curves", "limits": limits_of(limits), "kind": loaded.kind.name} | (
                curves
            )
        problems = problems_of(judged.lines, text, FILE)
        shown = verdict_of_table(judged, limits)
        yield {"stage": "table", "problems": [one._asdict() for one in problems]} | shown
    except CamtoolsError as error:
        yield _problems(error, text)


def _state_of(tree: Shown, folder: str) -> tuple[object, ...]:
    """Return what changes when the files that a part names do."""
    found: list[object] = []
    for name in files_named(tree):
        try:
            state = (Path(folder) / name).stat()
            found.append((name, state.st_mtime_ns, state.st_size, state.st_ino))
        except (OSError, ValueError):
            found.append(name)
    return tuple(found)


def _edit(request: Shown) -> Iterator[Shown]:
    text = str(request["text"])
    try:
        yield {"stage": "text", "text": edited(text, tuple(request["path"]), request["value"])}
    except CamtoolsError as error:
        yield _problems(error, text)


_ACTIONS = {"preview": _preview, "edit": _edit}


def answers_to(request: Shown, memory: Memory) -> Iterator[Shown]:
    """Yield the answers to one request, the cheap ones first."""
    with remembering(memory):
        yield from _ACTIONS[request["do"]](request)


def _tell(answer: Shown) -> None:
    sys.stdout.write(json.dumps(answer, default=str) + "\n")  # dates of TOML
    sys.stdout.flush()


def _carry_out(request: Shown, memory: Memory) -> None:
    """Answer a request; the last answer always has the stage `done`."""
    begin_s, is_dropped = time.process_time(), False
    answers = answers_to(request, memory)
    try:
        while True:
            _Switch.is_on = True
            answer = next(answers, None)
            _Switch.is_on = False
            if answer is None:
                break
            spent_s = time.process_time() - begin_s
            _tell({"id": request["id"], "cpu_s": spent_s} | answer)
    except SupersededError:
        is_dropped = True
    except MemoryError:
        problem = "takes more memory than a preview may; give fewer points or lobes"
        _tell({"id": request["id"]} | _problems(CamtoolsError([problem]), ""))
    finally:
        _Switch.is_on = False
    spent_s = time.process_time() - begin_s
    _tell({"id": request["id"], "stage": _DONE, "is_dropped": is_dropped, "cpu_s": spent_s})


def _drop(_number: int, _frame: FrameType | None) -> None:
    if _Switch.is_on:
        _Switch.is_on = False
        raise SupersededError


def main(memory_mb: int) -> None:
    """Answer requests until standard input ends."""
    signal.signal(signal.SIGUSR1, _drop)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # control-C ends the panel, which ends this
    kinds()
    resource.setrlimit(resource.RLIMIT_AS, (memory_mb << 20, memory_mb << 20))
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.nice(5)  # a cut that is watched comes first
    memory = Memory(_REMEMBERED)
    _tell({"id": 0, "stage": "ready"})
    for line in sys.stdin:
        request: dict[str, Any] = json.loads(line)
        _carry_out(request, memory)


if __name__ == "__main__":
    main(int(sys.argv[1]))
