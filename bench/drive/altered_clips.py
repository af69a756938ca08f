#!/usr/bin/env python3
"""Writes other pictures of labelled clips: each clip turned, backwards, smaller, cropped, with fewer pictures.

    bench/drive/altered_clips.py OUT FOLDER...         OUT/turned/bear/frames, OUT/turned/bear/masks and so on
    ./run evaluate suite OUT/turned --out=out/turned

A FOLDER holds clips as davis and davis-train do. Needs OpenCV for Python (Debian's python3-opencv).
"""

import sys
from pathlib import Path

import cv2


def middle(picture, _):
    """The middle three quarters of both sides."""
    height, width = picture.shape[:2]
    return picture[height // 8 : height - height // 8, width // 8 : width - width // 8]


def half(picture, is_mask):
    """Half the size."""
    height, width = picture.shape[:2]
    return cv2.resize(picture, (width // 2, height // 2), interpolation=cv2.INTER_NEAREST if is_mask else cv2.INTER_AREA)


def turned(picture, _):
    """Turned clockwise by 90 degrees."""
    return cv2.rotate(picture, cv2.ROTATE_90_CLOCKWISE)


def same(picture, _):
    return picture


# name: what is done to a picture, which pictures
VARIANTS = {
    "turned": (turned, slice(None)),
    "backwards": (same, slice(None, None, -1)),
    "half": (half, slice(None)),
    "middle": (middle, slice(None)),
    "every_third": (same, slice(None, None, 3)),
}


def write(clip, out, change, which):
    """One clip, its pictures renumbered."""
    for part in ("frames", "masks"):
        (out / part).mkdir(parents=True, exist_ok=True)
    for index, frame in enumerate(sorted((clip / "frames").iterdir())[which]):
        mask = cv2.imread(str(clip / "masks" / f"{frame.stem}.png"), cv2.IMREAD_UNCHANGED)
        picture = change(cv2.imread(str(frame)), False)
        cv2.imwrite(str(out / "frames" / f"{index:05d}.jpg"), picture, [cv2.IMWRITE_JPEG_QUALITY, 92])
        cv2.imwrite(str(out / "masks" / f"{index:05d}.png"), change(mask, True))


def main():
    """Writes all variants of all clips."""
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    for name, (change, which) in VARIANTS.items():
        for folder in map(Path, sys.argv[2:]):
            for clip in sorted(folder.iterdir()):
                write(clip, Path(sys.argv[1]) / name / clip.name, change, which)


if __name__ == "__main__":
    main()
