"""Further truth in a drive's folder, beside masks and tracks, and how a run compares with it.

    boxes.csv        things in boxes (csv_truth): which of them are marked (box_scores)
    poses.txt        the camera's poses (KITTI's format, row k is frame k), camera.json its lens and
                     rate: against the run's trajectory.txt (TUM) and camera.json (trajectory)
    own_vehicle.png  255 on the own vehicle: its share that is marked
"""

from pathlib import Path

import numpy as np

from . import trajectory
from .box_scores import BoxScores
from .csv_truth import read_boxes
from .errors import UsageError
from .pixel_scores import ratio, threshold_of
from .truth_masks import STATIC, read_mask

FILES = {"boxes": "boxes.csv", "poses": "poses.txt", "camera": "camera.json",
         "own_vehicle": "own_vehicle.png"}


def find_further_truth(frames):
    """Paths of the FILES beside the input: in the folder that holds frames/ or the video."""
    folder = Path(frames).absolute().parent
    return {name: folder / file for name, file in FILES.items() if (folder / file).is_file()}


class FurtherScores:
    """boxes: BoxScores; figures: the rest of further.json."""

    def __init__(self):
        self.boxes = None
        self.figures = {"focal_error_percent": None, "own_vehicle_marked_share": None}

    def is_empty(self):
        return self.boxes is None and not any(value is not None for value in self.figures.values())

    def to_json(self):
        json = {"boxes": self.boxes.to_json()} if self.boxes else {}
        return json | self.figures

    def table(self):
        text = self.boxes.table() if self.boxes else ""
        for name, prefix in (("trajectory", ""), ("trajectory_with_shifted_rows",
                             "with row k of the poses taken for frame k{row_shift:+d}: ")):
            if name in self.figures:
                text += prefix.format(**self.figures) + _trajectory_text(self.figures[name])
        if (error := self.figures["focal_error_percent"]) is not None:
            text += f"focal length {error:+.2f} percent\n"
        if (share := self.figures["own_vehicle_marked_share"]) is not None:
            text += f"own vehicle: {share:.4f} of its pixels marked\n"
        return text


def _trajectory_text(errors):
    numbers = {name: "-" if value is None else f"{value:.3f}" for name, value in errors.items()}
    return ("rotation {rotation_degrees_per_second} degrees a second (neighbours "
            "{rotation_neighbours_degrees_per_second}), direction of travel {direction_degrees} "
            "degrees; medians, ").format(**numbers) + (
                f"{errors['frames']} frames, {errors['travelling_pairs']} travelling\n")


def score_further(run, truth, options):
    """truth: paths by the names of FILES. InputError for missing and damaged files."""
    scores = FurtherScores()
    boxes = read_boxes(truth["boxes"]) if "boxes" in truth else None
    if boxes is not None or "own_vehicle" in truth:
        _score_maps(run, boxes, truth.get("own_vehicle"), options, scores)
    camera = trajectory.read_camera(truth["camera"]) if "camera" in truth else None
    if "poses" in truth and run.file("trajectory.txt").exists():
        rate = (camera or {}).get("frames_per_second", 0)
        _score_trajectory(run, truth["poses"], rate if rate > 0 else options.poses_fps, scores)
    if camera and run.file("camera.json").exists():
        estimate = trajectory.read_camera(run.file("camera.json"))
        scores.figures["focal_error_percent"] = trajectory.focal_error_percent(estimate, camera)
    return scores


def _score_maps(run, boxes, own_vehicle, options, scores):
    box_scores = BoxScores(options.threshold)
    of_frame = dict(list(boxes.groupby("frame"))) if boxes is not None else {}
    own = read_mask(own_vehicle) != STATIC if own_vehicle else None
    shares = []
    for line in run.scorable_lines():
        if line.of_prior and not options.with_prior:
            continue
        if line.index not in of_frame and own is None:
            continue
        grid = run.grid(line, options.pixels)
        probability, _ = run.maps(line, options.pixels)
        if line.index in of_frame:
            box_scores.add(of_frame[line.index], probability, grid)
        if own is not None:
            if own.shape != (grid.height, grid.width):
                raise UsageError(f"the mask {own_vehicle} has another size than frame {line.index}")
            marked = probability[grid.sample(own)] >= threshold_of(options.threshold)
            shares.append(ratio(marked.sum(), marked.size) or 0.0)
    if box_scores.frames:
        scores.boxes = box_scores
    if shares:
        scores.figures["own_vehicle_marked_share"] = float(np.mean(shares))


def _score_trajectory(run, path, rate, scores):
    """With row k of the truth as frame k - 1 or k + 1, too, where that at least halves the rotation
    error: the truth's clock is then in doubt."""
    if not rate > 0:
        raise UsageError(f"--poses-fps={rate}; it must be positive")
    truth = trajectory.read_kitti(path)
    estimate = trajectory.by_frame(trajectory.read_tum(run.file("trajectory.txt")),
                                   {line.index: line.seconds for line in run.lines})
    scores.figures = {"trajectory": trajectory.compare(estimate, truth, rate)} | scores.figures
    name = "rotation_degrees_per_second"
    best = scores.figures["trajectory"][name]
    limit = None if best is None else best / 2
    for shift in (-1, 1):
        moved = {frame + shift: pose for frame, pose in truth.items()}
        errors = trajectory.compare(estimate, moved, rate)
        if limit is not None and errors[name] is not None and errors[name] < limit:
            limit = errors[name]
            scores.figures |= {"trajectory_with_shifted_rows": errors, "row_shift": shift}
