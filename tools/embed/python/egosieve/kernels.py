"""Kernels of scikit-learn's as the covariances that the library names by text."""

import math
from typing import NamedTuple

import numpy as np


class Translation(NamedTuple):
    """sigma_f^2 times the function that `text` names, with these scales; noise_stddev is None without noise."""

    text: str
    scales: list
    signal_stddev: float
    noise_stddev: object


class _Part(NamedTuple):
    """weight times a function; `terms` of a sum are more than one, and `scales` those of all."""

    weight: float
    text: str
    scales: list
    terms: int = 1


_MATERN = {0.5: "matern12", 1.5: "matern32", 2.5: "matern52"}


def _lengths(name, values, n_features):
    """One length for all features, or one for each."""
    lengths = np.atleast_1d(values).astype(float).tolist()
    if np.ndim(values) == 0 or len(lengths) == 1:
        return f"isotropic({name})", lengths[:1]
    if len(lengths) != n_features:
        raise ValueError(f"kernel: {len(lengths)} length scales for {n_features} features")
    return name, lengths


def _base(kernel, n_features):
    """One of scikit-learn's kernels that is no composition."""
    kind = type(kernel).__name__
    if kind == "ConstantKernel":
        return _Part(float(kernel.constant_value), "constant", [])
    if kind == "WhiteKernel":
        return _Part(float(kernel.noise_level), "white", [])
    if kind == "RBF":
        return _Part(1.0, *_lengths("squared_exponential", kernel.length_scale, n_features))
    if kind == "Matern" and kernel.nu in _MATERN:
        return _Part(1.0, *_lengths(_MATERN[kernel.nu], kernel.length_scale, n_features))
    if kind == "RationalQuadratic":
        return _Part(1.0, "isotropic(rational_quadratic)", [float(kernel.alpha), float(kernel.length_scale)])
    if kind == "DotProduct":
        sigma = float(kernel.sigma_0)
        if sigma == 0.0:
            return _Part(1.0, "isotropic(linear)", [1.0])
        return _Part(1.0, "isotropic(linear) + constant", [1.0, sigma], 2)
    if kind == "ExpSineSquared" and n_features == 1:
        return _Part(1.0, "periodic", [float(kernel.length_scale), float(kernel.periodicity)])
    raise ValueError(
        f"kernel: {kernel!r} has no counterpart here"
        + (" for more than one feature" if kind == "ExpSineSquared" else "")
        + "; there are ConstantKernel, WhiteKernel, RBF, Matern(nu=0.5, 1.5, 2.5), RationalQuadratic, DotProduct, "
        "ExpSineSquared (of one feature), their sums and products, and the names that GaussianProcess lists"
    )


def _enclosed(part):
    return f"({part.text})" if part.terms > 1 else part.text


def _sum(a, b):
    # f_a + (amplitude)^2 f_b, the weight of a being that of the whole.
    return _Part(
        a.weight,
        f"{a.text} + {_enclosed(b)}",
        [*a.scales, math.sqrt(b.weight / a.weight), *b.scales],
        a.terms + 1,
    )


def _product(a, b):
    weight = a.weight * b.weight
    if a.text == "constant":
        return b._replace(weight=weight)
    if b.text == "constant":
        return a._replace(weight=weight)
    return _Part(weight, f"{_enclosed(a)} * {_enclosed(b)}", [*a.scales, *b.scales])


def _convert(kernel, n_features):
    kind = type(kernel).__name__
    if kind in ("Sum", "Product"):
        join = _sum if kind == "Sum" else _product
        return join(_convert(kernel.k1, n_features), _convert(kernel.k2, n_features))
    return _base(kernel, n_features)


def _without_noise(kernel):
    """The kernel without what white noise is added to it, and the variance of that."""
    if type(kernel).__name__ == "Sum":
        for noise, rest in ((kernel.k2, kernel.k1), (kernel.k1, kernel.k2)):
            if type(noise).__name__ == "WhiteKernel":
                kept, more = _without_noise(rest)
                return kept, more + float(noise.noise_level)
    return kernel, 0.0


def translate(kernel, n_features):
    """What is equal to one of sklearn.gaussian_process.kernels, found by its classes' names."""
    kept, noise = _without_noise(kernel)
    part = _convert(kept, n_features)
    return Translation(part.text, part.scales, math.sqrt(part.weight), math.sqrt(noise) if noise > 0.0 else None)
