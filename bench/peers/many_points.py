#!/usr/bin/env python3
"""More points than a factor has room for: exact means by conjugate gradients beside the factor and GPyTorch.

    bench/peers/many_points.py [--points N,N] [--dimensions D,D] [--rank M] [--tolerance T] [--methods TEXT,TEXT]

The Matern 5/2 of problem.py with given hyperparameters, from its points until the mean of 256 queries. "iterative" is
approximation="iterative", "exact" the model with a factor, "GPyTorch" its conjugate gradients in float64 with the same rank and
tolerance. "product" has rank 1 and the tolerance 0.999: its seconds by (iterations + 1) are those of one iteration. Each
runs in a process of its own, on two cores. Columns: seconds, those of the processors, most memory, and the largest
difference of the means from those of "exact" at the same size. Writes many_points.md into bench/results.
./run install is run first; GPyTorch is installed by pip into the user's cache folder.
"""

import argparse
import importlib
import json
import os
import resource
import sys
import time
import warnings
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from common import CACHE, RESULTS, ROOT, call, environment, machine, markdown, say, work  # noqa: E402
from problem import NOISE, length_of, make_data  # noqa: E402

METHODS = ("iterative", "exact", "GPyTorch")
QUERIES = 256
GPYTORCH = ["numpy<2", "scipy<1.13", "scikit-learn", "torch", "gpytorch"]


def egosieve_mean(egosieve, approximation, X, y, queries, rank, tolerance):
    """Means, iterations and residual of this library."""
    gp = egosieve.GaussianProcess("matern52", scales=[length_of(X.shape[1])] * X.shape[1], noise_stddev=NOISE, optimize=False,
                                  approximation=approximation, inducing_points=rank, tolerance=tolerance)  # fmt: skip
    gp.fit(X, y)
    found = gp.hyperparameters_
    return gp.predict(queries, precision="float64"), found["iterations"], found["residual"]


def gpytorch_mean(gpytorch, X, y, queries, rank, tolerance):
    """The same of GPyTorch, which does not tell its iterations."""
    import torch

    torch.set_num_threads(2)
    X, y, queries = (torch.as_tensor(array, dtype=torch.float64) for array in (X, y, queries))

    class Model(gpytorch.models.ExactGP):
        def forward(self, x):
            return gpytorch.distributions.MultivariateNormal(x.new_zeros(len(x)), self.kernel(x))

    likelihood = gpytorch.likelihoods.GaussianLikelihood()
    model = Model(X, y, likelihood).double()
    likelihood.noise = NOISE**2
    model.kernel = gpytorch.kernels.MaternKernel(nu=2.5).double()
    model.kernel.lengthscale = length_of(X.shape[1])
    model.eval()
    settings = gpytorch.settings
    with (
        torch.no_grad(), settings.skip_posterior_variances(True), settings.max_cholesky_size(0), settings.max_cg_iterations(1000),
        settings.eval_cg_tolerance(tolerance), settings.cg_tolerance(tolerance), settings.max_preconditioner_size(rank),
    ):  # fmt: skip
        return model(queries).mean.numpy(), None, None


def measure(method, points, dimension, rank, tolerance):
    """What one process finds, as JSON on stdout."""
    X, y, queries = make_data(points, dimension, QUERIES)
    X, y = X[:points], y[:points]
    warnings.simplefilter("ignore")
    library = importlib.import_module("gpytorch" if method == "GPyTorch" else "egosieve")
    wall, processors = time.perf_counter(), time.process_time()
    answer = {}
    try:
        if method == "GPyTorch":
            mean, iterations, residual = gpytorch_mean(library, X, y, queries, rank, tolerance)
        elif method == "product":
            mean, iterations, residual = egosieve_mean(library, "iterative", X, y, queries, 1, 0.999)
        else:
            mean, iterations, residual = egosieve_mean(library, method, X, y, queries, rank, tolerance)
        answer = {"mean": mean.tolist(), "iterations": iterations, "residual": residual}
    except (RuntimeError, MemoryError) as error:
        answer = {"error": str(error)}
    answer |= {"seconds": time.perf_counter() - wall, "processors": time.process_time() - processors}
    answer["megabytes"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(json.dumps(answer))


def row(method, points, dimension, found, exact):
    """A line of the table."""
    if "error" in found:
        return [points, dimension, method, *[""] * 5, found["error"][:80]]
    numbers = [f"{found['seconds']:.1f}", f"{found['processors']:.1f}", found["iterations"] or "", f"{found['residual']:.1e}" if found["residual"] else "",
               f"{found['megabytes']:.0f}"]  # fmt: skip
    error = max(abs(a - b) for a, b in zip(found["mean"], exact)) if exact and method != "exact" else None
    return [points, dimension, method, *numbers, "" if error is None else f"{error:.1e}"]


def main():
    """Measures everything and writes the table after each size."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, default in (("points", "4000,20000,50000"), ("dimensions", "2,6"), ("rank", "512"), ("tolerance", "1e-8"),
                          ("methods", ",".join(METHODS))):  # fmt: skip
        parser.add_argument(f"--{name}", default=default)
    parser.add_argument("--measure", nargs=3, help=argparse.SUPPRESS)
    options = parser.parse_args()
    rank, tolerance = int(options.rank), float(options.tolerance)
    if options.measure:
        return measure(options.measure[0], *map(int, options.measure[1:]), rank, tolerance)
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:2])
    installed = CACHE / "peers" / "installed"
    call(ROOT / "run", "install", f"--prefix={installed}")
    os.environ["PYTHONPATH"] = str(next(installed.glob("lib/python3.*/site-packages")))
    python = environment("peers/gpytorch", GPYTORCH) if "GPyTorch" in options.methods else "/usr/bin/python3"
    rows = []
    for points in map(int, options.points.split(",")):
        for dimension in map(int, options.dimensions.split(",")):
            found = {}
            for method in options.methods.split(","):
                found[method] = work(python if method == "GPyTorch" else "/usr/bin/python3", HERE / "many_points.py", f"--rank={rank}",
                                     f"--tolerance={tolerance}", "--measure", method, points, dimension)  # fmt: skip
                say(f"{method} n={points} D={dimension}: {found[method]['seconds']:.1f} s")
            exact = found.get("exact", {}).get("mean")
            rows += [row(method, points, dimension, one, exact) for method, one in found.items()]
            table = markdown([">n", ">D", "method", ">s", ">s of processors", ">iterations", ">residual", ">MB", "difference"], rows)
            where = f"{machine()}; load {os.getloadavg()[0]:.1f}; rank {rank}, tolerance {tolerance:g}\n\n"
            (RESULTS / "many_points.md").write_text(where + table)
    print(table)


if __name__ == "__main__":
    main()
