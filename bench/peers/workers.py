"""One library's side of peers.py: workers.py LIBRARY COVARIANCE POINTS DIMENSION QUERIES JOINT_QUERIES, then one task per line on
stdin, one JSON answer per line.

    prepare   imports, fits (hyperparameters are given), and predicts what is compared with float64: the version
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
import resource
import sys
import time

import numpy as np
from libraries import LIBRARIES
from problem import UPDATE, float64_covariance, float64_posterior, make_data

FEW = 256
SLOW = 4.0  # seconds for FEW queries
LARGEST_CHECKED = 4000  # points; more would take gigabytes in float64


class Session:
    """The tasks of one worker."""

    def __init__(self, library, covariance, points, dimension, queries, joint_queries):
        self.kind, self.covariance, self.points, self.dimension = library, covariance, points, dimension
        self.X, self.y, self.queries = make_data(points, dimension, queries)
        self.joint_queries = self.queries[:joint_queries]
        self.begin = 0
        self.counts = dict.fromkeys(("mean", "predict"), FEW)  # of the warming call; what is slow stays there

    def prepare(self):
        self.library = LIBRARIES[self.kind](self.covariance, self.dimension)
        self.library.fit(self.X[: self.points], self.y[: self.points])
        self.first = self.library.predict(self.queries[:FEW])
        return {"version": self.library.version, "precision": self.library.precision}

    def seconds(self, task):
        end = self.begin + self.points
        points = self.X[self.begin : end], self.y[self.begin : end]
        update = (*points, self.X[end : end + UPDATE], self.y[end : end + UPDATE])
        library, few = self.library, self.queries[:FEW]
        calls = {
            "fit": lambda: (library.fit(*points), library.predict(few[:1])),
            "mean": lambda: library.mean(self.queries[: self.counts[task]]),
            "predict": lambda: library.predict(self.queries[: self.counts[task]]),
            "replace": lambda: library.replace(*update).predict(few),
            "append": lambda: library.append(*update).predict(few),
            "joint": lambda: library.joint(self.joint_queries),
            "samples": lambda: library.samples(self.joint_queries),
        }
        start = time.perf_counter()
        calls[task]()
        seconds = time.perf_counter() - start
        if task == "append":
            library.undo_append(self.points)
        elif task == "replace":
            self.begin += UPDATE
        elif task in self.counts:
            count = self.counts[task]
            if count == FEW and seconds < SLOW:
                self.counts[task] = len(self.queries)
            seconds /= count
        return {"seconds": seconds}

    def finish(self):
        # The measure of errors comes last, so that its memory is not counted.
        account = {"peak_mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}
        if self.points <= LARGEST_CHECKED:
            covariance, few = float64_covariance(self.covariance, self.dimension), self.queries[:FEW]
            exact = float64_posterior(covariance, self.X[: self.points], self.y[: self.points], few)
            errors = (float(np.abs(own - other).max()) for own, other in zip(self.first, exact))
            account |= dict(zip(("mean_error", "variance_error"), errors))
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
            answer = {"prepare": session.prepare, "finish": session.finish}.get(task, lambda: session.seconds(task))()
        except Exception as error:  # reported, with its kind, to the one who asked
            answer = {"error": f"{type(error).__name__}: {error}"[:300]}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
