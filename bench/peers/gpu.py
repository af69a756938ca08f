#!/usr/bin/env python3
"""PyTorch's and GPyTorch's exact posterior on a GPU, on the problem of BM_DensePosteriorPicture and BM_DeviceRegression.

    bench/peers/gpu.py [--points 4000]

n points in D = 6, arcsine or Matern 5/2, every pixel of 1242 x 375; float32 without TF32, in chunks of queries that run
fastest. `torch` is the shortest program: the covariances of a chunk, a triangular solve, sums of squares. `gpytorch` is
ExactGP with the Cholesky factor cached. Times are medians of five runs after one that warms up, queries and results in the
device's memory; `with copies` counts copies from and to the host, as Evaluate's do.
"""

import argparse
import math
import statistics
import sys
import time

import gpytorch
import torch

PIXELS, DIMENSION, NOISE = 1242 * 375, 6, 0.01
CHUNKS = (2048, 4096, 8192, 16384, 65536)


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


class Exact(gpytorch.models.ExactGP):
    """Zero mean, Matern 5/2."""

    def __init__(self, inputs, targets):
        likelihood = gpytorch.likelihoods.GaussianLikelihood().cuda()
        super().__init__(inputs, targets, likelihood)
        self.kernel = gpytorch.kernels.ScaleKernel(gpytorch.kernels.MaternKernel(2.5))
        self.cuda().eval()
        likelihood.noise = NOISE

    def forward(self, x):
        """GPyTorch's interface."""
        return gpytorch.distributions.MultivariateNormal(x.new_zeros(len(x)), self.kernel(x))


def rivals(inputs, targets):
    """(library, task, what it computes: of a chunk of queries; fit: of nothing)."""
    identity = NOISE * torch.eye(len(inputs), device="cuda")
    for covariance in (arcsine, matern52):

        def fit(covariance=covariance):
            factor = torch.linalg.cholesky(covariance(inputs, inputs) + identity)
            return factor, torch.cholesky_solve(targets[:, None], factor)

        factor, alpha = fit()

        def mean(part, covariance=covariance, alpha=alpha):
            return [covariance(part, inputs) @ alpha]

        def both(part, covariance=covariance, factor=factor, alpha=alpha):
            k = covariance(part, inputs)
            return k @ alpha, 1 - (torch.linalg.solve_triangular(factor, k.T, upper=False) ** 2).sum(0)

        library = f"torch {torch.__version__} {covariance.__name__}"
        for task, call in (("fit", fit), ("mean", mean), ("mean and variance", both), ("mean and variance, with copies", both)):
            yield library, task, call
    for fast in (False, True):
        model = Exact(inputs, targets)

        def posterior(part, model=model, fast=fast):
            with gpytorch.settings.max_cholesky_size(10**6), gpytorch.settings.fast_pred_var(fast):
                found = model(part)
                return found.mean, found.variance

        yield f"gpytorch {gpytorch.__version__} matern52", f"mean and variance{', fast_pred_var' * fast}", posterior


def evaluate(call, queries, chunk, copies):
    """All queries in chunks; copies: from the host and to it."""
    found = [torch.cat(values) for values in zip(*(call(part) for part in queries.cuda().split(chunk)))]
    return [values.cpu() for values in found] if copies else found


def main():
    """Prints a row per task."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=4000)
    options = parser.parse_args()
    if not torch.cuda.is_available():
        sys.exit("gpu.py: PyTorch sees no GPU")
    torch.backends.cuda.matmul.allow_tf32 = False
    torch.manual_seed(1)
    queries = torch.rand(PIXELS, DIMENSION, device="cuda") * 2 - 1
    inputs = torch.rand(options.points, DIMENSION, device="cuda") * 2 - 1
    print(torch.cuda.get_device_name())
    with torch.no_grad():
        for library, task, call in rivals(inputs, torch.sin(3 * inputs[:, 0])):
            copies = task.endswith("copies")
            asked = queries.cpu() if copies else queries
            if task == "fit":
                taken, chunk = seconds(call), ""
            else:
                taken, chunk = min((seconds(lambda: evaluate(call, asked, c, copies)), f"chunks of {c}") for c in CHUNKS)
            print(f"{library:32} {task:34} {1e3 * taken:10.2f} ms {chunk}")


if __name__ == "__main__":
    main()
