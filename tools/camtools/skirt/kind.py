"""The skirt of a piston as a kind of part.

>>> KIND.speed_words(600.0)
['--rpm', '600.0']
"""

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import NM_PER_MM, Floats
from camtools.cut.correction import Drawing
from camtools.cut.path import ToolPath
from camtools.pipeline.kind import Kind, Rig
from camtools.sim.results import Cut, control_of
from camtools.skirt.geometry.profile import smoothing_takes_um
from camtools.skirt.geometry.skirt_geometry import make_geometry
from camtools.skirt.part.part_file import SkirtPart, margin_mm, spread, with_zones
from camtools.skirt.report.outcome import (
    SkirtOutcome,
    compare_removal,
    section_machine,
    table_errors,
)
from camtools.skirt.report.summary import drawing_of, emit_text, make_summary
from camtools.skirt.table.generate import GeneratedSkirt, generate
from camtools.skirt.tool.exact_shape import exact_skirt
from camtools.skirt.tool.texture import check_texture, proposed_law


class SkirtKind(Kind[SkirtPart, GeneratedSkirt, SkirtOutcome]):
    """Skirts of pistons: ovals over the height."""

    name = "piston"
    plural = "pistons"
    rank = 0
    commands = ("mktables", "run", "mkgcode", "analyse", "trade")
    model = SkirtPart

    reported = "camtools.skirt.report.report"
    make = staticmethod(generate)
    make_corrected = staticmethod(generate)
    exact = staticmethod(exact_skirt)
    summary = staticmethod(make_summary)
    text = staticmethod(emit_text)
    facts = staticmethod(table_errors)
    machine = staticmethod(section_machine)

    def drawing(self, part: SkirtPart) -> Drawing:
        """See `Kind.drawing`; a correction is smooth over the height, several bands are not."""
        if part.piston.lands:
            problem = "has no meaning with [[piston.land]], whose bands do not err alike"
            raise CamtoolsError([f"--measured: {problem}; correct diameters by X"])
        geometry = make_geometry(part)

        def radius_mm(turn: Floats, z_mm: Floats) -> Floats:
            return geometry.drawn_mm(2 * np.pi * turn, z_mm)

        swing_mm = max(geometry.deepest_mm(float(z)) for z in geometry.breaks_mm())
        document, windows = drawing_of(part, geometry), part.piston.window_areas
        return Drawing(geometry.skirt_mm, radius_mm, swing_mm, document, windows)

    def at_speed(self, part: SkirtPart, rpm: float | None) -> SkirtPart:
        """Return the part for another mean speed: only a modulated spindle's law depends on it."""
        if rpm is None or part.process.mode == "uniform":
            return part
        process = part.process.model_copy(update={"spindle_rpm": rpm})
        return part.model_copy(update={"process": process})

    def check_feed(self, part: SkirtPart, feed_mm: float) -> None:
        """See `Kind.check_feed`."""
        if part.piston.lands:
            problem = "has no meaning with [[piston.land]], whose bands have feeds of their own"
            raise CamtoolsError([f"--feed: {problem}; leave it out"])
        check_texture(part, feed_mm)

    def proposed_feed(self, part: SkirtPart) -> str:
        """See `Kind.proposed_feed`."""
        return proposed_law(part)

    def turns(self, made: GeneratedSkirt, feed_mm: float) -> float:
        """See `Kind.turns`."""
        ends = made.table.z_first_nm / NM_PER_MM, made.table.z_last_nm / NM_PER_MM
        feed_mm = made.table.feed_nm / NM_PER_MM if made.part.piston.lands else feed_mm
        return ToolPath(made.part.process.path, *ends, feed_mm).turns

    def sections_mm(self, made: GeneratedSkirt, feed_mm: float) -> list[float]:
        """See `Kind.sections_mm`: at heights that profile and ovality name, and in each land."""
        named_mm = {float(z) for z in made.geometry.breaks_mm()}
        piston = made.part.piston
        if piston.has_fit or piston.lands:  # which have breaks that the drawing does not name
            ovality = piston.ovality.height_mm if piston.ovality is not None else ()
            named_mm = {float(z) for z in (*piston.profile.height_mm, *ovality)}
        found = spread(sorted(named_mm), piston.skirt_mm, margin_mm(feed_mm))
        found += [(land.from_mm + land.to_mm) / 2 for land in piston.lands]
        return with_zones(sorted(found), made.part.tolerances, piston.window_areas)

    def taken_um(self, made: GeneratedSkirt) -> float:
        """See `Kind.taken_um`."""
        return smoothing_takes_um(made.part)

    def outcome(self, cut: Cut[GeneratedSkirt], rig: Rig) -> SkirtOutcome:
        """Return the cut; a part with a modulated spindle is cut uniformly for comparison."""
        control = control_of(rig.result.surface)
        even = compare_removal(rig, cut.generated)
        return SkirtOutcome(**vars(cut), even=even, control=control)


KIND = SkirtKind()
