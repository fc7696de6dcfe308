"""The whole way of a cam: table, cut on the host simulator, gauge, report.

>>> from camtools.lobe.motion import example_cam
>>> at_speed(example_cam(), 30.0).process.spindle_rpm
30.0
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

from camtools.base.command import BAD_INPUT
from camtools.base.errors import CamtoolsError
from camtools.base.stage import Stage
from camtools.cli.job import Job, say, shown, without_faults, write_files
from camtools.cli.mktables import cam_products
from camtools.lobe.generate import GeneratedCam, generate_cam
from camtools.lobe.part import MAX_RPM, MIN_RPM, CamPart
from camtools.lobe.report_text import CamOutcome, cam_text
from camtools.sim.camsim import (
    SUMMARY,
    SURFACE,
    TRACE,
    Simulator,
    cam_machine_text,
    camsim_path,
    compare,
    cut,
    traced_turns,
)
from camtools.sim.results import Json, read_summary, read_surface, read_swing, read_trace
from camtools.skirt.geometry import NM_PER_MM

_FORM_ERROR_UM = 1.0  # a cam's profile is good within this


def at_speed(part: CamPart, rpm: float | None) -> CamPart:
    """Return the cam for another speed: on the base circle, where its law is that of the surface.

    Raises
    ------
    CamtoolsError
        Out of the range of a part file.
    """
    if rpm is None:
        return part
    if not MIN_RPM <= rpm <= MAX_RPM:
        problem = f"--rpm {rpm:g}: out of range"
        raise CamtoolsError([f"{problem}; give r/min, {MIN_RPM:g} .. {MAX_RPM:g}"])
    process = part.process.model_copy(update={"spindle_rpm": rpm})
    return part.model_copy(update={"process": process})


def _turns(job: Job, cam: GeneratedCam) -> float:
    """Return how many turns the cut takes, about."""
    feed_mm = job.feed_mm or cam.part.process.feed_mm
    return (cam.table.z_last_nm - cam.table.z_first_nm) / NM_PER_MM / feed_mm


def _complete_summary(outcome: CamOutcome, total_s: float) -> Json:
    """Return camsim's summary with what else is known."""
    cam = outcome.generated
    error = {"u_nm": cam.lift.error, "angle_deg": cam.angle.error, "tolerance_nm": cam.tolerance_nm}
    ticks = int(outcome.trace.t_s.size)
    return outcome.summary | {
        "table_error": error,
        "trace": {"file": TRACE, "ticks": ticks, "is_complete": outcome.is_trace_complete},
        "comparison": [variant._asdict() for variant in outcome.variants],
        "run_wall_time_s": total_s,
    }


def _simulate(job: Job, cam: GeneratedCam, folder: Path) -> CamOutcome | None:
    """Cut and gauge; return nothing when camsim refused and said why."""
    name = cam.part.part.name
    machine, window = f"{name}_machine.toml", traced_turns(_turns(job, cam), cam.mean_rpm)
    files = cam_products(cam, with_plots=False)
    files[machine] = cam_machine_text(cam.part.machine.limits).encode("ascii")
    write_files(folder, files)
    simulator = Simulator(camsim_path(), folder, f"{name}.camtab")
    feed = [] if job.feed_mm is None else ["--feed", repr(job.feed_mm)]
    words = ["--machine", machine, *job.tolerance(_FORM_ERROR_UM), *feed, *job.extra]
    if cut(simulator, words, window) == BAD_INPUT:
        return None
    variants = compare(simulator, without_faults(words), window)
    results = (read_summary(folder / SUMMARY), read_surface(folder / SURFACE))
    trace, swing = read_trace(folder / TRACE), read_swing(folder / TRACE)
    return CamOutcome(cam, *results, trace, window is None, variants, swing)


def run_cam(job: Job, part: CamPart, begin_s: float) -> int:
    """Make, cut and report a cam; return the exit status.

    Parameters
    ----------
    job : Job
        What was asked for.
    begin_s : float
        Monotonic time at which the command began [s].
    """
    from camtools.lobe.report import make_cam_report  # matplotlib is slow to load

    try:
        cam = generate_cam(at_speed(part, job.rpm))
    except CamtoolsError as error:
        raise CamtoolsError([f"{job.part_path}: {line}" for line in error.lines]) from error
    folder = job.folder(part.part.name)
    with Stage(folder) as stage:
        say(f"cutting {_turns(job, cam):.0f} turns on the host simulator")
        outcome = _simulate(job, cam, stage.folder)
        if outcome is None:
            return BAD_INPUT
        say("drawing the report")
        write_files(stage.folder, make_cam_report(outcome))
        summary = _complete_summary(outcome, time.monotonic() - begin_s)
        text = json.dumps(summary, indent=1, allow_nan=False) + "\n"
        write_files(stage.folder, {SUMMARY: text.encode("ascii")})
        stage.publish()
    sys.stdout.write(cam_text(outcome, shown(folder), time.monotonic() - begin_s))
    return 0 if outcome.is_good else 1
