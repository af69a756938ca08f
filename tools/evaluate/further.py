"""Further truth in a drive's folder, beside masks and tracks, and how a run compares with it.

    boxes.csv        things in boxes (csv_truth): which of them are marked (box_scores)
    poses.txt        the camera's poses (KITTI's format, row k is frame k), camera.json its lens and
                     rate: against the run's trajectory.txt (TUM) and camera.json (trajectory)
    own_vehicle.png  255 on the own vehicle: its share that is marked
"""

from pathlib import Path

import numpy as np
import pandas

from . import trajectory
from .box_scores import BoxScores
from .csv_truth import read_boxes
from .files import UsageError, to_text
from .pixel_scores import ratio, threshold_of
from .truth import STATIC, read_mask

FILES = {"boxes": "boxes.csv", "poses": "poses.txt", "camera": "camera.json",
         "own_vehicle": "own_vehicle.png"}
NOMINAL_RATE = 10.0  # frames per second of a folder of images, as for segment
# Columns and headings. row_shift k: with row i of the poses taken for frame i + k.
CAMERA = {"rotation_degrees_per_second": "rotation d/s",
          "rotation_neighbours_degrees_per_second": "neighbours",
          "direction_degrees": "direction d", "focal_error_percent": "focal %",
          "own_vehicle_marked_share": "own marked", "row_shift": "row shift"}


def find_further_truth(frames):
    """Paths of the FILES beside the input: in the folder that holds frames/ or the video."""
    folder = Path(frames).absolute().parent
    return {name: folder / file for name, file in FILES.items() if (folder / file).is_file()}


def rate_of(truth):
    """Frames per second, by camera.json."""
    camera = trajectory.read_camera(truth["camera"]) if "camera" in truth else {}
    return camera.get("frames_per_second", 0) or NOMINAL_RATE


def score_further(run, truth, options):
    """The content of further.json; empty without any further truth. truth: paths by the names of
    FILES. InputError for missing and damaged files."""
    scores = {}
    if "boxes" in truth or "own_vehicle" in truth:
        scores |= _score_maps(run, truth, options)
    if "poses" in truth and (run.path / "trajectory.txt").exists():
        scores |= _score_trajectory(run, truth)
    if "camera" in truth and (run.path / "camera.json").exists():
        cameras = (trajectory.read_camera(p) for p in (run.path / "camera.json", truth["camera"]))
        scores["focal_error_percent"] = trajectory.focal_error_percent(*cameras)
    nothing = dict.fromkeys(("focal_error_percent", "own_vehicle_marked_share"))
    return nothing | scores if scores else {}


def _score_maps(run, truth, options):
    box_scores, shares = BoxScores(options.threshold), []
    boxes = dict(list(read_boxes(truth["boxes"]).groupby("frame"))) if "boxes" in truth else {}
    own = read_mask(truth["own_vehicle"]) != STATIC if "own_vehicle" in truth else None
    for line in run.scorable_lines():
        if line.of_prior and not options.with_prior or own is None and line.index not in boxes:
            continue
        grid = run.grid(line, options.pixels)
        probability, _ = run.maps(line, options.pixels)
        if line.index in boxes:
            box_scores.add(boxes[line.index], probability, grid)
        if own is not None:
            if own.shape != line.size:
                raise UsageError(f"the mask {truth['own_vehicle']} has another size than frame "
                                 f"{line.index}")
            marked = probability[grid.sample(own)] >= threshold_of(options.threshold)
            shares.append(ratio(marked.sum(), marked.size) or 0.0)
    scores = {"boxes": box_scores.to_json()} if box_scores.frames else {}
    return scores | ({"own_vehicle_marked_share": float(np.mean(shares))} if shares else {})


def _score_trajectory(run, truth):
    """With row k of the truth as frame k - 1 or k + 1, too, where that at least halves the rotation
    error: the truth's clock is then in doubt."""
    rate, poses = rate_of(truth), trajectory.read_kitti(truth["poses"])
    estimate = trajectory.by_frame(trajectory.read_tum(run.path / "trajectory.txt"),
                                   {line.index: line.time_seconds for line in run.lines})
    errors = {shift: trajectory.compare(
        estimate, {frame + shift: pose for frame, pose in poses.items()}, rate)
        for shift in (0, -1, 1)}
    rotation = {shift: found["rotation_degrees_per_second"] for shift, found in errors.items()}
    rotation = {shift: error for shift, error in rotation.items() if error is not None}
    best = min(rotation, key=rotation.get, default=0)
    scores = {"trajectory": errors[0]}
    if 0 in rotation and rotation[best] < rotation[0] / 2:
        scores |= {"trajectory_with_shifted_rows": errors[best], "row_shift": best}
    return scores


def camera_table(drives):
    """drives: (columns that name the drive, content of its further.json)."""
    rows = []
    for name, scores in drives:
        if scores.get("trajectory") or any(scores.get(column) is not None for column in CAMERA):
            rows.append(name | scores | scores.get("trajectory", {}) | {"row_shift": 0})
        if "row_shift" in scores:
            rows.append(name | scores | scores["trajectory_with_shifted_rows"])
    if not rows:
        return ""
    table = pandas.DataFrame(rows).reindex(columns=[*drives[0][0], *CAMERA])
    return to_text(table.rename(columns=CAMERA), 3)
