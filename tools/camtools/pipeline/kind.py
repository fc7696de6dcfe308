"""What a kind of part brings: its model, its table, its exact shape, what it measures, its report.

A kind is one package of camtools with a module `kind` that holds an instance, KIND, of a class
derived from `Kind`. The registry finds it; nothing else names it.

>>> sorted(Kind.__abstractmethods__)[:3]
['facts', 'machine', 'make']
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar, Generic, NamedTuple, TypeVar, cast

import numpy as np

from camtools.base.command import BAD_INPUT
from camtools.base.errors import CamtoolsError
from camtools.base.quantities import NM_PER_MM, Floats
from camtools.base.text import Json
from camtools.cut.correction import Correction, Drawing
from camtools.part.common import PartFile
from camtools.part.model import TomlTable
from camtools.sim.results import AnyCut, Cut
from camtools.sim.simulate import Result, cut
from camtools.table.channel import RATIO_ONE, Channel
from camtools.table.evaluate import evaluate_at
from camtools.table.header import MadeTable

if TYPE_CHECKING:  # it loads matplotlib, which takes longer than a table
    from camtools.report.kind_report import KindReport


class ExactTurn(NamedTuple):
    """One turn at a height; arrays of shape (n,) over the drawing's angle."""

    phi_rad: Floats
    radius_mm: Floats  # of the part, as drawn
    nominal_mm: float  # radius of the circle from which deviations count
    u_mm: Floats  # travel of U from the middle of its stroke, towards the axis
    d1: Floats  # mm/rad
    d2: Floats  # mm/rad^2
    d3: Floats  # mm/rad^3


class HeightCurve(NamedTuple):
    """A line of the profile over the height."""

    name: str
    radius_mm: Floats  # shape of the heights


class ProfileOver(NamedTuple):
    """Radii of the part over its height."""

    z_mm: Floats
    curves: tuple[HeightCurve, ...]


class SpeedRatio(NamedTuple):
    """Speed of the spindle over its mean, and two derivatives by the angle."""

    value: Floats
    d1: Floats
    d2: Floats


class Exact(ABC):
    """The exact geometry of a part."""

    heights_mm: tuple[float, float]  # first and last, without what the tool travels in the air

    def nearest_mm(self, z_mm: float) -> float:
        """Return the height of the part that is nearest to a height."""
        low, high = self.heights_mm
        return min(max(z_mm, low), high)

    @abstractmethod
    def turn_at(self, z_mm: float, n: int) -> ExactTurn:
        """Return the section at a height and U along it at n angles, evenly from 0 on."""

    @abstractmethod
    def profile(self) -> ProfileOver:
        """Return radii over the height."""

    def ratio_at(self, speed: Channel, phi_rad: Floats, z_mm: float) -> SpeedRatio:
        """Return the speed of a modulated spindle at a height."""
        return ratio_of(speed, phi_rad, z_mm * NM_PER_MM)


def ratio_of(speed: Channel, phi_rad: Floats, height: float) -> SpeedRatio:
    """Return a speed channel at angles; `height` in nm, or the number of a pattern."""
    turns = phi_rad / (2 * np.pi)
    law = evaluate_at(speed, turns, np.full(turns.size, height))
    return SpeedRatio(law.value / RATIO_ONE, law.d1 / RATIO_ONE, law.d2 / RATIO_ONE)


def even_angles(n: int) -> Floats:
    """Return n angles of a turn, from 0 on [rad]."""
    return 2 * np.pi * np.arange(n, dtype=np.float64) / n


PartT = TypeVar("PartT", bound=PartFile)
MadeT = TypeVar("MadeT", bound=MadeTable)
CutT = TypeVar("CutT", bound=AnyCut)


class Rig(NamedTuple):
    """How a part was cut, for what a kind measures besides; its folder is the working folder."""

    result: Result  # with the table "surface"
    table: str  # name of the file
    words: list[str]  # options of camsim, faults left out
    turns: float  # that the cut takes, about


def made_cut(table: str, words: Sequence[str], **options: Any) -> Result:  # noqa: ANN401
    """Cut as `cut` does, with its options, and refuse what the controller refuses."""
    result = cut([table, *words], **options)
    if result.status == BAD_INPUT:
        raise CamtoolsError([result.message])
    return result


class Kind(ABC, Generic[PartT, MadeT, CutT]):
    """A kind of part."""

    name: ClassVar[str]  # `part.kind` of its part files
    plural: ClassVar[str]  # many of them, for messages
    rank: ClassVar[int]  # place in lists of kinds; the first one judges a part file that names none
    commands: ClassVar[tuple[str, ...]]  # of the project that can do something with such a part
    model: ClassVar[type[TomlTable]]  # of its part file: a TomlTable that is a PartFile
    reported: ClassVar[str]  # module that holds its REPORT; loading it takes longer than a table

    @abstractmethod
    def make(self, part: PartT, tolerance_nm: float | None = None) -> MadeT:
        """Return the table of a part, or refuse what cannot be cut."""

    def exact(self, part: PartT) -> Exact:
        """Return the exact shape of a part and the motion of U, where there is a preview."""
        problem = f"{self.plural} have no preview"
        raise CamtoolsError([f"part.kind = '{self.name}': {problem}; make the table by mktables"])

    def drawing(self, part: PartT) -> Drawing:
        """Return what a gauged part is compared with, where tables are corrected."""
        problem = f"tables of {self.plural} are not corrected by gauged parts"
        raise CamtoolsError([f"part.kind = '{self.name}': {problem}; leave out --measured"])

    def make_corrected(
        self, part: PartT, tolerance_nm: float | None, correction: Correction
    ) -> MadeT:
        """Return the table of the drawing less a correction; errors as `make` and `drawing`."""
        self.drawing(part)
        raise NotImplementedError

    def check_feed(self, part: PartT, feed_mm: float) -> None:
        """Refuse a feed in place of the part's that leaves more than the drawing accepts."""

    def proposed_feed(self, part: PartT) -> str:
        """Return a feed law that keeps the limits of the surface, as text for the part file."""
        problem = f"{self.plural} have no limits of scallop or roughness"
        raise CamtoolsError([f"part.kind = '{self.name}': {problem}; leave out --propose-feed"])

    @abstractmethod
    def summary(self, made: MadeT) -> Json:
        """Return everything that is known about a table; no dates, no paths."""

    @abstractmethod
    def text(self, summary: Json) -> str:
        """Return a summary as a few lines for people."""

    def at_speed(self, part: PartT, rpm: float | None) -> PartT:
        """Return the part for another speed, where its table depends on it."""
        return part

    def mean_rpm(self, made: MadeT, rpm: float | None) -> float:
        """Return the mean speed of the cut [r/min] when this speed, or none, is asked for."""
        return rpm or made.part.process.spindle_rpm

    def speed_words(self, rpm: float | None) -> list[str]:
        """Return camsim's options for the speed that is asked for."""
        return [] if rpm is None else ["--rpm", repr(rpm)]

    @abstractmethod
    def turns(self, made: MadeT, feed_mm: float) -> float:
        """Return how many turns the cut takes, about."""

    def sections_mm(self, made: MadeT, feed_mm: float) -> list[float]:
        """Return the heights of the sections that are gauged, rising; none: as camsim does."""
        return []

    def taken_um(self, made: MadeT) -> float:
        """Return how much of the form error smoothing of the drawing's points takes [um]."""
        return 0.0

    @abstractmethod
    def machine(self, part: PartT) -> str:
        """Return camsim's machine file: a machine with the limits of the part."""

    def outcome(self, cut: Cut[MadeT], rig: Rig) -> CutT:
        """Return all that is known about a cut; a kind that measures more does so here."""
        return cast(CutT, cut)

    @abstractmethod
    def facts(self, made: MadeT) -> Json:
        """Return what the summary of a cut says of the table's errors."""

    def report(self) -> "KindReport[CutT]":
        """Return what reports of cuts, and pictures of tables, show."""
        found: KindReport[CutT] = import_module(self.reported).REPORT
        return found


AnyKind = Kind[Any, Any, Any]
