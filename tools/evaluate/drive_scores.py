"""All figures of one run's maps against one truth, collected frame by frame.

Pooled figures are over all scored pixels together; mean figures are over the frames that have them.
Frames without movers have no AUC and no IoU; they give a false-positive rate at the declared
threshold, pooled over these frames. If the truth is scattered points, figures of outlines and
objects are absent. A figure is None whenever there are no data for it.
"""

import numpy as np

from .boundary import boundary_f
from .objects import ObjectTally, components_of, objects_of_map, score_objects
from .pixel_scores import FULL_PIXEL, Counts, mean_of, score_of, threshold_of
from .truth import DYNAMIC, VOID
from .uncertainty import Uncertainty

THRESHOLDS = np.round(0.05 * np.arange(1, 20), 2)  # at which the mean IoU over frames is also given
# A frame's figures: their names in files and headings in tables.
FIGURES = {"auc": "AUC", "average_precision": "AP", "iou": "IoU", "f": "F",
           "boundary_f": "bound. F", "best_iou": "best IoU", "false_positive_rate": "FP rate",
           "brier": "Brier", "log_loss": "log loss"}


class DriveScores:
    """options: threshold, object_low, object_high, object_iou. min_area: of the scored pixels."""

    def __init__(self, options, min_area):
        self.options, self.min_area = options, min_area
        self.threshold = threshold_of(options.threshold)
        self.pooled, self.without_movers = Counts(), Counts()
        self.uncertainty, self.class_uncertainty = (Uncertainty(self.threshold) for _ in range(2))
        self.has_deviation = False
        self.frames = []  # of each: index, numbers of pixels, FIGURES
        self.ious = []  # of each with movers, by THRESHOLDS
        self.objects = ObjectTally(options.object_iou)

    def add(self, frame):
        known = frame.truth != VOID
        score = frame.probability[known]
        positive = frame.truth[known] == DYNAMIC
        own = Counts(score, positive)
        self.pooled.add(own)
        p = score / FULL_PIXEL
        self.class_uncertainty.add(score, score_of(2 * np.sqrt(p * (1 - p))), positive)
        if frame.deviation is not None:
            self.has_deviation = True
            self.uncertainty.add(score, frame.deviation[known], positive)
        at, calibration = own.at(self.threshold), own.calibration()
        figures = dict.fromkeys(FIGURES) | {
            "index": frame.index, "dynamic_pixels": int(positive.sum()),
            "static_pixels": int((~positive).sum()), "void_pixels": int((~known).sum()),
            "auc": own.auc(), "average_precision": own.average_precision(),
            "false_positive_rate": at["false_positive_rate"],
            "brier": calibration["brier"], "log_loss": calibration["log_loss"]}
        outline = None if frame.scattered else self._score_regions(frame, ~known)
        if positive.any():
            ious = own.ious()
            self.ious.append(ious[[threshold_of(t) for t in THRESHOLDS]])
            figures |= {"iou": at["iou"], "f": at["f"], "best_iou": float(ious.max()),
                        "boundary_f": outline}
        else:
            self.without_movers.add(own)
        self.frames.append(figures)

    def _score_regions(self, frame, void):
        """Adds the objects; gives the boundary measure."""
        dynamic = frame.truth == DYNAMIC
        ids = components_of(dynamic) if frame.ids is None else frame.ids
        predicted = objects_of_map(np.where(void, -1, frame.probability),
                                   threshold_of(self.options.object_low),
                                   threshold_of(self.options.object_high))
        self.objects.add(*score_objects(predicted, ids, void, self.min_area), frame.objects)
        return boundary_f((frame.probability >= self.threshold) & ~void, dynamic)

    def mean(self, figure):
        return mean_of(frame[figure] for frame in self.frames)

    def to_json(self):
        best = self.pooled.best_threshold()
        ious = np.mean(self.ious, axis=0).tolist() if self.ious else []
        without_movers = self.without_movers.at(self.threshold)
        return {
            "pooled_auc": self.pooled.auc(),
            "mean_auc": self.mean("auc"),
            "average_precision": self.pooled.average_precision(),
            "mean_average_precision": self.mean("average_precision"),
            "at_declared_threshold": self.pooled.at(self.threshold),
            "at_best_threshold": None if best is None else self.pooled.at(best),
            "mean_iou": self.mean("iou"),
            "mean_f": self.mean("f"),
            "mean_best_iou": self.mean("best_iou"),
            "mean_iou_at_0.05_to_0.95": ious,
            "mean_iou_best_threshold": max(ious, default=None),
            "mean_boundary_f": self.mean("boundary_f"),
            "mean_brier": self.mean("brier"),
            "mean_log_loss": self.mean("log_loss"),
            "false_positive_rate_without_movers": without_movers["false_positive_rate"],
            "calibration": self.pooled.calibration(),
            "uncertainty": self.uncertainty.to_json() if self.has_deviation else None,
            "class_uncertainty": self.class_uncertainty.to_json(),
            "object_thresholds": [self.options.object_low, self.options.object_high],
            **self.objects.to_json(),
            "curve_threshold_fpr_recall_precision": self.pooled.curve(),
        }
