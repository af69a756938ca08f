#!/usr/bin/env python3
"""PyTorch's and GPyTorch's exact posterior on a GPU, on the problem of BM_DensePosteriorPicture and BM_DeviceRegression.

    bench/peers/gpu.py [--points 4000] [--json FILE]

n points in D = 6, arcsine or Matern 5/2, every pixel of 1242 x 375; float32 without TF32, in chunks of queries that run
fastest. `torch` is the shortest program: the covariances of a chunk, a triangular solve, sums of squares. `gpytorch` is
ExactGP with the Cholesky factor cached. Times are medians of five runs after one that warms up, queries and results in the
device's memory; `with copies` counts copies from and to the host, as Evaluate's do.
"""

import argparse
import json
import math
import statistics
import sys
import time

import torch

PIXELS, DIMENSION = 1242 * 375, 6


def matern52(a, b):
    """Of scaled points: (m, D) and (n, D) give (m, n)."""
    distance = math.sqrt(5.0) * torch.cdist(a, b)
    return (1 + distance + distance**2 / 3) * torch.exp(-distance)


def arcsine(a, b):
    """Paper equation 5 without scales: (m, D) and (n, D) give (m, n)."""
    a, b = (torch.cat([torch.ones(len(x), 1, device=x.device, dtype=x.dtype), x], 1) for x in (a, b))
    inner = 2 * a @ b.T
    of_a, of_b = (1 + 2 * (x**2).sum(1) for x in (a, b))
    return 2 / math.pi * torch.asin(inner / torch.sqrt(of_a[:, None] * of_b[None, :]))


def seconds(call):
    """Median of five, the device idle before and after."""
    taken = []
    for _ in range(6):
        torch.cuda.synchronize()
        begin = time.perf_counter()
        call()
        torch.cuda.synchronize()
        taken.append(time.perf_counter() - begin)
    return statistics.median(taken[1:])


def fastest(make):
    """The least of `seconds(make(chunk))` over chunk sizes, and that chunk."""
    return min((seconds(make(chunk)), chunk) for chunk in (4096, 16384, 65536))


def torch_rows(n, covariance, queries, inputs):
    """Fit, mean, mean and variance."""
    identity = 0.01 * torch.eye(n, device="cuda")
    targets = torch.sin(3 * inputs[:, 0])

    def fit():
        factor = torch.linalg.cholesky(covariance(inputs, inputs) + identity)
        return factor, torch.cholesky_solve(targets[:, None], factor)

    factor, alpha = fit()

    def mean(chunk):
        return lambda: torch.cat([covariance(q, inputs) @ alpha for q in queries.split(chunk)])

    def both(chunk):
        def call():
            means, variances = [], []
            for part in queries.split(chunk):
                k = covariance(part, inputs)
                means.append(k @ alpha)
                v = torch.linalg.solve_triangular(factor, k.T, upper=False)
                variances.append(1 - (v**2).sum(0))
            return torch.cat(means), torch.cat(variances)

        return call

    host = queries.cpu()

    def copied(chunk):
        call = both(chunk)
        return lambda: [x.cpu() for x in (host.cuda(), *call())]

    return {"fit": (seconds(fit), None), "mean": fastest(mean), "mean and variance": fastest(both),
            "mean and variance, with copies": fastest(copied)}  # fmt: skip


def gpytorch_rows(queries, inputs):
    """ExactGP of a Matern 5/2."""
    import gpytorch

    class Model(gpytorch.models.ExactGP):
        """Zero mean."""

        def __init__(self, likelihood):
            super().__init__(inputs, torch.sin(3 * inputs[:, 0]), likelihood)
            self.mean_module = gpytorch.means.ZeroMean()
            self.covar_module = gpytorch.kernels.ScaleKernel(gpytorch.kernels.MaternKernel(2.5))

        def forward(self, x):
            """GPyTorch's interface."""
            return gpytorch.distributions.MultivariateNormal(self.mean_module(x), self.covar_module(x))

    likelihood = gpytorch.likelihoods.GaussianLikelihood().cuda()
    model = Model(likelihood).cuda().eval()
    likelihood.noise = 0.01

    def both(chunk):
        def call():
            for part in queries.split(chunk):
                posterior = model(part)
                posterior.mean, posterior.variance

        return call

    with torch.no_grad(), gpytorch.settings.max_cholesky_size(10**6), gpytorch.settings.skip_posterior_variances(False):
        exact = min((seconds(both(chunk)), chunk) for chunk in (2048, 8192))
        with gpytorch.settings.fast_pred_var():
            fast = min((seconds(both(chunk)), chunk) for chunk in (2048, 8192))
    return {"mean and variance": exact, "mean and variance, fast_pred_var": fast}


def main():
    """Prints a row per task."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=4000)
    parser.add_argument("--json")
    options = parser.parse_args()
    if not torch.cuda.is_available():
        sys.exit("gpu.py: PyTorch sees no GPU")
    torch.backends.cuda.matmul.allow_tf32 = False
    torch.manual_seed(1)
    queries = torch.rand(PIXELS, DIMENSION, device="cuda") * 2 - 1
    inputs = torch.rand(options.points, DIMENSION, device="cuda") * 2 - 1
    with torch.no_grad():
        tables = {f"torch {torch.__version__} {c.__name__}": torch_rows(options.points, c, queries, inputs)
                  for c in (arcsine, matern52)}  # fmt: skip
    try:
        import gpytorch

        tables[f"gpytorch {gpytorch.__version__} matern52"] = gpytorch_rows(queries, inputs)
    except ImportError as error:
        print(f"gpu.py: no GPyTorch ({error})", file=sys.stderr)
    print(torch.cuda.get_device_name())
    for library, rows in tables.items():
        for task, (taken, chunk) in rows.items():
            print(f"{library:32} {task:34} {1e3 * taken:10.2f} ms {'' if chunk is None else f'chunks of {chunk}'}")
    if options.json:
        with open(options.json, "w") as file:
            json.dump({"device": torch.cuda.get_device_name(), "points": options.points, "seconds": tables}, file, indent=1)


if __name__ == "__main__":
    main()
