"""Real clips for bench_colmap.py: their pictures, masks, and what is known to move in them."""

import os
import shutil
import sys
from pathlib import Path

import cv2
import numpy as np
from common import PROGRAM, ROOT, call, environment, markdown, say, work
from drives import DILATION_PIXELS, cell

sys.path.insert(0, str(ROOT / "tests" / "vision" / "strangers"))

from score import area, read_boxes  # noqa: E402

WORKER = Path(__file__).resolve().parent / "worker.py"
DATA = Path(os.environ.get("EGOSIEVE_DATA", ROOT.parent / "shared" / "data"))
BOXES = ROOT / "tests" / "vision" / "strangers" / "boxes.csv"
GREYS = {"standing": 0, "unknown": 128, "moving": 255}
MAPPERS = ("incremental", "global")
FEATURES = 2000
MODELS = ("none", "none, then points", "ours", "true")
COLUMNS = {
    "registered": (">images registered", "{:.0f}"),
    "points": (">3-D points", "{:.0f}"),
    "observations_on_movers": (">observations on movers", "{:.4f}"),
    "reprojection_error_pixels": (">reprojection error, pixels", "{:.3f}"),
    "track_length": (">track length", "{:.1f}"),
}


def resized(picture, width, how):
    """At most as wide as that."""
    height, least = round(picture.shape[0] * width / picture.shape[1]), min(width, picture.shape[1])
    return picture if least == picture.shape[1] else cv2.resize(picture, (width, height), interpolation=how)


def davis(folder):
    """(name, picture, its true mask) of each picture of a sequence of DAVIS."""
    for path in sorted((folder / "frames").glob("*.jpg")):
        yield path.stem, cv2.imread(str(path)), cv2.imread(str(folder / "masks" / f"{path.stem}.png"), cv2.IMREAD_GRAYSCALE)


def stranger(path, frames):
    """The same of the part of a video that has boxes; the mask, of boxes filled with their grey, is None for pictures without."""
    boxes = read_boxes(BOXES)[path.stem]
    first = max((min(boxes) + max(boxes) - frames) // 2, 0)
    video = cv2.VideoCapture(str(path))
    for index in range(first + frames):
        there, picture = video.read()
        if there and index >= first:
            mask = np.zeros(picture.shape[:2], np.uint8)
            for row in sorted(boxes.get(index, []), key=lambda row: GREYS[row["motion"]]):
                mask[area(row)] = GREYS[row["motion"]]
            yield f"{index:06d}", picture, mask if index in boxes else None


class Clip:
    """A clip's files below --out, made where they are missing."""

    def __init__(self, name, options):
        self.name, self.boxed = name, name.startswith("strangers/")
        self.root = Path(options.out) / f"{name.replace('/', '_')}_{options.frames}_{options.width}_{options.every}"
        self.drive = self.root / "drive"
        if (self.root / "masked").exists():
            return
        say(f"{name}: masking")
        for folder in ("all", "drive/frames", "drive/masks", "true"):
            (self.root / folder).mkdir(parents=True, exist_ok=True)
        pictures = list(stranger(DATA / f"{name}.mp4", options.frames) if self.boxed else davis(DATA / name))[: options.frames]
        if not pictures:
            raise SystemExit(f"bench_colmap: {DATA / name} has no pictures; is EGOSIEVE_DATA the folder of the test data?")
        near = np.ones((2 * DILATION_PIXELS + 1,) * 2, np.uint8)
        for index, (stem, picture, mask) in enumerate(pictures):
            cv2.imwrite(str(self.root / "all" / f"{stem}.png"), resized(picture, options.width, cv2.INTER_AREA))
            if index % options.every == 0 or self.boxed and mask is not None:
                (self.drive / "frames" / f"{stem}.png").hardlink_to(self.root / "all" / f"{stem}.png")
            if mask is not None:
                mask = resized(mask, options.width, cv2.INTER_NEAREST)
                cv2.imwrite(str(self.drive / "masks" / f"{stem}.png"), mask)
                cv2.imwrite(str(self.root / "true" / f"{stem}.png.png"), 255 - cv2.dilate(mask, near))
        self.masks(self.root / "all", "ours", f"--dilate={DILATION_PIXELS}")
        (self.root / "masked").touch()

    def masks(self, source, out, *flags):
        """`egosieve masks` for COLMAP."""
        call(PROGRAM, "masks", source, "--for=colmap", f"--out={self.root / out}", "--overwrite", "--progress=none", *flags)

    def model(self, python, masks, mapper, seed):
        """The folder of the largest model."""
        database, out = self.root / f"{masks}.db", self.root / "models" / f"{masks}_{mapper}_{seed}"
        if not (self.root / f"{masks}.matched").exists():
            say(f"{self.name}: matching, masks {masks}")
            database.unlink(missing_ok=True)
            work(python, WORKER, "match", self.drive, "-" if masks == "none" else self.root / masks, database, "estimated", FEATURES)
            (self.root / f"{masks}.matched").touch()
        if not (out / "largest" / "points3D.bin").exists():
            say(f"{self.name}: {mapper} mapping, masks {masks}, seed {seed}")
            work(python, WORKER, "model", self.drive, database, out, seed, mapper)
        return out / "largest"

    def scores(self, python, masks, mapper, seed):
        """Of a model; `none, then points`: of that without masks, after `egosieve points`."""
        model = self.model(python, masks.partition(",")[0], mapper, seed)
        if "," in masks and (model / "points3D.bin").stat().st_size > 8:
            static = model.with_name("static")
            call(PROGRAM, "points", model, f"--masks={self.root / 'ours'}", f"--out={static}", "--overwrite", "--progress=none")
            model = static
        return work(python, WORKER, "score", self.drive, model)

    def undistorted(self, python):
        """Mean IoU of our masks and the true ones, as they are and where both are undistorted, ours by --undistort, the true ones as pictures."""
        plain, dense, truth = (self.root / name for name in ("plain", "dense", "dense_true"))
        model = max((self.model(python, "ours", mapper, 1) for mapper in MAPPERS), key=lambda one: work(python, WORKER, "score", self.drive, one)["registered"])
        for folder in (dense, truth):
            shutil.rmtree(folder, ignore_errors=True)
        work(python, WORKER, "undistort", self.drive / "frames", model, dense)
        work(python, WORKER, "undistort", self.drive / "masks", model, truth)
        self.masks(self.root / "ours.run", "plain")
        self.masks(self.root / "ours.run", "dense/masks", f"--undistort={dense}", f"--sparse={model}")
        names = sorted(path.name for path in (truth / "images").glob("*.png"))
        return [iou(names, self.drive / "masks", plain), iou(names, truth / "images", dense / "masks")]


def iou(names, truth, masks):
    """Mean over the pictures where something moves and that have a mask; grey counts nowhere."""
    shares = []
    for path in (truth / name for name in names):
        true, ours = (cv2.imread(str(file), cv2.IMREAD_GRAYSCALE) for file in (path, masks / f"{path.name}.png"))
        if ours is not None and (true > 191).any():
            moves, marked, counts = true > 191, ours == 0, (true > 191) | (true < 64)
            shares.append((moves & marked).sum() / ((moves | marked) & counts).sum())
    return float(np.mean(shares)) if shares else None


def table(options):
    """The record and the text of bench_colmap --clips."""
    python = environment("colmap", ["pycolmap", "numpy", "pillow"])
    version = call(python, "-c", "import pycolmap; print(pycolmap.__version__)").strip()
    rows, masks = [], []
    for clip in [Clip(name, options) for name in options.clips]:
        for mapper in MAPPERS:
            for kind in MODELS[: 3 if clip.boxed else 4]:
                runs = [clip.scores(python, kind, mapper, seed) for seed in range(1, options.seeds + 1)]
                rows.append({"clip": clip.name, "pictures": len(list((clip.drive / "frames").iterdir())), "mapper": mapper, "masks": kind, "runs": runs})
        masks.append({"clip": clip.name, "iou": clip.undistorted(python)})
    cells = [[row["clip"], row["pictures"], row["mapper"], row["masks"],
              *(cell([run.get(name) for run in row["runs"]], form) for name, (_, form) in COLUMNS.items())] for row in rows]  # fmt: skip
    text = (
        f"`./run bench_colmap --clips={','.join(options.clips)} --frames={options.frames} --width={options.width} --seeds={options.seeds} --every={options.every}`, "
        f"pycolmap {version}, {FEATURES} features a picture at most, lens estimated by COLMAP. Each cell: the median over COLMAP's seeds and, where "
        "they differ, the least and the greatest. Images registered: of the largest model. Observations on movers: the share of the points' observations that lie on what moves, by DAVIS's masks, or in the "
        "labelled frames by hand-made boxes, which hold some of what is behind a mover, too.\n\n"
        + markdown(["clip", ">pictures", "mapper", "masks", *(title for title, _ in COLUMNS.values())], cells)
        + "\nMasks without `--dilate` and the true ones, mean IoU, on the pictures as they are and undistorted by the model with our masks that has more images:\n\n"
        + markdown(["clip", ">as they are", ">undistorted"], [[row["clip"], *(cell([value], "{:.3f}") for value in row["iou"])] for row in masks])
    )  # fmt: skip
    record = {"pycolmap": version, "frames": options.frames, "width": options.width, "every": options.every, "features": FEATURES, "rows": rows, "undistorted": masks}
    return record, text
