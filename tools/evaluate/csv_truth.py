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

from .errors import InputError, UsageError

CLASSES = {"Car": "vehicle", "Van": "vehicle", "Truck": "vehicle", "Tram": "vehicle",
           "Bus": "vehicle", "Pedestrian": "person", "Person": "person",
           "Person_sitting": "person", "Cyclist": "cyclist"}
DISTANCES = ("0-10 m", "10-20 m", "20-40 m", "40+ m", "near", "far", "unknown")


def _read(path, required, optional=()):
    """The fields as text, by name; row k is line k + 2 where no line is empty."""
    try:
        table = pandas.read_csv(path, dtype=str, keep_default_na=False, skipinitialspace=True)
    except FileNotFoundError:
        raise InputError(f"there is no {path}") from None
    except (pandas.errors.ParserError, pandas.errors.EmptyDataError, UnicodeDecodeError) as error:
        raise InputError(f"{path} is no table: {error}") from None
    table.columns = table.columns.str.strip()
    for name in required:
        if name not in table:
            raise InputError(f'{path}, line 1 has no field "{name}"; it must be: '
                             f"{','.join(required)}")
    table = table.reindex(columns=[*required, *optional], fill_value="")
    return table.apply(lambda column: column.str.strip())


def _check(path, table, is_good, what):
    if not is_good.all():
        raise InputError(f"{path}, line {int(np.argmin(is_good.to_numpy())) + 2}: {what}")


def _numbers(path, table, name, integer=False, least=None, empty=None):
    """empty: the value of empty fields, which are an error without it."""
    texts = table[name]
    values = pandas.to_numeric(texts, errors="coerce")
    good = np.isfinite(values) & ((values % 1 == 0) if integer else True)
    if least is not None:
        good &= values >= least
    if empty is not None:
        values = values.where(texts != "", empty)
        good |= texts == ""
    kind = f"integer{'' if least is None else f' from {least}'}" if integer else "number"
    _check(path, table, good, f"{name} is no {kind}")
    return values.astype(np.int64) if integer else values


def read_tracks(path):
    """Columns frame, x, y, dynamic. UsageError unless there are points of both classes."""
    table = _read(path, ("track", "label", "frame", "x", "y"))
    _numbers(path, table, "track", integer=True)
    points = pandas.DataFrame({"frame": _numbers(path, table, "frame", integer=True, least=0),
                               "x": _numbers(path, table, "x"), "y": _numbers(path, table, "y"),
                               "dynamic": _numbers(path, table, "label", True, 1) >= 2})
    if points.empty or points.dynamic.all() or not points.dynamic.any():
        raise UsageError(f"{path}: {(~points.dynamic).sum()} static and {points.dynamic.sum()} "
                         "dynamic points; both are needed")
    return points


def read_boxes(path):
    """Columns frame, left, top, right, bottom, truncated, occluded, kind, distance.

    kind: "moving vehicle" and so on; empty if motion or class is unknown.
    """
    table = _read(path, ("frame", "id", "type", "x1", "y1", "x2", "y2", "moving"),
                  ("truncated", "occluded", "depth", "range"))
    _numbers(path, table, "id", integer=True)
    boxes = pandas.DataFrame({"frame": _numbers(path, table, "frame", integer=True, least=0)})
    for side, name in (("left", "x1"), ("top", "y1"), ("right", "x2"), ("bottom", "y2")):
        boxes[side] = _numbers(path, table, name)
    has_area = (boxes.right > boxes.left) & (boxes.bottom > boxes.top)
    _check(path, table, has_area, "the box has no area")
    _check(path, table, table.moving.isin(["", "0", "1"]), "moving is not 0, 1 or empty")
    _check(path, table, table.range.isin(["", "near", "far"]), "range is not near, far or empty")
    for name in ("truncated", "occluded"):
        boxes[name] = _numbers(path, table, name, integer=True, empty=0)
    motion = table.moving.map({"1": "moving ", "0": "standing "})
    boxes["kind"] = (motion + table.type.map(CLASSES)).fillna("")
    depth = _numbers(path, table, "depth", empty=np.nan)
    by_depth = pandas.cut(depth, [-np.inf, 10, 20, 40, np.inf], right=False, labels=DISTANCES[:4])
    boxes["distance"] = by_depth.astype(object).fillna(table.range.replace("", "unknown"))
    return boxes
