"""Reads a run folder of `egosieve segment` (tools/run_folder/run_folder.h)."""

import json
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from .files import InputError, UsageError, read_json, read_numbers

FORMAT = 2
FULL_PIXEL = 65535  # the 16-bit score of a probability of 1


@dataclass(frozen=True)
class Grid:
    """Every stride-th column and row of an image, and always the last ones."""

    width: int  # of the image, pixels
    height: int
    stride: int

    def _places(self, size):
        return np.minimum(np.arange(0, size - 1 + self.stride, self.stride), size - 1)

    @property
    def x(self):
        """The columns' pixels."""
        return self._places(self.width)

    @property
    def y(self):
        return self._places(self.height)

    def sample(self, image):
        return image[np.ix_(self.y, self.x)]


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


class RunFolder:
    """lines: of frames.jsonl, by index. Their size is (height, width); in frames of_prior nothing
    was learnt yet: the map is the same everywhere.

    InputError if there is no run; UsageError if it is of another format.
    """

    def __init__(self, path):
        self.path = Path(path)
        self.description = read_json(self.path / "run.json")
        if self.description.get("format_version") != FORMAT:
            raise UsageError(f"{path}/run.json has another format than {FORMAT}; segment again")
        self.input = Path(self.description["input"]["path"])
        self.stride = self.description["maps"]["stride_pixels"]
        self.lines = self._read_lines()

    def _read_lines(self):
        entries = {entry["index"]: entry for entry in _read_log(self.path / "frames.jsonl")}
        for log in sorted((self.path / "log").glob("*.jsonl")):  # maps that were made later
            for entry in _read_log(log):
                if entry["index"] not in entries or entry["width_pixels"] > 0:
                    entries[entry["index"]] = entry
        lines, learnt = [], False
        for _, entry in sorted(entries.items()):
            learnt = learnt or entry["model_size"] > 0 or entry["outcome"] == "learnt"
            size = entry["height_pixels"], entry["width_pixels"]
            lines.append(SimpleNamespace(**entry, size=size, of_prior=not learnt))
        return lines

    def frame_file(self, folder, line, suffix=".png"):
        return self.path / folder / f"{line.index:06d}{suffix}"

    def scorable_lines(self):
        """The lines with a map. UsageError if there are none."""
        lines = [line for line in self.lines if line.width_pixels > 0]
        if not lines:
            raise UsageError(f"the run in {self.path} has no map; segment the drive again")
        return lines

    def grid(self, line, pixels="grid"):
        stride = 1 if pixels == "full" else self.stride
        return Grid(line.width_pixels, line.height_pixels, stride)

    def maps(self, line, pixels="grid"):
        """(probability, deviation or None), 16-bit scores: of the grid or of full/."""
        grid = self.grid(line, pixels)
        size = len(grid.y), len(grid.x)
        probability, deviation = (self.frame_file(pixels, line, f".{what}.png")
                                  for what in ("prob", "std"))
        return (read_numbers(probability, size),
                read_numbers(deviation, size) if deviation.exists() else None)
