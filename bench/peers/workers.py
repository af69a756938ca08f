"""One library's side of peers.py: workers.py LIBRARY COVARIANCE POINTS DIMENSION QUERIES JOINT_QUERIES, then one task per line on
stdin, one JSON answer per line.

    prepare   imports, fits (hyperparameters are given), compares with float64: errors, versions
    fit       the model from its points until its first prediction, of one query: seconds
    mean      the mean alone at all queries: seconds per query
    predict   mean and variance of f at all queries: seconds per query
    replace   64 new points, the 64 oldest gone, then mean and variance at 256 queries: seconds
    append    64 new points, then mean and variance at 256 queries: seconds; they are dropped again untimed
    joint     mean and joint covariance of f at the first JOINT_QUERIES queries: seconds
    samples   1,000 samples of f there, the covariance among what is timed: seconds
    finish    memory, errors

mean and predict compute 256 queries only where these alone take over 4 s. The models are one and the same: COVARIANCE with
lengths 0.8 sqrt(D / 6), alpha 1, weights 1.5, periods 1.7, sigma_f = 1, sigma_n = NOISE, on points and labels of a smooth
boundary. `prepare` reports a library without the covariance.
"""

import json
import sys
import time

import numpy as np
from libraries import LIBRARIES
from problem import COVARIANCES, UPDATE, float64_posterior, make_data

FEW = 256
SLOW = 4.0  # seconds for FEW queries
LARGEST_CHECKED = 4000  # points; more would take gigabytes in float64


def memory_mib(field):
    """VmRSS: now; VmHWM: at most."""
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) / 1024 for line in status if line.startswith(field))


class Session:
    """The tasks of one worker."""

    def __init__(self, library, covariance, points, dimension, queries, joint_queries):
        self.kind, self.covariance, self.points, self.dimension = library, covariance, points, dimension
        self.X, self.y, self.queries = make_data(points, dimension, queries)
        self.joint_queries = self.queries[:joint_queries]
        self.begin = 0
        few = min(FEW, queries)  # of the warming call; what is slow stays there
        self.counts = {"mean": few, "predict": few}

    def window(self):
        here = slice(self.begin, self.begin + self.points)
        new = slice(here.stop, here.stop + UPDATE)
        return self.X[here], self.y[here], self.X[new], self.y[new]

    def prepare(self):
        self.library = LIBRARIES[self.kind](self.covariance, self.dimension)
        self.after_import = memory_mib("VmRSS")
        start = time.perf_counter()
        self.library.fit(self.X[: self.points], self.y[: self.points])
        self.first = self.library.predict(self.queries[:FEW])
        return {
            "version": self.library.version,
            "precision": self.library.precision,
            "first_seconds": time.perf_counter() - start,
        }

    def fit(self):
        start = time.perf_counter()
        self.library.fit(*self.window()[:2])
        self.library.predict(self.queries[:1])
        return {"seconds": time.perf_counter() - start}

    def of_each(self, task):
        """Seconds per query."""
        if not hasattr(self.library, task):
            return {"error": "not offered alone"}
        count = self.counts[task]
        start = time.perf_counter()
        getattr(self.library, task)(self.queries[:count])
        seconds = time.perf_counter() - start
        if count == FEW and seconds < SLOW:
            self.counts[task] = len(self.queries)
        return {"seconds": seconds / count}

    def mean(self):
        return self.of_each("mean")

    def predict(self):
        return self.of_each("predict")

    def replace(self):
        window = self.window()
        start = time.perf_counter()
        self.library.replace(*window).predict(self.queries[:FEW])
        seconds = time.perf_counter() - start
        self.begin += UPDATE
        return {"seconds": seconds}

    def append(self):
        window = self.window()
        start = time.perf_counter()
        self.library.append(*window).predict(self.queries[:FEW])
        seconds = time.perf_counter() - start
        self.library.undo_append(self.points)
        return {"seconds": seconds}

    def joint(self):
        start = time.perf_counter()
        covariance = self.library.joint(self.joint_queries)[1]
        seconds = time.perf_counter() - start
        self.own_covariance = np.array(covariance[:FEW, :FEW], np.float64)
        return {"seconds": seconds}

    def samples(self):
        start = time.perf_counter()
        self.library.samples(self.joint_queries)
        return {"seconds": time.perf_counter() - start}

    def finish(self):
        # The measure of errors comes last, so that its memory is not counted.
        account = {"after_import_mib": self.after_import, "peak_mib": memory_mib("VmHWM")}
        if self.points > LARGEST_CHECKED:
            return account
        mean, covariance = float64_posterior(
            COVARIANCES[self.covariance], self.X[: self.points], self.y[: self.points], self.queries[:FEW]
        )
        account["mean_error"] = float(np.abs(self.first[0] - mean).max())
        account["variance_error"] = float(np.abs(self.first[1] - np.diag(covariance)).max())
        if hasattr(self, "own_covariance"):
            account["covariance_error"] = float(np.abs(self.own_covariance - covariance).max())
        return account


def main():
    """Answers until stdin ends."""
    library, covariance, *sizes = sys.argv[1:]
    session = Session(library, covariance, *map(int, sizes))
    answers = sys.stdout
    sys.stdout = sys.stderr  # what libraries print is no answer
    for line in sys.stdin:
        task = line.strip()
        try:
            answer = getattr(session, task)()
        except Exception as error:  # reported, with its kind, to the one who asked
            answer = {"error": f"{type(error).__name__}: {error}"[:300]}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
