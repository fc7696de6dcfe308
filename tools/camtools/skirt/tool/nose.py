"""What the tip of a tool with a round nose must follow, and where the nose touches.

In the plane of the axis and one angle the surface is a curve R(z), and the nose a circle. The
circle touches the curve where their slopes are equal, at the kink of a curve that juts out, or at
an end of it.

>>> class Cone:
...     def values(self, phi: Floats, z: Floats) -> Floats:
...         return np.stack([10 + 0.75 * z, 0 * z, 0 * z, 0 * z])
>>> rays = Rays(Cone(), np.array([0.0, 20.0]))
>>> touch = find_contact(rays, np.array([0.0]), np.array([10.0]), 2.0, 0.0, 20.0)
>>> f"{touch.z_mm[0] - 10:.6f} {touch.above_mm(2.0)[0]:.6f}"
'1.200000 -0.400000'

The nose is a circle in the plane of the axis and the edge, as the edge of a round insert whose
rake face lies at centre height. At every angle and height the tip stands where the circle just
touches the surface: the envelope of the surface moved by the circle, MATHS.md (107). Beyond its
ends the surface goes on as its tangent, so that the tip passes them without a kink.

>>> from camtools.skirt.geometry.skirt_geometry import make_geometry
>>> from camtools.skirt.part.part_file import example_part
>>> drawing = make_geometry(example_part())
>>> tip = tip_geometry(drawing, Tool(nose_radius_mm=0.8))
>>> f"{1e6 * (tip.radius_mm(56.0) - drawing.radius_mm(56.0)):.3f} nm"
'11.586 nm'
>>> tip_geometry(drawing, Tool()) is drawing
True
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from camtools.base.errors import GeometryError
from camtools.base.quantities import Bools, Floats, FloatsLike, Ints, SectionValues
from camtools.base.solvers import unsolved
from camtools.part.common import MIN_NOSE_MM, Tool
from camtools.skirt.geometry.skirt_geometry import Geometry, dense_heights_mm

_STEP_MM = 1e-3  # of differences along the height
ACROSS_MM = 1e-9  # how far beyond a break its other side is looked at
_FOUND_MM = 1e-8
_MAX_STEPS = 100
_WITHIN = 1 - 1e-9  # of the nose's radius: the circle's slope is finite there


class Surface(Protocol):
    """A surface over angle and height, smooth between the breaks of its heights."""

    def values(self, phi: Floats, z: Floats) -> Floats:
        """Return the radius and three derivatives by the angle, shape (4, n)."""


class Along(NamedTuple):
    """Derivatives along the height, of the radius and of its angle derivatives, shape (4, n)."""

    first: Floats
    second: Floats


@dataclass(frozen=True, eq=False)
class Rays:
    """A surface with derivatives along the height, taken from inside one piece of it."""

    surface: Surface
    breaks_mm: Floats  # heights between which it is smooth, rising, both ends included

    def piece(self, z: Floats) -> Ints:
        """Return the index of the piece above each height, of the last one at the end."""
        found = np.searchsorted(self.breaks_mm, z, side="right") - 1
        return np.asarray(np.clip(found, 0, self.breaks_mm.size - 2), dtype=np.int64)

    def along(self, phi: Floats, z: Floats) -> Along:
        """Return the derivatives at heights of a parabola inside the piece of each."""
        piece = self.piece(z)
        low, high = self.breaks_mm[piece], self.breaks_mm[piece + 1]
        step = np.minimum(_STEP_MM, (high - low) / 4)
        middle = np.clip(z, low + step, high - step)
        below, here, above = (self.surface.values(phi, middle + k * step) for k in (-1, 0, 1))
        second = (below - 2 * here + above) / step**2
        return Along((above - below) / (2 * step) + second * (z - middle), second)


class NoseContact(NamedTuple):
    """Contacts, all of the shape (n,)."""

    z_mm: Floats
    off_mm: Floats  # above the middle of the nose
    is_free: Floats  # 1 where slopes are equal, 0 at a kink or an end

    def above_mm(self, nose_mm: float) -> Floats:
        """Return the lowest place of the nose's centre line less its radius: at most 0."""
        root = np.sqrt(nose_mm**2 - self.off_mm**2)
        return np.asarray(-(self.off_mm**2) / (nose_mm + root), dtype=np.float64)


def find_contact(
    rays: Rays, phi: Floats, centre_mm: Floats, nose_mm: float, low_mm: float, high_mm: float
) -> NoseContact:
    """Return the contact of each nose with the heights low_mm .. high_mm, MATHS.md (107) .. (109).

    Newton's method on the difference of the slopes, inside a bracket; a step never crosses a break
    but stops at it and looks at its other side. Errs by less than 1e-8 mm of height.

    The nose's radius is less than that of every hollow between the two heights.
    """
    z = np.clip(centre_mm, low_mm, high_mm)
    is_free, todo = np.ones(z.size), np.arange(z.size)
    search = _Search(rays, nose_mm, centre_mm, low_mm, high_mm)
    for _ in range(_MAX_STEPS):
        z[todo], is_free[todo], is_found = search.step(phi[todo], z[todo], todo)
        todo = todo[~is_found]
        if todo.size == 0:
            return NoseContact(z, z - centre_mm, is_free)
    raise unsolved("tool.nose_mm: contact")


class _Search:
    """Brackets of a search; a bound counts as tested once the slopes there are known."""

    def __init__(
        self, rays: Rays, nose_mm: float, centre_mm: Floats, low_mm: float, high_mm: float
    ) -> None:
        self.rays, self.nose_mm, self.centre_mm = rays, nose_mm, centre_mm
        reach = nose_mm * _WITHIN
        self.low = np.clip(centre_mm - reach, low_mm, high_mm)
        self.high = np.clip(centre_mm + reach, low_mm, high_mm)
        self.is_tested = np.zeros((2, centre_mm.size), dtype=bool)

    def step(self, phi: Floats, z: Floats, todo: Ints) -> tuple[Floats, Floats, Bools]:
        """Return the next heights, whether slopes are equal there, and which are found."""
        along = self.rays.along(phi, z)
        off = np.clip(z - self.centre_mm[todo], -self.nose_mm * _WITHIN, self.nose_mm * _WITHIN)
        root = np.sqrt(self.nose_mm**2 - off**2)
        rise = along.first[0] - off / root
        bend = along.second[0] - self.nose_mm**2 / root**3
        is_up, is_down = rise >= 0, rise <= 0
        self.low[todo] = np.where(is_up, z, self.low[todo])
        self.high[todo] = np.where(is_down, z, self.high[todo])
        self.is_tested[0, todo] |= is_up
        self.is_tested[1, todo] |= is_down
        low, high = self.low[todo], self.high[todo]
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = np.where(bend < 0, z - rise / bend, np.where(is_up, np.inf, -np.inf))
        wish = self._to_break(z, np.clip(newton, low, high))
        is_stale = is_up & self.is_tested[1, todo] & (wish >= high)
        is_stale |= is_down & self.is_tested[0, todo] & (wish <= low)
        new = np.where(is_stale, (low + high) / 2, wish)
        is_free = np.abs(newton - z) < _FOUND_MM
        is_found = is_free | (high - low < _FOUND_MM)
        return np.where(is_found & ~is_free, z, new), np.where(is_free, 1.0, 0.0), is_found

    def _to_break(self, z: Floats, wish: Floats) -> Floats:
        """Return wishes that leave the piece of z cut to just beyond the break between them."""
        breaks, piece = self.rays.breaks_mm, self.rays.piece(z)
        above, below = breaks[piece + 1] + ACROSS_MM, breaks[piece] - ACROSS_MM
        last = breaks.size - 2
        wish = np.where((wish > above) & (piece < last), above, wish)
        return np.asarray(np.where((wish < below) & (piece > 0), below, wish), dtype=np.float64)


LEFT_MM = 1e-4  # what a nose may leave in a crease
_ANGLES = 72
_CHECKS_PER_PIECE = 32
_CREASE_RAD = 1e-9  # differences of slopes below this are rounding
_APART_MM = 0.01  # edges of the arc at a kink that count as two breaks
_WIDER = 1.05


@dataclass(frozen=True, eq=False)
class _Drawn:
    """The surface to be left as the contact takes it; flat: its long half axis at all angles."""

    work: Geometry
    is_flat: bool = False

    def values(self, phi: Floats, z: Floats) -> Floats:
        """See `nose_contact.Surface.values`; heights within the drawing."""
        radius_mm = self.work.radius_mm(z)
        if self.is_flat:
            zero = np.zeros(z.shape)
            return np.stack([radius_mm, zero, zero, zero])
        u = self.work.delta(phi, z)
        return np.stack([radius_mm - u.delta, -u.d1, -u.d2, -u.d3])


@dataclass(frozen=True, eq=False)
class _Continued:
    """A surface that goes on beyond its ends as its tangents there."""

    inside: Rays

    def values(self, phi: Floats, z: Floats) -> Floats:
        """See `nose_contact.Surface.values`."""
        breaks = self.inside.breaks_mm
        within = np.clip(z, breaks[0], breaks[-1])
        found = self.inside.surface.values(phi, within)
        out = np.flatnonzero(z != within)
        if out.size:
            slopes = self.inside.along(phi[out], within[out]).first
            beyond = z - within
            found[:, out] += slopes * beyond[out]
        return found


def _rays(drawing: Geometry, nose_mm: float, *, is_flat: bool = False) -> Rays:
    """Return the surface that a nose may touch, a radius of it beyond both ends."""
    breaks = drawing.breaks_mm()
    beyond = np.concatenate(([breaks[0] - nose_mm], breaks, [breaks[-1] + nose_mm]))
    return Rays(_Continued(Rays(_Drawn(drawing, is_flat), breaks)), beyond)


@dataclass(frozen=True, eq=False)
class NoseGeometry(Geometry):
    """The tip's surface: radius_mm(z) - delta(phi, z) is where the tip of the nose stands."""

    work: Geometry = field(kw_only=True)  # that the nose leaves; all other fields are its own
    nose_mm: float = field(kw_only=True)  # radius

    def radius_mm(self, z_mm: FloatsLike | Sequence[float], derivative: int = 0) -> Floats:
        """Return the tip's radius at the long axis, or its derivatives by the height."""
        z = np.asarray(z_mm, dtype=np.float64)
        flat, zero = z.ravel(), np.zeros(z.size)
        rays = _rays(self.work, self.nose_mm, is_flat=True)
        touch = self._touch(rays, zero, flat)
        root = np.sqrt(self.nose_mm**2 - touch.off_mm**2)
        if derivative == 0:
            found = rays.surface.values(zero, touch.z_mm)[0] + touch.above_mm(self.nose_mm)
        elif derivative == 1:
            found = touch.off_mm / root
        else:
            bend, circle = rays.along(zero, touch.z_mm).second[0], self.nose_mm**2 / root**3
            found = np.where(touch.is_free > 0, bend * circle / (circle - bend), -circle)
        return np.asarray(found.reshape(z.shape), dtype=np.float64)

    def delta(self, phi_rad: FloatsLike, z_mm: FloatsLike) -> SectionValues:
        """See `Geometry.delta`; the jerk alone leaves out the third derivative by the height."""
        phi, z = np.asarray(phi_rad, dtype=np.float64), np.asarray(z_mm, dtype=np.float64)
        shape = np.broadcast_shapes(phi.shape, z.shape)
        flat_phi, flat_z = (np.broadcast_to(values, shape).ravel() for values in (phi, z))
        touch = self._touch(self._rays, flat_phi, flat_z)
        r, r1, r2, r3 = self._rays.surface.values(flat_phi, touch.z_mm)
        along = self._rays.along(flat_phi, touch.z_mm)
        root = np.sqrt(self.nose_mm**2 - touch.off_mm**2)
        stiffness = self.nose_mm**2 / root**3 - along.second[0]
        travel = touch.is_free * along.first[1] / stiffness  # dz/dphi of the contact
        circle3 = -3 * touch.off_mm * self.nose_mm**2 / root**5
        tip2 = r2 + along.first[1] * travel
        tip3 = r3 + 3 * (along.first[2] + along.second[1] * travel) * travel + circle3 * travel**3
        long_mm = np.broadcast_to(self.radius_mm(z), shape).ravel()
        u = (long_mm - r - touch.above_mm(self.nose_mm), -r1, -tip2, -tip3)
        return SectionValues(*(values.reshape(shape) for values in u))

    def breaks_mm(self) -> Floats:
        """Return heights of the nose at which its contact passes a break of the shape."""
        inner = self.work.breaks_mm()[1:-1]
        slopes = np.stack([self._slopes(inner, below=True), self._slopes(inner)])
        edges = inner[:, None] - self.nose_mm * np.sin(np.arctan(slopes))
        widest = np.abs(edges[1] - edges[0]).argmax(axis=1)
        first, second = np.take_along_axis(edges, widest[None, :, None], axis=2)[:, :, 0]
        wide = np.abs(second - first) > _APART_MM
        heights = np.unique(np.concatenate([first, second[wide]]))
        inside = (heights > self.z_first_mm) & (heights < self.z_last_mm)
        return np.concatenate(([self.z_first_mm], heights[inside], [self.z_last_mm]))

    @cached_property
    def _rays(self) -> Rays:
        return _rays(self.work, self.nose_mm)

    def _slopes(self, z: Floats, *, below: bool = False) -> Floats:
        """Return the slopes along the height all round, shape (n, angles)."""
        return slopes_at(self._rays, z, below=below)

    @cached_property
    def _creases_mm(self) -> Floats:
        """Heights at which the surface has a crease: between two of them a contact is the only."""
        inner = self.work.breaks_mm()[1:-1]
        bends = self._slopes(inner) - self._slopes(inner, below=True)
        return np.asarray(inner[bends.max(axis=1, initial=0.0) > _CREASE_RAD])

    @cached_property
    def _reach_mm(self) -> float:
        """How far a contact lies from the middle of the nose, at most."""
        heights = dense_heights_mm(self.work, _CHECKS_PER_PIECE)
        steepest = max(
            float(np.abs(self._slopes(heights, below=below)).max()) for below in (False, True)
        )
        return self.nose_mm * min(1.0, _WIDER * float(np.sin(np.arctan(steepest))))

    def _touch(self, rays: Rays, phi: Floats, centre_mm: Floats) -> NoseContact:
        """Return the deepest contact; beside a crease the deeper one of both its sides."""
        ends = float(rays.breaks_mm[0]), float(rays.breaks_mm[-1])
        best = find_contact(rays, phi, centre_mm, self.nose_mm, *ends)
        creases = np.concatenate(([ends[0]], self._creases_mm, [ends[1]]))
        for i in range(1, creases.size - 1):
            near = np.flatnonzero(np.abs(centre_mm - creases[i]) <= self._reach_mm)
            if near.size == 0:
                continue
            sides = (creases[i - 1], creases[i] - ACROSS_MM), (creases[i], creases[i + 1])
            for low, high in sides:
                side = find_contact(rays, phi[near], centre_mm[near], self.nose_mm, low, high)
                best = self._deeper(rays, phi, best, side, near)
        return best

    def _deeper(
        self, rays: Rays, phi: Floats, best: NoseContact, side: NoseContact, near: Ints
    ) -> NoseContact:
        """Return the contacts at which the tip stands further out."""
        kept = NoseContact(*(column[near] for column in best))
        mine, others = (
            rays.surface.values(phi[near], contact.z_mm)[0] + contact.above_mm(self.nose_mm)
            for contact in (kept, side)
        )
        is_deeper = others > mine
        for column, deeper in zip(best, side, strict=True):
            column[near[is_deeper]] = deeper[is_deeper]
        return best


def _all_round(z: Floats) -> tuple[Floats, Floats]:
    """Return angles and heights of points all round at each height."""
    phi = 2 * np.pi * np.arange(_ANGLES) / _ANGLES
    return np.tile(phi, z.size), np.repeat(z, _ANGLES)


def slopes_at(rays: Rays, z: Floats, *, below: bool = False) -> Floats:
    """Return dR/dz at heights all round, shape (n, angles); below: of the piece that ends there."""
    at = np.nextafter(z, -np.inf) if below else z
    slopes = rays.along(*_all_round(at)).first[0]
    return np.asarray(slopes.reshape(z.size, _ANGLES), dtype=np.float64)


def tip_geometry(drawing: Geometry, tool: Tool) -> Geometry:
    """Return what the tip must follow; of a tool with a point the drawing itself."""
    if not tool.is_round:
        return drawing
    own = {member.name: getattr(drawing, member.name) for member in fields(Geometry)}
    check_nose(drawing, tool.nose_radius_mm)
    return NoseGeometry(**own, work=drawing, nose_mm=tool.nose_radius_mm)


def check_nose(drawing: Geometry, nose_mm: float) -> None:
    """Refuse a nose that does not fit into a hollow or a crease, MATHS.md (108)."""
    rays = Rays(_Drawn(drawing), drawing.breaks_mm())
    places = _narrowest_hollow(rays, drawing), _sharpest_crease(rays, drawing)
    largest_mm, angle_deg, z_mm, what = min(places, key=lambda place: place[0])
    if nose_mm < largest_mm:
        return
    problem = f"{nose_mm:g} mm does not fit into the {what} at {angle_deg:g} degrees, height "
    fits_mm = np.floor(largest_mm * 0.999 * 1000) / 1000
    remedy = f"give at most {fits_mm:g} mm, or a profile without it"
    if fits_mm < MIN_NOSE_MM:
        remedy = "give a profile or an ovality without it"
    raise GeometryError("tool.nose_radius_mm", f"{problem}{z_mm:.6g} mm", remedy)


_Place = tuple[float, float, float, str]


def _narrowest_hollow(rays: Rays, drawing: Geometry) -> _Place:
    """Return the least radius of a hollow along the height, and where it is."""
    grid_phi, grid_z = _all_round(dense_heights_mm(drawing, _CHECKS_PER_PIECE))
    along = rays.along(grid_phi, grid_z)
    curvature = along.second[0] / (1 + along.first[0] ** 2) ** 1.5
    worst = int(curvature.argmax())
    radius_mm = 1 / float(curvature[worst]) if curvature[worst] > 0 else float("inf")
    angle_deg = float(np.degrees(grid_phi[worst]))
    return radius_mm, angle_deg, float(grid_z[worst]), f"hollow of {radius_mm:.4g} mm"


def _sharpest_crease(rays: Rays, drawing: Geometry) -> _Place:
    """Return the largest radius that leaves no more than LEFT_MM in a crease, and where it is."""
    inner = drawing.breaks_mm()[1:-1]
    below, above = (np.arctan(slopes_at(rays, inner, below=is_below)) for is_below in (True, False))
    bend = above - below
    if not bend.size or bend.max() <= _CREASE_RAD:
        return float("inf"), 0.0, 0.0, "crease"
    i, k = np.unravel_index(int(bend.argmax()), bend.shape)
    half = float(bend[i, k]) / 2
    radius_mm = LEFT_MM * float(np.cos(half)) / (2 * float(np.sin(half / 2)) ** 2)
    what = f"crease of {np.degrees(2 * half):.4g} degrees"
    return radius_mm, float(k) * 360 / _ANGLES, float(inner[i]), what
