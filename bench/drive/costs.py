#!/usr/bin/env python3
"""What a frame costs by picture size, model size, cores and drive length, with the exponents of the growth.

    bench/drive/costs.py [--profile default] [--frames 8] [--megapixels 0.25,0.5,1,2,4,8] [--only TABLE,TABLE]

Processor seconds are those of all threads, which other programs on the machine disturb less than the clock. The
exponent b of cost ~ x^b is a least-squares line through the logarithms. Writes costs.json and costs.md into
bench/results.
"""

import argparse
import json
import math
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
PROGRAM = ROOT / "bazel-bin" / "bench" / "drive" / "bench_drive"
RESULTS = ROOT / "bench" / "results"
TABLES = ("size", "model", "cores", "length")


def measure(profile, frames, **flags):
    """One run of bench_drive; the profile's entry with the picture's size."""
    command = [str(PROGRAM), f"--profiles={profile}", f"--frames={frames}"]
    command += [f"--{name}={value}" for name, value in flags.items()]
    print("costs: " + " ".join(command[1:]), file=sys.stderr, flush=True)
    result = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
    return result | result["profiles"][0]


def exponent(points):
    """Slope of log y over log x."""
    xs, ys = [math.log(x) for x, _ in points], [math.log(y) for _, y in points]
    x_mean, y_mean = sum(xs) / len(xs), sum(ys) / len(ys)
    return sum((x - x_mean) * (y - y_mean) for x, y in zip(xs, ys)) / sum((x - x_mean) ** 2 for x in xs)


def row(x, result):
    return {
        "x": x,
        "seconds_per_frame": result["seconds_per_frame_median"],
        "processor_seconds_per_frame": result["processor_seconds_per_frame_median"],
        "resident_mebibytes": result["resident_mebibytes"],
        "processor_seconds": result["processor_seconds"],
        "seconds": result["seconds"],
    }


def tables(options):
    sizes = [float(size) for size in options.megapixels.split(",")]
    profile, frames = options.profile, options.frames
    wanted = options.only.split(",")
    if "size" in wanted:
        yield "megapixels", "processor_seconds_per_frame", [
            row(size, measure(profile, frames, megapixels=size)) for size in sizes]
    if "model" in wanted:
        yield "points of the model", "processor_seconds_per_frame", [
            row(points, measure(profile, max(frames, 12), model_points=points)) for points in (400, 800, 1500, 3000)]
    if "cores" in wanted:
        yield "threads", "seconds_per_frame", [
            row(threads, measure(profile, max(frames, 16), threads=threads)) for threads in (1, 2)]
    if "length" in wanted:
        yield "frames of the drive", "processor_seconds", [
            row(count, measure(profile, count)) for count in (25, 50, 100)]


def to_markdown(profile, found):
    lines = [f"Profile {profile}; kitti-residential, 1242x375 where no size is given. `bench/drive/costs.py`", ""]
    for table in found:
        lines += [f"| {table['by']} | seconds per frame | processor seconds per frame | MiB resident |",
                  "|---:|---:|---:|---:|"]
        lines += [f"| {r['x']:g} | {r['seconds_per_frame']:.3f} | {r['processor_seconds_per_frame']:.3f} | "
                  f"{r['resident_mebibytes']:.0f} |" for r in table["rows"]]
        lines += ["", f"{table['fitted'].replace('_', ' ')} grow as x^{table['exponent']:.2f}.", ""]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--profile", default="default")
    parser.add_argument("--frames", type=int, default=8)
    parser.add_argument("--megapixels", default="0.25,0.5,1,2,4,8")
    parser.add_argument("--only", default=",".join(TABLES))
    options = parser.parse_args()
    found = [
        {"by": by, "fitted": fitted, "exponent": exponent([(r["x"], r[fitted]) for r in rows]), "rows": rows}
        for by, fitted, rows in tables(options)
    ]
    name = "costs" if options.profile == "default" else f"costs_{options.profile}"
    (RESULTS / f"{name}.json").write_text(json.dumps(found, indent=2) + "\n")
    (RESULTS / f"{name}.md").write_text(to_markdown(options.profile, found))


if __name__ == "__main__":
    main()
