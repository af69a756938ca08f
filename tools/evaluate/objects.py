"""Which objects were found, and which predicted objects are false.

The truth gives every pixel an object id (0: none), and so does the prediction. A predicted object
may cover several neighbouring objects of the truth. Therefore each of its pixels is assigned to the
nearest of them:

    IoU(o) = |P and o| / |o or { p in predicted objects that touch o : nearest(p) = o }|
    found(o)      IoU(o) >= the threshold
    false object  a predicted object of at least min_area pixels; the share of its pixels on objects
                  (or on void pixels) is below a tenth

Objects below min_area pixels (of the scored map: grid or full) do not count as missed or false;
their pixels remain in IoU.
"""

import cv2
import numpy as np
import pandas

from .files import to_text
from .pixel_scores import ratio

MIN_OVERLAP = 0.1  # least overlap of a predicted object that is not false


def components_of(mask):
    """Numbers of the regions of 8-connected pixels, from 1."""
    return cv2.connectedComponents(mask.astype(np.uint8), connectivity=8, ltype=cv2.CV_32S)[1]


def objects_of_map(scores, low, high):
    """Numbers of the regions with scores >= low that hold a score >= high
    (vision/objects/map_objects.h)."""
    regions = components_of(scores >= low)
    return np.where(np.isin(regions, np.unique(regions[scores >= high])), regions, 0)


def _nearest_object(ids):
    _, labels = cv2.distanceTransformWithLabels((ids == 0).astype(np.uint8), cv2.DIST_L2,
                                                cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL)
    id_of_label = np.zeros(labels.max() + 1, ids.dtype)
    id_of_label[labels[ids != 0]] = ids[ids != 0]
    return id_of_label[labels]


def score_objects(predicted, ids, void, min_area):
    """([(id, IoU)] of the objects, number of false objects)."""
    count = max(int(predicted.max()), int(ids.max())) + 1
    areas, predicted_areas = (np.bincount(n.ravel(), minlength=count) for n in (ids, predicted))
    on_objects = np.bincount(predicted[(ids != 0) | void], minlength=count)
    pair = predicted.astype(np.int64) * count
    both = (predicted != 0) & (ids != 0)
    hits = np.bincount(ids[both], minlength=count)
    charged = np.zeros(count, int)
    if both.any():
        nearest = _nearest_object(ids)
        beside = (predicted != 0) & (ids == 0) & ~void
        touches = np.isin((pair + nearest)[beside], np.unique((pair + ids)[both]))
        charged = np.bincount(nearest[beside][touches], minlength=count)
    found = [(int(o), float(hits[o] / (areas[o] + charged[o])))
             for o in np.flatnonzero(areas >= min_area) if o > 0]
    is_false = (predicted_areas >= min_area) & (on_objects < MIN_OVERLAP * predicted_areas)
    return found, int(is_false[1:].sum())


def _groups(thing):
    """The groups of a synthetic drive's object, beside "all"."""
    distance, relation, kind = (thing[n] for n in ("distance_metres", "relation", "class"))
    yield f"relation {relation}"
    yield f"class {kind}"
    size = np.searchsorted([100, 400, 1600], thing["area_pixels"], side="right")
    yield "size " + ("under 100", "100-399", "400-1599", "from 1600")[size]
    place = np.searchsorted([20, 40], distance, side="right")
    yield "distance " + ("under 20 m", "20-40 m", "from 40 m")[place]
    if distance < 40:
        is_person = kind in ("pedestrian", "cyclist")
        yield f"{relation} within 40 m"
        yield "person or cyclist within 40 m" if is_person else "vehicle within 40 m"
        if not is_person:
            yield f"{relation} vehicle within 40 m"
    if kind == "pedestrian" and distance < 25:
        yield "person within 25 m"


class ObjectTally:
    """The objects of a drive that were found, by group, and the false ones.

    An object seen in ten frames counts ten times.
    """

    def __init__(self, iou_threshold):
        self.iou_threshold = iou_threshold
        self.ious = {}  # by group
        self.frames = self.false_objects = 0

    def add(self, found, false_objects, known=None):
        """known: properties of the frame's objects, by id."""
        self.frames += 1
        self.false_objects += false_objects
        for number, iou in found:
            thing = (known or {}).get(number)
            for group in ("all", *(_groups(thing) if thing else ())):
                self.ious.setdefault(group, []).append(iou)

    def to_json(self):
        levels = {"recall": self.iou_threshold, "recall_at_0.3": 0.3, "recall_at_0.5": 0.5}
        groups = {}
        for group, ious in sorted(self.ious.items()):
            recalls = {name: float(np.mean(np.array(ious) >= iou)) for name, iou in levels.items()}
            groups[group] = {"objects": len(ious), **recalls, "mean_iou": float(np.mean(ious))}
        return {"false_objects_per_frame": ratio(self.false_objects, self.frames),
                "object_recall": groups}


def object_tables(evaluations):
    """Movers found by group in maps and in masks, where the truth has groups.

    evaluations: (variant, eval.json) of each drive; all of a variant's drives together.
    """
    text = ""
    for title, place in (("movers in maps", "scores"), ("movers in masks", "masks")):
        rows = [{title: group, "variant": variant, "objects": own["objects"],
                 **{iou: own["objects"] * own[f"recall_at_{iou}"] for iou in (0.3, 0.5)}}
                for variant, evaluation in evaluations if evaluation[place]
                for group, own in evaluation[place]["object_recall"].items()]
        if len({row[title] for row in rows}) < 2:
            continue
        sums = pandas.DataFrame(rows).groupby([title, "variant"], sort=False).sum()
        table = sums.groupby(title).objects.max().to_frame()
        for variant in sums.index.unique("variant"):
            own = sums.xs(variant, level="variant")
            for iou in (0.3, 0.5):
                table[f"{variant}, IoU {iou}"] = own[iou] / own.objects
        text += to_text(table.reset_index(), 3)
    return text
