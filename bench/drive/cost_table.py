#!/usr/bin/python3
"""How the cost of a drive grows with the pictures' size, the model's points, cores and the drive's length.

    bench/drive/cost_table.py [--profile NAME]

As bench_drive.py measures it on KITTI's residential street, scaled; cost = a x^b, fitted by least squares of the logarithms. Writes
cost.json and cost.md in bench/results.
"""

import argparse
import json
import os

import bench_drive
import numpy as np
from common import RESULTS, machine, markdown

PROCESSOR, CLOCK = "processor_seconds_per_frame", "seconds_per_frame"
# title, what varies, its values, frames, what is read, its name, the unit of the values
SERIES = [
    ("Size of the pictures", "megapixels", [0.25, 0.5, 1, 2, 4, 8], 16, PROCESSOR, "processor s per frame", "megapixels"),
    ("Points of the model", "budget", [500, 1000, 2000, 4000], 40, PROCESSOR, "processor s per frame", "points"),
    ("Cores", "threads", [1, 2], 40, CLOCK, "s per frame", "threads"),
    ("Length of the drive", "frames", [40, 80, 160, 320], None, "processor_seconds", "processor s in all", "frames"),
]


def page(record):
    """A table for each series."""
    text = (
        f"# What a drive costs\n\n`bench/drive/cost_table.py --profile={record['profile']}`, {record['machine']}, load {record['load']:.1f} before. "
        "KITTI's residential\nstreet back and forth, the second half of the frames. Cost = a x^b, b by least squares of the logarithms.\n"
    )
    for series in record["series"]:
        rows = [(f"{p['at']:g}", f"{p['cost']:.3g}", p["model_points"], f"{p['resident_mebibytes']:.0f}") for p in series["points"]]
        table = markdown([f">{series['unit']}", f">{series['what']}", ">points in the model", ">resident, MiB"], rows)
        text += f"\n## {series['title']}\n\n{table}\nExponent b = {series['exponent']:.2f}.\n"
    return text


def main():
    """Measures and writes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--profile", default="default")
    options = parser.parse_args()
    record = {"profile": options.profile, "machine": machine(), "load": os.getloadavg()[0], "series": []}
    for title, varied, values, frames, field, what, unit in SERIES:
        points = []
        for value in values:
            flags = [f"--{varied}={value}"] if varied in ("budget", "threads") else []
            megapixels = value if varied == "megapixels" else None
            found = bench_drive.measure([options.profile], frames or value, megapixels, flags)[0]
            points.append({"at": value, "cost": found[field]} | {k: found[k] for k in ("model_points", "resident_mebibytes")})
            print(f"{title}: {value} {unit}, {found[field]:.3g} {what}", flush=True)
        slope = np.polyfit(*np.log([(p["at"], p["cost"]) for p in points]).T, 1)[0]
        record["series"].append({"title": title, "unit": unit, "what": what, "exponent": slope, "points": points})
    (RESULTS / "cost.json").write_text(json.dumps(record, indent=1) + "\n")
    (RESULTS / "cost.md").write_text(page(record))


if __name__ == "__main__":
    main()
