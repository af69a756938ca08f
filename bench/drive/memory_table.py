#!/usr/bin/python3
"""How much memory `egosieve run` takes over a long video: learning, masks, numbered movers, overlay and page.

    bench/drive/memory_table.py [--video FILE] [--width PIXELS] [--frames N] [--profile NAME] [--minutes M]

Plays a video forwards and backwards, scaled to that width, until it has so many frames, and runs the program on that. Writes the resident memory by step,
and by fifth of the frames, so that growth would show, into memory.json and memory.md in bench/results, beside those of other widths.
"""

import argparse
import itertools
import json
import math
import os
import signal
import subprocess
import sys
import tempfile
import time
from datetime import date
from pathlib import Path

import cv2

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from common import PROGRAM, RESULTS, ROOT, machine, markdown  # noqa: E402

DATA = Path(os.environ.get("EGOSIEVE_DATA", ROOT.parent / "shared" / "data"))
RATE, PARTS = 30, 5


def pictures(video, width):
    """The video's pictures of that width, forwards and backwards without end; those of one way are kept as JPEG."""
    capture, kept = cv2.VideoCapture(str(video)), []
    while (picture := capture.read()[1]) is not None:
        height = round(picture.shape[0] * width / picture.shape[1] / 2) * 2
        kept.append(cv2.imencode(".jpg", cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA))[1])
    if len(kept) < 2:
        sys.exit(f"memory_table: no pictures in {video}; set EGOSIEVE_DATA or give --video")
    yield from (cv2.imdecode(kept[i], cv2.IMREAD_COLOR) for i in itertools.cycle([*range(len(kept) - 1), *range(len(kept) - 1, 0, -1)]))


def write_video(source, frames, file):
    """A video of so many pictures of the source; its size (width, height)."""
    writer = None
    for picture in itertools.islice(source, frames):
        writer = writer or cv2.VideoWriter(str(file), cv2.VideoWriter_fourcc(*"mp4v"), RATE, picture.shape[1::-1])
        writer.write(picture)
    writer.release()
    return picture.shape[1::-1]


def resident(process):
    """Resident memory of a process, MiB; 0 where it has ended."""
    lines = Path(f"/proc/{process.pid}/status").read_text().split("\n")
    return sum(int(line.split()[1]) for line in lines if line.startswith("VmRSS")) / 1024


def done_so_far(run):
    """(step, its frames that are done)"""
    masks, log = run / "masks", run / "frames.jsonl"
    if list(run.glob("overlay.mp4*")):
        return "overlay and page", 0
    if masks.exists():
        return "masks", len(os.listdir(masks))
    return "learning", log.read_bytes().count(b"\n") if log.exists() else 0


def run_once(video, run, profile, minutes):
    """[(step, frames done, MiB)] over a run, which is ended after so many minutes. Exit code 4 is of frames not to be relied on."""
    samples, end = [], time.monotonic() + 60 * minutes
    with open(f"{run}.log", "w") as output:
        process = subprocess.Popen([PROGRAM, "run", video, f"--out={run}", f"--profile={profile}"], stdout=output, stderr=output)
        while process.poll() is None:
            if time.monotonic() > end:
                process.terminate()
                end = math.inf
            samples.append((*done_so_far(run), resident(process)))
            time.sleep(0.25)
    if process.returncode not in (0, 4, 130, -signal.SIGTERM):
        sys.exit(f"memory_table: exit code {process.returncode}: {Path(f'{run}.log').read_text().strip()[-500:]}")
    return samples


def by_part(samples, frames):
    """{step: [most MiB in each of PARTS equal parts of the frames, None where it did not get there]}"""
    table = {}
    for step, done, memory in samples:
        most = table.setdefault(step, [None] * PARTS)
        part = min(done * PARTS // frames, PARTS - 1)
        most[part] = max(most[part] or 0, memory)
    return table


def section(record):
    """The table of one width."""
    frames, steps = record["frames"], record["steps"]
    told = lambda value: "-" if value is None else f"{value:.0f}"  # noqa: E731
    rows = [(f"{frames * k // PARTS} to {frames * (k + 1) // PARTS}", told(steps["learning"][k]), told(steps.get("masks", [None] * PARTS)[k])) for k in range(PARTS)]
    last = told(steps.get("overlay and page", [None])[0])
    return (
        f"\n## {' x '.join(map(str, record['size']))}\n\n`bench/drive/memory_table.py --width={record['size'][0]} --frames={frames} --profile={record['profile']}`, commit {record['commit']}, {record['date']},\n"
        f"{record['machine']}. {record['video']}, {RATE} pictures per second.\n\n{markdown(['>frames', '>learning, MiB', '>masks and numbers, MiB'], rows)}\n"
        f"Overlay and page: {last} MiB.\n"
    )


def page(records):
    """All widths' tables."""
    return "# Memory of a long video\n\n`egosieve run` of a video that is played forwards and backwards: the most resident memory while these frames were done.\n" + "".join(map(section, records))


def main():
    """Measures and writes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--video", type=Path, default=DATA / "strangers" / "dashcam_intersection.mp4")
    parser.add_argument("--width", type=int, default=640, help="of the pictures, pixels")
    parser.add_argument("--frames", type=int, default=4500)
    parser.add_argument("--profile", default="fast")
    parser.add_argument("--minutes", type=float, default=600, help="after which the run is ended; the table is then of what was done")
    options = parser.parse_args()
    commit = subprocess.run(["git", "rev-parse", "--short=8", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=False).stdout.strip()
    record = {"video": options.video.name, "profile": options.profile, "frames": options.frames, "commit": commit, "date": str(date.today()), "machine": machine()}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "long.mp4"
        record["size"] = write_video(pictures(options.video, options.width), options.frames, file)
        record["steps"] = by_part(run_once(file, Path(folder) / "run", options.profile, options.minutes), options.frames)
    file = RESULTS / "memory.json"
    others = [other for other in (json.loads(file.read_text()) if file.exists() else []) if other["size"][0] != options.width]
    file.write_text(json.dumps(records := sorted([*others, record], key=lambda r: -r["size"][0]), indent=1) + "\n")
    (RESULTS / "memory.md").write_text(page(records))
    print(section(record), end="")


if __name__ == "__main__":
    main()
