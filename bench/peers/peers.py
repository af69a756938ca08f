#!/usr/bin/env python3
"""Egosieve compared with other libraries: one run, the same data, the same two cores.

    bench/peers/peers.py [--rounds N] [--cases TEXT,TEXT]

Exact posteriors in scikit-learn, GPyTorch, GPy and OpenTURNS: every covariance that one of them has with n = 1000 points in
D = 6 dimensions, and the Matern 5/2 with n = 1000 to 16000 and D = 2 and 32. Of each the fit at given hyperparameters, the
mean, mean and variance at 4,096 queries, and the joint covariance of 2,000; of the squared exponential also updates by 64
points, and of the Matern 5/2 1,000 samples. Every library runs in a process of its own (workers.py); the processes
alternate, one timed call at a time, so that other load on the machine affects all alike. Results are medians over the
rounds; the first call of each, which warms up, does not count, unless it takes over 8 s: then it is the only one.

pip installs each peer in a virtual environment in the user's cache folder, outside the repository; one that cannot be
installed is listed with the reason. Writes peers.json, peers.md and peers.svg into bench/results after every case.
--cases: those whose names ("matern52 n=4000 D=6") contain one of the texts. `./run install` is run first.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

import charts  # noqa: E402
from common import CACHE, RESULTS, ROOT, call, environment, machine, say  # noqa: E402
from libraries import LIBRARIES  # noqa: E402

BASE = ["numpy<2", "scipy<1.13", "scikit-learn"]  # of every worker, for the errors, too
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "POCL_MAX_PTHREAD_COUNT")
ALL = ("egosieve", "scikit-learn", "GPyTorch exact", "GPy", "OpenTURNS")
WITHOUT_OPENTURNS = ALL[:-1]  # it would take most of the time
OF_MANY_POINTS = ALL[:3]  # GPy would need tens of gigabytes
TASKS = ("fit", "mean", "predict", "joint")
COVARIANCES = (
    "matern52", "matern32", "matern12", "squared_exponential", "rational_quadratic", "arcsine", "periodic", "linear",
)  # fmt: skip
QUERIES, JOINT_QUERIES = 4096, 2000
LONG = 8.0  # seconds; longer calls are not repeated


class Case(NamedTuple):
    """What is measured together."""

    covariance: str
    points: int = 1000
    dimension: int = 6
    workers: tuple = ALL
    tasks: tuple = TASKS

    def name(self):
        return f"{self.covariance} n={self.points} D={self.dimension}"


CASES = (
    Case("matern52", 4000, workers=WITHOUT_OPENTURNS, tasks=(*TASKS, "samples")),
    Case("matern52", 4000, 32, workers=WITHOUT_OPENTURNS),
    *(Case(covariance) for covariance in COVARIANCES),
    Case("squared_exponential", 4000, 6, (*WITHOUT_OPENTURNS, "GPyTorch fast_pred_var"), (*TASKS, "replace", "append")),
    Case("matern52", 4000, 2, workers=WITHOUT_OPENTURNS),
    Case("matern52", 8000, workers=OF_MANY_POINTS),
    Case("matern52", 16000, workers=OF_MANY_POINTS),
)


def interpreters():
    """Of each library that could be installed the interpreter of its environment, and why the others could not."""
    found, absent = {}, {}
    for name, library in LIBRARIES.items():
        try:
            found[name] = environment(f"peers/{library.module_name}", [*BASE, *library.packages])
        except RuntimeError as error:
            absent[name] = str(error).splitlines()[-1]
    return found, absent


class Worker:
    """A process that holds one library's model and does one task at a time."""

    def __init__(self, name, case, interpreter, modules):
        self.name = name
        sizes = [str(size) for size in (case.points, case.dimension, QUERIES, JOINT_QUERIES)]
        self._process = subprocess.Popen(
            [interpreter, str(HERE / "workers.py"), name, case.covariance, *sizes],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env=os.environ | dict.fromkeys(THREADS, "2") | {"PYTHONPATH": str(modules), "PYTHONWARNINGS": "ignore"},
        )  # fmt: skip

    def ask(self, task):
        """The worker's answer, a dictionary; {"error": ...} where it died."""
        try:
            self._process.stdin.write(task + "\n")
            self._process.stdin.flush()
            line = self._process.stdout.readline()
            if line:
                return json.loads(line)
        except (BrokenPipeError, ValueError):
            pass
        errors = self._process.stderr.read().strip().splitlines()
        return {"error": (errors or ["the process ended"])[-1][:300]}

    def stop(self):
        """Ends the process."""
        self._process.stdin.close()
        self._process.wait()


def measure(workers, rounds, tasks):
    """Results by worker: medians of seconds, errors, memory; or why there are none."""
    results = {worker.name: worker.ask("prepare") | {"seconds": {}} for worker in workers}
    for task in tasks:
        asked = [worker for worker in workers if "error" not in results[worker.name]]
        seconds = {worker.name: [] for worker in asked}
        for turn in range(rounds + 1):
            for worker in list(asked):
                start = time.perf_counter()
                answer = worker.ask(task)
                long = time.perf_counter() - start > LONG
                if "error" not in answer and (turn > 0 or long):
                    seconds[worker.name].append(answer["seconds"])
                if "error" in answer or (turn == 0 and long):
                    asked.remove(worker)
        for name, times in seconds.items():
            if times:
                results[name]["seconds"][task] = statistics.median(times)
    for worker in workers:
        if "error" not in results[worker.name]:
            results[worker.name] |= worker.ask("finish")
        worker.stop()
    return results


def main():
    """Runs everything and writes the results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--cases", default="")
    options = parser.parse_args()
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:2])
    say("installing egosieve")
    installed = CACHE / "peers" / "installed"
    call(ROOT / "run", "install", f"--prefix={installed}")
    modules = next(installed.glob("lib/python3.*/site-packages"))
    pythons, absent = interpreters()
    record = {"queries": QUERIES, "joint_queries": JOINT_QUERIES, "rounds": options.rounds, "absent": absent, "cases": []}
    for case in CASES:
        if not any(text in case.name() for text in options.cases.split(",")):
            continue
        workers = [Worker(name, case, pythons[name], modules) for name in case.workers if name in pythons]
        results = measure(workers, options.rounds, case.tasks)
        where = {"processor": machine().partition(", ")[2], "load": os.getloadavg()[0]}
        record["cases"].append({**case._asdict(), "machine": where, "results": results})
        (RESULTS / "peers.json").write_text(json.dumps(record, indent=1) + "\n")
        (RESULTS / "peers.md").write_text(charts.tables(record))
        charts.draw(record, RESULTS / "peers.svg")
        say(f"{case.name()}: done")
    print((RESULTS / "peers.md").read_text())


if __name__ == "__main__":
    main()
