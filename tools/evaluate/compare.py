#!/usr/bin/python3
"""Compares the segmenter with other methods on the same labels, descriptors, frames and pixels.

    tools/evaluate/compare.py ../shared/data/davis-train --out=out/compare --max_frames=24
    tools/evaluate/compare.py drive/frames --truth=drive/masks --out=out/compare

INPUT is a video or a folder of pictures with --truth, or a folder of sequences, each with frames/ and
masks/, labels/ or tracks.csv. `egosieve segment --dump_features` gives every method the same labelled
places and the same grid. Needs Debian's python3-sklearn, python3-opencv and python3-numpy.

    arcsine, squared_exponential   the segmenter with either covariance
    svm, logistic, forest          scikit-learn's classifiers, trained anew in each frame on the labels
                                   kept so far: thinned, balanced and bounded as for the segmenter
    labels                         the label of the place nearest to each pixel
    ransac                         distance to OpenCV's RANSAC model of the same pairs of places
    optical_flow                   the same, and the wrong side of infinity (Klappstein et al., 2009)
    dense_optical_flow             the same for DIS flow at each pixel
    homography_flow                distance of DIS flow at each pixel to a homography

Distances d become scores d / (d + 3 px). All methods get the segmenter's location prior (LP1 of
vision/segmentation/location_prior.h). Truth of 128 is void. AUC is the mean over frames with both
classes, J the mean intersection over union of scores of at least 1/2 with the truth, over frames with
movers. Intervals hold 95 % of resamples of blocks of frames, the same for both methods.

Writes compare.csv (a row per method and frame), compare.json and the runs into --out. A run that is
there is used again.
"""

import argparse
import csv
import json
import subprocess
import time
from pathlib import Path

import cv2
import numpy as np
from scipy.spatial import cKDTree
from sklearn.ensemble import RandomForestClassifier
from sklearn.linear_model import LogisticRegression
from sklearn.metrics import roc_auc_score
from sklearn.model_selection import GridSearchCV
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import PolynomialFeatures
from sklearn.svm import SVC

COVARIANCES = ("arcsine", "squared_exponential")
METHODS = (*COVARIANCES, "svm", "logistic", "forest", "labels", "ransac", "optical_flow",
           "dense_optical_flow", "homography_flow")  # fmt: skip
RESAMPLES = 2000
RANSAC_PIXELS, RANSAC_SURE = 1.0, 0.999
STATIC, FUNDAMENTAL = 1, 3  # `kind` of a dump


class Dump:
    """A frame's file of --dump_features; shapes are those of tools/segment/feature_dump.h."""

    def __init__(self, path):
        arrays = np.load(path)
        self.index, self.labelled, self.first, self.second = (int(n) for n in arrays["frames"])
        self.width, self.height, stride = (int(n) for n in arrays["grid"])
        self.labels, self.inputs, self.field = arrays["labels"], arrays["inputs"], arrays["field"]
        self.kind = int(arrays["kind"][0])
        positions, others = arrays["positions"], arrays["others"]
        self.places = positions if self.labelled == self.index else others
        self.pair = (positions, others) if self.labelled == self.first else (others, positions)
        columns = np.minimum(np.arange(-(-(self.width - 1) // stride) + 1) * stride, self.width - 1)
        rows = np.minimum(np.arange(-(-(self.height - 1) // stride) + 1) * stride, self.height - 1)
        self.shape = (len(rows), len(columns))
        x, y = np.meshgrid(columns, rows)
        self.pixels = np.stack([x.ravel(), y.ravel()], axis=1)  # G x 2, (x, y)

    def spread(self, values):
        """At each pixel of the grid the value of the nearest place; 0 without places."""
        if len(values) == 0:
            return np.zeros(len(self.pixels))
        return np.asarray(values)[cKDTree(self.places).query(self.pixels)[1]]


class LocationPrior:
    """(LP1) of vision/segmentation/location_prior.h."""

    COLUMNS, ROWS, MEMORY, FRAMES = 64, 36, 0.99, 4.0

    def __init__(self, weight):
        self.weight, self.frames = weight, 0.0
        self.sums = np.zeros((self.ROWS, self.COLUMNS), np.float32)

    def learn(self, dump):
        if len(dump.labels) == 0 or dump.kind == STATIC:
            return
        self.sums *= self.MEMORY
        self.frames = self.frames * self.MEMORY + 1.0
        moving = dump.labels >= 0.5
        cells = dump.places[moving] / (dump.width, dump.height) * (self.COLUMNS, self.ROWS)
        column, row = np.clip(cells.astype(int), 0, (self.COLUMNS - 1, self.ROWS - 1)).T
        np.add.at(self.sums, (row, column), dump.labels[moving])

    def apply(self, probability, dump):
        mean = self.sums.mean()
        if not mean > 0.0:
            return probability
        density = cv2.GaussianBlur(self.sums, (0, 0), 2.0, borderType=cv2.BORDER_REFLECT)
        ratio = (self.frames * density / mean + self.FRAMES) / (self.frames + self.FRAMES)
        cells = (dump.pixels + 0.5) / (dump.width, dump.height) * (self.COLUMNS, self.ROWS) - 0.5
        x, y = cells.astype(np.float32).T
        factor = cv2.remap((ratio**self.weight).astype(np.float32), x, y, cv2.INTER_LINEAR,
                           borderMode=cv2.BORDER_REPLICATE).ravel()  # fmt: skip
        return probability * factor / (1.0 - probability + probability * factor)


class Classifier:
    """One of scikit-learn's, with a memory of labelled descriptors like the segmenter's."""

    SEARCH_EVERY = 50  # frames between two choices of the SVM's parameters
    FEWEST = 10  # points of each class

    def __init__(self, name, flags):
        self.name, self.machine, self.trainings, self.best = name, None, 0, {}
        self.budget, self.radius = int(flags["budget"]), float(flags["density"])
        self.age = int(flags["dynamic_age"])
        self.inputs, self.moving, self.births = np.zeros((0, 6)), np.zeros(0, bool), np.zeros(0, int)
        self.random = np.random.default_rng(1)

    def thinned(self, inputs, moving):
        """Rows with one point per class in each cell of `density` on a side, in random order."""
        order = self.random.permutation(len(inputs))
        if self.radius > 0.0:
            cells = np.column_stack([np.floor(inputs[order] / self.radius), moving[order]])
            order = order[np.unique(cells, axis=0, return_index=True)[1]]
        return self.random.permutation(order)

    @staticmethod
    def bounded(rows, moving, most):
        """The first `most` rows, of each class half of them or all that there are."""
        own, other = rows[moving[rows]], rows[~moving[rows]]
        kept = min(len(own), max(most // 2, most - len(other)))
        return np.concatenate([own[:kept], other[: most - kept]])

    def learn(self, dump):
        moving = dump.labels >= 0.5
        rows = self.bounded(self.thinned(dump.inputs, moving), moving, self.budget // 2)
        stay = ~self.moving | (self.births > dump.index - self.age)
        self.inputs = np.concatenate([dump.inputs[rows], self.inputs[stay]])
        self.moving = np.concatenate([moving[rows], self.moving[stay]])
        self.births = np.concatenate([np.full(len(rows), dump.index), self.births[stay]])
        kept = self.bounded(np.arange(len(self.inputs)), self.moving, self.budget)
        self.inputs, self.moving, self.births = (
            a[kept] for a in (self.inputs, self.moving, self.births))  # fmt: skip
        if min(self.moving.sum(), (~self.moving).sum()) >= self.FEWEST:
            self.machine = self.trained()

    def trained(self):
        if self.name == "logistic":
            machine = make_pipeline(PolynomialFeatures(2), LogisticRegression(max_iter=300))
        elif self.name == "forest":
            machine = RandomForestClassifier(100, min_samples_leaf=3, random_state=1)
        else:
            if self.trainings % self.SEARCH_EVERY == 0:
                grid = {"gamma": [0.5, 2.0, 8.0, 32.0], "C": [1.0, 10.0]}
                search = GridSearchCV(SVC(), grid, cv=3, scoring="balanced_accuracy")
                self.best = search.fit(self.inputs, self.moving).best_params_
            machine = SVC(probability=True, random_state=1, **self.best)
        self.trainings += 1
        return machine.fit(self.inputs, self.moving)

    def answer(self, dump, _images):
        if len(dump.labels) > 0:
            self.learn(dump)
        if self.machine is None:
            return np.full(len(dump.pixels), self.moving.mean() if len(self.moving) else 0.0)
        return self.machine.predict_proba(dump.field)[:, 1]


def score(distances):
    """Strictly increasing in distances in pixels; 1/2 at 3 pixels."""
    return np.asarray(distances) / (np.asarray(distances) + 3.0)


def homogeneous(points):
    return np.column_stack([points, np.ones(len(points))])


def transfer_distances(first, second, homography):
    moved = homogeneous(first) @ homography.T
    return np.hypot(*(moved[:, :2] / moved[:, 2:] - second).T)


def line_distances(first, second, fundamental):
    lines = homogeneous(first) @ fundamental.T
    return np.abs((lines * homogeneous(second)).sum(1)) / np.hypot(lines[:, 0], lines[:, 1])


def fundamental_of(first, second):
    """OpenCV's RANSAC; None if there is no such matrix."""
    if len(first) < 8:
        return None
    cv2.setRNGSeed(1)
    matrix = cv2.findFundamentalMat(first, second, cv2.FM_RANSAC, RANSAC_PIXELS, RANSAC_SURE)[0]
    return None if matrix is None or matrix.shape != (3, 3) else matrix


def homography_of(first, second):
    if len(first) < 4:
        return None
    cv2.setRNGSeed(1)
    return cv2.findHomography(first, second, cv2.RANSAC, RANSAC_PIXELS, confidence=RANSAC_SURE)[0]


def flow_violations(first, second, fundamental, width, height):
    """Distance in pixels to the part of the epipolar line that a static point in front may be on.

    A static point of inverse depth s >= 0 lies at x2 ~ K R K^-1 x1 + s K t. The focal length is
    guessed. Of the four decompositions of the essential matrix the least violated one is taken.
    """
    focal = 0.7 * max(width, height)
    k = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])
    turn_1, turn_2, shift = cv2.decomposeEssentialMat(k.T @ fundamental @ k)
    least = np.full(len(first), np.inf)
    for turn in (turn_1, turn_2):
        for move in (shift, -shift):
            far = homogeneous(first) @ (k @ turn @ np.linalg.inv(k)).T
            epipole = (k @ move).ravel()
            start = far[:, :2] / far[:, 2:]
            along = (epipole[:2] - epipole[2] * start) / far[:, 2:]
            along /= np.linalg.norm(along, axis=1, keepdims=True)
            beyond = ((second - start) * along).sum(1)
            behind = np.where(far[:, 2] > 0, np.maximum(0.0, -beyond - 1.0), 10.0)
            if np.minimum(behind, 10.0).sum() < np.minimum(least, 10.0).sum():
                least = behind
    return np.hypot(line_distances(first, second, fundamental), least)


def by_ransac(dump, _images):
    first, second = dump.pair
    if dump.kind == FUNDAMENTAL:
        matrix, distances = fundamental_of(first, second), line_distances
    else:
        matrix, distances = homography_of(first, second), transfer_distances
    return dump.spread([] if matrix is None else score(distances(first, second, matrix)))


def by_optical_flow(dump, images):
    first, second = dump.pair
    matrix = fundamental_of(first, second) if dump.kind == FUNDAMENTAL else None
    if matrix is None:
        return by_ransac(dump, images)
    return dump.spread(score(flow_violations(first, second, matrix, dump.width, dump.height)))


def dense_pairs(dump, images):
    """Pixels of the pair's other frame and of this one: DIS flow back from each grid pixel."""
    other = dump.first if dump.index == dump.second else dump.second
    if other < 0 or other == dump.index:
        return None
    flow = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM).calc(
        images(dump.index), images(other), None)  # fmt: skip
    x, y = dump.pixels.T
    return dump.pixels + flow[y, x], dump.pixels.astype(float)


def by_dense_flow(distances_of):
    def answer(dump, images):
        pairs = dense_pairs(dump, images)
        distances = None if pairs is None else distances_of(dump, *pairs)
        return np.zeros(len(dump.pixels)) if distances is None else score(distances)

    return answer


def homography_distances(_dump, first, second):
    matrix = homography_of(first, second)
    return None if matrix is None else transfer_distances(first, second, matrix)


def dense_violations(dump, first, second):
    matrix = fundamental_of(first, second)
    if matrix is None:
        return None
    return flow_violations(first, second, matrix, dump.width, dump.height)


FRAME_BY_FRAME = {
    "labels": lambda dump, _images: dump.spread(dump.labels),
    "ransac": by_ransac,
    "optical_flow": by_optical_flow,
    "dense_optical_flow": by_dense_flow(dense_violations),
    "homography_flow": by_dense_flow(homography_distances),
}


def segmented(options, source, folder, covariance):
    """The run folder and its lines; segments unless the run is there."""
    run = folder / covariance
    if not (run / "run.json").exists() or json.loads((run / "run.json").read_text())["ended"] != "done":
        words = [options.program, "segment", source, f"--out={run}", f"--covariance={covariance}",
                 f"--dump_features={folder / 'features'}", f"--max_frames={options.max_frames}",
                 "--overwrite", "--progress=none", *options.segment_flags.split()]  # fmt: skip
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode not in (0, 4):
            raise SystemExit(f"compare: {source}: {done.stderr.strip()[-500:]}")
    return run, [json.loads(line) for line in (run / "frames.jsonl").read_text().splitlines()]


def pictures(source):
    """A function from a frame's index to its grey picture."""
    if source.is_dir():
        files = sorted(p for p in source.iterdir() if p.suffix.lower() in (".png", ".jpg", ".jpeg"))
        return lambda index: cv2.imread(str(files[index]), cv2.IMREAD_GRAYSCALE)
    video = cv2.VideoCapture(str(source))

    def read(index):
        video.set(cv2.CAP_PROP_POS_FRAMES, index)
        return cv2.cvtColor(video.read()[1], cv2.COLOR_BGR2GRAY)

    return read


def truth_of(truth, line, dump):
    """Rows of the grid with truth, and whether they move; None for a frame without truth."""
    if truth.suffix == ".csv":
        table = np.genfromtxt(truth, delimiter=",", names=True)
        table = table[table["frame"] == line["index"]]
        places = np.column_stack([table["x"], table["y"]])
        return (cKDTree(dump.pixels).query(places)[1], table["label"] > 1) if len(places) else None
    for stem in (Path(line["image"] or "").stem, f"{line['index']:06d}"):
        mask = cv2.imread(str(truth / f"{stem}.png"), cv2.IMREAD_GRAYSCALE) if stem else None
        if mask is not None:
            if mask.shape != (dump.height, dump.width):
                raise SystemExit(f"compare: {truth}/{stem}.png does not fit its frame")
            values = mask[dump.pixels[:, 1], dump.pixels[:, 0]]
            rows = np.flatnonzero(values != 128)
            return rows, values[rows] > 0
    return None


def compare_drive(options, name, source, truth):
    """Rows of (drive, frame, method, AUC or nan, J or nan, milliseconds)."""
    folder = options.out / "runs" / name
    runs = {method: segmented(options, source, folder, method) for method in COVARIANCES
            if method in options.methods}  # fmt: skip
    run, lines = next(iter(runs.values()))
    flags = json.loads((run / "run.json").read_text())["flags"]
    prior, images = LocationPrior(float(flags["location_prior"])), pictures(source)
    rivals = {m: Classifier(m, flags).answer if m in ("svm", "logistic", "forest") else FRAME_BY_FRAME[m]
              for m in options.methods if m not in COVARIANCES}  # fmt: skip
    rows = []
    for position, line in enumerate(lines):
        path = folder / "features" / f"{line['index']:06d}.npz"
        if not path.exists():  # a damaged frame
            continue
        dump = Dump(path)
        prior.learn(dump)
        maps, took = {}, {}
        for method, (run, own) in runs.items():
            grid = cv2.imread(str(run / "grid" / f"{line['index']:06d}.prob.png"), cv2.IMREAD_UNCHANGED)
            maps[method] = grid.ravel() / 65535.0
            stages = ("selection", "training", "calibration", "posterior", "inference")
            took[method] = sum(own[position]["milliseconds"][stage] for stage in stages)
        for method, answer in rivals.items():
            start = time.perf_counter()
            probability = answer(dump, images)
            took[method] = 1e3 * (time.perf_counter() - start)
            maps[method] = prior.apply(probability, dump)
        if (found := truth_of(truth, line, dump)) is None:
            continue
        pixels, moves = found
        for method in options.methods:
            scores = maps[method][pixels]
            called = scores >= 0.5
            auc = roc_auc_score(moves, scores) if 0 < moves.sum() < len(moves) else np.nan
            j = (called & moves).sum() / (called | moves).sum() if moves.any() else np.nan
            rows.append((name, line["index"], method, auc, j, took[method]))
    return rows


def lead(drives, block, random):
    """Mean and 95 % interval of differences by frame; drives: one array per drive."""
    sums, count = np.zeros(RESAMPLES), 0
    for values in drives:
        n, b = len(values), min(block, len(values))
        starts = random.integers(0, n - b + 1, (RESAMPLES, -(-n // b)))
        picked = (starts[:, :, None] + np.arange(b)).reshape(RESAMPLES, -1)[:, :n]
        sums += values[picked].sum(1)
        count += n
    return np.concatenate(drives).mean(), *np.percentile(sums / count, [2.5, 97.5])


def summarise(options, rows):
    """One entry per method: means over frames, and the first method's lead in AUC and J."""
    random, table = np.random.default_rng(1), []
    drives = list(dict.fromkeys(row[0] for row in rows))
    figures = {m: [np.array([r[3:6] for r in rows if r[0] == d and r[2] == m]) for d in drives]
               for m in options.methods}  # fmt: skip
    first = options.methods[0]
    for method, own in figures.items():
        whole = np.concatenate(own)
        entry = {"method": method, "auc": np.nanmean(whole[:, 0]), "j": np.nanmean(whole[:, 1]),
                 "milliseconds": np.nanmean(whole[:, 2]),
                 "auc_by_drive": {d: np.nanmean(v[:, 0]) for d, v in zip(drives, own)}}  # fmt: skip
        for column, key in enumerate(("auc", "j")):
            less = [(a - b)[:, column] for a, b in zip(figures[first], own)]
            less = [v[~np.isnan(v)] for v in less if not np.isnan(v).all()]
            if method != first and less:
                entry[f"{first}_leads_in_{key}"] = lead(less, options.block, random)
        table.append(entry)
    return table


def sequences(folder):
    """(name, frames, truth) of each folder with frames/ and a truth, at any depth."""
    found = []
    for frames in sorted(folder.glob("**/frames")):
        truths = [frames.parent / name for name in ("masks", "labels", "tracks.csv")]
        if truth := next((t for t in truths if t.exists()), None):
            found.append((str(frames.parent.relative_to(folder)), frames, truth))
    return found


def main():
    """Segments, compares, writes and prints."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("input", type=Path)
    parser.add_argument("--truth", type=Path, help="masks or tracks.csv of the one drive INPUT")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--methods", default=",".join(METHODS), help="the first is compared with the others")
    parser.add_argument("--max_frames", type=int, default=0, help="of each drive; 0: all")
    parser.add_argument("--block", type=int, default=10, help="frames in a row that are drawn together")
    parser.add_argument("--segment_flags", default="", help="flags of segment, by spaces")
    parser.add_argument("--program", type=Path, default=Path(__file__).resolve().parents[2] / ".build/egosieve")
    options = parser.parse_args()
    options.methods = options.methods.split(",")
    if unknown := [m for m in options.methods if m not in METHODS]:
        parser.error(f"no method {unknown[0]}; the methods are {', '.join(METHODS)}")
    if not set(options.methods) & set(COVARIANCES):
        parser.error(f"--methods needs one of {', '.join(COVARIANCES)}")
    drives = [("drive", options.input, options.truth)] if options.truth else sequences(options.input)
    rows = [row for name, source, truth in drives for row in compare_drive(options, name, source, truth)]
    if not rows:
        parser.error(f"no frame with truth in {options.input}")
    with open(options.out / "compare.csv", "w", newline="") as file:
        csv.writer(file).writerows([("drive", "frame", "method", "auc", "j", "milliseconds"), *rows])
    table = summarise(options, rows)
    (options.out / "compare.json").write_text(json.dumps(table, indent=1) + "\n")
    first = options.methods[0]
    print(f"{'method':20}    AUC      J  ms/frame  {first} less this: AUC, J")
    for entry in table:
        leads = [entry.get(f"{first}_leads_in_{key}") for key in ("auc", "j")]
        text = "  ".join("{:+.3f} [{:+.3f}, {:+.3f}]".format(*found) for found in leads if found)
        print(f"{entry['method']:20} {entry['auc']:.4f} {entry['j']:.4f} {entry['milliseconds']:9.1f}  {text}")


if __name__ == "__main__":
    main()
