#!/usr/bin/env python3
"""Two builds of the benchmarks in turn: compare_builds.py OLD NEW [--filter=REGEX] [--rounds=N]

Prints of each benchmark that both have the rate of NEW over that of OLD: the median, least and largest over the rounds, in which
the builds take turns at going first. By processor time, which other programs on the machine disturb least, and by the clock.
Builds: `bazel build //bench:kernel_bench`, copied from bazel-bin before the next.
"""

import argparse
import json
import os
import statistics
import subprocess
import tempfile


def names(program, pattern):
    """Of the benchmarks that match."""
    found = subprocess.run([program, "--benchmark_list_tests", f"--benchmark_filter={pattern}"], capture_output=True, text=True, check=True)
    return found.stdout.split()


def seconds(program, name):
    """(processor time, time by the clock) of an iteration; None where the benchmark failed."""
    with tempfile.NamedTemporaryFile(suffix=".json") as file:
        subprocess.run([program, f"--benchmark_filter=^{name}$", f"--json={file.name}"], capture_output=True, check=True)
        run = json.load(open(file.name))["benchmarks"][0]
    return None if run.get("error_occurred") else (run["cpu_time"], run["real_time"])


def main():
    """Measures and prints."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("--filter", default="DensePosterior")
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    shared = [name for name in names(options.old, options.filter) if name in names(options.new, options.filter)]
    ratios = {name: [] for name in shared}
    for turn in range(options.rounds):
        for name in shared:
            found = {program: seconds(program, name) for program in sorted((options.old, options.new), reverse=turn % 2 == 1)}
            if None not in found.values():
                ratios[name].append([found[options.old][i] / found[options.new][i] for i in (0, 1)])
    print(f"load {os.getloadavg()[0]:.1f}")
    for name, values in ratios.items():
        for what, column in (("processor time", 0), ("the clock", 1)):
            of = [value[column] for value in values]
            if of:
                print(f"{name}, by {what}: {statistics.median(of):.3f} ({min(of):.3f} to {max(of):.3f})")


if __name__ == "__main__":
    main()
