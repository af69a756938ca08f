#!/usr/bin/python3
"""Clips with a caption and a station's logo drawn into each picture, as on much video of strangers.

    bench/drive/draw_captions.py CLIPS OUT [--frames N]

CLIPS: a folder of clips, each with frames/ and masks/, as davis-train. Both stay where they are through the clip, half and nearly opaque.
Writes OUT/CLIP/frames and links OUT/CLIP/masks.
"""

import argparse
from pathlib import Path

import cv2

WHITE, YELLOW, RED, DARK = (255, 255, 255), (0, 220, 255), (60, 60, 220), (20, 20, 20)


def drawn(picture, opacity, draw):
    over = picture.copy()
    draw(over)
    return cv2.addWeighted(over, opacity, picture, 1 - opacity, 0)


def captioned(picture):
    """Sizes are for pictures of 854 x 480, as DAVIS's are."""
    height, width = picture.shape[:2]
    left, bottom = width // 2 - 190, height - 24
    picture = drawn(picture, 0.5, lambda p: cv2.rectangle(p, (left, bottom - 40), (left + 380, bottom), DARK, -1))
    cv2.putText(picture, "Recorded on holiday, part 3", (left + 10, bottom - 13), cv2.FONT_HERSHEY_TRIPLEX, 0.75, YELLOW, 1, cv2.LINE_AA)

    def logo(over):
        cv2.ellipse(over, (60, 55), (42, 26), 0, 0, 360, RED, -1, cv2.LINE_AA)
        cv2.putText(over, "tv", (36, 66), cv2.FONT_HERSHEY_SCRIPT_COMPLEX, 1.2, WHITE, 2, cv2.LINE_AA)

    return drawn(picture, 0.85, logo)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("clips", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--frames", type=int, default=24, help="of each clip, from its first")
    options = parser.parse_args()
    for clip in sorted(options.clips.iterdir()):
        if not (clip / "masks").is_dir():
            continue
        frames = options.out / clip.name / "frames"
        frames.mkdir(parents=True, exist_ok=True)
        masks = frames.parent / "masks"
        if not masks.is_symlink():
            masks.symlink_to((clip / "masks").resolve())
        for path in sorted((clip / "frames").iterdir())[: options.frames]:
            cv2.imwrite(str(frames / f"{path.stem}.png"), captioned(cv2.imread(str(path))))


if __name__ == "__main__":
    main()
