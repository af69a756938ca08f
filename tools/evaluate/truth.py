"""The truth of a drive's pixels in any form, beside the run's maps.

    masks       a folder of masks. A pixel is 0 static, 128 void (unknown), else dynamic; one of a
                colour mask is dynamic if any channel is not 0 (void: all channels 128)
    synthetic   a folder that `egosieve synthesize` wrote, or its masks/: objects, too, with their
                numbers by pixel (ids/) and class, relation, moving, distance_metres, area_pixels
    tracks      a file of labelled points (csv_truth): the map is interpolated linearly between grid
                pixels at each point; there are no outlines and no objects

A mask belongs to a frame by name, if the input was a folder and every mask has the name, without
extension, of a frame in it; else by number, if every mask's name has one (its last run of digits)
and all differ; else by order, if there are as many masks as frames, as far as these are known: the
k-th file in natural order is the mask of the k-th frame. Frame k of a track is the frame whose name
has the number k, if the drive is a folder and all names have different numbers; else the frame with
index k.
"""

import re
from dataclasses import dataclass, field
from itertools import chain, count
from pathlib import Path

import cv2
import numpy as np
from scipy.ndimage import map_coordinates

from .csv_truth import read_tracks
from .files import InputError, UsageError, read_image, read_json, read_numbers

STATIC, VOID, DYNAMIC = 0, 128, 255
EXTENSIONS = {".png", ".jpg", ".jpeg", ".jpe", ".bmp", ".tif", ".tiff", ".pgm", ".ppm", ".pnm",
              ".pbm", ".webp", ".jp2"}


def _natural_key(path):
    """Characters in their order, but runs of digits by their numbers."""
    parts = re.findall(r"\d+|\D", path.name, re.ASCII | re.DOTALL)
    return [(ord("0"), int(part)) if part.isdecimal() else (ord(part), 0) for part in parts]


def list_images(folder):
    """In natural order; empty if there are none, or no folder."""
    files = sorted(Path(folder).iterdir()) if Path(folder).is_dir() else []
    images = [path for path in files if path.is_file() and path.name[0] != "."
              and path.suffix.lower() in EXTENSIONS]
    return sorted(images, key=_natural_key)


def _numbers_in(names):
    """Places of names by their last run of digits; empty if a name has none or two are equal."""
    found = [re.findall(r"\d+", name) for name in names]
    places = {int(digits[-1]): place for place, digits in enumerate(found) if digits}
    return places if len(places) == len(names) else {}


def list_masks(folder, names, indices=()):
    """(matched by name, number or order; paths by frame). names: of the input's frames, without
    extension. indices: of the run's frames."""
    files = list_images(folder)
    if not files:
        what = "image in" if Path(folder).is_dir() else "folder"
        raise InputError(f"no {what} {folder}; give the folder of masks to --truth")
    index = {name: i for i, name in enumerate(names)}
    by_name = {index.get(file.stem): file for file in files}
    if None not in by_name and len(by_name) == len(files):
        return "name", by_name
    if numbers := _numbers_in([file.stem for file in files]):
        return "number", {number: files[place] for number, place in numbers.items()}
    if names and len(names) != len(files):
        raise UsageError(f"the {len(files)} masks in {folder} have neither the names nor the "
                         f"numbers of the {len(names)} frames; rename them")
    frames = chain(indices, count(indices[-1] + 1 if indices else 0))
    return "order", dict(zip(frames, files))


def read_mask(path):
    """STATIC, VOID or DYNAMIC per pixel."""
    image = read_image(path, cv2.IMREAD_ANYCOLOR | cv2.IMREAD_ANYDEPTH)
    if image.dtype != np.uint8:
        raise InputError(f"the mask {path} has no 8-bit pixels; remove or replace it")
    image = image.reshape(*image.shape[:2], -1)
    truth = np.full(image.shape[:2], DYNAMIC, np.uint8)
    truth[(image == STATIC).all(axis=2)] = STATIC
    truth[(image == VOID).all(axis=2)] = VOID
    return truth


def interpolate(image, grid, x, y):
    """A grid's map at pixels of the image, linearly; the last step of a grid may be shorter."""
    rows = np.interp(y, grid.y, np.arange(len(grid.y)))
    columns = np.interp(x, grid.x, np.arange(len(grid.x)))
    return map_coordinates(image, [rows, columns], output=float, order=1, mode="nearest")


@dataclass
class ScoredFrame:
    """A frame at the scored pixels; points lie in one row, in no order."""

    index: int
    probability: np.ndarray  # 16-bit scores
    deviation: np.ndarray  # likewise; None: none
    truth: np.ndarray  # STATIC, VOID or DYNAMIC
    scattered: bool = False
    ids: np.ndarray = None  # numbers of movers; None: regions of the truth
    objects: dict = field(default_factory=dict)  # their properties


class DriveTruth:
    """frames: those with a truth. kind: masks, synthetic, tracks. matched_by: name, number, order.
    points: of tracks, by frame. objects: of a synthetic drive, by frame and number.

    InputError for missing and damaged files; UsageError if frames cannot be matched.
    """

    def __init__(self, path, run):
        self.path = Path(path).absolute()
        self.points, self.masks, self.objects = {}, {}, {}
        names = [image.stem for image in list_images(run.input)]
        if self.path.is_file():
            self._open_tracks(names)
        else:
            self._open_masks(names, [line.index for line in run.lines])
        self.scattered = self.kind == "tracks"
        self.frames = {**self.points, **self.masks}.keys()

    def _open_tracks(self, names):
        place = _numbers_in(names)
        self.kind, self.matched_by = "tracks", "name" if place else "number"
        for number, own in read_tracks(self.path).groupby("frame"):
            # Of no frame: behind all of them.
            index = place.get(number, len(names) + number) if place else number
            self.points[index] = own

    def _open_masks(self, names, indices):
        self.kind, folder = "masks", self.path
        for drive in (self.path, self.path.parent):
            if (drive / "scene.json").exists() and self.path in (drive, drive / "masks"):
                self.kind, self.drive, folder = "synthetic", drive, drive / "masks"
                self.objects = {frame["index"]: {o["id"]: o for o in frame["objects"]}
                                for frame in read_json(drive / "scene.json")["frames"]}
        self.matched_by, self.masks = list_masks(folder, names, indices)

    def mask(self, line):
        mask = read_mask(self.masks[line.index])
        if mask.shape != line.size:
            raise UsageError(f"the mask {self.masks[line.index]} has another size than its frame; "
                             "give the masks of this drive")
        return mask

    def moving_ids(self, line):
        """Numbers of movers by pixel, 0: none. None if the truth does not distinguish objects."""
        if line.index not in self.objects:
            return None
        ids = read_numbers(self.drive / "ids" / f"{line.index:06d}.png", line.size)
        moving = [number for number, o in self.objects[line.index].items() if o["moving"]]
        return np.where(np.isin(ids, moving), ids, 0)

    def compare(self, line, grid, maps):
        """The frame's maps beside its truth."""
        if self.scattered:
            return self._compare_points(line.index, grid, maps)
        ids = self.moving_ids(line)
        return ScoredFrame(line.index, *maps, grid.sample(self.mask(line)),
                           ids=None if ids is None else grid.sample(ids),
                           objects=self.objects.get(line.index, {}))

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
    places = (folder / "frames" for folder in (path, path.parent))
    beside = next((place for place in places if place.is_dir()), None)
    if not beside or run.input.exists() and beside.samefile(run.input):
        return
    first = int(run.description["flags"].get("from", 0) or 0)
    if _fingerprint(beside, first) != run.description["input"]["fingerprint"]:
        raise UsageError(f"the run in {run.path} is of {run.input}, the truth {truth} of "
                         f"{beside}, which are other frames; give the truth of this drive")


def _fingerprint(folder, first):
    """Of a folder's frames, as run.json holds it: the Fowler-Noll-Vo hash of a picture."""
    files = list_images(folder)
    if first >= len(files):
        return None
    value = 0xCBF29CE484222325
    for byte in read_image(files[first], cv2.IMREAD_COLOR).tobytes():  # turned as the file says
        value = (value ^ byte) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
    return f"{value:016x}-{len(files)}"
