"""The truth of a drive in any form, beside the run's maps.

    masks       a folder of masks (truth_masks)
    synthetic   a folder that `egosieve synthesize` wrote, or its masks/: also has objects
    tracks      a file of labelled points (csv_truth): the map is interpolated linearly between grid
                pixels at each point; there are no outlines and no objects

Frame k of a track is the frame whose name has the number k, if the drive is a folder and all names
have different numbers; else the frame with index k.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.ndimage import map_coordinates

from .csv_truth import read_tracks
from .errors import UsageError
from .synthetic_truth import SyntheticTruth, drive_folder
from .truth_masks import (DYNAMIC, STATIC, frame_names, list_images, list_masks, number_in,
                          read_mask)
from .run_folder import read_image


def interpolate(image, grid, x, y):
    """A grid's map at pixels of the image, linearly; the last step of a grid may be shorter."""
    rows = np.interp(y, grid.y, np.arange(len(grid.y)))
    columns = np.interp(x, grid.x, np.arange(len(grid.x)))
    return map_coordinates(image, [rows, columns], output=float, order=1, mode="nearest")


@dataclass
class ScoredFrame:
    """A frame at the scored pixels; scattered points lie in one row, in no order."""

    index: int
    probability: np.ndarray  # 16-bit scores
    deviation: np.ndarray  # likewise; None: none
    truth: np.ndarray  # STATIC, VOID or DYNAMIC
    scattered: bool = False
    ids: np.ndarray = None  # numbers of movers; None: regions of the truth
    objects: dict = field(default_factory=dict)  # their properties


class DriveTruth:
    """frames: those with a truth. kind: masks, synthetic, tracks. matched_by: name, number, order.

    InputError for missing and damaged files; UsageError if frames cannot be matched as asked for.
    """

    def __init__(self, path, run, match="auto"):
        self.path = Path(path).absolute()
        self.synthetic = None
        self.points = self.masks = None
        if self.path.is_file():
            self._open_tracks(frame_names(run.input), match)
        else:
            self._open_masks(frame_names(run.input), [line.index for line in run.lines], match)
        self.scattered = self.points is not None

    def _open_tracks(self, names, match):
        points = read_tracks(self.path)
        if match == "order":
            raise UsageError("tracks name their frames and cannot be matched by order; leave "
                             "--match out")
        self.kind, numbers = "tracks", [number_in(name) for name in names]
        by_name = match != "number" and None not in numbers and len(set(numbers)) == len(numbers)
        self.matched_by = "name" if names and by_name else "number"
        index = {number: i for i, number in enumerate(numbers)} if self.matched_by == "name" else {}
        self.points = {}
        for number, own in points.groupby("frame"):
            behind = len(names) + number  # no frame has this index
            self.points[index.get(number, behind) if index else number] = own
        self.frames = set(self.points)

    def _open_masks(self, names, indices, match):
        folder, drive = self.path, drive_folder(self.path)
        self.kind = "synthetic" if drive else "masks"
        if drive:
            self.synthetic = SyntheticTruth(drive)
            folder = drive / "masks"
        self.matched_by, self.masks = list_masks(folder, names, match)
        if self.matched_by == "order":  # mask k belongs to the k-th frame of the run
            behind = (indices[-1] if indices else -1) + 1 - len(indices)
            self.masks = {indices[k] if k < len(indices) else k + behind: mask
                          for k, mask in self.masks.items()}
        self.frames = set(self.masks)

    def count_points(self):
        return sum(map(len, self.points.values())) if self.scattered else 0

    def mask(self, frame, size):
        """None if it differs in size, (height, width), from the frame."""
        mask = read_mask(self.masks[frame])
        return mask if mask.shape == size else None

    def objects(self, frame):
        return self.synthetic.objects.get(frame, {}) if self.synthetic else {}

    def moving_ids(self, frame, size):
        """None if the truth does not distinguish objects."""
        if not self.synthetic or frame not in self.synthetic.objects:
            return None
        ids = self.synthetic.moving_ids(frame)
        return ids if ids.shape == size else None

    def compare(self, line, grid, maps):
        """The frame's maps beside its truth; None if its mask has another size."""
        if self.scattered:
            return self._compare_points(line.index, grid, maps)
        size = (grid.height, grid.width)
        mask = self.mask(line.index, size)
        if mask is None:
            return None
        ids = self.moving_ids(line.index, size)
        return ScoredFrame(line.index, *maps, grid.sample(mask),
                           ids=None if ids is None else grid.sample(ids),
                           objects=self.objects(line.index))

    def inside(self, frame, grid):
        """The points of a frame that lie in the image."""
        own = self.points[frame]
        return own[own.x.between(0, grid.width - 1) & own.y.between(0, grid.height - 1)]

    def _compare_points(self, frame, grid, maps):
        own = self.inside(frame, grid)
        at = [None if m is None else np.floor(interpolate(m, grid, own.x, own.y) + 0.5).astype(int)
              for m in maps]
        truth = np.where(own.dynamic, DYNAMIC, STATIC)
        return ScoredFrame(frame, *at, truth, scattered=True)


def check_same_drive(run, truth):
    """UsageError if the truth belongs to other frames than the run's."""
    path = Path(truth).absolute()
    for beside in (path / "frames", path.parent / "frames"):
        if not beside.is_dir():
            continue
        if Path(run.input).exists() and beside.samefile(run.input):
            return
        if fingerprint(beside, int(run.flag("from", 0) or 0)) == run.fingerprint:
            return
        raise UsageError(f"the run in {run.path} is of {run.input}, the truth {truth} of {beside}, "
                         "which are other frames; give the truth of this drive")


def fingerprint(folder, first):
    """Of a folder's frames, as run.json holds it: the Fowler-Noll-Vo hash of a picture."""
    files = list_images(folder)
    if first >= len(files):
        return None
    value = 0xCBF29CE484222325
    for byte in read_image(files[first], 1).tobytes():  # 1: in colour, turned as the file says
        value = (value ^ byte) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
    return f"{value:016x}-{len(files)}"
