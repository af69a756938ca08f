#!/usr/bin/env python3
"""The trajectories of ORB-SLAM3, a monocular SLAM, with and without masks, on drives whose poses are known.

    ./run bench_slam [--drives NAME:SEED,NAME:SEED] [--frames N] [--width PIXELS] [--runs N] [--out DIR]

Drives and masks are those of bench_colmap.py, which makes them: without masks, ours, true ones, dilated by 10 pixels alike.
ORB-SLAM3 takes no masks: what is masked is painted over smoothly, so that nothing is detected there. Its vocabulary is made
from the drives' own features, for the one that it is shipped with is no package. It runs on several threads and gives another
trajectory each time: --runs of each. Writes bench/results/slam.md.

pip installs pyorbslam3 in a virtual environment in the user's cache folder, outside the repository.
"""

import argparse
import json
import statistics
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "colmap"))

import bench_colmap  # noqa: E402  (the drives)

CACHE = bench_colmap.CACHE.parent / "slam"
PIP = ["pyorbslam3==0.1.1", "numpy", "opencv-python-headless"]


def make_environment():
    """The interpreter of a virtual environment with pyorbslam3."""
    interpreter = CACHE / "bin" / "python"
    if interpreter.exists() and subprocess.run([interpreter, "-c", "import pyorbslam3, numpy, cv2"], capture_output=True).returncode == 0:  # fmt: skip
        return interpreter
    bench_colmap.say(f"making {CACHE}")
    for command in (["/usr/bin/python3", "-m", "venv", CACHE], [interpreter, "-m", "pip", "install", "-q", *PIP]):
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"bench_slam: {' '.join(map(str, command))} failed: {done.stderr.strip() or done.stdout.strip()}")
    return interpreter


def work(interpreter, *arguments):
    """The last line of what the worker prints, from JSON."""
    done = subprocess.run([str(word) for word in (interpreter, HERE / "worker.py", *arguments)],
                          capture_output=True, text=True, timeout=bench_colmap.TIMEOUT_SECONDS)  # fmt: skip
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if not lines:
        raise RuntimeError(f"{' '.join(map(str, arguments))}: {done.stderr.strip()[-500:]}")
    return json.loads(lines[-1])


def table(rows, options):
    """The results as Markdown."""
    text = (
        f"`./run bench_slam --drives={','.join(options.drives)} --frames={options.frames} --width={options.width} --runs={options.runs}`, "
        f"{PIP[0]}. Each cell: the median of the runs and, where they differ, the least and the greatest.\n\n"
        "| drive | its length, m | masks | frames tracked | trajectory error, m |\n|---|---:|---|---:|---:|\n"
    )
    for drive, masks, runs in rows:
        tracked = bench_colmap.cell([run["tracked"] for run in runs], "{:.0f}")
        error = bench_colmap.cell([run["trajectory_error_metres"] for run in runs], "{:.2f}")
        text += f"| {drive} | {statistics.median(run['length_metres'] for run in runs):.1f} | {masks} | {tracked} | {error} |\n"
    return text


def parse_arguments():
    """The flags."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drives", default="crossing:100,junction:102,street:100,following:100", help="scenario and seed of egosieve synthesize")
    parser.add_argument("--frames", type=int, default=100, help="of each drive")
    parser.add_argument("--width", type=int, default=640, help="of the pictures, pixels")
    parser.add_argument("--runs", type=int, default=3, help="of each drive and kind of masks")
    parser.add_argument("--out", default=str(bench_colmap.ROOT / "out" / "colmap"), help="folder for drives and masks, that of bench_colmap")
    options = parser.parse_args()
    options.drives = options.drives.split(",")
    return options


def main():
    """Drives by masks by runs, then the table."""
    options = parse_arguments()
    interpreter = make_environment()
    drives = [bench_colmap.Drive(bench_colmap.make_environment(), name, options) for name in options.drives]
    rows = []
    for drive in drives:
        drive.prepare()
        vocabulary = drive.root / "vocabulary.txt"
        if not vocabulary.exists():
            work(interpreter, "vocabulary", drive.drive, vocabulary)
        for masks in bench_colmap.MASKS:
            runs = []
            for run in range(1, options.runs + 1):
                bench_colmap.say(f"{drive.name}: tracking, masks {masks}, run {run}")
                runs.append(work(interpreter, "track", drive.drive, "-" if masks == "none" else drive.root / masks, vocabulary))
            rows.append((drive.name, masks, runs))
    bench_colmap.RESULTS.mkdir(exist_ok=True)
    text = table(rows, options)
    (bench_colmap.RESULTS / "slam.md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
