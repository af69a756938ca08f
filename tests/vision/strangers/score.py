#!/usr/bin/python3
"""Scores runs of `egosieve segment` on the strangers' clips against boxes labelled by hand.

    tests/vision/strangers/score.py out/strangers [--masks]

The folder holds runs named by their clips; clips without a run are left out. Marked is a pixel
whose probability is above 0.5, with --masks one that the masks of `egosieve refine` mark.
Columns, shares in percent:
  near      mean share marked of the boxes of near moving vehicles
  other     the same of all other moving boxes: far vehicles, people, animals
  standing  the same of standing boxes, less what boxes of other motion cover
  found     after each of these: boxes of which more than half is marked, of how many
  outside   mean share marked of the picture outside all boxes
Boxes of unknown motion count nowhere. The last line is on doubt: how well the overlap with what
moves that frames.jsonl expects tells bad frames from good ones, and how many the program calls
unreliable. A perfect mask fills about two thirds of its boxes; so bad is an IoU with the moving
boxes below 0.2, good one above 0.35, and where nothing moves, the area marked tells.
Needs OpenCV for Python (Debian's python3-opencv).
"""

import argparse
import csv
import json
import sys
from collections import defaultdict
from pathlib import Path

import cv2
import numpy as np

VEHICLES = ('car', 'truck', 'bus', 'motorbike', 'bicycle')
LEAST_OVERLAP = 0.4  # kLeastOverlap of tools/run_folder/doubtful_frames.cc
COLUMNS = ('near', 'other', 'standing')


def read_boxes(path):
    """The table's rows by clip and frame."""
    frames = defaultdict(lambda: defaultdict(list))
    with open(path, newline='') as table:
        for row in csv.DictReader(table):
            frames[row['clip']][int(row['frame'])].append(row)
    return frames


def masked_pixels(run, frame):
    """Where the frame's mask is set."""
    path = run / 'masks' / f'{frame:06d}.png'
    mask = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if mask is None:
        sys.exit(f'score: no mask {path}; egosieve refine makes it')
    return mask > 0


def marked_pixels(run, frame, stride, sizes):
    """Where the frame's map is above 0.5, at the picture's size."""
    path = run / 'grid' / f'{frame:06d}.prob.png'
    grid = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if grid is None or frame not in sizes:
        sys.exit(f'score: no map {path}')
    # Grid pixel c lies at the picture's column c * stride.
    scale = np.array([[1 / stride, 0, 0], [0, 1 / stride, 0]])
    return cv2.warpAffine(grid / 65535, scale, sizes[frame], borderMode=cv2.BORDER_REPLICATE,
                          flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP) > 0.5


def group(row):
    """The column in which a box counts."""
    if row['motion'] != 'moving':
        return row['motion']
    return 'near' if row['near'] == '1' and row['class'] in VEHICLES else 'other'


def area(row):
    """The box as a pair of slices."""
    return (slice(int(row['y0']), int(row['y1']) + 1), slice(int(row['x0']), int(row['x1']) + 1))


def box_overlap(marked, rows):
    """IoU of what is marked with the moving boxes; without any, 1 if next to nothing is marked."""
    moving, unknown = np.zeros_like(marked), np.zeros_like(marked)
    for row in rows:
        if row['motion'] != 'standing':
            (moving if row['motion'] == 'moving' else unknown)[area(row)] = True
    moving &= ~unknown
    if not moving.any():
        return float(marked.mean() < 0.003)
    return (marked & moving).sum() / ((marked & ~unknown) | moving).sum()


def score_frame(marked, rows, shares):
    """Appends the frame's shares to the lists of `shares`, by column."""
    boxes, others = np.zeros_like(marked), np.zeros_like(marked)
    for row in rows:
        boxes[area(row)] = True
        others[area(row)] |= group(row) != 'standing'
    for row in rows:
        inside = marked[area(row)]
        if group(row) == 'standing':
            inside = inside[~others[area(row)]]
        if inside.size:
            shares[group(row)].append(inside.mean())
    shares['outside'].append(marked[~boxes].mean())


def score_run(run, frames, masks):
    """Lists of shares by column, of all labelled frames of a run.

    Also 'doubt': of each frame the overlap found, that expected, and whether it is flagged.
    """
    stride = json.loads((run / 'run.json').read_text())['maps']['stride_pixels']
    records = map(json.loads, (run / 'frames.jsonl').read_text().splitlines())
    lines = {line['index']: line for line in records}
    sizes = {index: (line['width_pixels'], line['height_pixels']) for index, line in lines.items()}
    shares = defaultdict(list)
    for frame, rows in sorted(frames.items()):
        marked = masked_pixels(run, frame) if masks else marked_pixels(run, frame, stride, sizes)
        score_frame(marked, rows, shares)
        expected, doubt = lines[frame]['expected_overlap'], lines[frame]['doubt']
        flagged = bool(doubt) or expected < LEAST_OVERLAP
        shares['doubt'].append((box_overlap(marked, rows), expected, flagged))
    return shares


def print_line(name, shares):
    cells = []
    for column in COLUMNS:
        values = shares[column]
        cells.append(f'{100 * np.mean(values):10.1f}' if values else f'{"-":>10}')
        cells.append(f'{sum(share > 0.5 for share in values)}/{len(values)}'.rjust(8))
    print(f'{name:32}' + ''.join(cells) + f'{100 * np.mean(shares["outside"]):10.1f}')


def print_doubt(frames):
    bad = np.array([frame[1:] for frame in frames if frame[0] < 0.2])
    good = np.array([frame[1:] for frame in frames if frame[0] > 0.35])
    if bad.size and good.size:
        lower, equal = bad[:, :1] < good[:, 0], bad[:, :1] == good[:, 0]
        print(f'doubt: {len(bad)} bad frames, {len(good)} good ones, '
              f'AUC {(lower + 0.5 * equal).mean():.2f}; flagged {bad[:, 1].mean():.2f} of the bad, '
              f'{good[:, 1].mean():.2f} of the good')


def main():
    layout = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=layout)
    parser.add_argument('runs', type=Path, help='the folder of runs')
    parser.add_argument('--masks', action='store_true', help='score masks, not maps')
    parser.add_argument('--boxes', type=Path, default=Path(__file__).with_name('boxes.csv'))
    arguments = parser.parse_args()
    clips = read_boxes(arguments.boxes)
    total = defaultdict(list)
    print(f'{"clip":32}' + ''.join(f'{column:>10}   found' for column in COLUMNS) + '   outside')
    for clip in sorted(name for name in clips if (arguments.runs / name).is_dir()):
        shares = score_run(arguments.runs / clip, clips[clip], arguments.masks)
        print_line(clip, shares)
        for column, values in shares.items():
            total[column] += values
    if not total:
        sys.exit(f'score: {arguments.runs} holds no run named by a clip')
    print_line('all', total)
    print_doubt(total['doubt'])


if __name__ == '__main__':
    main()
