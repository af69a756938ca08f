#!/usr/bin/env python3
"""Measures the figures of docs/results.md at the present commit, and writes the page.

    ./run results                  all: docs/results.json, then the page from docs/results.md.in; about half an hour
    ./run results davis demo       these alone; the page says where another commit gave the others
    ./run results --page           the page alone, from results.json

results.json has the commit, the machine, and of each measurement its command and its figures. Real data: $EGOSIEVE_DATA, else
../shared/data; without them only the synthetic measurements are made.
"""

import argparse
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import time
from datetime import date
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "bench"))

from common import machine  # noqa: E402

OUT = ROOT / "out" / "results"
DATA = Path(os.environ.get("EGOSIEVE_DATA", ROOT.parent / "shared" / "data"))
EVALUATE = "tools/evaluate/egosieve-eval"
SUITE = f"{EVALUATE} suite %s --max-frames=24 --no-plots -q --out={{out}}/%s"

# Pictures of each clip of davis-train that has so many, as clips of their own, numbered anew.
PARTS = (
    "rm -rf {out}/%(name)s; for d in {data}/davis-train/*; do [ $(ls $d/frames | wc -l) -ge %(fewest)d ] || continue; n=10000; c={out}/%(name)s/$(basename $d); "
    "mkdir -p $c/frames $c/masks; for f in $(ls $d/frames | %(filter)s); do n=$((n + 1)); ln -s $(realpath $d/frames/$f) $c/frames/$n.jpg; "
    "ln -s $(realpath $d/masks/${{f%%.*}}.png) $c/masks/$n.png; done; done; "
)
ENDS = PARTS % {"name": "ends", "fewest": 40, "filter": "tail -24"}
BACKWARDS = PARTS % {"name": "backwards", "fewest": 24, "filter": "head -24 | tac"}
DRIVING = "mkdir -p {out}/driving; for d in kitti-cyclist kitti-residential kt3dmoseg; do ln -sfn $(realpath {data}/$d) {out}/driving/$d; done; "


def suite(name):
    """Means over the sequences, the worst, and what the flagged frames are worth."""
    table = json.loads((OUT / name / "suite.json").read_text())
    group = next(g for g in table["groups"] if g["group"] == "all")["figures"]
    figures = {f"{k}_{which}": v[which] for k, v in group.items() if v for which in ("mean", "median", "least")}
    found = sorted((s["mask_j"], s["sequence"]) for s in table["sequences"] if s["mask_j"] is not None)
    figures["worst_j"] = ", ".join(f"{sequence} {j:.2f}" for j, sequence in found[:5])
    figures["sequences"] = len(table["sequences"])
    figures["auc_by_sequence"] = ", ".join(f"{s['sequence']} {s['mean_auc']:.3f}" for s in table["sequences"])
    figures["j_by_sequence"] = ", ".join(f"{sequence} {j:.2f}" for j, sequence in sorted(found, key=lambda f: f[1]))
    return figures


def doubt(name):
    """How the maps' expected IoU ranks bad masks, as the suite's table says it."""
    text = (OUT / f"{name}.log").read_text()
    found = re.search(r"(\d+) of (\d+) frames have a mask J below 0.3; .* AUC of ([\d.]+):.*below 0.4 ([\d.]+) of these and ([\d.]+)", text)
    return dict(zip(("bad", "frames", "auc", "flagged_of_bad", "flagged_of_others"), map(float, found.groups()))) if found else {}


def strangers(name):
    """Of the maps and the masks: near moving vehicles marked, area outside all boxes, percent; what the flags are worth."""
    text = (OUT / f"{name}.log").read_text()
    (near_map, outside_map), (near_mask, outside_mask) = (
        (float(line.split()[1]), float(line.split()[-1])) for line in text.splitlines() if line.startswith("all ")
    )
    found = re.findall(r"doubt: (\d+) bad frames, (\d+) good ones, AUC ([\d.]+); flagged ([\d.]+) of the bad, ([\d.]+) of the good", text)
    flags = dict(zip(("bad", "good", "auc", "flagged_of_bad", "flagged_of_good"), map(float, found[-1])))
    return {"near_map": near_map, "outside_map": outside_map, "near_mask": near_mask, "outside_mask": outside_mask} | flags


def boxes(name):
    """Moving vehicles whose boxes are marked, and the area marked outside all boxes."""
    scores = json.loads((OUT / name / "further.json").read_text())["boxes"]
    vehicles = scores["kinds"]["moving vehicle"]["all"]
    return {"marked": vehicles["marked"], "boxes": vehicles["boxes"], "outside_percent": 100 * scores["outside_marked_share"]}


def profiles(name):
    """Seconds per frame of each profile."""
    found = json.loads((OUT / f"{name}.log").read_text())
    return {p["profile"]: p["seconds_per_frame"] for p in found} | {
        f"{p['profile']}_processor": p["processor_seconds_per_frame"] for p in found
    }


def benchmarks(name):
    """Rates of Google Benchmark, in units of 1e9 per second, by name."""
    found = json.loads((OUT / f"{name}.json").read_text())["benchmarks"]
    return {b["name"]: b["evaluations_per_second"] / 1e9 for b in found if "evaluations_per_second" in b}


def clock(name):
    """Nothing but the seconds, which all have."""
    return {}


# name: what it runs, and how its figures are read. The run's own seconds are always among them.
MEASUREMENTS = {
    "davis_train": (SUITE % ("{data}/davis-train", "davis_train"), lambda n: suite(n) | doubt(n)),
    "davis_ends": (ENDS + SUITE % ("{out}/ends", "davis_ends"), lambda n: suite(n) | doubt(n)),
    "davis_backwards": (BACKWARDS + SUITE % ("{out}/backwards", "davis_backwards"), suite),
    "davis_captions": (
        "rm -rf {out}/captions; bench/drive/draw_captions.py {data}/davis-train {out}/captions && " + SUITE % ("{out}/captions", "davis_captions"),
        suite,
    ),
    "davis_joined": (
        "rm -rf {out}/joined; bench/drive/join_clips.py {data}/davis-train {out}/joined && " + SUITE % ("{out}/joined", "davis_joined"),
        suite,
    ),
    "davis": (SUITE % ("{data}/davis", "davis"), suite),
    "real": (DRIVING + SUITE % ("{out}/driving", "real"), suite),
    "live": (DRIVING + SUITE % ("{out}/driving", "live") + " --no-masks --segment-flags='--ahead=0 --no_first_pass'", suite),
    "dashcam": (
        "{program} segment {data}/highway/dashcam_reflections.mp4 --out={out}/dashcam --overwrite --progress=none && "
        f"{EVALUATE} {{out}}/dashcam --boxes=tests/tools/evaluate/labels/dashcam_reflections.csv --no-plots -q",
        boxes,
    ),
    # Of each clip the labelled frames, with 60 before and 10 after them.
    "strangers": (
        "awk -F, 'NR > 1 {{ if (!($1 in first)) first[$1] = $2; last[$1] = $2 }} END {{ for (c in first) print c, first[c], last[c] }}' "
        "tests/vision/strangers/boxes.csv | sort | while read c first last; do {program} run {data}/strangers/$c.mp4 --out={out}/strangers/$c "
        "--from=$((first < 60 ? 0 : first - 60)) --to=$((last + 10)) --no_video </dev/null || [ $? = 4 ] || exit 1; done || exit 1; "
        "for what in '' --masks; do tests/vision/strangers/score.py {out}/strangers $what; done",
        strangers,
    ),
    "drives": (
        "rm -rf {out}/fresh; for s in street junction dashcam crossing overtaking stop_and_go; do for k in 101 102 103; do {program} synthesize "
        f"--scenario=$s --seed=$k --frames=40 --out={{out}}/fresh/$s$k --progress=none || exit 1; done; done; {EVALUATE} suite {{out}}/fresh --no-plots -q --out={{out}}/drives",
        suite,
    ),
    "first_mask": ("rm -rf {out}/cows; {program} run {data}/davis/cows/frames --out={out}/cows", clock),
    "first_picture": (
        "rm -rf {out}/first {out}/pocl; POCL_CACHE_DIR={out}/pocl {program} run {data}/strangers/dashcam_intersection.mp4 --out={out}/first & "
        "until [ -e {out}/first/preview.png ] || ! kill -0 $!; do sleep 0.1; done; kill $!; wait $!; [ -e {out}/first/preview.png ]",
        clock,
    ),
    "speed": ("bench/drive/bench_drive.py --frames=40 --profiles=default,fast,opencv", profiles),
    "gp": (
        "{bench} --benchmark_filter='BM_DensePosterior(Mean|Variance)' --json={out}/gp.json",
        benchmarks,
    ),
    "kills": ("{kill_soak} --seconds=60", clock),
}


def measure(name, record):
    """One measurement, into the record; its output in out/results/NAME.log."""
    template, read = MEASUREMENTS[name]
    names = {"program": "bazel-bin/tools/egosieve", "bench": "bazel-bin/bench/bench", "kill_soak": "bazel-bin/tests/tools/faults/kill_soak"}
    command = template.format(data=shlex.quote(os.path.relpath(DATA, ROOT)), out="out/results", **names)
    shutil.rmtree(OUT / name, ignore_errors=True)  # a suite would use its former runs
    start = time.monotonic()
    with open(OUT / f"{name}.log", "w") as log:
        environment = os.environ | {"EGOSIEVE_DATA": str(DATA), "EGOSIEVE_PROGRAM": str(ROOT / names["program"])}
        done = subprocess.run(["bash", "-c", command], cwd=ROOT, env=environment, stdout=log, stderr=subprocess.STDOUT if read is clock else None, check=False)
    if done.returncode not in (0, 4):
        raise SystemExit(f"results: {name}: exit code {done.returncode}: {command}")
    seconds = time.monotonic() - start
    git = lambda *words: subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=False)  # noqa: E731
    changed = git("diff", "--quiet", "HEAD", "--", ".", ":!docs").returncode != 0
    commit = git("rev-parse", "--short=8", "HEAD").stdout.strip() + "-dirty" * changed
    record[name] = {"command": command, "commit": commit, "date": str(date.today()), "machine": machine(), "load": os.getloadavg()[0],
                    "figures": {"seconds": seconds, "last_line": (OUT / f"{name}.log").read_text().strip().split("\n")[-1][:200], **read(name)}}  # fmt: skip
    print(f"results: {name}, {seconds:.0f} s", flush=True)


def page(record):
    """docs/results.md; KeyError while a measurement is missing."""
    states = {(m["commit"], m["date"], m["machine"]) for m in record.values()}
    told = "; ".join(f"commit {commit}, {day}, {where}" for commit, day, where in sorted(states))
    values = {name: {"command": record[name]["command"], **record[name]["figures"]} for name in MEASUREMENTS}
    rates = "\n".join(f"| {name} | {rate:.2f} |" for name, rate in values["gp"].items() if name.startswith("BM_"))
    hours = 36e6 * values["speed"]["default_processor"] / 3600
    return (ROOT / "docs" / "results.md.in").read_text().format(state=told, gp_rows=rates, thousand=f"{hours:,.0f}", **values)


def main():
    """Measures what is asked and writes both files."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(MEASUREMENTS))
    parser.add_argument("--page", action="store_true", help="write the page alone")
    options = parser.parse_args()
    if unknown := set(options.names) - set(MEASUREMENTS):
        parser.error(f"no measurement {', '.join(sorted(unknown))}")
    file = ROOT / "docs" / "results.json"
    record = json.loads(file.read_text()) if file.exists() else {}
    OUT.mkdir(parents=True, exist_ok=True)
    for name in [] if options.page else options.names or MEASUREMENTS:
        if "{data}" not in MEASUREMENTS[name][0] or DATA.is_dir():
            measure(name, record)
            if file.exists():  # another call may have written it since
                record = json.loads(file.read_text()) | {name: record[name]}
            file.write_text(json.dumps(record, indent=1) + "\n")
    (ROOT / "docs" / "results.md").write_text(page(record))


if __name__ == "__main__":
    main()
