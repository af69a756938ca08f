"""Scores masks and numbers of `egosieve refine` against truth.

    J   IoU of the mask in frames with movers, mean over frames
    F   boundary measure, likewise
    T   temporal instability between consecutive frames, mean over pairs, and the same of the true
        masks
    ids IDF1 and HOTA, and the objects that were found, with the movers of ids as predicted objects,
        if the truth distinguishes its objects

Frames are added in their order. Void pixels are static in both masks.
"""

from .boundary import boundary_f
from .identity import Identity
from .objects import ObjectTally, score_objects
from .pixel_scores import mean_of
from .stability import describe_outline, outline_change
from .truth import DYNAMIC, VOID


class MaskScores:
    """min_area: pixels of the image below which an object is not counted."""

    def __init__(self, options):
        self.min_area = options.object_area
        self.frames, self.last = 0, None  # last: index and outlines of the frame before
        self.js, self.fs, self.ts, self.true_ts = {}, [], [], []  # js: by the frame's index
        self.objects = ObjectTally(options.object_iou)
        self.identity = Identity(self.min_area)

    def add(self, index, mask, truth, ids=None, true_ids=None, known=None):
        """mask: boolean. ids: numbers of objects, None: none. known: of the true objects."""
        void, real = truth == VOID, truth == DYNAMIC
        called = mask & ~void
        self.frames += 1
        if real.any():
            self.js[index] = (called & real).sum() / (called | real).sum()
            self.fs.append(boundary_f(called, real))
        outlines = describe_outline(called), describe_outline(real)
        if self.last and self.last[0] + 1 == index:
            for values, before, now in zip((self.ts, self.true_ts), self.last[1], outlines):
                values.append(outline_change(before, now))
        self.last = index, outlines
        if ids is not None and true_ids is not None:
            self.objects.add(*score_objects(ids, true_ids, void, self.min_area), known)
            self.identity.add(true_ids, ids, void)

    def to_json(self):
        return {"frames": self.frames, "j": mean_of(self.js.values()),
                "boundary_f": mean_of(self.fs),
                "temporal_instability": mean_of(self.ts),
                "temporal_instability_of_truth": mean_of(self.true_ts),
                "identity": self.identity.score(), **self.objects.to_json()}
