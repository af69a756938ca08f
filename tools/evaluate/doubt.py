"""Whether the maps' expected IoU (`expected_overlap` of frames.jsonl) tells which masks are bad."""

import numpy as np
from sklearn.metrics import roc_auc_score

BAD = 0.3  # J of a mask
LEVELS = 0.3, 0.4, 0.5


def describe(frames):
    """A line for people; empty unless some masks are bad and some are not.

    frames: (J of the mask, expected IoU of the map) of each frame with movers and a map.
    """
    j, expected = np.array([frame for frame in frames if None not in frame]).reshape(-1, 2).T
    bad = j < BAD
    if bad.all() or not bad.any():
        return ""
    auc = roc_auc_score(bad, -expected)
    shares = "; ".join(f"below {level:.1f} {(expected[bad] < level).mean():.3f} of these and "
                       f"{(expected[~bad] < level).mean():.3f} of the others" for level in LEVELS)
    return (f"{bad.sum()} of {len(bad)} frames have a mask J below {BAD}; the expected IoU ranks "
            f"them with an AUC of {auc:.3f}: {shares}\n")
