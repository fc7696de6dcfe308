"""The exact design of a camshaft for the simulator's gauge, independent of the table.

>>> from camtools.lobe.generate import generate_lobes
>>> from camtools.lobe.motion import example_lobe
>>> design_of_lobes(generate_lobes(example_lobe()))["lobes"][0]["law"]
'poly345'
"""

from __future__ import annotations

from camtools.base.json_text import Json
from camtools.lobe.generate import GeneratedLobes
from camtools.lobe.lift import Disc, LiftLaw, Listed, Poly345, Risen, curve_of
from camtools.lobe.rise_laws import (
    Cycloidal,
    Harmonic,
    ModifiedSine,
    ModifiedTrapezoid,
    Polydyne,
    Quintic,
)


def _law(law: LiftLaw) -> Json:
    """Return a law of lift as numbers; a list as the pieces of its spline."""
    if isinstance(law, Poly345):
        return {"law": "poly345", "lift_mm": law.lift_mm, "half_angle_rad": law.half_angle_rad}
    if isinstance(law, Risen):
        return _flanks(law)
    if isinstance(law, Disc):
        return {"law": "disc", "reach_mm": law.reach_mm, "offset_mm": law.offset_mm}
    assert isinstance(law, Listed)
    curve = curve_of(law)
    return {
        "law": "pieces",
        "breaks_rad": curve.x.tolist(),
        "coefficients": curve.c.T.ravel().tolist(),
    }


def _flanks(law: Risen) -> Json:
    names = {
        Quintic: "poly345",
        Cycloidal: "cycloidal",
        ModifiedSine: "modified-sine",
        ModifiedTrapezoid: "modified-trapezoid",
        Harmonic: "harmonic",
        Polydyne: "polydyne",
    }
    numbers = {
        "lift_mm": law.lift_mm,
        "rise_rad": law.rise_rad,
        "dwell_rad": law.dwell_rad,
        "fall_rad": law.fall_rad,
    }
    soft = {
        f"{name}_deflection": one.deflection
        for name, one in (("rise", law.rise), ("fall", law.fall))
        if isinstance(one, Polydyne)
    }
    return {"law": "flanks", "shape": names[type(law.rise)]} | numbers | soft


def design_of_lobes(result: GeneratedLobes) -> Json:
    """Return the shape for programs that measure: laws in radians and millimetres, no table.

    Pieces of a list are quintics, highest power first, of the angle above each break.
    """
    process, cam = result.part.process, result.part.cam
    return {
        "shape": "cam",
        "follower": cam.follower,
        "operation": "turning" if process.operation == "turning" else "grinding",
        **({"path": "plunge"} if process.is_plunge else {}),
        "speed": process.speed,
        "base_mm": float(cam.base_radius_mm),
        "roller_mm": float(cam.roller_radius_mm),
        "follower_mm": float(result.part.follower_radius_mm),
        "base_speed": float(process.spindle_rpm) / result.mean_rpm,
        "lobes": [
            {"z_mm": list(lobe.z_mm), "phase_rad": lobe.phase_rad} | _law(lobe.law)
            for lobe in result.lobes
        ],
    }
