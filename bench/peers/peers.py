#!/usr/bin/env python3
"""Egosieve beside what a user would otherwise take: one run, the same data, the same two cores.

    bench/peers/peers.py [--joint] [--rounds N] [--points N] [--queries N] [--only NAME,NAME] [--out FOLDER]

Exact posterior (mean and variance of f) from n = 4000 points in D = 6 dimensions, and updates of that posterior by 64
points, in scikit-learn, GPyTorch (exact, and with fast_pred_var), GPy and OpenTURNS. Every library runs in a process
of its own (workers.py); the processes take turns, one timed call at a time, so that whatever else the machine does
hits all alike. Results are medians over the rounds; the first call of each, which warms up, does not count.

The peers come by pip into a virtual environment in the user's cache folder, outside the repository; one that cannot be
had is named with the reason. Writes peers.json, peers.md and peers.svg into bench/results.

--joint measures the joint covariance of 2,000 queries and 1,000 samples from it instead, in egosieve, scikit-learn and
GPyTorch, and writes joint.json and joint.md.
"""

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
from pathlib import Path

import charts

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
CACHE = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "egosieve" / "peers"

# Packages by pip of each library, which share one NumPy.
PIP = {
    "base": ["numpy<2", "scipy<1.13"],
    "scikit-learn": ["scikit-learn"],
    "GPyTorch": ["torch", "gpytorch"],
    "GPy": ["GPy", "matplotlib"],
    "OpenTURNS": ["openturns"],
}
# Worker of workers.py and the library that it needs.
WORKERS = {
    "egosieve": None,
    "egosieve arcsine": None,
    "scikit-learn": "scikit-learn",
    "GPyTorch exact": "GPyTorch",
    "GPyTorch fast_pred_var": "GPyTorch",
    "GPy": "GPy",
    "GPy MLP": "GPy",
    "OpenTURNS": "OpenTURNS",
}
TASKS = ("predict", "replace", "append")
JOINT_TASKS = ("joint", "samples")
JOINT_WORKERS = ("egosieve", "scikit-learn", "GPyTorch exact")


def say(text):
    """Progress, beside the results."""
    print(f"peers: {text}", file=sys.stderr, flush=True)


def two_cores():
    """The environment in which two threads compute, whatever the library."""
    threads = {name: "2" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "POCL_MAX_PTHREAD_COUNT")}
    return {**os.environ, **threads}


def make_environment(wanted):
    """The interpreter of a virtual environment with what could be installed, and why the rest could not."""
    interpreter = CACHE / "venv" / "bin" / "python"
    absent = {}
    if not interpreter.exists():
        say(f"making {CACHE / 'venv'}")
        made = subprocess.run(["/usr/bin/python3", "-m", "venv", str(CACHE / "venv")], capture_output=True, text=True)
        if made.returncode != 0:
            say("no virtual environment; taking what /usr/bin/python3 has")
            return "/usr/bin/python3", absent
    for library in ["base"] + sorted({WORKERS[name] for name in wanted} - {None}):
        command = [str(interpreter), "-m", "pip", "install", "-q", "--disable-pip-version-check", *PIP["base"], *PIP[library]]
        say(f"pip install {' '.join(PIP[library])}")
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            absent[library] = "pip: " + (done.stderr.strip().splitlines() or ["failed"])[-1]
    return str(interpreter), absent


def install_egosieve():
    """Where the Python module lies."""
    prefix = CACHE / "installed"
    say("installing egosieve")
    subprocess.run([str(ROOT / "run"), "install", f"--prefix={prefix}"], check=True, stdout=subprocess.DEVNULL)
    return next(prefix.glob("lib/python3.*/site-packages"))


class Worker:
    """A process that holds one library's model and does one task at a time."""

    def __init__(self, name, interpreter, module_path, options):
        self.name = name
        command = [interpreter, str(HERE / "workers.py"), name, str(options.points), str(options.queries)]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env={**two_cores(), "PYTHONPATH": str(module_path)},
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
    results = {worker.name: {} for worker in workers}
    for worker in list(workers):
        answer = worker.ask("prepare")
        results[worker.name] = answer
        if "error" in answer:
            say(f"{worker.name}: {answer['error']}")
            workers.remove(worker)
    seconds = {worker.name: {task: [] for task in tasks} for worker in workers}
    for task in tasks:
        for turn in range(rounds + 1):
            for worker in list(workers):
                answer = worker.ask(task)
                if "seconds" in answer and turn > 0:
                    seconds[worker.name][task].append(answer["seconds"])
                if "error" in answer:
                    results[worker.name].setdefault("failed", {})[task] = answer["error"]
        say(f"{task}: done")
    for worker in workers:
        results[worker.name].update(worker.ask("finish"))
        results[worker.name]["seconds"] = {
            task: statistics.median(times) for task, times in seconds[worker.name].items() if times
        }
        worker.stop()
    return results


def machine():
    """What computed."""
    model = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "?")
    return {"processor": model, "cores": 2, "system": platform.platform(), "load": os.getloadavg()[0]}


def main():
    """Runs everything and writes the results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--points", type=int, default=4000)
    parser.add_argument("--queries", type=int, help="default: 4096; with --joint 2000")
    parser.add_argument("--joint", action="store_true")
    parser.add_argument("--only")
    parser.add_argument("--out", default=str(ROOT / "bench/results"))
    options = parser.parse_args()
    options.queries = options.queries or (2000 if options.joint else 4096)
    options.only = options.only or ",".join(JOINT_WORKERS if options.joint else WORKERS)
    wanted = [name for name in WORKERS if name in options.only.split(",")]

    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:2])
    module_path = install_egosieve()
    interpreter, absent = make_environment(wanted)
    workers = [Worker(name, interpreter, module_path, options) for name in wanted if WORKERS[name] not in absent]
    results = measure(workers, options.rounds, JOINT_TASKS if options.joint else TASKS)
    for name in wanted:
        if WORKERS[name] in absent:
            results[name] = {"error": absent[WORKERS[name]]}

    record = {
        "points": options.points, "queries": options.queries, "dimension": 6, "update": 64, "rounds": options.rounds,
        "machine": machine(), "results": results,
    }  # fmt: skip
    out = Path(options.out)
    out.mkdir(parents=True, exist_ok=True)
    name = "joint" if options.joint else "peers"
    (out / f"{name}.json").write_text(json.dumps(record, indent=1) + "\n")
    table = charts.joint_table(record) if options.joint else charts.table(record)
    (out / f"{name}.md").write_text(table)
    if not options.joint:
        (out / "peers.svg").write_text(charts.bars(record))
    print(table)


if __name__ == "__main__":
    main()
