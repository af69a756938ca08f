#!/usr/bin/env python3
"""The reconstructions of COLMAP with and without masks, on drives whose poses are known.

    ./run bench_colmap [--drives NAME:SEED,NAME:SEED] [--frames N] [--width PIXELS] [--seeds N] [--lens given|estimated]
                       [--out DIR] [--results NAME]

Synthesises the drives, masks them by `egosieve masks --for=colmap --dilate=10`, and reconstructs each without masks,
with these and with the true ones, dilated alike, once for each of COLMAP's seeds. The lens is given, or with --lens=estimated COLMAP's own estimate; all else is COLMAP's
default for a video from one camera. Counts the images of the largest model, its absolute trajectory error
after the best similarity, and the share of its 3-D points that lie on movers. Finished steps are kept in --out (default
out/colmap): the same command continues. Writes NAME.json and NAME.md into bench/results; the default NAME is colmap.

pip installs pycolmap in a virtual environment in the user's cache folder, outside the repository.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
RESULTS = ROOT / "bench" / "results"
CACHE = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "egosieve" / "colmap"
PIP = ["pycolmap", "numpy", "pillow"]
DILATION_PIXELS = 10
MASKS = ("none", "ours", "true")
TIMEOUT_SECONDS = 3600


def say(text):
    """Progress, beside the results."""
    print(f"bench_colmap: {text}", file=sys.stderr, flush=True)


def make_environment():
    """The interpreter of a virtual environment with pycolmap."""
    interpreter = CACHE / "bin" / "python"
    if interpreter.exists() and subprocess.run([interpreter, "-c", "import pycolmap, numpy, PIL"], capture_output=True).returncode == 0:  # fmt: skip
        return interpreter
    say(f"making {CACHE}")
    for command in (["/usr/bin/python3", "-m", "venv", CACHE], [interpreter, "-m", "pip", "install", "-q", *PIP]):
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"bench_colmap: {' '.join(map(str, command))} failed: {done.stderr.strip() or done.stdout.strip()}")
    return interpreter


def egosieve(*arguments):
    """A command of the program; its failure ends the bench."""
    subprocess.run([os.environ["EGOSIEVE_PROGRAM"], *map(str, arguments), "--progress=none"], check=True, stdout=subprocess.DEVNULL)


class Drive:
    """A scenario's files below --out, made where they are missing."""

    def __init__(self, interpreter, name, options):
        self._interpreter = interpreter
        self._options = options
        self.name = name
        self._scenario, self._seed = name.split(":")
        self.root = Path(options.out) / f"{self._scenario}_{self._seed}_{options.frames}_{options.width}"
        self.drive = self.root / "drive"

    def _work(self, *arguments):
        done = subprocess.run([str(word) for word in (self._interpreter, HERE / "worker.py", *arguments)],
                              capture_output=True, text=True, timeout=TIMEOUT_SECONDS)  # fmt: skip
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(map(str, arguments))}: {done.stderr.strip()[-500:]}")
        return json.loads(done.stdout.strip().splitlines()[-1])

    def prepare(self):
        """Frames, truth and masks."""
        if not (self.drive / "scene.json").exists():
            say(f"{self.name}: synthesising")
            egosieve("synthesize", f"--scenario={self._scenario}", f"--seed={self._seed}",
                     f"--frames={self._options.frames}", f"--width={self._options.width}",
                     f"--height={self._options.width * 9 // 16}", f"--out={self.drive}", "--overwrite")  # fmt: skip
        done = self.root / "masked"
        if not done.exists():
            say(f"{self.name}: masking")
            egosieve("masks", self.drive / "frames", "--for=colmap", f"--dilate={DILATION_PIXELS}",
                     f"--out={self.root / 'ours'}", "--overwrite")  # fmt: skip
            self._work("true_masks", self.drive, self.root / "true", DILATION_PIXELS)
            done.touch()

    def reconstruct(self, masks, seed):
        """A model's scores; of those that were made before, what was written of them."""
        lens = self._options.lens
        end = "" if lens == "given" else f"_{lens}"
        result = self.root / f"{masks}{end}_{seed}.json"
        if not result.exists():
            database = self.root / f"{masks}{end}.db"
            matched = self.root / f"{masks}{end}.matched"
            if not matched.exists():
                say(f"{self.name}: matching, masks {masks}")
                database.unlink(missing_ok=True)
                self._work("match", self.drive, "-" if masks == "none" else self.root / masks, database, lens)
                matched.touch()
            say(f"{self.name}: reconstructing, masks {masks}, seed {seed}")
            scores = self._work("map", self.drive, database, self.root / "models" / f"{masks}{end}_{seed}", seed, lens)
            result.write_text(json.dumps(scores) + "\n")
        return json.loads(result.read_text())


def cell(values, form):
    """Median, with the least and the greatest where they differ; a dash where there is none."""
    values = [value for value in values if value is not None]
    if not values:
        return "-"
    low, middle, high = (form.format(value) for value in (min(values), statistics.median(values), max(values)))
    return middle if low == high else f"{middle} ({low} to {high})"


def table(rows, options, version):
    """The results as Markdown."""
    text = (
        f"`./run bench_colmap --drives={','.join(options.drives)} --frames={options.frames} --width={options.width} --seeds={options.seeds}{'' if options.lens == 'given' else ' --lens=' + options.lens}`, pycolmap {version}. Each cell: the median over COLMAP's seeds and, "
        "where they differ, the least and the greatest.\n\n"
        "| drive | masks | images registered | trajectory error, m | 3-D points | of these on movers |\n"
        "|---|---|---:|---:|---:|---:|\n"
    )
    for row in rows:
        runs = row["runs"]
        columns = [("registered", "{:.0f}"), ("trajectory_error_metres", "{:.4f}"), ("points", "{:.0f}"), ("points_on_movers", "{:.3f}")]
        cells = [cell([run.get(name) for run in runs], form) for name, form in columns]
        text += f"| {row['drive']} | {row['masks']} | " + " | ".join(cells) + " |\n"
    return text


def parse_arguments():
    """The flags."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drives", default="buses:100,junction:102,crossing:100,street:100", help="scenario and seed of egosieve synthesize")
    parser.add_argument("--frames", type=int, default=80, help="of each drive")
    parser.add_argument("--width", type=int, default=640, help="of the pictures, pixels")
    parser.add_argument("--seeds", type=int, default=2, help="of COLMAP's, from 1 on")
    parser.add_argument("--lens", choices=("given", "estimated"), default="given", help="the drive's, or COLMAP's estimate")
    parser.add_argument("--out", default=str(ROOT / "out" / "colmap"), help="folder for drives, masks and models")
    parser.add_argument("--results", default="colmap", metavar="NAME", help="of the files in bench/results")
    options = parser.parse_args()
    options.drives = options.drives.split(",")
    return options


def main():
    """Drives by masks by seeds, then the table."""
    options = parse_arguments()
    interpreter = make_environment()
    version = subprocess.run([interpreter, "-c", "import pycolmap; print(pycolmap.__version__)"], capture_output=True, text=True, check=True).stdout.strip()  # fmt: skip
    drives = [Drive(interpreter, name, options) for name in options.drives]
    for drive in drives:
        drive.prepare()
    rows = [{"drive": drive.name, "masks": masks, "runs": []} for drive in drives for masks in MASKS]
    for seed in range(1, options.seeds + 1):
        for row, drive in zip(rows, [drive for drive in drives for _ in MASKS]):
            row["runs"].append(drive.reconstruct(row["masks"], seed))
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / f"{options.results}.json").write_text(json.dumps({"pycolmap": version, "frames": options.frames, "width": options.width, "rows": rows}, indent=1) + "\n")  # fmt: skip
    text = table(rows, options, version)
    (RESULTS / f"{options.results}.md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
