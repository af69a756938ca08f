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

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from .errors import InputError
from .run_folder import read_json

SPAN_SECONDS = TRAVEL_SECONDS = 1.0
LEAST_TRAVEL_METRES = 0.1


def _rows(path, count):
    """Lines of `count` finite numbers; # begins a comment."""
    rows = []
    if not Path(path).exists():
        raise InputError(f"there is no {path}")
    for number, line in enumerate(Path(path).read_text(errors="replace").split("\n"), 1):
        if not line.strip() or line.startswith("#"):
            continue
        try:
            row = [float(word) for word in line.split()]
        except ValueError as error:
            raise InputError(f"{path}, line {number}: {error}") from None
        if len(row) != count or not np.isfinite(row).all():
            raise InputError(f"{path}, line {number}: {len(row)} numbers; there must be {count}, "
                             "all finite")
        rows.append(row)
    return np.array(rows).reshape(-1, count)


def read_tum(path):
    """[(seconds, (rotation, centre))] of lines `seconds tx ty tz qx qy qz qw`, camera to world."""
    rows = _rows(path, 8)
    for row in rows:
        if not row[4:].any():
            raise InputError(f"{path}: the quaternion at {row[0]} s is zero")
    return [(row[0], (Rotation.from_quat(row[4:]).as_matrix(), row[1:4])) for row in rows]


def read_kitti(path):
    """{frame: (rotation, centre)} of lines with the 12 numbers of [R c], row by row."""
    poses = {}
    for frame, row in enumerate(_rows(path, 12).reshape(-1, 3, 4)):
        left, _, right = np.linalg.svd(row[:, :3])
        if np.linalg.det(row[:, :3]) <= 0:
            raise InputError(f"{path}, row {frame + 1}: the first three columns are no rotation")
        poses[frame] = left @ right, row[:, 3]
    return poses


def by_frame(timed, seconds):
    """Each pose at the frame with the nearest time, if that is less than half the smallest step
    away. seconds: by frame, increasing."""
    frames, times = np.array(list(seconds)), np.array(list(seconds.values()))
    half = np.diff(times).min() / 2 if len(times) > 1 else np.inf
    poses = {}
    for time, pose in timed:
        place = np.argmin(abs(times - time)) if len(times) else None
        if place is not None and abs(times[place] - time) < half:
            poses[int(frames[place])] = pose
    return poses


def _median(values):
    return float(np.median(values)) if values else None


def _rotation_error(pairs, span):
    errors = []
    for i, (start, (estimate, _), (truth, _)) in enumerate(pairs):
        for end, (later, _), (true_later, _) in pairs[i + 1:]:
            if end - start >= span - 1e-9:
                relative = (estimate.T @ later).T @ (truth.T @ true_later)
                angle = Rotation.from_matrix(relative).magnitude()
                errors.append(np.degrees(angle) / (end - start))
                break
    return _median(errors)


def _angle(a, b):
    if not a.any() or not b.any():
        return 90.0
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def _direction_errors(pairs):
    for i, (start, (estimate, here), (truth, true_here)) in enumerate(pairs):
        for end, (_, there), (_, true_there) in pairs[i + 1:]:
            if end - start > TRAVEL_SECONDS + 1e-9:
                break
            if np.linalg.norm(true_there - true_here) > LEAST_TRAVEL_METRES:
                yield _angle(estimate.T @ (there - here), truth.T @ (true_there - true_here))
                break


def compare(estimate, truth, frames_per_second):
    pairs = [(frame / frames_per_second, estimate[frame], pose)
             for frame, pose in sorted(truth.items()) if frame in estimate]
    directions = list(_direction_errors(pairs))
    return {"frames": len(pairs),
            "rotation_degrees_per_second": _rotation_error(pairs, SPAN_SECONDS),
            "rotation_neighbours_degrees_per_second": _rotation_error(pairs, 0.0),
            "travelling_pairs": len(directions),
            "direction_degrees": _median(directions)}


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
