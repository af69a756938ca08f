"""Errors of an estimated trajectory and focal length.

Nothing is aligned: all figures are about relative motion in the camera's own axes, so the world's
frame and the trajectory's scale have no influence. R_i, c_i: rotation (world from camera) and
centre of frame i, at t_i seconds; ^ marks estimates.

    rotation    angle((R^_i^T R^_j)^T R_i^T R_j) / (t_j - t_i), degrees/s, j the first frame at
                least a second after i; its median over i. `neighbours` takes neighbouring frames
    direction   angle between R^_i^T (c^_j - c^_i) and R_i^T (c_j - c_i), degrees, j the first
                frame after i with |c_j - c_i| > 0.1 m; its median over the i that have such a j
                within a second. An estimate that does not travel is 90 degrees off
    focal       100 (f^ / w^) / (f / w) - 100, percent; w is the image's width in pixels

Only frames with both an estimate and a truth count.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from .files import InputError, read_json

SPAN_SECONDS = TRAVEL_SECONDS = 1.0
LEAST_TRAVEL_METRES = 0.1
MEDIANS = ("rotation_degrees_per_second", "rotation_neighbours_degrees_per_second",
           "direction_degrees")


def _rows(path, count):
    """Lines of `count` numbers; # begins a comment."""
    try:
        rows = np.loadtxt(path, ndmin=2).reshape(-1, count)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: {error}; a line must have {count} numbers") from None
    if not np.isfinite(rows).all():
        raise InputError(f"{path}: all numbers must be finite")
    return rows


def read_tum(path):
    """[(seconds, (rotation, centre))] of lines `seconds tx ty tz qx qy qz qw`, camera to world."""
    rows = _rows(path, 8)
    return [(row[0], (Rotation.from_quat(row[4:]).as_matrix(), row[1:4])) for row in rows]


def read_kitti(path):
    """{frame: (rotation, centre)} of lines with the 12 numbers of [R c], row by row."""
    rows = _rows(path, 12).reshape(-1, 3, 4)
    if (np.linalg.det(rows[:, :, :3]) <= 0).any():
        raise InputError(f"{path}: the first three columns of a row are no rotation")
    return {frame: (Rotation.from_matrix(row[:, :3]).as_matrix(), row[:, 3])
            for frame, row in enumerate(rows)}


def by_frame(timed, seconds):
    """Each pose at the frame with the nearest time, if that is less than half the smallest step
    away. seconds: by frame, increasing."""
    frames, times = np.array(list(seconds)), np.array(list(seconds.values()))
    half = np.diff(times).min() / 2 if len(times) > 1 else np.inf
    places = [np.argmin(abs(times - time)) for time, _ in timed]
    return {int(frames[place]): pose for place, (time, pose) in zip(places, timed)
            if abs(times[place] - time) < half}


def _relative(poses, i, j):
    """Rotations and ways from frames i to frames j, in the camera's axes of i."""
    turns, centres = poses
    back = turns[i].inv()
    return back * turns[j], back.apply(centres[j] - centres[i])


def _median(values):
    return float(np.median(values)) if len(values) else None


def _rotation_error(estimate, truth, times, span):
    later = np.searchsorted(times, times + span - 1e-9)
    later = np.maximum(later, np.arange(len(times)) + 1)
    i = np.flatnonzero(later < len(times))
    if not len(i):
        return None
    (turn, _), (true_turn, _) = (_relative(poses, i, later[i]) for poses in (estimate, truth))
    angles = np.degrees((turn.inv() * true_turn).magnitude())
    return _median(angles / (times[later[i]] - times[i]))


def _direction_errors(estimate, truth, times):
    pairs, centres = [], truth[1]
    for i, end in enumerate(np.searchsorted(times, times + TRAVEL_SECONDS + 1e-9, side="right")):
        way = np.linalg.norm(centres[i + 1:end] - centres[i], axis=1)
        pairs += [(i, i + 1 + j) for j in np.flatnonzero(way > LEAST_TRAVEL_METRES)[:1]]
    if not pairs:
        return []
    a, b = (_relative(poses, *np.transpose(pairs))[1] for poses in (estimate, truth))
    angles = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1))
    return np.where(a.any(axis=1), np.degrees(angles), 90.0)


def compare(estimate, truth, frames_per_second):
    frames = sorted(set(truth) & set(estimate))
    if not frames:
        return {"frames": 0, "travelling_pairs": 0} | dict.fromkeys(MEDIANS)
    times = np.array(frames) / frames_per_second
    both = [(Rotation.from_matrix([poses[frame][0] for frame in frames]),
             np.array([poses[frame][1] for frame in frames])) for poses in (estimate, truth)]
    directions = _direction_errors(*both, times)
    medians = (_rotation_error(*both, times, SPAN_SECONDS), _rotation_error(*both, times, 0.0),
               _median(directions))
    return {"frames": len(frames), "travelling_pairs": len(directions),
            **dict(zip(MEDIANS, medians))}


def read_camera(path):
    """camera.json of a run or of a drive's truth: focal_pixels, width, maybe frames_per_second."""
    camera = read_json(path)
    for name in ("focal_pixels", "width"):
        value = camera.get(name) if isinstance(camera, dict) else None
        if not isinstance(value, (int, float)) or not value > 0:
            raise InputError(f"{path}: {name} = {value}; it must be a positive number")
    return camera


def focal_error_percent(estimate, truth):
    """Signed."""
    ratio, true_ratio = (c["focal_pixels"] / c["width"] for c in (estimate, truth))
    return 100 * ratio / true_ratio - 100
