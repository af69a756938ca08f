"""How well numbers stay with their movers: IDF1 and HOTA of masks of numbered objects.

    s(i, j)   IoU of object i of the truth and object j of the prediction in one frame
    IDF1      the one-to-one assignment of whole tracks with the most frames in which s >= 1/2; IDTP
              of these, IDF1 = 2 IDTP / (truth's objects + predicted objects), summed over frames
    HOTA      per frame, the assignment with the largest sum of A(i, j) s(i, j), where
              m(i, j) = sum over frames of s(i, j) / (sum_k s(i, k) + sum_k s(k, j) - s(i, j)),
              A = m / (frames of i + frames of j - m); at each a of 0.05, 0.10, ..., 0.95 the pairs
              with s >= a are true positives TP, the others missed FN or false FP
              DetA = TP / (TP + FN + FP),  AssA = mean over TP of
              c / (frames of i + frames of j - c), c the frames in which i and j are a pair
              HOTA = mean over a of sqrt(DetA AssA)

Objects of the truth below `min_area` pixels are left out. So are predicted objects of which more
than half lies on such objects or on void pixels.

References: Ristani et al. (2016); Luiten et al., HOTA (2021), and its program TrackEval.
"""

import numpy as np
from scipy.optimize import linear_sum_assignment
from sklearn.metrics.cluster import contingency_matrix

THRESHOLDS = 0.05 * np.arange(1, 20)
SLACK = np.finfo(float).eps  # for rounding where similarities meet thresholds; as in TrackEval


def assign_largest(scores):
    """Pairs (rows, columns) of the largest total score; pairs of score 0 are not joined."""
    rows, columns = linear_sum_assignment(scores, maximize=True)
    joined = scores[rows, columns] > 0
    return rows[joined], columns[joined]


class Identity:
    def __init__(self, min_area):
        self.min_area = min_area
        self.truth, self.predicted = {}, {}  # index of a track by its number
        self.frames = []  # (tracks of the truth, tracks predicted, similarity)

    def add(self, truth, predicted, void):
        """Numbers of objects, 0: none. void: where the truth is unknown."""
        whole = np.bincount(truth.ravel())
        ignored = void | ((truth != 0) & (whole < self.min_area)[truth])
        real = np.where(ignored, 0, truth)
        numbers, called = np.unique(real), np.unique(predicted)
        common = contingency_matrix(real.ravel(), predicted.ravel())
        areas, called_areas = common.sum(axis=1), common.sum(axis=0)
        on_ignored = np.bincount(predicted[ignored], minlength=called[-1] + 1)[called]
        rows, columns = numbers != 0, (called != 0) & (2 * on_ignored <= called_areas)
        similarity = (common / (areas[:, None] + called_areas - common))[np.ix_(rows, columns)]
        tracks = [np.array([known.setdefault(n, len(known)) for n in ns.tolist()], int)
                  for known, ns in ((self.truth, numbers[rows]), (self.predicted, called[columns]))]
        self.frames.append((*tracks, similarity))

    def _association(self, pairs):
        """pairs / (frames of i + frames of j - pairs)."""
        truth, predicted = (np.bincount(np.concatenate([frame[side] for frame in self.frames]),
                                        minlength=n) for side, n in enumerate(pairs.shape))
        return pairs / np.maximum(truth[:, None] + predicted - pairs, 1e-300)

    def score(self):
        """None if neither has an object."""
        real = sum(len(frame[0]) for frame in self.frames)
        called = sum(len(frame[1]) for frame in self.frames)
        if real + called == 0:
            return None
        size = len(self.truth), len(self.predicted)
        matches, together = np.zeros(size), np.zeros(size)
        for i, j, s in self.frames:
            matches[np.ix_(i, j)] += s >= 0.5
            union = s.sum(1, keepdims=True) + s.sum(0, keepdims=True) - s
            together[np.ix_(i, j)] += np.divide(s, union, out=np.zeros_like(s), where=s > 0)
        alignment = self._association(together)
        pairs = np.zeros((len(THRESHOLDS), *size))
        for i, j, s in self.frames:
            rows, columns = assign_largest(alignment[np.ix_(i, j)] * s)
            is_pair = s[rows, columns] >= THRESHOLDS[:, None] - SLACK
            pairs[:, i[rows], j[columns]] += is_pair
        found = pairs.sum((1, 2))
        detection = found / (real + called - found)
        association = np.array([(p * self._association(p)).sum() for p in pairs])
        association /= np.maximum(found, 1)
        return {"idf1": float(2 * matches[assign_largest(matches)].sum() / (real + called)),
                "hota": float(np.sqrt(detection * association).mean()),
                "detection": float(detection.mean()), "association": float(association.mean()),
                "truth_objects": real, "predicted_objects": called}
