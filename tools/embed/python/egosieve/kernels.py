"""Kernels of scikit-learn's as the covariances that the library names by text."""

from typing import NamedTuple

import numpy as np


class Translation(NamedTuple):
    """sigma_f^2 times the function that `text` names, with these scales; noise_stddev is None without noise.

    bounds: as GaussianProcess takes them.
    """

    text: str
    scales: list
    signal_stddev: float
    noise_stddev: object
    bounds: dict


# A hyperparameter is an array: its value, lower and upper bound; equal bounds fix it.
_ONE = np.ones(3)


def _fixed(value):
    return value[1] == value[2]


def _over(a, b):
    return a / b[[0, 2, 1]]


class _Part(NamedTuple):
    """weight times a function; `terms` of a sum are more than one, and `scales` those of all."""

    weight: np.ndarray
    text: str
    scales: list
    terms: int = 1
    even: bool = True  # whether k(x, x) is the same everywhere


_MATERN = {0.5: "matern12", 1.5: "matern32", 2.5: "matern52"}


def _values(kernel, name):
    """One of these arrays for each element of a hyperparameter."""
    values = np.atleast_1d(getattr(kernel, name)).astype(float)
    bounds = getattr(kernel, name + "_bounds")
    pairs = values[:, None] if isinstance(bounds, str) else np.atleast_2d(bounds).astype(float)
    return list(np.column_stack([values, np.broadcast_to(pairs, (len(values), 2))]))


def _stationary(name, kernel, n_features):
    """One length for all features, or one for each."""
    lengths = _values(kernel, "length_scale")
    if len(lengths) == 1:
        return _Part(_ONE, f"isotropic({name})", lengths)
    if len(lengths) != n_features:
        raise ValueError(f"kernel: {len(lengths)} length scales for {n_features} features")
    return _Part(_ONE, name, lengths)


def _base(kernel, n_features):
    """One of scikit-learn's kernels that is no composition and no noise."""
    kind = type(kernel).__name__
    if kind == "ConstantKernel":
        return _Part(_values(kernel, "constant_value")[0], "constant", [])
    if kind == "RBF":
        return _stationary("squared_exponential", kernel, n_features)
    if kind == "Matern" and kernel.nu in _MATERN:
        return _stationary(_MATERN[kernel.nu], kernel, n_features)
    if kind == "RationalQuadratic":
        return _Part(_ONE, "isotropic(rational_quadratic)", _values(kernel, "alpha") + _values(kernel, "length_scale"))
    if kind == "DotProduct":
        sigma = _values(kernel, "sigma_0")[0]
        if sigma[0] == 0.0:
            return _Part(_ONE, "isotropic(linear)", [_ONE], even=False)
        return _Part(_ONE, "isotropic(linear) + constant", [_ONE, sigma], 2, even=False)
    if kind == "ExpSineSquared" and n_features == 1:
        return _Part(_ONE, "periodic", _values(kernel, "length_scale") + _values(kernel, "periodicity"))
    raise ValueError(
        f"kernel: {kernel!r} has no counterpart here"
        + (" for more than one feature" if kind == "ExpSineSquared" else "")
        + "; there are ConstantKernel, WhiteKernel, RBF, Matern(nu=0.5, 1.5, 2.5), RationalQuadratic, DotProduct, "
        "ExpSineSquared (of one feature), their sums and products, and the names that GaussianProcess lists"
    )


def _enclosed(part):
    return f"({part.text})" if part.terms > 1 else part.text


def _sum(a, b):
    # f_a + (amplitude)^2 f_b, the weight of a being that of the whole. A fixed weight comes first, so that the
    # amplitudes of others need no bounds that depend on it.
    if _fixed(b.weight) and not _fixed(a.weight):
        a, b = b, a
    amplitude = _over(b.weight, a.weight) ** 0.5
    return _Part(a.weight, f"{a.text} + {_enclosed(b)}", [*a.scales, amplitude, *b.scales], a.terms + 1, a.even and b.even)


def _product(a, b):
    weight = a.weight * b.weight
    if a.text == "constant":
        return b._replace(weight=weight)
    if b.text == "constant":
        return a._replace(weight=weight)
    return _Part(weight, f"{_enclosed(a)} * {_enclosed(b)}", [*a.scales, *b.scales], even=a.even and b.even)


def _either(join, a, b):
    return b if a is None else a if b is None else join(a, b)


def _variance(part):
    """k(x, x) of a part that has the same everywhere."""
    if part is None or not part.even or part.terms > 1:
        raise ValueError("kernel: a WhiteKernel is multiplied only by ConstantKernel and stationary kernels here")
    return part.weight


def _convert(kernel, n_features):
    """The part of the function and the variance of the noise, each None where there is none."""
    kind = type(kernel).__name__
    if kind == "WhiteKernel":
        return None, _values(kernel, "noise_level")[0]
    if kind not in ("Sum", "Product"):
        return _base(kernel, n_features), None
    (a, noise_a), (b, noise_b) = (_convert(part, n_features) for part in (kernel.k1, kernel.k2))
    if kind == "Sum":
        return _either(_sum, a, b), _either(np.add, noise_a, noise_b)
    # (a + noise_a) (b + noise_b): noise is 0 between different points, and at one point the variances multiply.
    noise = None if noise_a is None or noise_b is None else noise_a * noise_b
    for one, other in ((noise_a, b), (noise_b, a)):
        if one is not None and other is not None:
            noise = _either(np.add, one * _variance(other), noise)
    return (None if a is None or b is None else _product(a, b)), noise


def has_noise(kernel):
    """Whether a WhiteKernel is part of it."""
    if type(kernel).__name__ in ("Sum", "Product"):
        return has_noise(kernel.k1) or has_noise(kernel.k2)
    return type(kernel).__name__ == "WhiteKernel"


def translate(kernel, n_features):
    """What is equal to one of sklearn.gaussian_process.kernels, found by its classes' names."""
    part, noise = _convert(kernel, n_features)
    if part is None:
        raise ValueError(f"kernel: {kernel!r} is noise alone")
    noise = None if noise is None or noise[0] == 0.0 else noise**0.5
    signal = part.weight**0.5
    bounds = {"scales": [tuple(scale[1:]) for scale in part.scales], "signal_stddev": signal[1:]}
    if noise is not None:
        bounds["noise_stddev"] = noise[1:]
    return Translation(part.text, [scale[0] for scale in part.scales], signal[0], None if noise is None else noise[0], bounds)


def with_values(kernel, found):
    """`kernel` with the values that make its translation that of `found`, a model's hyperparameters.

    Logarithms depend linearly on one another, but for sums of noises: Newton's method with the least change. The
    text of `found` where `kernel` cannot have them.
    """
    if translate(kernel, found["dimension"]).text != found["kernel"]:
        return found["kernel"]
    wanted = np.log([*found["scales"], found["signal_stddev"], found["noise_stddev"]])

    def difference(theta):
        now = translate(kernel.clone_with_theta(theta), found["dimension"])
        noise = wanted[-1] if now.noise_stddev is None else np.log(now.noise_stddev)
        return wanted - [*np.log([*now.scales, now.signal_stddev]), noise]

    theta = np.array(kernel.theta)
    for _ in range(20):
        left = difference(theta)
        if not len(theta) or np.abs(left).max() < 1e-12:
            break
        slopes = np.stack([(left - difference(theta + step)) / 1e-4 for step in 1e-4 * np.eye(len(theta))], axis=1)
        theta = theta + np.linalg.lstsq(slopes, left, rcond=1e-6)[0]
    return kernel.clone_with_theta(theta) if np.abs(difference(theta)).max() < 1e-6 else found["kernel"]


_NAMES = ("Sum", "Product", "ConstantKernel", "WhiteKernel", "RBF", "Matern", "RationalQuadratic", "DotProduct", "ExpSineSquared")


def for_json(value):
    """Parameters as JSON has them: arrays as lists, kernels of scikit-learn's and tuples as objects of one key."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    if isinstance(value, dict):
        return {name: for_json(entry) for name, entry in value.items()}
    if isinstance(value, (list, tuple)):
        entries = [for_json(entry) for entry in value]
        return {"tuple": entries} if isinstance(value, tuple) else entries
    if type(value).__name__ in _NAMES:
        return {type(value).__name__: for_json(value.get_params(deep=False))}
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    raise TypeError(f"a parameter of type {type(value).__name__} cannot be saved")


def from_json(entry):
    """The inverse for a dict; a kernel is None where scikit-learn is not installed."""
    name, *others = entry or [None]
    if name == "tuple":
        return tuple(entry[name])
    if others or name not in _NAMES:
        return entry
    try:
        from sklearn.gaussian_process import kernels as known
    except ImportError:
        return None
    return getattr(known, name)(**entry[name])
