"""Binary truth against 16-bit scores: ranking, thresholds, calibration.

Scores are integers from 0 to 65535, so the counts of both classes by score hold all there is to
know: the figures are exact, and counts of frames and drives add. A pixel is called positive at
threshold v if its score is v or more.
"""

import numpy as np
from sklearn import metrics

from .run_folder import FULL_PIXEL

LEVELS = FULL_PIXEL + 1


def score_of(probability):
    """The 16-bit score of a probability, or of an array of them."""
    return np.floor(np.clip(probability, 0, 1) * FULL_PIXEL + 0.5).astype(np.int64)


def threshold_of(probability):
    """The smallest score that is not below the probability."""
    return int(np.ceil(np.clip(probability, 0, 1) * FULL_PIXEL))


def ratio(part, whole):
    return float(part / whole) if whole else None


def mean_of(values):
    values = [value for value in values if value is not None]
    return float(np.mean(values)) if values else None


class Counts:
    """Positives and negatives by score."""

    def __init__(self, scores=(), positive=()):
        scores, positive = np.asarray(scores, np.int64), np.asarray(positive, bool)
        self.positives = np.bincount(scores[positive], minlength=LEVELS)
        self.negatives = np.bincount(scores[~positive], minlength=LEVELS)

    def add(self, other):
        self.positives += other.positives
        self.negatives += other.negatives

    @property
    def both(self):
        """Whether both classes are there."""
        return self.positives.any() and self.negatives.any()

    def samples(self):
        """(truth, score, weight) of each class and occurring score, as scikit-learn wants them."""
        levels = np.flatnonzero(self.positives + self.negatives)
        truth = np.repeat([1, 0], len(levels))
        weights = np.concatenate([self.positives[levels], self.negatives[levels]])
        return truth, np.tile(levels, 2) / FULL_PIXEL, weights.astype(float)

    def _metric(self, function):
        if not self.both:
            return None
        truth, score, weight = self.samples()
        return float(function(truth, score, sample_weight=weight))

    def auc(self):
        return self._metric(metrics.roc_auc_score)

    def average_precision(self):
        return self._metric(metrics.average_precision_score)

    def at(self, threshold):
        """Ratios at a threshold; None where the denominator is 0."""
        tp, fp = self.positives[threshold:].sum(), self.negatives[threshold:].sum()
        fn, tn = self.positives[:threshold].sum(), self.negatives[:threshold].sum()
        return {"threshold": threshold / FULL_PIXEL, "iou": ratio(tp, tp + fp + fn),
                "f": ratio(2 * tp, 2 * tp + fp + fn), "precision": ratio(tp, tp + fp),
                "recall": ratio(tp, tp + fn), "false_positive_rate": ratio(fp, fp + tn)}

    def ious(self):
        """The IoU at each threshold; needs positives."""
        hits, alarms = (n[::-1].cumsum()[::-1] for n in (self.positives, self.negatives))
        return hits / (self.positives.sum() + alarms)

    def best_threshold(self):
        """The lowest threshold with the largest IoU; None without positives."""
        return int(np.argmax(self.ious())) if self.positives.any() else None

    def curve(self, points=200):
        """Rows of (threshold, false-positive rate, recall, precision), from nothing called positive
        to everything; about evenly spaced along the ROC curve. Empty without both classes.
        """
        if not self.both:
            return []
        levels = np.flatnonzero(self.positives + self.negatives)[::-1]
        hits, alarms = self.positives[levels].cumsum(), self.negatives[levels].cumsum()
        rates, recalls = alarms / alarms[-1], hits / hits[-1]
        rows, last, step = [(LEVELS / FULL_PIXEL, 0.0, 0.0, 1.0)], 0.0, 2 / max(1, points - 2)
        lengths = rates + recalls
        while last < lengths[-1]:
            # The first point a step away, else the end: where everything is called.
            place = np.flatnonzero((lengths - last >= step) | (lengths == lengths[-1]))[0]
            rows.append((levels[place] / FULL_PIXEL, rates[place], recalls[place],
                         hits[place] / (hits[place] + alarms[place])))
            last = lengths[place]
        return [tuple(map(float, row)) for row in rows]

    def calibration(self, bins=15):
        """Whether stated probabilities match frequencies; None without pixels.

        Log loss takes a stated 0 or 1 for half a step from it: a 0 is any value that rounds to it.
        ECE is that of Guo et al., On Calibration of Modern Neural Networks (2017), for two classes.
        """
        truth, stated, weight = self.samples()
        if not len(truth):
            return None
        half = 0.5 / FULL_PIXEL
        clipped = np.clip(stated, half, 1 - half)
        place = np.minimum((stated * bins).astype(int), bins - 1)
        pixels, sums, positives = (np.bincount(place, w, bins)
                                   for w in (weight, weight * stated, weight * truth))
        some = np.maximum(pixels, 1)
        rows = [{"low": b / bins, "high": (b + 1) / bins, "pixels": int(pixels[b]),
                 "mean_stated": float(sums[b] / some[b]),
                 "positive_share": float(positives[b] / some[b])} for b in range(bins)]
        return {"log_loss": float(metrics.log_loss(truth, clipped, sample_weight=weight)),
                "brier": float(metrics.brier_score_loss(truth, stated, sample_weight=weight)),
                "expected_calibration_error": float(abs(sums - positives).sum() / weight.sum()),
                "reliability": rows}
