"""How many labelled boxes a map marks, by class, motion and distance, and which share of the area
outside all boxes it marks.

    marked   the mean of p over the box's middle is the threshold or more; the middle is the
             rectangle about the box's centre with 0.6 of each of its sides, clipped to the image,
             and p is interpolated linearly
    outside  the pixels of the map in no box at all

Boxes that are largely truncated or occluded, and boxes with unknown motion, unknown class, or a
middle outside the image are not counted as marked or not; they are no area outside, either.
"""

from collections import Counter

import numpy as np
import pandas

from .csv_truth import DISTANCES
from .drive_truth import interpolate
from .pixel_scores import FULL_PIXEL, ratio, threshold_of
from .texts import to_text

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


def in_box(box, grid):
    """The grid's pixels in the box."""
    rows, columns = (grid.y >= box.top) & (grid.y <= box.bottom), (
        grid.x >= box.left) & (grid.x <= box.right)
    return np.outer(rows, columns)


def in_middle(box, grid):
    def within(places, low, high):
        return abs(2 * places - low - high) <= MIDDLE * (high - low)

    return np.outer(within(grid.y, box.top, box.bottom), within(grid.x, box.left, box.right))


class BoxScores:
    def __init__(self, threshold):
        self.threshold = threshold
        self.boxes, self.marked = Counter(), Counter()  # by (kind, distance)
        self.frames = self.left_out = self.outside = self.outside_marked = 0

    def add(self, boxes, probability, grid):
        """One frame: its boxes and its map's 16-bit scores."""
        self.frames += 1
        outside = np.ones(probability.shape, bool)
        for box in boxes.itertuples():
            outside &= ~in_box(box, grid)
            hidden = box.truncated > MOST_HIDDEN or box.occluded > MOST_HIDDEN
            mean = None if hidden or not box.kind else mean_in_middle(box, probability, grid)
            if mean is None:
                self.left_out += 1
                continue
            for distance in ("all", box.distance):
                self.boxes[box.kind, distance] += 1
                self.marked[box.kind, distance] += mean >= self.threshold
        self.outside += int(outside.sum())
        self.outside_marked += int((probability[outside] >= threshold_of(self.threshold)).sum())

    def merge(self, other):
        self.boxes += other.boxes
        self.marked += other.marked
        for name in ("frames", "left_out", "outside", "outside_marked"):
            setattr(self, name, getattr(self, name) + getattr(other, name))

    def _distances(self):
        there = {distance for _, distance in self.boxes}
        return [distance for distance in ("all", *DISTANCES) if distance in there]

    def to_json(self):
        kinds = {kind: {distance: {"boxes": self.boxes[kind, distance],
                                   "marked": int(self.marked[kind, distance])}
                        for distance in sorted(self._distances()) if self.boxes[kind, distance]}
                 for kind in KINDS if self.boxes[kind, "all"]}
        return {"threshold": self.threshold, "frames": self.frames, "left_out": self.left_out,
                "kinds": kinds, "outside_pixels": self.outside,
                "outside_marked_share": ratio(self.outside_marked, self.outside) or 0.0}

    def table(self):
        distances = self._distances() or ["all"]
        rows = [kind for kind in KINDS if self.boxes[kind, "all"]]
        table = pandas.DataFrame({"boxes marked": rows})
        for distance in distances:
            pairs = [(self.marked[kind, distance], self.boxes[kind, distance]) for kind in rows]
            table[distance] = [f"{marked} of {boxes} {marked / boxes:.2f}" if boxes else "-"
                               for marked, boxes in pairs]
        share = ratio(self.outside_marked, self.outside) or 0.0
        return (f"{to_text(table)}{self.left_out} boxes left out (largely hidden, or class or "
                f"motion unknown); outside all boxes {share:.4f} is marked; {self.frames} "
                "frames\n")
