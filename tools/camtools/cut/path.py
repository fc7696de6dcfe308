"""How Z follows the turns: plain helix, ring-helix, steps, MATHS.md (40) .. (43), (100).

A ring-helix turns a closed ring at every section of the drawing and one turn of a helix between
two of them ("variable cross-section helix"); section distance and lead are both the feed. As
printed, Z's speed jumps twice per two turns. With a ramp, Z moves with trapezoidal speed within
the turn of the helix: the rings stay whole. A stepped path keeps the section during each turn and
steps to the next one at its end.

>>> path = ToolPath("ring-helix", 0.0, 0.4, 0.2)
>>> [f"{mm:.3f}" for mm in path.height_mm(np.array([0.5, 1.25, 2.0, 3.5]))], path.turns
(['0.000', '0.050', '0.200', '0.300'], 5.0)
"""

from dataclasses import dataclass
from math import ceil, sqrt

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.part.common import MachineLimits

_WHOLE = 1e-9  # of a feed: a height range is a whole number of feeds
LEAST_RAMP = 1 / 256  # of a turn: a shorter one would win nothing
MOST_STEP = 0.5  # of a turn: a longer step is no step


@dataclass(frozen=True)
class ToolPath:
    """A path along the skirt.

    The feed is the lead of the helix; of the other paths the distance of their sections, but for
    the last step, which is what is left of the range. `ramp` is the share of a helix turn, or of a
    step, over which Z gathers speed, and again over which it loses it; 0 is the path as printed.
    """

    kind: str  # "helix", "ring-helix" or "stepped"
    z_first_mm: float
    z_last_mm: float
    feed_mm: float
    ramp: float = 0.0  # 0 .. 0.5, not of a helix
    step: float = 0.0  # share of a turn, at its end, that a step takes, 0 .. 0.5; 0 is a jump

    @property
    def feeds(self) -> float:
        """Return the height range in feeds."""
        feeds = (self.z_last_mm - self.z_first_mm) / self.feed_mm
        whole = round(feeds)
        return float(whole) if whole > 0 and abs(feeds - whole) < _WHOLE * whole else feeds

    @property
    def n_rings(self) -> int:
        """Return the number of closed rings."""
        return 0 if self.kind == "helix" else ceil(self.feeds) + 1

    @property
    def turns(self) -> float:
        """Return the length of the path; m rings take 2 m - 1 turns."""
        if self.kind == "stepped":
            return float(self.n_rings)
        return self.feeds if self.kind == "helix" else float(2 * self.n_rings - 1)

    def height_mm(self, turns: Floats) -> Floats:
        """Return Z at turns since the start of the path; it stands before and after."""
        done = np.clip(turns, 0.0, self.turns)
        if self.kind == "ring-helix":
            whole = np.floor(done)
            ring = np.floor(whole / 2)
            step = np.minimum(1.0, self.feeds - ring)
            done = ring + step * np.where(whole % 2 == 1, self._risen(done - whole), 0.0)
        if self.kind == "stepped":
            whole = np.floor(done)
            into = np.clip((done - whole - 1 + self.step) / (self.step or 1.0), 0.0, 1.0)
            done = whole + np.clip(self.feeds - whole, 0.0, 1.0) * self._risen(into)
        return np.minimum(self.z_first_mm + self.feed_mm * done, self.z_last_mm)

    def _risen(self, share: Floats) -> Floats:
        """Return the share of the lead that is fed at shares of a helix turn."""
        if self.ramp == 0:
            return share
        r, near = self.ramp, np.minimum(share, 1 - share)
        fed = np.where(near < r, near**2 / (2 * r), near - r / 2) / (1 - r)
        return np.asarray(np.where(share <= 0.5, fed, 1 - fed), dtype=np.float64)

    def tracks_mm(self, angle: float) -> Floats:
        """Return the heights at which the tool passes an angle [turns, 0 .. 1), rising.

        The last turn of a ring-helix ends where it began: passed once.
        """
        n = max(1, ceil(self.turns - angle - _WHOLE))
        return self.height_mm(angle + np.arange(n, dtype=np.float64))

    def scallop_mm(self, angle: float, z_mm: Floats, nose_mm: float) -> Floats:
        """Return how far the tool leaves the surface proud at an angle [turns, 0 .. 1] and heights.

        The height is d^2 / (2 nose) at a distance d from the nearest track, d^4 / (8 nose^3) less
        than that of the nose's circle.
        """
        tracks = self.tracks_mm(angle)
        right = np.clip(np.searchsorted(tracks, z_mm), 1, max(1, tracks.size - 1))
        left = np.minimum(right - 1, tracks.size - 1)
        right = np.minimum(right, tracks.size - 1)
        off = np.minimum(np.abs(z_mm - tracks[left]), np.abs(tracks[right] - z_mm))
        return np.asarray(off**2 / (2 * nose_mm), dtype=np.float64)


def ramp_of(feed_mm: float, spindle_rpm: float, limits: MachineLimits) -> float:
    """Return the shortest ramp of a ring-helix that Z's acceleration allows, as the firmware's.

    At least LEAST_RAMP (firmware/motion/cam_motion.h).
    Z's speed is feed n / (1 - r), its acceleration feed n^2 / (r (1 - r)), n in turns per second.
    CamtoolsError has the highest speed of the spindle where no ramp keeps both limits.
    """
    per_s = spindle_rpm / 60
    speed, acceleration = limits.z_speed_mm_s, limits.z_acceleration_mm_s2
    root = 0.25 - feed_mm * per_s**2 / acceleration
    if root < 0:
        needed = f"at least {4 * feed_mm * per_s**2:.9g} mm/s2 of Z, z_acceleration_mm_s2 is "
        raise _refusal(needed + f"{acceleration:g}", feed_mm, spindle_rpm, limits)
    ramp = max(0.5 - sqrt(root), LEAST_RAMP)
    if feed_mm * per_s > speed * (1 - ramp):
        needed = f"at least {feed_mm * per_s / (1 - ramp):.9g} mm/s of Z, z_speed_mm_s is "
        raise _refusal(needed + f"{speed:g}", feed_mm, spindle_rpm, limits)
    return ramp


def _step(feed_mm: float, limits: MachineLimits) -> tuple[float, float]:
    """Return speed [mm/s] and duration [s] of the quickest step."""
    v = min(limits.z_speed_mm_s, sqrt(feed_mm * limits.z_acceleration_mm_s2))
    return v, feed_mm / v + v / limits.z_acceleration_mm_s2


def highest_step_rpm(feed_mm: float, limits: MachineLimits) -> float:
    """Return the highest spindle speed at which a step takes MOST_STEP of a turn [r/min]."""
    return 60 * MOST_STEP / _step(feed_mm, limits)[1]


def step_of(feed_mm: float, spindle_rpm: float, limits: MachineLimits) -> tuple[float, float]:
    """Return the quickest step of a stepped path: its share of a turn and its ramp, MATHS.md (100).

    CamtoolsError has the highest speed of the spindle where it would take more than half a turn.
    """
    v, step_s = _step(feed_mm, limits)
    share = step_s * spindle_rpm / 60
    if share > MOST_STEP:
        problem = f"a step of {feed_mm:g} mm takes {step_s * 1000:.3g} ms, {share:.3g} of a turn"
        best = np.floor(10 * highest_step_rpm(feed_mm, limits)) / 10
        remedy = f'turn at {best:.1f} r/min at most, feed less, or set path = "helix"'
        raise CamtoolsError([f'process.path = "stepped": {problem}; {remedy}'])
    return share, v / limits.z_acceleration_mm_s2 / step_s


def _refusal(
    needed: str, feed_mm: float, spindle_rpm: float, limits: MachineLimits
) -> CamtoolsError:
    best = np.floor(highest_rpm(feed_mm, limits) * 10) / 10
    most = np.floor(largest_feed_mm(spindle_rpm, limits) * 10_000) / 10_000
    remedy = f"turn at {best:.1f} r/min at most, with a feed of {most:.4f} mm at most, "
    remedy += 'or with path = "helix"'
    return CamtoolsError([f'process.path = "ring-helix": needs {needed}; {remedy}'])


def highest_rpm(feed_mm: float, limits: MachineLimits) -> float:
    """Return the highest spindle speed at which Z can follow a ring-helix [r/min].

    The ramp that meets both limits: 1 / n = feed / v + v / a, v at most sqrt(feed a) where the
    ramps meet.
    """
    v = min(limits.z_speed_mm_s, sqrt(feed_mm * limits.z_acceleration_mm_s2))
    ramp_s = max(v / limits.z_acceleration_mm_s2, feed_mm / v * LEAST_RAMP / (1 - LEAST_RAMP))
    return 60 / (feed_mm / v + ramp_s)


def largest_feed_mm(spindle_rpm: float, limits: MachineLimits) -> float:
    """Return the largest feed of a ring-helix that Z can follow at a speed of the spindle [mm]."""
    turn_s = 60 / spindle_rpm
    acceleration = limits.z_acceleration_mm_s2
    v = min(limits.z_speed_mm_s, acceleration * turn_s / 2)
    return v * (turn_s - max(v / acceleration, LEAST_RAMP * turn_s))
