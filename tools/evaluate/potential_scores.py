"""How well a run's potential (`egosieve segment --potential`) ranks standing things that could move
above the scenery: the area under the ROC curve at the grid's pixels, by kind of thing.

The truth is a synthetic drive, whose objects are known per pixel, or boxes. With boxes, a thing is
the middle of its box, and scenery is everything outside all boxes.
"""

import numpy as np

from .box_scores import in_box, in_middle
from .errors import UsageError
from .pixel_scores import Counts

VOID = "void"


def kinds_by_scene(truth, frame, grid):
    """The kind of each pixel of the grid; "": scenery."""
    ids = truth.ids(frame)
    if ids.shape != (grid.height, grid.width):
        raise UsageError(f"frame {frame} has {grid.width} x {grid.height} pixels, {truth.folder} "
                         "another size")
    ids = grid.sample(ids)
    kinds = np.full(ids.shape, "", object)
    for number, thing in truth.objects[frame].items():
        name = {"pedestrian": "person", "cyclist": "cyclist"}.get(thing["class"], "vehicle")
        kinds[ids == number] = f"{'moving' if thing['moving'] else 'standing'} {name}"
    return kinds


def kinds_by_boxes(boxes, grid):
    kinds = np.full((len(grid.y), len(grid.x)), "", object)
    for box in boxes.itertuples():
        inside, middle = in_box(box, grid), in_middle(box, grid)
        # Where boxes overlap, it is not known which of them hides the other.
        told = middle & (kinds == "") if box.kind else np.zeros_like(middle)
        kinds[inside & ~told] = VOID
        kinds[told] = box.kind
    return kinds


class PotentialScores:
    def __init__(self):
        self.frames = 0
        self.things, self.scenery = {}, Counts()

    def add(self, potential, kinds):
        """16-bit scores; the pixels' kinds."""
        self.frames += 1
        for kind in set(kinds.ravel()) - {VOID}:
            scores = potential[kinds == kind]
            counts = self.things.setdefault(kind, Counts()) if kind else self.scenery
            counts.add(Counts(scores, np.full(scores.size, bool(kind))))

    def _auc(self, kind):
        both = Counts()
        both.positives = self.things[kind].positives
        both.negatives = self.scenery.negatives
        return both.auc()

    def to_json(self):
        kinds = {kind: {"pixels": int(counts.positives.sum()), "auc": self._auc(kind)}
                 for kind, counts in sorted(self.things.items())}
        return {"frames": self.frames, "scenery_pixels": int(self.scenery.negatives.sum()),
                "kinds": kinds}

    def table(self):
        scores = self.to_json()
        return "".join(
            f"potential, {kind} against scenery: AUC {own['auc']:.4f} ({own['pixels']} and "
            f"{scores['scenery_pixels']} pixels of the grid, {self.frames} frames)\n"
            for kind, own in scores["kinds"].items() if own["auc"] is not None)
