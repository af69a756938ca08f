"""Tables of truth: a header of field names in any order; unknown fields are ignored.

    tracks  track,label,frame,x,y: label 1 is static, labels of 2 and more are movers; pixels from 0
    boxes   frame,id,type,x1,y1,x2,y2,moving and optionally truncated,occluded,depth,range

Fields of boxes:

    frame      index in the input, from 0
    type       Car, Van, Truck, Tram, Bus: vehicle; Pedestrian, Person, Person_sitting: person;
               Cyclist: cyclist; any other: an area of unknown content
    x1 .. y2   pixels from 0: left, top, right and bottom edge
    moving     1, 0, or empty if unknown
    truncated  by the image's border: 0 not, 1 partly, 2 largely
    occluded   0 not, 1 partly, 2 largely, 3 unknown
    depth      metres along the optical axis
    range      near (nearer than 50 m) or far, if the depth is only estimated by eye
"""

import numpy as np
import pandas

from .files import InputError, UsageError

CLASSES = {"Car": "vehicle", "Van": "vehicle", "Truck": "vehicle", "Tram": "vehicle",
           "Bus": "vehicle", "Pedestrian": "person", "Person": "person",
           "Person_sitting": "person", "Cyclist": "cyclist"}
DISTANCES = ("0-10 m", "10-20 m", "20-40 m", "40+ m", "near", "far", "unknown")


# What a field must be, by the name of its kind; texts are of none.
KINDS = {"number": np.isfinite, "integer": lambda values: values % 1 == 0,
         "integer from 0": lambda values: (values % 1 == 0) & (values >= 0),
         "integer from 1": lambda values: (values % 1 == 0) & (values >= 1)}
TRACKS = {"track": "integer", "label": "integer from 1", "frame": "integer from 0", "x": "number",
          "y": "number"}
BOXES = {"frame": "integer from 0", "id": "integer", "type": "text", "x1": "number",
         "y1": "number", "x2": "number", "y2": "number", "moving": "text"}
MORE_OF_BOXES = {"truncated": "integer", "occluded": "integer", "depth": "number", "range": "text"}


def _check(path, is_good, what):
    if not is_good.all():
        raise InputError(f"{path}, line {int(np.argmin(is_good.to_numpy())) + 2}: {what}")


def _read(path, required, optional=()):
    """Kinds of fields by name; an empty optional number is not a number."""
    try:
        table = pandas.read_csv(path, dtype=str, keep_default_na=False, skipinitialspace=True)
    except (OSError, ValueError) as error:
        raise InputError(f"{path} is no table: {error}") from None
    table.columns = table.columns.str.strip()
    if absent := [name for name in required if name not in table]:
        raise InputError(f'{path}, line 1 has no field "{absent[0]}"; it must be: '
                         f"{','.join(required)}")
    table = table.reindex(columns=[*required, *optional], fill_value="")
    table = table.apply(lambda column: column.str.strip())
    for name, kind in {**required, **dict(optional)}.items():
        if kind in KINDS:
            values = pandas.to_numeric(table[name], errors="coerce")
            may_lack = (table[name] == "") & (name in optional)
            _check(path, KINDS[kind](values) | may_lack, f"{name} is no {kind}")
            table[name] = values
    return table


def read_tracks(path):
    """Columns frame, x, y, dynamic. UsageError unless there are points of both classes."""
    points = _read(path, TRACKS).astype({"frame": int})
    points["dynamic"] = points.label >= 2
    if points.empty or points.dynamic.all() or not points.dynamic.any():
        raise UsageError(f"{path}: {(~points.dynamic).sum()} static and {points.dynamic.sum()} "
                         "dynamic points; both are needed")
    return points


def read_boxes(path):
    """Columns frame, left, top, right, bottom, truncated, occluded, kind, distance.

    kind: "moving vehicle" and so on; empty if motion or class is unknown.
    """
    boxes = _read(path, BOXES, MORE_OF_BOXES).astype({"frame": int})
    _check(path, (boxes.x2 > boxes.x1) & (boxes.y2 > boxes.y1), "the box has no area")
    _check(path, boxes.moving.isin(["", "0", "1"]), "moving is not 0, 1 or empty")
    _check(path, boxes.range.isin(["", "near", "far"]), "range is not near, far or empty")
    motion = boxes.moving.map({"1": "moving ", "0": "standing "})
    by_depth = pandas.cut(boxes.depth, [-np.inf, 10, 20, 40, np.inf], right=False,
                          labels=DISTANCES[:4])
    sides = {"x1": "left", "y1": "top", "x2": "right", "y2": "bottom"}
    return boxes.rename(columns=sides).fillna({"truncated": 0, "occluded": 0}).assign(
        kind=(motion + boxes.type.map(CLASSES)).fillna(""),
        distance=by_depth.astype(object).fillna(boxes.range.replace("", "unknown")))
