#!/usr/bin/python3
"""Clips of two shots: the beginning of each, and then as many later pictures of the next.

    bench/drive/join_clips.py CLIPS OUT [--frames N]

CLIPS: a folder of clips, each with frames/ and masks/, as davis-train. Pictures keep their place in their own clip, so the second shot has
pictures N / 2 to N - 1. Writes links OUT/CLIP/frames and OUT/CLIP/masks.
"""

import argparse
from pathlib import Path


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("clips", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--frames", type=int, default=24, help="of each joined clip")
    options = parser.parse_args()
    clips = [clip for clip in sorted(options.clips.iterdir()) if (clip / "masks").is_dir()]
    half = options.frames // 2
    for first, second in zip(clips, clips[1:] + clips[:1]):
        for kind in ("frames", "masks"):
            folder = options.out / first.name / kind
            folder.mkdir(parents=True)
            pictures = sorted((first / kind).iterdir())[:half] + sorted((second / kind).iterdir())[half : options.frames]
            for index, path in enumerate(pictures):
                (folder / f"{index:05d}{path.suffix}").symlink_to(path.resolve())


if __name__ == "__main__":
    main()
