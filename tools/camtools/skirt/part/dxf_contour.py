"""The half profile of a DXF drawing as lines and arcs over the height.

Polylines, lines and arcs of a layer are one contour, in whatever order they are drawn: sorted by
height, each begins where the one below it ends. The origin is on the axis of the part.

>>> Edge((0.0, 45.0), (10.0, 45.5), 0.0, "entity 4F (LINE) of layer PROFILE").high
(10.0, 45.5)
"""

import logging
from contextlib import redirect_stdout
from itertools import pairwise
from math import copysign, dist
from pathlib import Path
from typing import Any, NamedTuple

from camtools.base.errors import InputError
from camtools.base.files import read_limited
from camtools.part.model import MAX_HEIGHT_MM, MIN_STEP_MM, SAME_MM
from camtools.table.points import LENGTHS

MIN_RADIUS_MM, MAX_RADIUS_MM = 0.5, 2000
_MAX_BYTES = 20_000_000
_JOINED_MM = 1e-4  # ends that are so close are one point
_INSUNITS = {1: "inch", 4: "mm"}
_MOST_LAYERS = 20  # named in a refusal
_CURVED = 0b1111110  # flags of a POLYLINE: fitted curves, three dimensions, meshes
_READ = "lines, arcs and plane polylines"
_DIGITS = 10  # of mm: below them is the rounding of angles
_RISES = "leave only what rises on the layer, and check the key axis"
_PLANE = 1e-9  # of a normal of length 1

Point = tuple[float, float]  # height and radius [mm]


class Edge(NamedTuple):
    """A line or an arc of the contour."""

    low: Point
    high: Point
    radius_mm: float  # of an arc, above 0 convex, below 0 hollow; 0: a line
    place: str  # entity and layer, for messages


def read_contour(
    path: Path, layer: str | None, axis: str, unit: str | None
) -> tuple[list[Edge], str]:
    """Return the half profile of a layer upwards, and in words how the drawing was understood.

    `axis`, "x" or "y", is that of the part.

    Raises InputError with entity and layer: no such layer, entities that are no lines or arcs, do
    not continue each other upwards, or are beyond the range of a part; unknown unit.
    """
    drawing = _loaded(path)
    entities, layer = _on_layer(path.name, list(drawing.modelspace()), layer)
    stated = _INSUNITS.get(drawing.header.get("$INSUNITS", 0))
    used = unit or stated
    if used is None:
        problem = "$INSUNITS of the drawing names neither mm nor inch"
        raise InputError(path.name, "", None, problem, 'set unit = "mm" or "inch"')
    found = (edge for entity in entities for edge in _edges(path.name, entity, axis, LENGTHS[used]))
    edges = sorted(found, key=lambda edge: edge.low)
    _check(path.name, edges, layer)
    source = "by the part file" if unit else "by $INSUNITS"
    ends = f"{edges[0].low[0]:g} .. {edges[-1].high[0]:g} mm"
    count = "1 segment" if len(edges) == 1 else f"{len(edges)} segments"
    words = f"layer {layer}, {count} at {ends}, unit {used} {source}, axis {axis}"
    return edges, words


def _loaded(path: Path) -> Any:  # noqa: ANN401 (ezdxf.document.Drawing)
    """Return the drawing of a file; its library is slow to load, and looks for fonts."""
    logging.getLogger("ezdxf").setLevel(logging.CRITICAL)
    try:
        read_limited(path, _MAX_BYTES)
        with redirect_stdout(None):
            import ezdxf

            return ezdxf.readfile(path)
    except Exception as error:  # whatever a damaged file leads to
        reason = getattr(error, "strerror", None) or "it is no DXF drawing"
        remedy = "give a DXF file, R12 or later, with its path relative to the part file"
        raise InputError(path.name, "", None, f"cannot be read: {reason}", remedy) from error


def _on_layer(file: str, entities: list[Any], layer: str | None) -> tuple[list[Any], str]:
    """Return the entities of a layer and its name, by default of the only one that has any."""
    layers = {entity.dxf.layer.casefold(): str(entity.dxf.layer) for entity in entities}
    wanted = next(iter(layers), "") if layer is None and len(layers) == 1 else (layer or "")
    if wanted.casefold() in layers:
        found = [entity for entity in entities if entity.dxf.layer.casefold() == wanted.casefold()]
        return found, layers[wanted.casefold()]
    problem = "has no layer name for the contour" if layer is None else f'layer "{layer}" is empty'
    names = ", ".join(sorted(layers.values())[:_MOST_LAYERS]) or "none"
    remedy = f"set layer to one that has entities in model space: {names}"
    raise InputError(file, "", None, problem, remedy)


def _edges(file: str, entity: Any, axis: str, mm: float) -> list[Edge]:  # noqa: ANN401
    """Return the lines and arcs of an entity, or refuse it."""
    kind = entity.dxftype()
    place = f"entity {entity.dxf.handle} ({kind}) of layer {entity.dxf.layer}"
    is_polyline = kind == "LWPOLYLINE" or (kind == "POLYLINE" and not entity.dxf.flags & _CURVED)
    problem, remedy = f"is none of {_READ}", "draw it by these, or move it to another layer"
    try:
        if is_polyline or kind in ("LINE", "ARC"):
            parts = entity.virtual_entities() if is_polyline else [entity]
            edges = [_edge(part, axis, mm, place) for part in parts]
            return [edge for edge in edges if dist(edge.low, edge.high) > _JOINED_MM]
    except _RefusedError as error:
        problem, remedy = error.args
    except Exception:  # whatever damaged numbers lead to
        problem, remedy = "is damaged", "draw it anew"
    raise InputError(file, place, None, problem, remedy)


class _RefusedError(Exception):
    """Problem and remedy of an entity."""


def _edge(part: Any, axis: str, mm: float, place: str) -> Edge:  # noqa: ANN401 (Line or Arc)
    """Return a line or an arc with its ends in the order of their heights, or refuse it."""
    is_arc = part.dxftype() == "ARC"
    ends = (part.start_point, part.end_point) if is_arc else (part.dxf.start, part.dxf.end)
    normal = part.dxf.extrusion.normalize().z if is_arc else 1.0
    if abs(ends[0].z - ends[1].z) * mm > _JOINED_MM or not abs(abs(normal) - 1) < _PLANE:
        raise _RefusedError("leaves the plane of the drawing", "draw it in the plane x, y")
    along, across = (0, 1) if axis == "x" else (1, 0)
    places = [round(end[axis] * mm, _DIGITS) + 0.0 for end in ends for axis in (along, across)]
    low, high = sorted([(places[0], places[1]), (places[2], places[3])])
    for z_mm, radius_mm in (low, high):
        if not (abs(z_mm) <= MAX_HEIGHT_MM and MIN_RADIUS_MM <= radius_mm <= MAX_RADIUS_MM):
            at = f"height {z_mm:.6g}, radius {radius_mm:.6g} mm is beyond"
            problem = f"{at} {MAX_HEIGHT_MM} mm or {MIN_RADIUS_MM} .. {MAX_RADIUS_MM} mm"
            remedy = "put the origin on the part's axis; check the keys unit and axis"
            raise _RefusedError(problem, remedy)
    return Edge(low, high, _arc_mm(part, across) * mm if is_arc else 0.0, place)


def _arc_mm(arc: Any, across: int) -> float:  # noqa: ANN401 (Arc)
    """Return the radius of an arc, below 0 where it is hollow seen from outside, or refuse it."""
    centre = arc.ocs().to_wcs(arc.dxf.center)[across]
    sides = [end[across] - centre for end in (arc.start_point, arc.end_point)]
    sweep_deg = (arc.dxf.end_angle - arc.dxf.start_angle) % 360
    if not (0 < sweep_deg < 180 and sides[0] * sides[1] > 0):
        raise _RefusedError("turns back over the height", _RISES)
    return copysign(arc.dxf.radius, sides[0])


def _check(file: str, edges: list[Edge], layer: str) -> None:
    """Refuse what is no contour from its lowest to its highest point."""
    if not edges:
        raise InputError(file, f"layer {layer}", None, "has no line and no arc", "draw the profile")
    for edge in edges:
        if edge.high[0] - edge.low[0] < MIN_STEP_MM - SAME_MM:
            problem = f"rises by less than {MIN_STEP_MM} mm at height {edge.low[0]:.6g} mm"
            raise InputError(file, edge.place, None, problem, _RISES)
    for below, above in pairwise(edges):
        gap_mm = dist(below.high, above.low)
        if gap_mm > _JOINED_MM:
            at = f"height {above.low[0]:.6g}, radius {above.low[1]:.6g} mm"
            problem = f"begins at {at}, {gap_mm:.3g} mm from the end of {below.place} below it"
            remedy = "join them, and leave one contour on the layer"
            raise InputError(file, above.place, None, problem, remedy)
