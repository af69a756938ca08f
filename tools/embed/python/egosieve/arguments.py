"""Arguments as arrays, checked, with scikit-learn's words where scikit-learn's users expect them."""

import sys
import warnings

import numpy as np


def _of_sklearn(name, substitute):
    """scikit-learn's exception or warning where that is loaded, so that its users can catch it."""
    return getattr(sys.modules.get("sklearn.exceptions"), name, substitute)


class NotFittedError(ValueError, AttributeError):
    """The estimator has no points yet."""


def not_fitted(estimator):
    """The exception for an estimator that was not fitted."""
    return _of_sklearn("NotFittedError", NotFittedError)(
        f"This {type(estimator).__name__} instance is not fitted yet: call fit or partial_fit first"
    )


def _numbers(name, values, array):
    """An array of objects as float64 where all are numbers, bool or missing (NaN)."""
    if hasattr(values, "to_numpy"):  # a data frame, whose missing values may be of a kind of their own
        try:
            return values.to_numpy(dtype=np.float64, na_value=np.nan)
        except (TypeError, ValueError):
            pass  # not numbers: said below
    if any(isinstance(value, str) for value in array.flat):
        raise TypeError(f"{name} holds text; it must hold numbers")
    try:
        return array.astype(np.float64)
    except (TypeError, ValueError) as error:
        raise TypeError(f"{name}: {error}") from None


def _floating(name, values):
    """`values` as an array of float32 or float64; a copy only where the type is another."""
    if hasattr(values, "toarray") or hasattr(values, "todense"):
        raise TypeError(f"{name} is a sparse matrix, but dense data is required: pass {name}.toarray()")
    if hasattr(values, "__dlpack__") and not hasattr(values, "__array__"):
        values = np.from_dlpack(values)
    array = np.asarray(values)
    if array.dtype == object:
        array = _numbers(name, values, array)
    if array.dtype.kind == "c":
        raise ValueError(f"Complex data not supported: {name} has dtype {array.dtype}")
    if array.dtype.kind not in "fiub" or array.dtype.itemsize > 8:
        raise TypeError(f"{name} has dtype {array.dtype}; it must be of numbers, float32 or float64")
    if array.dtype not in (np.float32, np.float64):
        array = array.astype(np.float64)
    return array


def _check_finite(name, array):
    # A sum is finite only where all are, but for overflow, which the second look tells apart.
    with np.errstate(over="ignore", invalid="ignore"):
        if np.isfinite(array.sum(dtype=np.float64)):
            return array
    for place in np.argwhere(~np.isfinite(array)):
        place = tuple(map(int, place))
        what = "NaN" if np.isnan(array[place]) else "infinity"
        raise ValueError(f"{name} contains {what}, first at {place}; NaN and infinity (inf) are not supported")
    return array


def _check_count(name, array, count):
    if len(array) != count:
        raise ValueError(f"Found input variables with inconsistent numbers of samples: X {count}, {name} {len(array)}")


def number(name, value):
    """One number, the same for every point."""
    if np.ndim(value) != 0:
        raise ValueError(f"{name} has shape {np.shape(value)}; it must be one number, the same for all points")
    return float(value)


def indices(name, values, size):
    """Indices of `size` things as NumPy takes them: integers, negative ones from the end, or an array of bool."""
    array = np.asarray(values)
    if array.size == 0 and array.dtype.kind != "b":
        return []
    if array.ndim != 1 or array.dtype.kind not in "iub":
        raise TypeError(f"{name} must be a list of integers or bool; it has dtype {array.dtype} and shape {array.shape}")
    if array.dtype.kind == "b":
        if len(array) != size:
            raise ValueError(f"{name} has {len(array)} values of bool; there are {size} points")
        array = np.flatnonzero(array)
    for index in array:
        if not -size <= index < size:
            raise ValueError(f"{name}: {index}; the model has {size} points")
    return [int(index) % size for index in array]


def matrix(name, values):
    """N x D numbers, N and D at least 1, finite."""
    array = _floating(name, values)
    if array.ndim < 2:
        raise ValueError(
            f"Expected 2D array, got {array.ndim}D array instead for {name}. Reshape your data with "
            f"{name}.reshape(-1, 1) if it has one feature or {name}.reshape(1, -1) if it is one sample"
        )
    if array.ndim > 2:
        raise ValueError(f"{name}: found array with dim {array.ndim}, expected 2")
    for what, count in zip(("sample", "feature"), array.shape):
        if count == 0:
            raise ValueError(f"{name}: found array with 0 {what}(s) (shape={array.shape}) while a minimum of 1 is required.")
    return _check_finite(name, array)


def axis(name, values):
    """A vector of finite numbers, at least one."""
    array = _floating(name, values)
    if array.ndim != 1 or len(array) == 0:
        raise ValueError(f"{name} has shape {array.shape}; it must be a vector with at least one number")
    return _check_finite(name, array)


def even_step(values):
    """The step of an axis where all are the same to float32's precision of its length; None where not."""
    if len(values) == 1:
        return 0.0
    step = float(values[-1] - values[0]) / (len(values) - 1)
    even = values[0] + step * np.arange(len(values))
    return step if np.allclose(values, even, rtol=0.0, atol=6e-8 * np.ptp(values)) else None


def variances(name, values, count):
    """Noise variances of `count` points from a number or an array; None where all are 0."""
    array = _floating(name, values)
    if array.ndim == 0:
        array = np.full(count, float(array))
    if array.shape != (count,):
        raise ValueError(f"{name} must be a scalar or an array with same number of entries as y ({count}); "
                         f"its shape is {array.shape}")  # fmt: skip
    for value in array[~((array >= 0) & np.isfinite(array))]:
        raise ValueError(f"{name} holds {value}; its values are finite and not negative")
    return array if array.any() else None


def seed(random_state):
    """A seed from None (0), an integer, or NumPy's generators, which it advances."""
    if isinstance(random_state, np.random.RandomState):
        return int(random_state.randint(2**31))
    return int(random_state.integers(2**63)) if isinstance(random_state, np.random.Generator) else int(random_state or 0)


def _flat(name, array):
    """A column as a vector, with a warning, as scikit-learn does."""
    if array.ndim != 2 or array.shape[1] != 1:
        return array
    warnings.warn(
        f"A column-vector {name} was passed when a 1d array was expected. "
        f"Please change the shape of {name} to (n_samples, ), for example using ravel().",
        _of_sklearn("DataConversionWarning", UserWarning),
        stacklevel=4,
    )
    return array[:, 0]


def targets(name, values, count):
    """`count` finite numbers, or a row for each of them; a column is taken with a warning, as scikit-learn does."""
    if values is None:
        raise ValueError(f"GaussianProcess requires {name} to be passed, but the target {name} is None")
    array = _flat(name, _floating(name, values))
    if array.ndim not in (1, 2) or array.ndim == 2 and array.shape[1] == 0:
        raise ValueError(f"{name} should be a 1d or 2d array, got an array of shape {array.shape} instead.")
    _check_count(name, array, count)
    return _check_finite(name, array)


def labels(name, values, count):
    """`count` class labels: texts, bool or whole numbers."""
    if values is None:
        raise ValueError(f"GaussianProcessClassifier requires {name} to be passed, but the target {name} is None")
    array = np.asarray(values)
    if array.dtype == object and getattr(getattr(values, "dtype", None), "kind", "O") in "biuf":
        array = values.to_numpy(dtype=values.dtype.numpy_dtype)  # pandas' nullable numbers and bool
    array = _flat(name, array)
    if array.ndim != 1:
        raise ValueError(f"{name} should be a 1d array, got an array of shape {array.shape} instead.")
    _check_count(name, array, count)
    if array.dtype == object:
        try:
            np.sort(array)
        except TypeError as error:
            raise ValueError(f"{name} holds labels that cannot be sorted, of different kinds or None: {error}") from None
    if array.dtype.kind in "fc":
        _check_finite(name, array)
        if array.dtype.kind == "c" or np.any(array != np.round(array)):
            raise ValueError(f"Unknown label type: continuous. {name} holds numbers that are not whole; they are no classes")
    return array


def feature_names(values):
    """The names of a data frame's columns where all are text, else None."""
    names = getattr(values, "columns", None)
    if names is None or not all(isinstance(name, str) for name in names):
        return None
    return np.asarray(list(names), dtype=object)


def queries(estimator, values, name="X"):
    """Rows as matrix() gives them; of a fitted estimator with the features that it was fitted with, in the same order."""
    if not estimator._is_fitted():
        return matrix(name, values)
    known, given = getattr(estimator, "feature_names_in_", None), feature_names(values)
    kind, count = type(estimator).__name__, estimator.n_features_in_
    if given is not None and known is None:
        warnings.warn(f"X has feature names, but {kind} was fitted without feature names", stacklevel=3)
    elif known is not None and given is None and hasattr(values, "shape"):
        warnings.warn(f"X does not have valid feature names, but {kind} was fitted with feature names", stacklevel=3)
    elif known is not None and given is not None and list(known) != list(given):
        raise ValueError(_differences(list(known), list(given)))
    X = matrix(name, values)
    if X.shape[1] != count:
        raise ValueError(f"{name} has {X.shape[1]} features, but {kind} is expecting {count} features as input")
    return X


def _differences(known, given):
    lines = ["The feature names should match those that were passed during fit."]
    unseen, missing = sorted(set(given) - set(known)), sorted(set(known) - set(given))
    for title, names in (("unseen at fit time:", unseen), ("seen at fit time, yet now missing:", missing)):
        if names:
            lines += [f"Feature names {title}", *(f"- {name}" for name in names[:5]), *["- ..."][: len(names) > 5]]
    if len(lines) == 1:
        lines.append("Feature names must be in the same order as they were in fit.")
    return "\n".join(lines) + "\n"


def address(name, handle):
    """Of an OpenCL object of PyOpenCL's, or the address itself."""
    value = getattr(handle, "int_ptr", handle)
    if isinstance(value, bool) or not isinstance(value, int) or value <= 0:
        raise TypeError(f"{name} is no OpenCL object: it has no int_ptr")
    return value


def event(address):
    """A cl_event as PyOpenCL's object, if PyOpenCL has been imported, else its address."""
    pyopencl = sys.modules.get("pyopencl")
    return address if pyopencl is None else pyopencl.Event.from_int_ptr(address, retain=False)
