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

from .synthetic_truth import is_person

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
    area, distance, relation = (thing[n] for n in ("area_pixels", "distance_metres", "relation"))
    yield f"relation {relation}"
    yield f"class {thing['class']}"
    yield ("size under 100" if area < 100 else "size 100-399" if area < 400 else
           "size 400-1599" if area < 1600 else "size from 1600")
    yield ("distance under 20 m" if distance < 20 else "distance 20-40 m" if distance < 40 else
           "distance from 40 m")
    if distance < 40:
        yield f"{relation} within 40 m"
        yield "person or cyclist within 40 m" if is_person(thing) else "vehicle within 40 m"
        if not is_person(thing):
            yield f"{relation} vehicle within 40 m"
    if thing["class"] == "pedestrian" and distance < 25:
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

    def merge(self, other):
        self.frames += other.frames
        self.false_objects += other.false_objects
        for group, ious in other.ious.items():
            self.ious[group] = self.ious.get(group, []) + ious

    def found(self, group="all", iou=None):
        """How many objects were found with this IoU, that of the options by default."""
        least = self.iou_threshold if iou is None else iou
        return int(np.sum(np.asarray(self.ious[group]) >= least))

    def recall(self, iou=None, group="all"):
        return self.found(group, iou) / len(self.ious[group]) if group in self.ious else None

    def false_per_frame(self):
        return self.false_objects / self.frames if self.frames else None

    def to_json(self):
        return {group: {"objects": len(ious), "recall": self.recall(None, group),
                        "recall_at_0.3": self.recall(0.3, group),
                        "recall_at_0.5": self.recall(0.5, group),
                        "mean_iou": float(np.mean(ious))}
                for group, ious in sorted(self.ious.items())}
