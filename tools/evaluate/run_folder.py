"""Reads a run folder of `egosieve segment` (tools/run_folder/run_folder.h)."""

import json
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from .errors import InputError, UsageError

FORMAT = 2
FULL_PIXEL = 65535  # the 16-bit score of a probability of 1


def read_json(path):
    try:
        return json.loads(Path(path).read_text(encoding="utf-8", errors="replace"))
    except FileNotFoundError:
        raise InputError(f"there is no {path}") from None
    except ValueError:
        raise InputError(f"{path} is no JSON; remove or replace it") from None


def read_image(path, flags=cv2.IMREAD_UNCHANGED):
    if not Path(path).is_file():
        what = "is not a regular file" if Path(path).exists() else "is not there"
        raise InputError(f"{path} {what}")
    image = cv2.imread(str(path), flags)
    if image is None:
        raise InputError(f"{path} is no image that can be read; remove or replace it")
    return image


@dataclass(frozen=True)
class Grid:
    """Every stride-th column and row of an image, and always the last ones."""

    width: int  # of the image, pixels
    height: int
    stride: int

    @property
    def x(self):
        """The columns' pixels."""
        return np.minimum(np.arange(0, self.width - 1 + self.stride, self.stride), self.width - 1)

    @property
    def y(self):
        return np.minimum(np.arange(0, self.height - 1 + self.stride, self.stride), self.height - 1)

    def sample(self, image):
        return image[np.ix_(self.y, self.x)]


@dataclass(frozen=True)
class Line:
    """A frame's line of frames.jsonl, as far as it is scored."""

    index: int
    seconds: float
    width: int  # pixels; 0: the frame has no map
    height: int
    of_prior: bool  # nothing was learnt yet: the map is the same everywhere
    expected_overlap: float = None  # IoU that the map expects of its own mask

    @property
    def has_map(self):
        return self.width > 0


class RunFolder:
    """InputError if there is no run; UsageError if it is of another format."""

    def __init__(self, path):
        self.path = Path(path)
        if not (self.path / "run.json").is_file():
            raise InputError(f"there is no run in {path}: it has no run.json")
        self.description = read_json(self.path / "run.json")
        if self.description.get("format_version") != FORMAT:
            raise UsageError(f"{path}/run.json has another format than {FORMAT}; segment again")
        try:
            self.input = self.description["input"]["path"]
            self.fingerprint = self.description["input"]["fingerprint"]
            self.stride = int(self.description["maps"]["stride_pixels"])
            self.lines = self._read_lines()
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(f"the run in {path} is damaged: {error!r}") from None

    def _read_lines(self):
        entries = {entry["index"]: entry for entry in self._read_log(self.path / "frames.jsonl")}
        for log in sorted((self.path / "log").glob("*.jsonl")):  # maps that were made later
            for entry in self._read_log(log):
                if entry["index"] not in entries or entry["width_pixels"] > 0:
                    entries[entry["index"]] = entry
        lines, learnt = [], False
        for index, entry in sorted(entries.items()):
            learnt = learnt or entry["model_size"] > 0 or entry["outcome"] == "learnt"
            size = entry["width_pixels"], entry["height_pixels"]
            lines.append(Line(index, entry["time_seconds"], *size, of_prior=not learnt,
                              expected_overlap=entry.get("expected_overlap")))
        return lines

    @staticmethod
    def _read_log(path):
        """A last line that a crash cut short is left out."""
        if not path.exists():
            raise InputError(f"there is no {path}; segment the drive again")
        text = path.read_text(encoding="utf-8", errors="replace")
        for number, line in enumerate(text.split("\n")[:-1], 1):
            try:
                yield json.loads(line)
            except ValueError:
                raise InputError(f"{path}, line {number}: the line is not JSON") from None

    def file(self, name):
        return self.path / name

    def frame_file(self, folder, index, suffix):
        return self.path / folder / f"{index:06d}{suffix}"

    def flag(self, name, default=None):
        return self.description["flags"].get(name, default)

    def scorable_lines(self):
        """The lines with a map. UsageError if there are none."""
        lines = [line for line in self.lines if line.has_map]
        if not lines:
            raise UsageError(f"the run in {self.path} has no map; segment the drive "
                             "again")
        return lines

    def grid(self, line, pixels="grid"):
        return Grid(line.width, line.height, 1 if pixels == "full" else self.stride)

    def _map(self, path, grid):
        image = read_image(path)
        size = (len(grid.y), len(grid.x))
        if image.dtype != np.uint16 or image.shape != size:
            raise InputError(f"{path} is no 16-bit grey image of {size[1]} x {size[0]} pixels; "
                             "segment the drive again")
        return image

    def maps(self, line, pixels="grid"):
        """(probability, deviation or None), 16-bit scores: of the grid or of full/."""
        grid = self.grid(line, pixels)
        probability = self.frame_file(pixels, line.index, ".prob.png")
        deviation = self.frame_file(pixels, line.index, ".std.png")
        if pixels == "full" and not probability.exists():
            raise UsageError(f"the run has no full/ map of frame {line.index}; run egosieve "
                             "refine --what=probability on it first, or use --pixels=grid")
        return (self._map(probability, grid),
                self._map(deviation, grid) if deviation.exists() else None)
