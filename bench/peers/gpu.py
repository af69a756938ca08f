#!/usr/bin/env python3
"""PyTorch's and GPyTorch's exact posterior on a GPU, on the problem of BM_DensePosteriorPicture and BM_DeviceRegression.

    bench/peers/gpu.py

4,000 points in D = 6, arcsine or Matern 5/2, every pixel of 1242 x 375; float32 without TF32, in chunks of queries that run
fastest. `torch` is the shortest program: the covariances of a chunk, a triangular solve, sums of squares. `gpytorch` is
ExactGP with the Cholesky factor cached. Times are medians of five runs after one that warms up, queries and results in the
device's memory; `with copies` counts copies from and to the host, as Evaluate's do.
"""

import itertools
import math
import statistics
import sys
import time
from functools import partial

import gpytorch
import torch

PIXELS, POINTS, DIMENSION, NOISE = 1242 * 375, 4000, 6, 0.01
# Name, method, and where the queries and results are.
TASKS = (("mean", "mean", "cuda"), ("mean and variance", "both", "cuda"), ("mean and variance, with copies", "both", "cpu"))
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


class Torch:
    """The shortest program."""

    def __init__(self, covariance, inputs):
        self.covariance, self.inputs, self.targets = covariance, inputs, torch.sin(3 * inputs[:, 0])
        self.fit()

    def fit(self):
        noise = NOISE * torch.eye(len(self.inputs), device="cuda")
        self.factor = torch.linalg.cholesky(self.covariance(self.inputs, self.inputs) + noise)
        self.alpha = torch.cholesky_solve(self.targets[:, None], self.factor)

    def mean(self, part):
        return [self.covariance(part, self.inputs) @ self.alpha]

    def both(self, part):
        k = self.covariance(part, self.inputs)
        return k @ self.alpha, 1 - (torch.linalg.solve_triangular(self.factor, k.T, upper=False) ** 2).sum(0)


class Exact(gpytorch.models.ExactGP):
    """Zero mean, Matern 5/2."""

    def __init__(self, inputs, fast):
        likelihood = gpytorch.likelihoods.GaussianLikelihood().cuda()
        super().__init__(inputs, torch.sin(3 * inputs[:, 0]), likelihood)
        self.kernel, self.fast = gpytorch.kernels.ScaleKernel(gpytorch.kernels.MaternKernel(2.5)), fast
        self.cuda().eval()
        likelihood.noise = NOISE

    def forward(self, x):
        """GPyTorch's interface."""
        return gpytorch.distributions.MultivariateNormal(x.new_zeros(len(x)), self.kernel(x))

    def both(self, part):
        with gpytorch.settings.max_cholesky_size(10**6), gpytorch.settings.fast_pred_var(self.fast):
            found = self(part)
            return found.mean, found.variance


def evaluate(call, queries, chunk):
    """All queries in chunks, copied from where they are to the device, and the results back."""
    found = zip(*(call(part) for part in queries.cuda().split(chunk)))
    return [torch.cat(values).to(queries.device) for values in found]


def main():
    """Prints a row per rival and task."""
    if not torch.cuda.is_available():
        sys.exit("gpu.py: PyTorch sees no GPU")
    torch.backends.cuda.matmul.allow_tf32 = False
    torch.manual_seed(1)
    queries, inputs = (2 * torch.rand(count, DIMENSION, device="cuda") - 1 for count in (PIXELS, POINTS))
    print(torch.cuda.get_device_name())
    with torch.no_grad():
        rivals = {
            f"torch {torch.__version__} arcsine": Torch(arcsine, inputs),
            f"torch {torch.__version__} matern52": Torch(matern52, inputs),
            f"gpytorch {gpytorch.__version__} matern52": Exact(inputs, False),
            f"gpytorch {gpytorch.__version__} matern52, fast_pred_var": Exact(inputs, True),
        }
        for (name, rival), (task, method, where) in itertools.product(rivals.items(), TASKS):
            if hasattr(rival, method):
                asked = queries.to(where)
                calls = {f"chunks of {c}": partial(evaluate, getattr(rival, method), asked, c) for c in CHUNKS}
                taken, chunk = min((seconds(call), size) for size, call in calls.items())
                print(f"{name:40} {task:32} {1e3 * taken:10.2f} ms, {chunk}")
        for name, rival in list(rivals.items())[:2]:
            print(f"{name:40} {'fit':32} {1e3 * seconds(rival.fit):10.2f} ms")


if __name__ == "__main__":
    main()
