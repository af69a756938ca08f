#!/usr/bin/env python3
"""The trajectories of ORB-SLAM3, a monocular SLAM, with and without masks, on drives whose poses are known.

    ./run bench_slam [--drives NAME:SEED,NAME:SEED] [--frames N] [--width PIXELS] [--runs N] [--out DIR]

Drives and masks are those of bench_colmap.py: without masks, ours, true ones, dilated by 10 pixels alike.
ORB-SLAM3 takes no masks: what is masked is painted over smoothly, so that nothing is detected there. Its vocabulary is made
from the drives' own features, for the one that it is shipped with is no package. It runs on several threads and gives another
trajectory each time: --runs of each. Writes bench/results/slam.md.

pip installs pyorbslam3 in a virtual environment in the user's cache folder, outside the repository.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from common import RESULTS, environment, markdown, say, work  # noqa: E402
from drives import MASKS, Drive, cell, parser  # noqa: E402

WORKER = Path(__file__).resolve().parent / "worker.py"
PIP = ["pyorbslam3==0.1.1", "numpy", "opencv-python-headless"]
DRIVES = ["crossing:100", "junction:102", "street:100", "following:100"]
FEWEST = 6  # frames of a trajectory whose error counts
COLUMNS = ("drive", ">its length, m", "masks", ">frames tracked", ">trajectory error, m")


def main():
    """Drives by masks by runs, then the table."""
    flags = parser(__doc__, DRIVES, 100)
    flags.add_argument("--runs", type=int, default=3, help="of each drive and kind of masks")
    options = flags.parse_args()
    python = environment("slam", PIP)
    rows = []
    for drive in [Drive(name, options) for name in options.drives]:
        vocabulary = drive.root / "vocabulary.txt"
        if not vocabulary.exists():
            work(python, WORKER, "vocabulary", drive.drive, vocabulary)
        length = np.linalg.norm(np.diff(drive.centres, axis=0), axis=1).sum()
        for masks in MASKS:
            found = []
            for run in range(1, options.runs + 1):
                say(f"{drive.name}: tracking, masks {masks}, run {run}")
                found.append(work(python, WORKER, "track", drive.drive, drive.masks(masks), vocabulary)["places"])
            errors = [drive.trajectory_error(places) if len(places) >= FEWEST else None for places in found]
            rows.append((drive.name, f"{length:.1f}", masks, cell(list(map(len, found)), "{:.0f}"), cell(errors, "{:.2f}")))
    text = (
        f"`./run bench_slam --drives={','.join(options.drives)} --frames={options.frames} --width={options.width} --runs={options.runs}`, "
        f"{PIP[0]}. Each cell: the median of the runs and, where they differ, the least and the greatest.\n\n" + markdown(COLUMNS, rows)
    )
    (RESULTS / "slam.md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
