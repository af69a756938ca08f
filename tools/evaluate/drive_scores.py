"""All figures of one run's maps against one truth, collected frame by frame.

Pooled figures are over all scored pixels together; mean figures are over the frames that have them.
Frames without movers have no AUC and no IoU; they give a false-positive rate at the declared
threshold, pooled over these frames. If the truth is scattered points, figures of outlines and
objects are absent. A figure is None whenever there are no data for it.
"""

import numpy as np

from .boundary import boundary_f
from .objects import ObjectTally, components_of, objects_of_map, score_objects
from .pixel_scores import FULL_PIXEL, Counts, score_of, threshold_of
from .truth_masks import DYNAMIC, VOID
from .uncertainty import Uncertainty

THRESHOLDS = np.round(0.05 * np.arange(1, 20), 2)  # at which the mean IoU over frames is also given
# A frame's figures: their names in files and headings in tables.
FIGURES = {"auc": "AUC", "average_precision": "AP", "iou": "IoU", "f": "F",
           "boundary_f": "bound. F", "best_iou": "best IoU", "false_positive_rate": "FP rate",
           "brier": "Brier", "log_loss": "log loss"}


def class_deviation(scores):
    """2 sqrt(p (1 - p)), the deviation of the class, which follows from the probability."""
    p = scores / FULL_PIXEL
    return score_of(2 * np.sqrt(p * (1 - p)))


class DriveScores:
    """options: threshold, object_low, object_high, object_iou. min_area: of the scored pixels."""

    def __init__(self, options, min_area):
        self.options, self.min_area = options, min_area
        self.threshold = threshold_of(options.threshold)
        self.pooled = Counts()
        self.uncertainty, self.class_uncertainty = (Uncertainty(self.threshold) for _ in range(2))
        self.has_deviation = False
        self.frames = []  # of each: index, numbers of pixels, FIGURES, ious by THRESHOLDS
        self.objects = ObjectTally(options.object_iou)
        self.without_movers = Counts()

    def add(self, frame):
        known = frame.truth != VOID
        score = frame.probability[known].astype(np.int64)
        positive = frame.truth[known] == DYNAMIC
        own = Counts(score, positive)
        self.pooled.add(own)
        self.class_uncertainty.add(score, class_deviation(score), positive)
        if frame.deviation is not None:
            self.has_deviation = True
            self.uncertainty.add(score, frame.deviation[known].astype(np.int64), positive)
        figures = {"index": frame.index, "dynamic_pixels": int(positive.sum()),
                   "static_pixels": int((~positive).sum()), "void_pixels": int((~known).sum()),
                   **self._figures(own)}
        if not frame.scattered:
            outline = self._score_regions(frame, ~known)
            figures["boundary_f"] = outline if positive.any() else None
        if not positive.any():
            self.without_movers.add(own)
        self.frames.append(figures)

    def _figures(self, own):
        at, calibration = own.at(self.threshold), own.calibration()
        figures = dict.fromkeys(FIGURES) | {
            "auc": own.auc(), "average_precision": own.average_precision(),
            "false_positive_rate": at["false_positive_rate"],
            "brier": calibration["brier"], "log_loss": calibration["log_loss"]}
        if own.positives.any():
            ious = own.ious()
            figures |= {"iou": at["iou"], "f": at["f"], "best_iou": float(ious.max()),
                        "ious": ious[[threshold_of(t) for t in THRESHOLDS]]}
        return figures

    def _score_regions(self, frame, void):
        """Adds the objects; gives the boundary measure."""
        dynamic = frame.truth == DYNAMIC
        ids = components_of(dynamic) if frame.ids is None else frame.ids
        predicted = objects_of_map(np.where(void, -1, frame.probability.astype(np.int64)),
                                   threshold_of(self.options.object_low),
                                   threshold_of(self.options.object_high))
        self.objects.add(*score_objects(predicted, ids, void, self.min_area), frame.objects)
        return boundary_f((frame.probability >= self.threshold) & ~void, dynamic)

    def merge(self, other):
        self.pooled.add(other.pooled)
        self.uncertainty.merge(other.uncertainty)
        self.class_uncertainty.merge(other.class_uncertainty)
        self.has_deviation |= other.has_deviation
        self.frames = self.frames + other.frames
        self.objects.merge(other.objects)
        self.without_movers.add(other.without_movers)

    def mean(self, figure):
        values = [frame[figure] for frame in self.frames if frame[figure] is not None]
        return float(np.mean(values)) if values else None

    def mean_ious(self):
        """Over the frames with movers, by THRESHOLDS; empty without such frames."""
        rows = [frame["ious"] for frame in self.frames if "ious" in frame]
        return np.mean(rows, axis=0).tolist() if rows else []

    def false_positive_rate_without_movers(self):
        return self.without_movers.at(self.threshold)["false_positive_rate"]

    def to_json(self):
        best = self.pooled.best_threshold()
        by_class = self.class_uncertainty
        uncertainty = {"area_under_sparsification_error": self.uncertainty.ause(),
                       "error_auc": self.uncertainty.error_auc(),
                       "sparsification": self.uncertainty.curve()}
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
            "mean_iou_at_0.05_to_0.95": self.mean_ious(),
            "mean_boundary_f": self.mean("boundary_f"),
            "false_positive_rate_without_movers": self.false_positive_rate_without_movers(),
            "calibration": self.pooled.calibration(),
            "uncertainty": uncertainty if self.has_deviation else None,
            "class_uncertainty": {"area_under_sparsification_error": by_class.ause(),
                                  "error_auc": by_class.error_auc()},
            "object_thresholds": [self.options.object_low, self.options.object_high],
            "false_objects_per_frame": self.objects.false_per_frame(),
            "object_recall": self.objects.to_json(),
            "curve_threshold_fpr_recall_precision": self.pooled.curve(),
        }

    def summary(self):
        """The main figures for people, one per line."""
        scores, ious = self.to_json(), self.mean_ious()
        best = f"{THRESHOLDS[np.argmax(ious)]:.2f}" if ious else ""
        uncertainty = scores["uncertainty"] or dict.fromkeys(
            ("area_under_sparsification_error", "error_auc"))
        calibration = scores["calibration"]
        figures = (
            ("average precision, pooled", scores["average_precision"]),
            ("average precision, mean over frames", scores["mean_average_precision"]),
            ("mean IoU over frames, declared threshold", scores["mean_iou"]),
            ("mean F over frames, declared threshold", scores["mean_f"]),
            ("mean IoU over frames, each frame's best threshold", scores["mean_best_iou"]),
            (f"mean IoU over frames, best one threshold ({best}):", max(ious, default=None)),
            ("mean boundary F, declared threshold", scores["mean_boundary_f"]),
            ("false-positive rate on frames without movers",
             scores["false_positive_rate_without_movers"]),
            ("calibration: ECE", calibration["expected_calibration_error"]),
            ("calibration: Brier", calibration["brier"]),
            ("calibration: log loss", calibration["log_loss"]),
            ("area under the sparsification error", uncertainty["area_under_sparsification_error"]),
            ("AUC of the deviation for finding errors", uncertainty["error_auc"]),
            ("AUC of the class's deviation, sqrt(p (1 - p)), for finding errors",
             scores["class_uncertainty"]["error_auc"]),
            ("false objects per frame", scores["false_objects_per_frame"]))
        lines = [f"{name} {value:.4f}" for name, value in figures if value is not None]
        for name in ("declared", "best"):
            at = scores[f"at_{name}_threshold"] or {"iou": None}
            if at["iou"] is not None:
                ratios = (f"{key.replace('_', ' ')} {value:.4f}" for key, value in at.items()
                          if key != "threshold" and value is not None)
                lines.append(f"{name} threshold {at['threshold']:.2f}, pooled: {', '.join(ratios)}")
        lines += [f"objects, {group}: {self.objects.found(group)} of {len(found)} found (IoU "
                  f"{self.objects.iou_threshold:.2f})"
                  for group, found in sorted(self.objects.ious.items())]
        return "".join(f"{line}\n" for line in lines)
