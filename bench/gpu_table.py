#!/usr/bin/env python3
"""The table of `./run bench_gpu` from Google Benchmark's JSON: gpu_table.py FILE.json

A benchmark a row: its time, and what it counts, of which `fraction_of_` is of the device's own peak in the same run.
"""

import json
import sys
from pathlib import Path

from common import markdown

COLUMNS = {
    "queries_per_second": "queries/s",
    "evaluations_per_second": "evaluations/s",
    "pairs_per_second": "pairs/s",
    "points_per_second": "points/s",
    "kitti_pictures_per_second": "pictures of 1242x375 /s",
    "gflops": "GFLOP/s",
    "fraction_of_fma_peak": "of the multiply-add peak",
}


def cell(value):
    """Three digits that count."""
    return "" if value is None else f"{value:,.0f}" if value >= 1000 else f"{value:.3g}"


def table(results):
    """Markdown."""
    rows, runs = [], [run for run in results["benchmarks"] if run.get("run_type") != "aggregate"]
    columns = {key: title for key, title in COLUMNS.items() if any(key in run for run in runs)}
    for run in runs:
        name = run["name"].replace("/real_time", "").replace("/process_time", "")
        time = run["error_message"] if run.get("error_occurred") else f"{cell(run['real_time'])} {run['time_unit']}"
        rows.append([name, time, *(cell(run.get(key)) for key in columns)])
    device = results["context"].get("device", "an unnamed device")
    return f"# Benchmarks on {device}\n\n" + markdown(["benchmark", ">time", *(f">{title}" for title in columns.values())], rows)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(f"usage: {sys.argv[0]} FILE.json")
    print(table(json.loads(Path(sys.argv[1]).read_text())), end="")
