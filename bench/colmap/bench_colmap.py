#!/usr/bin/env python3
"""The reconstructions of COLMAP with and without masks, on drives whose poses are known, or on real clips.

    ./run bench_colmap [--drives NAME:SEED,NAME:SEED] [--frames N] [--width PIXELS] [--seeds N] [--lens given|estimated]
                       [--out DIR] [--results NAME]
    ./run bench_colmap --clips davis-train/NAME,strangers/NAME [--every N] [--frames N] [--width PIXELS] [--seeds N] [--out DIR] [--results NAME]

Synthesises the drives, masks them by `egosieve masks --for=colmap --dilate=10`, and reconstructs each without masks,
with these and with the true ones, dilated alike, once for each of COLMAP's seeds. The lens is given, or with --lens=estimated COLMAP's own estimate; all else is COLMAP's
default for a video from one camera. Counts the images of the largest model, its absolute trajectory error
after the best similarity, and the share of its 3-D points that lie on movers. Finished steps are kept in --out (default
out/colmap): the same command continues. Writes NAME.json and NAME.md into bench/results; the default NAME is colmap, of clips colmap_real.

Of clips of the test data, clips.py, no pose is known: it counts images, points, and the observations that lie on what moves, with the incremental and the
global mapper, without masks, with the model without masks after `egosieve points`, and with masks; and compares undistorted masks with true ones. COLMAP gets every
N-th picture, masks are made from all; a clip of strangers is the part of it that has boxes, and keeps the pictures that have them.

pip installs pycolmap in a virtual environment in the user's cache folder, outside the repository.
"""

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import clips  # noqa: E402
from common import RESULTS, call, environment, markdown, say, work  # noqa: E402
from drives import MASKS, Drive, cell, parser  # noqa: E402

WORKER = Path(__file__).resolve().parent / "worker.py"
DRIVES = ["buses:100", "junction:102", "crossing:100", "street:100"]
COLUMNS = {
    "registered": (">images registered", "{:.0f}"),
    "trajectory_error_metres": (">trajectory error, m", "{:.4f}"),
    "points": (">3-D points", "{:.0f}"),
    "points_on_movers": (">of these on movers", "{:.3f}"),
}


def reconstruct(python, drive, masks, seed, lens):
    """A model's scores; of those that were made before, what was written of them."""
    name = masks if lens == "given" else f"{masks}_{lens}"
    result, database = drive.root / f"{name}_{seed}.json", drive.root / f"{name}.db"
    if not result.exists():
        if not (drive.root / f"{name}.matched").exists():
            say(f"{drive.name}: matching, masks {masks}")
            database.unlink(missing_ok=True)
            work(python, WORKER, "match", drive.drive, drive.masks(masks), database, lens)
            (drive.root / f"{name}.matched").touch()
        say(f"{drive.name}: reconstructing, masks {masks}, seed {seed}")
        model = work(python, WORKER, "map", drive.drive, database, drive.root / "models" / f"{name}_{seed}", seed, lens)
        places = model.pop("places")
        result.write_text(json.dumps(model | {"registered": len(places), "trajectory_error_metres": drive.trajectory_error(places)}) + "\n")
    return json.loads(result.read_text())


def write(name, record, text):
    """Both files of the results, and the text to the screen."""
    (RESULTS / f"{name}.json").write_text(json.dumps(record, indent=1) + "\n")
    (RESULTS / f"{name}.md").write_text(text)
    print(text)


def main():
    """Drives by masks by seeds, then the table."""
    flags = parser(__doc__, DRIVES, 80)
    flags.add_argument("--seeds", type=int, default=2, help="of COLMAP's, from 1 on")
    flags.add_argument("--lens", choices=("given", "estimated"), default="given", help="the drive's, or COLMAP's estimate")
    flags.add_argument("--clips", type=lambda text: text.split(","), help="of the test data, instead of drives")
    flags.add_argument("--every", type=int, default=3, metavar="N", help="of clips: COLMAP gets every N-th picture")
    flags.add_argument("--results", metavar="NAME", help="of the files in bench/results")
    options = flags.parse_args()
    options.results = options.results or ("colmap_real" if options.clips else "colmap")
    if options.clips:
        record, text = clips.table(options)
        write(options.results, record, text)
        return
    python = environment("colmap", ["pycolmap", "numpy", "pillow"])
    version = call(python, "-c", "import pycolmap; print(pycolmap.__version__)").strip()
    rows = []
    for drive in [Drive(name, options) for name in options.drives]:
        for masks in MASKS:
            runs = [reconstruct(python, drive, masks, seed, options.lens) for seed in range(1, options.seeds + 1)]
            rows.append({"drive": drive.name, "masks": masks, "runs": runs})
    record = {"pycolmap": version, "frames": options.frames, "width": options.width, "rows": rows}
    cells = [[row["drive"], row["masks"], *(cell([run.get(name) for run in row["runs"]], form) for name, (_, form) in COLUMNS.items())]
             for row in rows]  # fmt: skip
    lens = "" if options.lens == "given" else f" --lens={options.lens}"
    text = (
        f"`./run bench_colmap --drives={','.join(options.drives)} --frames={options.frames} --width={options.width} --seeds={options.seeds}"
        f"{lens}`, pycolmap {version}. Each cell: the median over COLMAP's seeds and, where they differ, the least and the greatest.\n\n"
        + markdown(["drive", "masks", *(title for title, _ in COLUMNS.values())], cells)
    )
    write(options.results, record, text)


if __name__ == "__main__":
    main()
