"""How much an outline changes its shape between frames: the temporal instability T of DAVIS.

    contour      the longest outline of the mask, as a polygon within 3 pixels of it, with points at
                 most 3 pixels apart
    descriptor   shape context of each point: the positions of the contour's points relative to it,
                 in 12 directions and 5 rings; the rings' outer radii are spaced evenly in their
                 logarithms from 1/8 to 2 mean distances between points
    c(i, j)      1/2 sum (h_i - h_j)^2 / (h_i + h_j), h normalised to sum 1
    matching     the monotone path of least cost through c (dynamic time warping), begun at the two
                 contours' first points; then again, begun at that path's best pair
    T            mean cost of the path's pairs, each point kept only in its best pair

T is 0 if the shape only moves, turns little and grows; flickering or boiling masks have a large T.
The T of the truth tells how much the object itself deforms.

Reference: Perazzi et al., A Benchmark Dataset and Evaluation Methodology for Video Object
Segmentation (CVPR 2016), section 4, and its program.
"""

import cv2
import numpy as np

TOLERANCE_PIXELS = SPACING_PIXELS = 3
DIRECTIONS, RINGS = 12, 5
INNER_RADIUS, OUTER_RADIUS = 0.125, 2  # mean distances


def _sample_contour(mask):
    contours, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    if not contours:
        return np.empty((0, 2))
    polygon = cv2.approxPolyDP(max(contours, key=len), TOLERANCE_PIXELS, True)[:, 0].astype(float)
    sides = np.roll(polygon, -1, axis=0) - polygon
    pieces = np.maximum(1, np.ceil(np.hypot(*sides.T) / SPACING_PIXELS)).astype(int)
    place = np.concatenate([np.arange(n) / n for n in pieces])
    return np.repeat(polygon, pieces, axis=0) + np.repeat(sides, pieces, axis=0) * place[:, None]


def describe_outline(mask):
    """A descriptor a row, float32; no row if the mask has no contour."""
    points = _sample_contour(mask)
    count = len(points)
    if not count:
        return np.empty((0, DIRECTIONS * RINGS), np.float32)
    x, y = (axis[None, :] - axis[:, None] for axis in points.T)
    distance = np.sqrt(x * x + y * y)
    edges = distance.mean() * np.geomspace(INNER_RADIUS, OUTER_RADIUS, RINGS)
    ring = np.searchsorted(edges, distance, side="right")
    turn = np.arctan2(y, x) / (2 * np.pi)
    direction = np.minimum(((turn - np.floor(turn)) * DIRECTIONS).astype(int), DIRECTIONS - 1)
    place = np.arange(count)[:, None] * DIRECTIONS * RINGS + direction * RINGS + ring
    bins = np.bincount(place[ring < RINGS], minlength=count * DIRECTIONS * RINGS)
    contexts = bins.reshape(count, -1).astype(np.float32)
    return contexts / np.maximum(contexts.sum(axis=1, keepdims=True), 1)


def _costs(before, now):
    cost = np.zeros((len(before), len(now)), np.float32)
    for a, b in zip(before.T, now.T):
        difference = a[:, None] - b
        cost += difference * difference / (a[:, None] + b + np.float32(1e-20))
    return cost / 2


def _least_path(cost):
    """Pairs (i, j) of the path of least cost from the last pair to the first."""
    rows, columns = cost.shape
    total = np.full((rows + 1, columns + 1), np.inf)
    total[0, 0] = 0
    flat, width = total.reshape(-1), columns + 1
    for diagonal in range(rows + columns - 1):  # independent of each other: a diagonal at a time
        i = np.arange(max(0, diagonal - columns + 1), min(rows, diagonal + 1))
        j = diagonal - i
        at = (i + 1) * width + j + 1
        best = np.minimum(np.minimum(flat[at - 1], flat[at - width]), flat[at - width - 1])
        flat[at] = best + cost[i, j]
    i, j = rows, columns
    path = [(i - 1, j - 1)]
    while (i, j) != (1, 1):
        corner, up, left = total[i - 1, j - 1], total[i - 1, j], total[i, j - 1]
        if corner <= min(up, left):
            i, j = i - 1, j - 1
        else:
            i, j = (i - 1, j) if up <= left else (i, j - 1)
        path.append((i - 1, j - 1))
    return np.array(path)


def _keep_best(pairs, cost, column):
    """Of the pairs with the same point of a contour, the first of the cheapest."""
    order = np.lexsort((cost[tuple(pairs.T)], pairs[:, column]))
    _, first = np.unique(pairs[order, column], return_index=True)
    return pairs[order][first]


def outline_change(before, now):
    """T between the descriptors of consecutive frames; None if one has no contour."""
    if not len(before) or not len(now):
        return None
    cost = _costs(before, now)
    path = _least_path(cost)
    start = path[np.argmin(cost[tuple(path.T)])]
    pairs = _least_path(np.roll(cost, tuple(-start), axis=(0, 1)))
    pairs = (pairs + start) % cost.shape
    pairs = _keep_best(_keep_best(pairs, cost, 0), cost, 1)
    return float(cost[tuple(pairs.T)].mean(dtype=float))
