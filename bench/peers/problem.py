"""What every worker computes: data, hyperparameters, and the posterior in float64 that errors are measured against."""

import math

import numpy as np

UPDATE = 64  # points
WEIGHT, PERIOD, NOISE = 1.5, 1.7, 0.3


def length_of(dimension):
    """The length at which neighbours are equally correlated in any dimension."""
    return 0.8 * math.sqrt(dimension / 6)


def make_data(points, dimension, queries):
    """Inputs and targets of the model, of 64 updates, and the queries."""
    random = np.random.default_rng(11)
    X = random.uniform(-1, 1, (points + 64 * UPDATE, dimension))
    y = np.tanh(3 * np.sin(2 * X[:, 0]) * X[:, 1] + X[:, -1]) + random.normal(0, NOISE, len(X))
    return X, y, random.uniform(-1, 1, (queries, dimension))


def arcsine(a, b):
    """The neural network covariance."""
    norms = [1 + 2 * WEIGHT**2 * (1 + (x**2).sum(1)) for x in (a, b)]
    return np.arcsin(2 * WEIGHT**2 * (1 + a @ b.T) / np.sqrt(norms[0][:, None] * norms[1][None]))


def periodic(a, b):
    """Over every input; the length of one."""
    exponent = sum(np.sin(np.pi * (a[:, d, None] - b[None, :, d]) / PERIOD) ** 2 for d in range(a.shape[1]))
    return np.exp(-2 * exponent / length_of(a.shape[1]) ** 2)


def float64_covariance(name, dimension):
    """By the formulas, or scikit-learn's."""
    from libraries import ScikitLearn

    own = {"arcsine": arcsine, "periodic": periodic}
    return own.get(name) or ScikitLearn.kernels(None, dimension, length_of(dimension))[name]()


def float64_posterior(covariance, X, y, queries):
    """Mean and variance of f, the measure of all errors."""
    from scipy.linalg import cho_factor, cho_solve, solve_triangular

    factor = cho_factor(covariance(X, X) + NOISE**2 * np.eye(len(X)), lower=True)
    cross = covariance(X, queries)
    half = solve_triangular(factor[0], cross, lower=True)
    return cross.T @ cho_solve(factor, y), np.diag(covariance(queries, queries)) - (half**2).sum(axis=0)
