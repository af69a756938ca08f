#!/usr/bin/env python3
"""The segmenter in Python: a textured square crosses a background that moves with the camera.

    segment.py [--frames N] [--device NAME]
"""

import argparse

import numpy as np

import egosieve

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--frames", type=int, default=5)
parser.add_argument("--device", default=None)
options = parser.parse_args()

WIDTH, HEIGHT, SIDE, TOP = 240, 160, 48, 56
random = np.random.default_rng(1)
background = np.kron(random.integers(0, 128, (HEIGHT, WIDTH)), np.ones((3, 3))).astype(np.uint8)
texture = np.kron(random.integers(127, 255, (SIDE // 3, SIDE // 3)), np.ones((3, 3))).astype(np.uint8)

segmenter = egosieve.Segmenter(device=options.device)
for t in range(options.frames):
    frame = background[:HEIGHT, 2 * t : 2 * t + WIDTH].copy()  # the camera pans
    square = np.s_[TOP : TOP + SIDE, 40 + 7 * t : 40 + 7 * t + SIDE]
    frame[square] = texture
    found = segmenter.process(frame, full=True)
    moving = found.probability > 0.5
    inside = moving[square].mean()
    outside = (moving.sum() - moving[square].sum()) / (moving.size - SIDE * SIDE)
    print(
        f"frame {t}: {inside:.0%} of the square moves, {outside:.0%} of the rest; "
        f"model of {found.report.model_size} points {found.report.reason}"
    )
raise SystemExit(0 if inside > 2 * outside else 1)
