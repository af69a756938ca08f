#!/usr/bin/python3
"""The cost per frame of a long drive, as JSON.

    ./run bench_drive [--frames N] [--profiles default,fast,paper,paper_full,opencv]
    ./run bench_drive --soak [--frames N]

KITTI's residential street, played back and forth, is segmented twice, whole and half of it; the second half of the frames is the steady
state, so its cost is the difference of the two, start and first pass apart. paper_full is the paper's profile without filters 2 and 3, so
that the model holds its 4,000 points on a drive this short; opencv is OpenCV's dense flow and its RANSAC fundamental matrix alone.

--soak is one long drive of small pictures, alternately synthetic and real: time per frame, memory and open files early and late. A fixed
piece of work, timed beside it, shows changes of the machine's own speed. The exit code is 1 where a frame has no map.
"""

import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from common import PROGRAM, ROOT, call  # noqa: E402

DATA = Path(os.environ.get("EGOSIEVE_DATA", ROOT.parent / "shared" / "data"))
PAPER_FULL = ["--profile=paper", "--set=novelty_filter=false", "--set=consistency_filter=false"]
SOAK_SIZE, SOAK_BUDGET, TURN = (416, 128), 400, 250


def back_and_forth(pictures, i):
    """The picture of frame i."""
    last = len(pictures) - 1
    return pictures[last - abs(last - i % (2 * last))]


def play(clips, turn, count, folder):
    """Links `count` pictures: each clip back and forth, another clip after every `turn` frames."""
    (folder / "frames").mkdir(parents=True)
    for i in range(count):
        picture = back_and_forth(clips[i // turn % len(clips)], i)
        (folder / "frames" / f"{i:06d}{picture.suffix}").symlink_to(picture)
    return folder / "frames"


def scaled(pictures, size, folder):
    """The pictures of that size (width, height), as PNG."""
    folder.mkdir(parents=True)
    for picture in pictures:
        cv2.imwrite(str(folder / f"{picture.stem}.png"), cv2.resize(cv2.imread(str(picture)), size, interpolation=cv2.INTER_AREA))
    return sorted(folder.iterdir())


def street():
    """The pictures of KITTI's residential street."""
    pictures = sorted((DATA / "kitti-residential" / "frames").resolve().iterdir())
    return pictures or sys.exit(f"bench_drive: no pictures in {DATA}; set EGOSIEVE_DATA")


def lines_of(run):
    """The run's log, a line per frame."""
    return [json.loads(line) for line in (run / "frames.jsonl").read_text().splitlines()]


def segment(frames, run, flags, samples=None):
    """Segments, watched where there is a list for samples; seconds by the clock, of the processor, and the most memory of any run, MiB."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    words = [PROGRAM, "segment", frames, f"--out={run}", "--fps=10", "--progress=none", *flags]
    process = subprocess.Popen([str(word) for word in words], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if samples is not None:
        threading.Thread(target=watch_soak, args=(process, run, samples), daemon=True).start()
    said = process.communicate()[1]
    if process.returncode != 0:
        sys.exit(f"bench_drive: exit code {process.returncode}: {said.strip()[-500:]}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = sum(getattr(after, f) - getattr(before, f) for f in ("ru_utime", "ru_stime"))
    return time.monotonic() - start, seconds, after.ru_maxrss / 1024


def stages(lines):
    """The median milliseconds of each stage."""
    return {name: round(statistics.median(line["milliseconds"].get(name, 0.0) for line in lines), 2) for name in lines[-1]["milliseconds"]}


def measure_profile(name, pictures, count, flags, scratch):
    """One profile's figures: of the whole drive, and by the difference of the whole and its first half."""
    half, costs = count // 2, []
    flags = [*(PAPER_FULL if name == "paper_full" else [f"--profile={name}"]), *flags]
    for frames in (half, count):
        run = scratch / f"{name}_{frames}"
        costs.append(segment(play([pictures], count, frames, scratch / f"{name}_{frames}_in"), run, flags))
    lines, figures = lines_of(run), {"profile": name, "frames": count}
    for clock, first, whole in zip(("seconds", "processor_seconds"), *costs):
        figures |= {clock: whole, f"{clock}_per_frame": (whole - first) / (count - half)}
    return figures | {
        "milliseconds_by_stage_median": stages(lines[half:]),
        "model_points": lines[-1]["model_size"],
        "resident_mebibytes": costs[1][2],
        "frames_without_map": sum(line["outcome"] == "failed" for line in lines),
    }


def measure_opencv(pictures, count):
    """OpenCV's flow and fundamental matrix on every fifth pixel, as a user writes them."""
    flow, before, clock, processor = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM), None, [], []
    for i in range(count):
        start, processor_start = time.monotonic(), time.process_time()
        grey = cv2.cvtColor(cv2.imread(str(back_and_forth(pictures, i))), cv2.COLOR_BGR2GRAY)
        if before is not None:
            moved = flow.calc(before, grey, None)[2::5, 2::5].reshape(-1, 2)
            places = np.mgrid[2 : grey.shape[1] : 5, 2 : grey.shape[0] : 5].T.reshape(-1, 2).astype(np.float32)
            cv2.findFundamentalMat(places, places + moved, cv2.FM_RANSAC, 1.0, 0.99)
            clock.append(time.monotonic() - start)
            processor.append(time.process_time() - processor_start)
        before = grey
    return {"profile": "opencv", "seconds_per_frame": statistics.median(clock), "processor_seconds_per_frame": statistics.median(processor)}


def measure(profiles, frames, megapixels=None, flags=()):
    """All profiles' figures."""
    with tempfile.TemporaryDirectory() as folder:
        scratch, pictures = Path(folder), street()
        if megapixels:
            height, width = cv2.imread(str(pictures[0])).shape[:2]
            scale = (1e6 * megapixels / (width * height)) ** 0.5
            pictures = scaled(pictures, (round(width * scale), round(height * scale)), scratch / "scaled")
        return [
            measure_opencv(pictures, frames) if name == "opencv" else measure_profile(name, pictures, frames, flags, scratch)
            for name in profiles
        ]


def fixed_work():
    """Milliseconds of the same work each time."""
    a = cv2.GaussianBlur(np.random.default_rng(1).integers(0, 256, SOAK_SIZE[::-1], dtype=np.uint8), (0, 0), 2.0)
    start = time.monotonic()
    cv2.DISOpticalFlow_create().calc(a, np.roll(a, 2, 1), None)
    return 1e3 * (time.monotonic() - start)


def watch_soak(process, run, samples):
    """Appends (frames done, memory in MiB, open files, milliseconds of fixed work) every few seconds, until the program ends."""
    while process.poll() is None:
        time.sleep(3)
        try:
            memory = int(next(x for x in Path(f"/proc/{process.pid}/status").read_text().split("\n") if x.startswith("VmRSS")).split()[1])
            done = (run / "frames.jsonl").read_bytes().count(b"\n")
            samples.append((done, memory / 1024, len(os.listdir(f"/proc/{process.pid}/fd")), fixed_work()))
        except (OSError, StopIteration):
            continue


def soak(count):
    """Early and late figures of one long drive, and their ratios."""
    with tempfile.TemporaryDirectory() as folder:
        scratch, samples = Path(folder), []
        call(PROGRAM, "synthesize", "--scenario=junction", "--frames=40", f"--out={scratch / 'made'}", "--progress=none",
             f"--width={SOAK_SIZE[0]}", f"--height={SOAK_SIZE[1]}")  # fmt: skip
        clips = [sorted((scratch / "made" / "frames").iterdir()), scaled(street(), SOAK_SIZE, scratch / "street")]
        run = scratch / "run"
        segment(play(clips, TURN, count, scratch / "in"), run, [f"--budget={SOAK_BUDGET}"], samples)
        lines = lines_of(run)
    begin, window = min(2000, count // 4), min(2 * TURN, count // 4)
    result = {"frames": count, "frames_without_map": sum(line["outcome"] == "failed" for line in lines)}
    for name, first in (("early", begin), ("late", count - window)):
        near = [s for s in samples if first <= s[0] <= first + window] or sys.exit("bench_drive: too few frames for a soak")
        result[name] = {
            "frames": f"{first}-{first + window}",
            "milliseconds_by_stage_median": stages(lines[first : first + window]),
            "milliseconds": statistics.mean(sum(line["milliseconds"].values()) for line in lines[first : first + window]),
            "resident_mebibytes": near[-1][1],
            "open_files": near[-1][2],
            "fixed_work_milliseconds": statistics.median(s[3] for s in near),
        }
    for field in ("milliseconds", "resident_mebibytes", "fixed_work_milliseconds"):
        result[f"{field}_ratio"] = result["late"][field] / result["early"][field]
    return result


def main():
    """Measures and prints."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--soak", action="store_true")
    parser.add_argument("--frames", type=int, help="300; of a soak 14500")
    parser.add_argument("--profiles", default="default,fast,paper,paper_full,opencv")
    options = parser.parse_args()
    if options.soak:
        results = [soak(options.frames or 14500)]
    else:
        results = measure(options.profiles.split(","), options.frames or 300)
    print(json.dumps(results, indent=1))
    sys.exit(any(result.get("frames_without_map") for result in results))


if __name__ == "__main__":
    main()
