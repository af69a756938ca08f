"""Whether the stated deviation is large where the map is wrong.

    error           e = |v - 65535 t| of a pixel with score v and truth t in {0, 1}
    sparsification  S(f) = mean error of the pixels that remain after the share f with the largest
                    deviation is removed, over the mean error of all; pixels of equal deviation are
                    removed together, in equal parts of error
    oracle          the same if the pixels with the largest error are removed first
    AUSE            integral over f from 0 to 1 of S - S_oracle: 0 for a perfect ranking
    error AUC       area under the ROC curve of the deviation as a score for "the pixel is wrong at
                    the threshold"

Reference: Ilg et al., Uncertainty Estimates and Multi-Hypotheses Networks for Optical Flow (2018).
"""

import numpy as np

from .pixel_scores import FULL_PIXEL, LEVELS, Counts


class _Removal:
    """Groups of pixels in the order of their removal: their numbers and sums of errors."""

    def __init__(self, pixels, errors):
        places = np.flatnonzero(pixels)[::-1]
        self.pixels, self.errors = pixels[places].astype(float), errors[places].astype(float)

    def area(self):
        """The integral over f of the mean remaining error.

        A group has k pixels with mean error g; before its removal there are n pixels with the sum
        E. After x of its pixels the mean is (E - g x) / (n - x):
            integral_0^k = g k + (E - g n) log(n / (n - k)),   g k for the last group (E = g n)
        """
        k, g = self.pixels, self.errors / self.pixels
        n = k[::-1].cumsum()[::-1]
        remaining = self.errors[::-1].cumsum()[::-1]
        curved = (remaining - g * n)[:-1] * np.log(n[:-1] / (n - k)[:-1])
        return (self.errors.sum() + curved.sum()) / n[0]

    def remaining(self, removed):
        """The mean error after the shares `removed`, below 1."""
        gone = np.asarray(removed) * self.pixels.sum()
        taken = np.interp(gone, np.append(0, self.pixels.cumsum()),
                          np.append(0, self.errors.cumsum()))
        return (self.errors.sum() - taken) / (self.pixels.sum() - gone)


class Uncertainty:
    """threshold: a pixel with this score or more is called dynamic."""

    def __init__(self, threshold):
        self.threshold = threshold
        self.pixels, self.error_sums = np.zeros(LEVELS, int), np.zeros(LEVELS, int)  # by deviation
        self.errors = np.zeros(LEVELS, int)  # pixels by error
        self.wrong = Counts()

    def add(self, scores, deviations, positive):
        errors = np.where(positive, FULL_PIXEL - scores, scores)
        self.pixels += np.bincount(deviations, minlength=LEVELS)
        self.error_sums += np.bincount(deviations, errors, LEVELS).astype(int)
        self.errors += np.bincount(errors, minlength=LEVELS)
        self.wrong.add(Counts(deviations, (scores >= self.threshold) != positive))

    def to_json(self, points=50):
        """sparsification: rows of (share removed, S, oracle)."""
        area, curve = None, []
        if self.error_sums.any():
            removals = (_Removal(self.pixels, self.error_sums),
                        _Removal(self.errors, self.errors * np.arange(LEVELS)))
            ranked, oracle = (removal.area() / removal.remaining(0) for removal in removals)
            area = float(ranked - oracle)
            shares = np.arange(points) / points
            remaining = [removal.remaining(shares) / removal.remaining(0) for removal in removals]
            curve = np.column_stack([shares, *remaining]).tolist()
        return {"area_under_sparsification_error": area, "error_auc": self.wrong.auc(),
                "sparsification": curve}
