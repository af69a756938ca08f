"""How well outlines agree: boundary measure F of DAVIS.

    boundary   pixels whose mask differs from the pixel to the right, below, or right below
    precision  share of the prediction's boundary within r pixels of the truth's
    recall     share of the truth's boundary within r pixels of the prediction's
    F = 2 precision recall / (precision + recall),   r = ceil(0.008 diagonal)

Both boundaries empty: F = 1; one empty: 0. Distances are Euclidean, between pixel centres.

Reference: Perazzi et al., A Benchmark Dataset and Evaluation Methodology for Video Object
Segmentation (CVPR 2016), section 4; as there, bipartite matching is approximated by dilation.
"""

import cv2
import numpy as np


def boundary_of(mask):
    padded = np.pad(mask, ((0, 1), (0, 1)), mode="edge")
    return (mask != padded[:-1, 1:]) | (mask != padded[1:, :-1]) | (mask != padded[1:, 1:])


def _share_near(boundary, other, radius):
    distance = cv2.distanceTransform((~other).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    # Squared distances are integers, so 0.5 allows for float32's rounding of the root.
    return float((distance[boundary] <= np.sqrt(radius**2 + 0.5)).mean())


def boundary_f(prediction, truth, share=0.008):
    """Boolean masks of one size."""
    called, real = boundary_of(prediction), boundary_of(truth)
    if not called.any() or not real.any():
        return float(called.any() == real.any())
    radius = np.ceil(share * np.hypot(*truth.shape))
    precision, recall = _share_near(called, real, radius), _share_near(real, called, radius)
    return 2 * precision * recall / (precision + recall) if precision + recall > 0 else 0.0
