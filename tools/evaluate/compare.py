#!/usr/bin/python3
"""Compares the segmenter with other methods on the same labels, descriptors, frames and pixels.

    tools/evaluate/compare.py ../shared/data/davis-train --out=out/compare --max_frames=24

INPUT is a folder of sequences, or one, each with frames/ and masks/, labels/ or tracks.csv.
`egosieve segment --set dump_features=DIR` gives every method the same labelled places and the same
grid. Needs Debian's python3-sklearn, python3-opencv and python3-numpy.

    arcsine, squared_exponential   the segmenter with either covariance
    svm, logistic, forest          scikit-learn's, trained anew in each frame on the labels kept so
                                   far: thinned, bounded and forgotten as by the segmenter
    labels                         the label of the place nearest to each pixel
    ransac                         distance of that place to OpenCV's RANSAC model of the same pairs
    optical_flow                   the same, and the wrong side of infinity (Klappstein, 2009)
    homography_flow                distance of DIS flow at each pixel to a homography

Distances d become scores d / (d + 3 px). All methods get the segmenter's location prior. Truth of
128 is void. AUC is the mean over frames with both classes. J is the mean intersection over union of
scores of at least 1/2 with the truth, over frames with movers. Intervals hold 95 % of resamples of
blocks of frames, the same blocks for both methods. Writes compare.csv (a row per method and frame),
compare.json and the runs into --out. A run that is there is used again.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import pandas
from scipy.ndimage import map_coordinates
from scipy.spatial import cKDTree
from sklearn.ensemble import RandomForestClassifier
from sklearn.linear_model import LogisticRegression
from sklearn.metrics import roc_auc_score
from sklearn.model_selection import GridSearchCV
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import PolynomialFeatures
from sklearn.svm import SVC

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from evaluate.files import InputError, UsageError, to_text  # noqa: E402
from evaluate.run_folder import FULL_PIXEL, Grid, RunFolder  # noqa: E402
from evaluate.sequences import find_sequences  # noqa: E402
from evaluate.truth import DYNAMIC, VOID, DriveTruth  # noqa: E402

COVARIANCES = ("arcsine", "squared_exponential")
CLASSIFIERS = ("svm", "logistic", "forest")
RESAMPLES, BLOCK = 2000, 10  # frames in a row that are drawn together
STATIC, FUNDAMENTAL = 1, 3  # `kind` of a dump


class Dump:
    """A frame's file of dump_features; shapes are those of DumpFeatures in tools/segment/segment_run.cc."""

    def __init__(self, path):
        arrays = np.load(path)
        self.index, self.labelled, self.first, self.second = (int(n) for n in arrays["frames"])
        grid = Grid(*(int(n) for n in arrays["grid"]))
        self.width, self.height = grid.width, grid.height
        self.labels, self.inputs, self.field = arrays["labels"], arrays["inputs"], arrays["field"]
        self.kind = int(arrays["kind"][0])
        positions, others = arrays["positions"], arrays["others"]
        self.places = positions if self.labelled == self.index else others
        self.pair = (positions, others) if self.labelled == self.first else (others, positions)
        self.pixels = np.stack(np.meshgrid(grid.x, grid.y), axis=-1).reshape(-1, 2)  # G x 2, (x, y)

    def spread(self, values):
        """At each pixel of the grid the value of the nearest place; 0 without places."""
        if values is None or len(values) == 0:
            return np.zeros(len(self.pixels))
        return np.asarray(values)[cKDTree(self.places).query(self.pixels)[1]]


class LocationPrior:
    """(LP1) of vision/segmentation/location_prior.h."""

    CELLS, MEMORY, FRAMES = (64, 36), 0.99, 4.0

    def __init__(self, weight):
        self.weight, self.frames, self.sums = weight, 0.0, np.zeros(self.CELLS[::-1], np.float32)

    def learn(self, dump):
        if len(dump.labels) == 0 or dump.kind == STATIC:
            return
        self.sums *= self.MEMORY
        self.frames = self.frames * self.MEMORY + 1.0
        moving = dump.labels >= 0.5
        cells = (dump.places[moving] / (dump.width, dump.height) * self.CELLS).astype(int)
        column, row = np.clip(cells, 0, np.array(self.CELLS) - 1).T
        np.add.at(self.sums, (row, column), dump.labels[moving])

    def apply(self, probability, dump):
        if not self.sums.mean() > 0.0:
            return probability
        density = cv2.GaussianBlur(self.sums, (0, 0), 2.0, borderType=cv2.BORDER_REFLECT)
        ratio = self.frames * density / self.sums.mean() + self.FRAMES
        factor = (ratio / (self.frames + self.FRAMES)) ** self.weight
        x, y = ((dump.pixels + 0.5) / (dump.width, dump.height) * self.CELLS - 0.5).T
        factor = map_coordinates(factor, (y, x), order=1, mode="nearest")
        return probability * factor / (1.0 - probability + probability * factor)


class Classifier:
    """One of scikit-learn's, with a memory of labelled descriptors like the segmenter's."""

    SEARCH_EVERY = 50  # frames between two choices of the SVM's parameters
    FEWEST = 10  # points of each class
    RARE = 0.25  # share of the memory that the rarer class keeps

    def __init__(self, name, flags):
        self.name, self.machine, self.trainings, self.best = name, None, 0, {}
        self.budget, self.radius = int(flags["budget"]), float(flags["density"])
        self.age, self.random = int(flags["dynamic_age"]), np.random.default_rng(1)
        # Rows of descriptor, class and frame, newest first.
        self.memory = np.zeros((0, 8))

    def thinned(self, points):
        """In random order, one point per class in each cell of `radius` on a side."""
        points = self.random.permutation(points)
        if self.radius > 0.0:
            cells = np.column_stack([np.floor(points[:, :6] / self.radius), points[:, 6]])
            points = points[np.unique(cells, axis=0, return_index=True)[1]]
        return self.random.permutation(points)

    def bounded(self, points, most):
        """The first `most` points, but of each class at least a share of RARE, if there are."""
        moving = points[:, 6] > 0
        few = int(self.RARE * most)
        protected = np.concatenate([np.flatnonzero(moving)[:few], np.flatnonzero(~moving)[:few]])
        others = np.setdiff1d(np.arange(len(points)), protected)
        return points[np.sort(np.concatenate([protected, others])[:most])]

    def learn(self, dump):
        size = len(dump.labels)
        new = np.column_stack([dump.inputs, dump.labels >= 0.5, np.full(size, dump.index)])
        old = self.memory[(self.memory[:, 6] == 0) | (self.memory[:, 7] > dump.index - self.age)]
        room = max(self.budget // 2, self.budget - len(old))
        new = self.bounded(self.thinned(new), room)
        self.memory = self.bounded(np.concatenate([new, old]), self.budget)
        moving = self.memory[:, 6] > 0
        if min(moving.sum(), (~moving).sum()) >= self.FEWEST:
            self.machine = self.trained(self.memory[:, :6], moving)

    def trained(self, inputs, moving):
        if self.name == "logistic":
            machine = make_pipeline(PolynomialFeatures(2), LogisticRegression(max_iter=300))
        elif self.name == "forest":
            machine = RandomForestClassifier(100, min_samples_leaf=3, random_state=1)
        else:
            if self.trainings % self.SEARCH_EVERY == 0:
                grid = {"gamma": [0.5, 2.0, 8.0, 32.0], "C": [1.0, 10.0]}
                search = GridSearchCV(SVC(), grid, cv=3, scoring="balanced_accuracy")
                self.best = search.fit(inputs, moving).best_params_
            machine = SVC(probability=True, random_state=1, **self.best)
        self.trainings += 1
        return machine.fit(inputs, moving)

    def answer(self, dump, _images):
        if len(dump.labels) > 0:
            self.learn(dump)
        if self.machine is None:
            return np.full(len(dump.pixels), self.memory[:, 6].mean() if len(self.memory) else 0.0)
        return self.machine.predict_proba(dump.field)[:, 1]


def homogeneous(points):
    return np.column_stack([points, np.ones(len(points))])


def transfer_distances(first, second, homography):
    moved = homogeneous(first) @ homography.T
    return np.hypot(*(moved[:, :2] / moved[:, 2:] - second).T)


def line_distances(first, second, fundamental):
    lines = homogeneous(first) @ fundamental.T
    return np.abs((lines * homogeneous(second)).sum(1)) / np.hypot(lines[:, 0], lines[:, 1])


def fitted(pair, is_fundamental):
    """OpenCV's RANSAC of a fundamental matrix or a homography; None if there is no such model."""
    if len(pair[0]) < 8:
        return None
    cv2.setRNGSeed(1)
    if not is_fundamental:
        return cv2.findHomography(*pair, cv2.RANSAC, 1.0, confidence=0.999)[0]
    matrix = cv2.findFundamentalMat(*pair, cv2.FM_RANSAC, 1.0, 0.999)[0]
    return matrix if matrix is not None and matrix.shape == (3, 3) else None


def violations_behind(first, second, fundamental, width, height):
    """How far beyond the image of infinity, away from nearer points, each point lies; pixels.

    A static point of inverse depth s >= 0 lies at x2 ~ K R K^-1 x1 + s K t. The focal length is
    guessed. Of the four decompositions of the essential matrix the least violated one is taken.
    """
    focal = 0.7 * max(width, height)
    k = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])
    turn_1, turn_2, shift = cv2.decomposeEssentialMat(k.T @ fundamental @ k)
    candidates = []
    for turn in (turn_1, turn_2):
        far = homogeneous(first) @ (k @ turn @ np.linalg.inv(k)).T
        start = far[:, :2] / far[:, 2:]
        for x, y, z in ((k @ move).ravel() for move in (shift, -shift)):
            along = (np.array([x, y]) - z * start) / far[:, 2:]
            beyond = ((second - start) * along).sum(1) / np.linalg.norm(along, axis=1)
            candidates.append(np.where(far[:, 2] > 0, np.maximum(0.0, -beyond - 1.0), 10.0))
    return min(candidates, key=lambda behind: np.minimum(behind, 10.0).sum())


def score(distances):
    return distances / (distances + 3.0)


def by_ransac(dump, _images, with_depth=False):
    is_fundamental = dump.kind == FUNDAMENTAL
    matrix = fitted(dump.pair, is_fundamental)
    if matrix is None:
        return dump.spread(None)
    if not is_fundamental:
        return dump.spread(score(transfer_distances(*dump.pair, matrix)))
    distances = line_distances(*dump.pair, matrix)
    if with_depth:
        behind = violations_behind(*dump.pair, matrix, dump.width, dump.height)
        distances = np.hypot(distances, behind)
    return dump.spread(score(distances))


def by_homography_flow(dump, images):
    other = dump.first if dump.index == dump.second else dump.second
    if other < 0 or other == dump.index:
        return dump.spread(None)
    dense = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    flow = dense.calc(images(dump.index), images(other), None)
    pair = (dump.pixels + flow[dump.pixels[:, 1], dump.pixels[:, 0]], dump.pixels.astype(float))
    matrix = fitted(pair, is_fundamental=False)
    return dump.spread(None) if matrix is None else score(transfer_distances(*pair, matrix))


FRAME_BY_FRAME = {
    "labels": lambda dump, _images: dump.spread(dump.labels),
    "ransac": by_ransac,
    "optical_flow": lambda dump, images: by_ransac(dump, images, with_depth=True),
    "homography_flow": by_homography_flow,
}
METHODS = (*COVARIANCES, *CLASSIFIERS, *FRAME_BY_FRAME)
STAGES = ("selection", "training", "calibration", "posterior", "inference")  # of a frame's line


def segmented(options, source, folder, covariance):
    """The run; segments unless it is there."""
    run = folder / covariance
    about = run / "run.json"
    if not about.exists() or json.loads(about.read_text())["ended"] != "done":
        words = [options.program.resolve(), "segment", source, f"--out={run}",
                 f"--set=covariance={covariance}", f"--set=dump_features={folder / 'features'}",
                 f"--max_frames={options.max_frames}", "--overwrite", "--progress=none", *options.segment_flags.split()]  # fmt: skip
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode not in (0, 4):
            raise InputError(f"{source}: {done.stderr.strip()[-500:]}")
    return RunFolder(run)


def truth_of(truth, line, dump):
    """Rows of the grid with truth, and whether they move; None for a frame without truth."""
    if line.index not in truth.frames:
        return None
    if truth.scattered:
        points = truth.points[line.index]
        return cKDTree(dump.pixels).query(points[["x", "y"]])[1], points.dynamic.to_numpy()
    values = truth.mask(line)[dump.pixels[:, 1], dump.pixels[:, 0]]
    rows = np.flatnonzero(values != VOID)
    return rows, values[rows] == DYNAMIC


def compare_drive(options, sequence):
    """A row per frame and method; AUC and J are not a number where a class is missing."""
    folder = options.out / "runs" / sequence.name
    runs = {m: segmented(options, sequence.frames, folder, m) for m in COVARIANCES if m in options.methods}
    run = next(iter(runs.values()))
    flags = run.description["flags"]
    truth = DriveTruth(sequence.truth, run)
    prior = LocationPrior(float(flags["location_prior"]))
    rivals = {m: Classifier(m, flags).answer if m in CLASSIFIERS else FRAME_BY_FRAME[m]
              for m in options.methods if m not in COVARIANCES}  # fmt: skip

    def picture(index):
        return cv2.imread(str(sequence.frames / run.lines[index].image), cv2.IMREAD_GRAYSCALE)

    rows = []
    for position, line in enumerate(run.lines):
        path = folder / f"features/{line.index:06d}.npz"
        if not path.exists():  # a damaged frame
            continue
        dump, maps, took = Dump(path), {}, {}
        prior.learn(dump)
        for method, own in runs.items():
            maps[method] = own.maps(line)[0].ravel() / FULL_PIXEL
            took[method] = sum(own.lines[position].milliseconds[stage] for stage in STAGES)
        for method, answer in rivals.items():
            start = time.perf_counter()
            probability = answer(dump, picture)
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
            rows.append({"drive": sequence.name, "frame": line.index, "method": method,
                         "auc": auc, "j": j, "milliseconds": took[method]})  # fmt: skip
    return rows


def lead(differences):
    """Mean and 95 % interval of differences by drive and frame; None without any."""
    random, sums = np.random.default_rng(1), np.zeros(RESAMPLES)
    for _, own in differences.groupby(level="drive"):  # blocks, the first frame after the last
        n, b = len(own), min(BLOCK, len(own))
        starts = random.integers(0, n, (RESAMPLES, -(-n // b)))
        picked = (starts[:, :, None] + np.arange(b)).reshape(RESAMPLES, -1)[:, :n] % n
        sums += own.to_numpy()[picked].sum(1)
    low, high = np.percentile(sums / len(differences), [2.5, 97.5])
    return [differences.mean(), low, high]


def summarise(rows):
    """One entry per method: means over frames, and the first method's lead in AUC and J."""
    figures = rows.pivot(index=["drive", "frame"], columns="method")
    methods, table = list(rows.method.unique()), []
    for method in methods:
        own = figures.xs(method, axis=1, level="method")
        entry = {"method": method, **own.mean(),
                 "auc_by_drive": own.auc.groupby(level="drive").mean().to_dict()}  # fmt: skip
        for key in ("auc", "j"):
            less = (figures[key][methods[0]] - own[key]).dropna()
            if method != methods[0] and len(less):
                entry[f"{methods[0]}_leads_in_{key}"] = lead(less)
        table.append(entry)
    return table


def main():
    """Segments, compares, writes and prints."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("input", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--methods", default=",".join(METHODS), help="compared with the first")
    parser.add_argument("--max_frames", type=int, default=0, help="of each drive; 0: all")
    parser.add_argument("--segment_flags", default="", help="flags of segment, by spaces")
    built = Path(__file__).resolve().parents[2] / "bazel-bin/tools/egosieve"
    parser.add_argument("--program", type=Path, default=os.environ.get("EGOSIEVE_PROGRAM", built))
    options = parser.parse_args()
    options.methods = options.methods.split(",")
    if unknown := [m for m in options.methods if m not in METHODS]:
        parser.error(f"no method '{unknown[0]}'; the methods are {', '.join(METHODS)}")
    if not set(options.methods) & set(COVARIANCES):
        parser.error(f"--methods needs one of {', '.join(COVARIANCES)}")
    try:
        sequences, _ = find_sequences(options.input)
        rows = pandas.DataFrame(row for s in sequences for row in compare_drive(options, s))
    except (InputError, UsageError) as error:
        parser.error(str(error))
    if rows.empty:
        parser.error(f"no frame with truth in {options.input}")
    rows.to_csv(options.out / "compare.csv", index=False, na_rep="nan")
    table = summarise(rows)
    (options.out / "compare.json").write_text(json.dumps(table, indent=1) + "\n")
    shown = pandas.DataFrame(table).drop(columns="auc_by_drive").astype(object)
    intervals = shown.filter(like="_leads_in_")
    shown[intervals.columns] = intervals.applymap(
        lambda found: "{:+.3f} [{:+.3f}, {:+.3f}]".format(*found) if found is not np.nan else "")
    print(to_text(shown), end="")


if __name__ == "__main__":
    main()
