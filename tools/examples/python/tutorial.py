#!/usr/bin/env python3
"""The figure of docs/tutorial.md: tutorial.py FIGURE.png [POINTS of the sparse model]; needs matplotlib."""

import sys

import egosieve
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

many = int(sys.argv[2]) if len(sys.argv) > 2 else 2000
random = np.random.default_rng(0)
figure, ((regression, priors), (sparse, classes)) = plt.subplots(2, 2, figsize=(10, 7), constrained_layout=True)
line = np.linspace(-1, 1, 300)[:, None]


def band(axes, mean, std, colour):
    """A mean with two standard deviations on either side."""
    axes.plot(line[:, 0], mean, color=colour)
    axes.fill_between(line[:, 0], mean - 2 * std, mean + 2 * std, color=colour, alpha=0.2, linewidth=0)


# Regression
X = random.uniform(-1, 0.5, (25, 1))
y = np.sin(5 * X[:, 0]) + random.normal(0, 0.1, 25)
gp = egosieve.GaussianProcess("matern52").fit(X, y)
band(regression, *gp.predict(line, return_std=True), "C0")
regression.plot(line[:, 0], gp.sample_y(line, n_samples=3, random_state=1), color="C0", linewidth=0.6)
regression.plot(X[:, 0], y, "k.", markersize=4)
regression.set_title("Mean, two deviations, three samples")

# Covariances: one sample of each prior
for kernel in ("squared_exponential", "matern12", "linear + matern52", "isotropic(periodic)"):
    sample = egosieve.GaussianProcess(kernel).sample_y(line, random_state=3)
    priors.plot(line[:, 0], sample[:, 0], label=kernel, linewidth=1)
priors.legend(fontsize="small")
priors.set_title("Samples of the prior, by covariance")

# A sparse model of many points
X = random.uniform(-1, 1, (many, 1))
y = np.sin(5 * X[:, 0]) + random.normal(0, 0.3, many)
few = egosieve.GaussianProcess("matern52", approximation="dtc", inducing_points=10).fit(X, y)
exact = egosieve.GaussianProcess("matern52").fit(X, y)
sparse.plot(X[:, 0], y, ".", color="0.8", markersize=1)
band(sparse, *exact.predict(line, return_std=True), "C0")
band(sparse, *few.predict(line, return_std=True), "C3")
sparse.set_title("Exact (blue) and ten inducing inputs (red)")

# Classes: labels -1 and 1
X = random.uniform(-1, 1, (150, 2))
labels = np.where(np.hypot(X[:, 0], X[:, 1] - 0.2) < 0.6, 1.0, -1.0)
classifier = egosieve.GaussianProcess("arcsine", noise_stddev=0.3).fit(X, labels)
axis = np.linspace(-1, 1, 80)
grid = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
probability = classifier.predict_proba(grid)[:, 1].reshape(80, 80)
drawn = classes.contourf(axis, axis, probability, levels=np.linspace(0, 1, 11), cmap="coolwarm")
classes.scatter(X[:, 0], X[:, 1], c=labels, s=6, cmap="coolwarm", edgecolors="k", linewidths=0.3)
figure.colorbar(drawn, ax=classes)
classes.set_title("Probability of the inner class")

figure.savefig(sys.argv[1], dpi=90)
