"""Synthetic drives with masks and known poses, for bench_colmap.py and bench_slam.py."""

import argparse
import statistics
from pathlib import Path

import cv2
import numpy as np
from common import PROGRAM, ROOT, call, say
from scipy.spatial.transform import Rotation

DILATION_PIXELS = 10
MASKS = ("none", "ours", "true")


class Drive:
    """A scenario's files below --out, made where they are missing."""

    def __init__(self, name, options):
        self.name = name
        scenario, seed = name.split(":")
        self.root = Path(options.out) / f"{scenario}_{seed}_{options.frames}_{options.width}"
        self.drive = self.root / "drive"
        if not (self.drive / "scene.json").exists():
            say(f"{name}: synthesising")
            call(PROGRAM, "synthesize", f"--scenario={scenario}", f"--seed={seed}", f"--frames={options.frames}", f"--width={options.width}",
                 f"--height={options.width * 9 // 16}", f"--out={self.drive}", "--overwrite", "--progress=none")  # fmt: skip
        if not (self.root / "masked").exists():
            say(f"{name}: masking")
            call(PROGRAM, "masks", self.drive / "frames", "--for=colmap", f"--dilate={DILATION_PIXELS}", f"--out={self.root / 'ours'}",
                 "--overwrite", "--progress=none")  # fmt: skip
            self._write_true_masks()
            (self.root / "masked").touch()
        # The last column of the 3 x 4 matrices, metres.
        self.centres = np.loadtxt(self.drive / "poses.txt").reshape(-1, 3, 4)[:, :, 3]

    def _write_true_masks(self):
        """As COLMAP reads them: 0 where something moves or is nearer than DILATION_PIXELS to it."""
        (self.root / "true").mkdir(parents=True, exist_ok=True)
        near = np.ones((2 * DILATION_PIXELS + 1,) * 2, np.uint8)
        for path in sorted((self.drive / "masks").glob("*.png")):
            moves = cv2.dilate(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE), near) > 127
            cv2.imwrite(str(self.root / "true" / f"{path.name}.png"), np.where(moves, 0, 255).astype(np.uint8))

    def masks(self, kind):
        """The folder of masks; "-" without masks."""
        return "-" if kind == "none" else self.root / kind

    def trajectory_error(self, places):
        """Root of the mean squared distance, metres, after the best similarity (Umeyama, 1991). places: by frame; None for few."""
        if len(places) < 3:
            return None
        true = self.centres[[int(frame) for frame in places]]
        a, b = (points - points.mean(axis=0) for points in (np.array(list(places.values())), true))
        turned = Rotation.align_vectors(b, a)[0].apply(a)
        scale = (turned * b).sum() / (turned**2).sum()
        return float(np.sqrt(((scale * turned - b) ** 2).sum(axis=1).mean()))


def cell(values, form):
    """Median, with the least and the greatest where they differ; a dash where there is none."""
    values = [value for value in values if value is not None]
    if not values:
        return "-"
    low, middle, high = (form.format(value) for value in (min(values), statistics.median(values), max(values)))
    return middle if low == high else f"{middle} ({low} to {high})"


def parser(description, drives, frames):
    """Of the flags that both benchmarks have."""
    made = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("--drives", type=lambda text: text.split(","), default=drives, help="scenario and seed of egosieve synthesize")
    made.add_argument("--frames", type=int, default=frames, help="of each drive")
    made.add_argument("--width", type=int, default=640, help="of the pictures, pixels")
    made.add_argument("--out", default=str(ROOT / "out" / "colmap"), help="folder for drives, masks and models")
    return made
