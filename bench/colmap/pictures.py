#!/usr/bin/python3
"""Draws models of `./run bench_colmap --clips` into one picture of the clip: points on movers red, others green.

    bench/colmap/pictures.py out/colmap/CLIP PICTURE.png OUT.jpg [--mapper NAME] [--seed N] [--undistorted] [--blank]

CLIP is a clip's folder there. Left without masks, right with ours. --undistorted: instead of points the undistorted picture, right with
its mask in red. --blank: on white, for clips whose licence allows no pictures, with the outline of what moves.
"""

import argparse
import sys
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from clips import WORKER  # noqa: E402
from common import environment, work  # noqa: E402

RED, GREEN, SIZE = (30, 30, 230), (90, 170, 40), 2


def titled(picture, text):
    """A line of text above a picture."""
    bar = np.full((26, picture.shape[1], 3), 255, np.uint8)
    cv2.putText(bar, text, (4, 18), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (0, 0, 0), 1, cv2.LINE_AA)
    return np.vstack([bar, picture])


def drawn(picture, points, text):
    """Static points first, so that none hides one on a mover."""
    picture = picture.copy()
    for x, y, moving in sorted(points, key=lambda point: point[2]):
        if 0 <= x < picture.shape[1] and 0 <= y < picture.shape[0]:
            cv2.circle(picture, (int(x), int(y)), SIZE, RED if moving else GREEN, -1, cv2.LINE_AA)
    return titled(picture, f"{text}: {sum(point[2] for point in points)} of {len(points)} points on movers (red)")


def main():
    """Panels side by side."""
    flags = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    flags.add_argument("clip", type=Path)
    flags.add_argument("picture")
    flags.add_argument("out")
    flags.add_argument("--mapper", default="incremental")
    flags.add_argument("--seed", type=int, default=1, help="of COLMAP's")
    flags.add_argument("--undistorted", action="store_true")
    flags.add_argument("--blank", action="store_true")
    options = flags.parse_args()
    python, drive = environment("colmap", ["pycolmap", "numpy", "pillow"]), options.clip / "drive"
    picture = cv2.imread(str(drive / "frames" / options.picture))
    if options.blank:
        picture[:] = 255
        moves = (cv2.imread(str(drive / "masks" / options.picture), cv2.IMREAD_GRAYSCALE) > 191).astype(np.uint8)
        cv2.drawContours(picture, cv2.findContours(moves, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0], -1, RED, 1)
    if options.undistorted:
        dense = options.clip / "dense"
        flat, mask = cv2.imread(str(dense / "images" / options.picture)), cv2.imread(str(dense / "masks" / f"{options.picture}.png"), cv2.IMREAD_GRAYSCALE)
        tinted = np.where((mask == 0)[..., None], (flat * 0.5 + np.array(RED) * 0.5).astype(np.uint8), flat)
        panels = [titled(flat, "Undistorted by COLMAP"), titled(tinted, "Mask of --undistort (red)")]
    else:
        panels = [drawn(picture, work(python, WORKER, "project", drive, options.clip / "models" / f"{masks}_{options.mapper}_{options.seed}" / "largest", options.picture)["points"], text)
                  for masks, text in (("none", "Without masks"), ("ours", "With masks"))]  # fmt: skip
    cv2.imwrite(options.out, np.hstack(panels), [cv2.IMWRITE_JPEG_QUALITY, 80])


if __name__ == "__main__":
    main()
