#!/usr/bin/python3
"""How the cost of a drive grows with the pictures' size, the model's points, cores and the drive's length.

    bench/drive/cost_table.py [--profile NAME] [--out DIR] [--quick]

As bench_drive.py measures it on KITTI's residential street, scaled; cost = a x^b, fitted by least squares of the logarithms. Writes
cost.json, cost.md and a figure of each, cost_megapixels.svg and so on, in DIR, default bench/results.
"""

import argparse
import json
import math
import os
import statistics
from pathlib import Path

import bench_drive
import figures
from machine import machine

ROOT = Path(__file__).resolve().parents[2]
PROCESSOR, CLOCK = "processor_seconds_per_frame", "seconds_per_frame"
# title, what varies, its values, frames, what is read, its name, the unit of the values
SERIES = [
    ("Size of the pictures", "megapixels", [0.25, 0.5, 1, 2, 4, 8], 16, PROCESSOR, "processor s per frame", "megapixels"),
    ("Points of the model", "budget", [500, 1000, 2000, 4000], 40, PROCESSOR, "processor s per frame", "points"),
    ("Cores", "threads", [1, 2], 40, CLOCK, "s per frame", "threads"),
    ("Length of the drive", "frames", [40, 80, 160, 320], None, "processor_seconds", "processor s in all", "frames"),
]


def measure(profile, what, value, frames):
    """The profile's figures where `what` has that value."""
    flags = [f"--{what}={value}"] if what in ("budget", "threads") else []
    return bench_drive.measure([profile], frames or value, value if what == "megapixels" else None, flags)[0]


def exponent(points):
    """b of cost = a x^b."""
    return statistics.linear_regression(*([math.log(p[i]) for p in points] for i in (0, 1))).slope


def markdown(record):
    """A table for each series."""
    lines = [
        "# What a drive costs",
        "",
        f"`bench/drive/cost_table.py --profile={record['profile']}`, {record['machine']}, load {record['load']:.1f} before. KITTI's residential",
        "street back and forth, the second half of the frames. Cost = a x^b, b by least squares of the logarithms.",
        "",
    ]
    for series in record["series"]:
        lines += [
            f"## {series['title']}",
            "",
            f"| {series['unit']} | {series['what']} | points in the model | resident, MiB |",
            "|---:|---:|---:|---:|",
            *[f"| {p['at']:g} | {p['cost']:.3g} | {p['model_points']} | {p['resident_mebibytes']:.0f} |" for p in series["points"]],
            "",
            f"Exponent b = {series['exponent']:.2f}.",
            "",
        ]
    return "\n".join(lines[:-1]) + "\n"


def plot(record, folder):
    """A figure for each series, both axes logarithmic."""
    drawn = []
    for (_, varied, *_), series in zip(SERIES, record["series"]):
        points = series["points"]
        line = (series["title"], [p["at"] for p in points], [p["cost"] for p in points])
        title = f"{series['title']}, b = {series['exponent']:.2f}"
        drawn.append(figures.lines(f"cost_{varied}", title, (series["unit"], series["what"]), [line], logarithmic_x=True, logarithmic_y=True))
    figures.draw(drawn, folder)


def main():
    """Measures and writes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--profile", default="default")
    parser.add_argument("--out", type=Path, default=ROOT / "bench" / "results")
    parser.add_argument("--quick", action="store_true", help="the two least values of each series alone")
    options = parser.parse_args()
    record = {"profile": options.profile, "machine": machine(), "load": os.getloadavg()[0], "series": []}
    for title, varied, values, frames, field, what, unit in SERIES:
        points = []
        for value in values[:2] if options.quick else values:
            found = measure(options.profile, varied, value, frames)
            points.append({"at": value, "cost": found[field]} | {k: found[k] for k in ("model_points", "resident_mebibytes")})
            print(f"{title}: {value} {unit}, {found[field]:.3g} {what}", flush=True)
        slope = exponent([(p["at"], p["cost"]) for p in points])
        record["series"].append({"title": title, "unit": unit, "what": what, "exponent": slope, "points": points})
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "cost.json").write_text(json.dumps(record, indent=1) + "\n")
    (options.out / "cost.md").write_text(markdown(record))
    plot(record, options.out)


if __name__ == "__main__":
    main()
