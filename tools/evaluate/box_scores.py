"""How many labelled boxes a map marks, by class, motion and distance, and which share of the area
outside all boxes it marks.

    marked   the mean of p over the box's middle is the threshold or more; the middle is the
             rectangle about the box's centre with 0.6 of each of its sides, clipped to the image,
             and p is interpolated linearly
    outside  the pixels of the map in no box at all

Boxes that are largely truncated or occluded, and boxes with unknown motion, unknown class, or a
middle outside the image are not counted as marked or not; they are no area outside, either.
"""

import numpy as np
import pandas

from .csv_truth import DISTANCES
from .files import to_text
from .pixel_scores import FULL_PIXEL, ratio, threshold_of
from .truth import interpolate

MIDDLE = 0.6
MOST_HIDDEN = 1  # the largest level of truncation and of occlusion that counts
KINDS = [f"{motion} {thing}" for motion in ("moving", "standing")
         for thing in ("vehicle", "person", "cyclist")]


def mean_in_middle(box, probability, grid):
    """None if the middle lies outside the image. probability: 16-bit scores."""
    sides = []
    for low, high, end in ((box.left, box.right, grid.width), (box.top, box.bottom, grid.height)):
        centre, half = (low + high) / 2, MIDDLE * (high - low) / 2
        sides.append(np.arange(max(0, np.ceil(centre - half)),
                               min(end - 1, np.floor(centre + half)) + 1))
    x, y = np.meshgrid(*sides)
    if not x.size:
        return None
    return float(interpolate(probability, grid, x.ravel(), y.ravel()).mean() / FULL_PIXEL)


class BoxScores:
    def __init__(self, threshold):
        self.threshold = threshold
        self.kinds = {}  # numbers of boxes by kind and distance
        self.frames = self.left_out = self.outside = self.outside_marked = 0

    def add(self, boxes, probability, grid):
        """One frame: its boxes and its map's 16-bit scores."""
        self.frames += 1
        outside = np.ones(probability.shape, bool)
        for box in boxes.itertuples():
            rows = (grid.y >= box.top) & (grid.y <= box.bottom)
            outside[np.ix_(rows, (grid.x >= box.left) & (grid.x <= box.right))] = False
            hidden = box.truncated > MOST_HIDDEN or box.occluded > MOST_HIDDEN
            mean = None if hidden or not box.kind else mean_in_middle(box, probability, grid)
            if mean is None:
                self.left_out += 1
                continue
            own = self.kinds.setdefault(box.kind, {})
            for distance in ("all", box.distance):
                counts = own.setdefault(distance, {"boxes": 0, "marked": 0})
                counts["boxes"] += 1
                counts["marked"] += int(mean >= self.threshold)
        self.outside += int(outside.sum())
        self.outside_marked += int((probability[outside] >= threshold_of(self.threshold)).sum())

    def to_json(self):
        return {"threshold": self.threshold, "frames": self.frames, "left_out": self.left_out,
                "kinds": self.kinds, "outside_pixels": self.outside,
                "outside_marked_share": ratio(self.outside_marked, self.outside) or 0.0}


def box_table(scores):
    """scores: to_json() of drives, which count together."""
    rows = [{"boxes marked": kind, "distance": distance, **counts} for one in scores
            for kind, own in one["kinds"].items() for distance, counts in own.items()]
    text = ""
    if rows:
        sums = pandas.DataFrame(rows).groupby(["boxes marked", "distance"]).sum()
        cells = [f"{marked} of {boxes} {marked / boxes:.2f}" for boxes, marked in sums.to_numpy()]
        table = sums.assign(cell=cells).cell.unstack()
        table = table.reindex(index=[kind for kind in KINDS if kind in table.index],
                              columns=[d for d in ("all", *DISTANCES) if d in table.columns])
        text = to_text(table.reset_index())
    drives = pandas.DataFrame(scores)
    pixels = drives.outside_pixels.sum()
    marked = (drives.outside_marked_share * drives.outside_pixels).sum() / max(1, pixels)
    return text + (f"{drives.left_out.sum()} boxes left out (largely hidden, or class or motion "
                   f"unknown); outside all boxes {marked:.4f} is marked; {drives.frames.sum()} "
                   "frames\n")
