#!/usr/bin/env python3
"""Whether the map gets better with what has been learnt: the same street early and late in a drive.

    bench/drive/rounds.py [--seed N] [--laps N] [--out DIR] [--program FILE] [-- FLAGS OF SEGMENT]

Scenario `rounds` passes the same places every 45 s. The drive is segmented whole, and the last lap once more in pieces: runs that
start 3 s before the pictures that are compared, with the whole run's camera, so that both use the same lens. The same
pictures are scored in both, by the AUC of each picture that has movers. Writes, in DIR, rounds.csv (a row per picture), rounds.svg and
rounds.md: the mean gain of the whole run with its 95 % interval, by a bootstrap over the pieces.
"""

import argparse
import csv
import random
import statistics
import subprocess
from pathlib import Path

import figures

FPS, LAP_SECONDS, PIECE_SECONDS = 10, 45, 3
RESAMPLES = 2000
EVALUATION = Path(__file__).resolve().parents[2] / "tools" / "evaluate" / "egosieve-eval"


def run(*words):
    """Runs the program; ends with its message where it fails."""
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"rounds: {' '.join(map(str, words))}: {done.stderr.strip()[-500:]}")


def scores(program, drive, out, flags):
    """The AUC of each picture of a run by its frame."""
    run(program, "segment", drive / "frames", f"--out={out}", f"--fps={FPS}", "--overwrite", *flags)
    run(EVALUATION, out, f"--truth={drive / 'masks'}", "--no-plots")
    with open(out / "eval.csv") as file:
        return {int(row["frame"]): float(row["auc"]) for row in csv.DictReader(file) if row["auc"] not in ("", "nan")}


def measure(options):
    """Rows of (piece, frame, AUC of the whole run, AUC of the piece's run)."""
    drive, lap, length = options.out / "drive", LAP_SECONDS * FPS, PIECE_SECONDS * FPS
    frames = options.laps * lap
    if not (drive / "scene.json").exists():
        run(options.program, "synthesize", "--scenario=rounds", f"--seed={options.seed}", f"--frames={frames}", f"--fps={FPS}",
            f"--out={drive}", "--overwrite")  # fmt: skip
    whole = scores(options.program, drive, options.out / "whole", options.flags)
    camera = options.out / "whole" / "camera.json"
    rows = []
    for piece, first in enumerate(range(frames - lap, frames - length + 1, length)):
        flags = [f"--from={first - length}", f"--to={first + length - 1}", f"--camera={camera}", *options.flags]
        early = scores(options.program, drive, options.out / f"piece_{piece:02}", flags)
        rows += [(piece, f, whole[f], early[f]) for f in range(first, first + length) if f in whole and f in early]
    return rows


def bootstrap(rows):
    """The mean gain of the whole run and its 95 % interval over the pieces."""
    leads = {}
    for piece, _, late, early in rows:
        leads.setdefault(piece, []).append(late - early)
    leads = list(leads.values())
    draw = random.Random(1)
    means = sorted(statistics.fmean(sum(draw.choices(leads, k=len(leads)), [])) for _ in range(RESAMPLES))
    return statistics.fmean(sum(leads, [])), means[int(0.025 * RESAMPLES)], means[int(0.975 * RESAMPLES)]


def plot(rows, folder):
    """Both by frame, like the paper's figure 4b."""
    found = {row[1]: row[2:] for row in rows}
    frames = range(min(found), max(found) + 1)
    names = ("the whole drive's run", f"runs that began {PIECE_SECONDS} to {2 * PIECE_SECONDS} s before")
    series = [(name, [f / FPS for f in frames], [found[f][i] if f in found else None for f in frames]) for i, name in enumerate(names)]
    figures.draw([figures.lines("rounds", "The same pictures in both", ("seconds of the drive", "AUC"), series)], folder)


def main():
    """Measures, writes and prints."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--laps", type=int, default=3)
    parser.add_argument("--out", type=Path, default=Path("out/rounds"))
    parser.add_argument("--program", type=Path, default=Path(__file__).resolve().parents[2] / "bazel-bin" / "tools" / "egosieve")
    parser.add_argument("flags", nargs="*", help="of segment, after --")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    rows = measure(options)
    with open(options.out / "rounds.csv", "w", newline="") as file:
        csv.writer(file).writerows([("piece", "frame", "auc_whole", "auc_begun_anew"), *rows])
    plot(rows, options.out)
    lead, least, most = bootstrap(rows)
    text = (
        f"{len(rows)} pictures of lap {options.laps} of seed {options.seed}: mean AUC {statistics.fmean(row[2] for row in rows):.4f} in the "
        f"whole run, {statistics.fmean(row[3] for row in rows):.4f} in runs that began {PIECE_SECONDS} to {2 * PIECE_SECONDS} s before; "
        f"the whole run leads by {lead:+.4f} (95 % interval {least:+.4f} to {most:+.4f})\n"
    )
    (options.out / "rounds.md").write_text(text)
    print(text, end="")


if __name__ == "__main__":
    main()
