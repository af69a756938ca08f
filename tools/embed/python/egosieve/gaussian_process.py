"""Gaussian process regression and classification in scikit-learn's manner."""

import json
import warnings

import numpy as np

from . import arguments, kernels
from ._gaussian_process import Model
from ._library import image as view
from .estimator import Regressor
from .exact_predictor import ExactPredictor
from .predictor import FrozenPosterior

_PARAMETERS_KEY = "egosieve.GaussianProcess"
# Deviations of y from zero at most: n (y / deviation)^2 is the condition number of K, eps^-1 = 5e15.
_FARTHEST = 1e4
# What means nothing to another process.
_OF_THE_PROCESS = ("opencl_context", "opencl_device")


def _numbers(*values):
    """Offset and scale of one target as numbers, of several as arrays."""
    return [value.tolist() if np.ndim(value) == 0 else value for value in values]


# What a kernel of scikit-learn's says as well, with their defaults.
_STARTS = {"scales": None, "signal_stddev": 1.0, "noise_stddev": 0.1}


class GaussianProcess(ExactPredictor, Regressor):
    """Gaussian process with a model that grows and shrinks, computed on an OpenCL device.

    With n points of one target or several, L L^T = K + diag(sigma_n^2 + alpha_i) and a = (L L^T)^-1 y,

        mean(x) = k* . a              variance(x) = k(x, x) - |L^-1 k*|^2

    The factor is float64. Queries are centred and scaled in float64; means and variances are computed in float32 on
    a device where its errors are below a hundredth of the posterior's deviation, else in float64: `precision` of predict.

    Parameters
    ----------
    kernel : str, or a kernel of scikit-learn's
        "arcsine", the neural network covariance sigma_f^2 asin(u.u' / sqrt((1 + u.u)(1 + u'.u'))) with
        u = sqrt(2) diag(w) (1, x); "squared_exponential", sigma_f^2 exp(-1/2 sum_d ((x_d - x'_d) / l_d)^2);
        "matern12", "matern32", "matern52", "rational_quadratic", "periodic", "linear", "constant", "white";
        sums, products and isotropic(...) of these, where all features share a scale:
        "matern52 + linear * isotropic(periodic)". Columns restrict a function to some features, counted from 0 as
        in slices: "matern52[0:3] * periodic[3]", "linear[0, 2]". Objects of sklearn.gaussian_process.kernels are translated:
        their values are the start, their bounds and fixed values hold unless `bounds` has others (without
        ConstantKernel the amplitude is fixed at 1), and a WhiteKernel is noise_stddev, of which predictions then
        speak as well. ValueError where `scales`, `signal_stddev` or `noise_stddev` are given and differ.
    scales : sequence of float, optional
        Weights w_0 (of the bias), ..., w_D, or length-scales l_1, ..., l_D, or those of the parts in their
        order, with an amplitude before those of each term of a sum but the first. Default: 2.01 for weights of
        the arcsine, 0.5 for length-scales, 1 for others.
    signal_stddev, noise_stddev : float
        sigma_f and sigma_n, positive; where `optimize` is true, the start. A covariance matrix that is singular to
        rounding gets a jitter added to sigma_n^2, which hyperparameters_ tells; fit warns where that more than doubles the
        deviation of the noise.
    alpha : float or array of shape (n_samples,)
        Noise variances of the points of fit on top of sigma_n^2, in units of the normalised y. Default: 0.
    mean : "zero", "constant" or "linear"
        The prior mean's function; its coefficients (coef_) are estimated by generalised least squares, and
        predictions carry their uncertainty.
    approximation : "exact", "dtc", "fitc" or "iterative"
        A sparse model approximates the points by inducing inputs among them, chosen by pivoted Cholesky: n m^2 flops
        in place of n^3 / 3. It has one target and the zero mean. "dtc" is trained by the variational bound. "iterative" is
        the exact mean for more points than 8 n^2 bytes allow, by conjugate gradients, preconditioned with m inducing inputs:
        n^2 / 2 covariances for each iteration, of which hyperparameters_ tells the number and the residual reached. It has the
        zero mean and nothing that needs variances, and is optimised by the exact likelihood of subset_size points.
    inducing_points : int
        m at most, of a sparse or an iterative model.
    tolerance : float
        Of an iterative model: |y - K_y a| <= tolerance |y|, which bounds the error of the mean by
        tolerance sigma_f |y| / sigma_n. RuntimeError where 1,000 iterations do not reach it.
    optimize : bool
        fit maximises the log marginal likelihood, or a sparse model's objective, over scales, sigma_f and sigma_n.
    normalize_y : bool
        fit subtracts the mean of each target and divides by its deviation; results are in the units of y. The mean is
        also subtracted, with a warning, where it exceeds 10,000 deviations and the prior mean is zero.
    subset_size : int
        Points that the optimisation uses at most, drawn at random; 0: all.
    n_restarts_optimizer : int
        Random starts of the optimisation after the first; the best result is kept.
    bounds : dict, optional
        Bounds of the optimisation: "scales", "signal_stddev" and "noise_stddev", each (lower, upper) or "fixed";
        "scales" may also be a list of these, one per scale. None in place of an end: the default, which follows
        the spread of the data. A key that is not there: the bounds of a kernel object's, else the default.
    random_state : int
        Seed of the subset and of the restarts.
    device : str, optional
        A device's index, part of its name, "cpu", "gpu" or "reference"; egosieve.devices() lists them.
    memory_cap_bytes : int
        Memory on the device for the tiles of predictions at most, without the model. 0: the device's own, 256 MiB or an
        eighth of a GPU's memory if that is more.
    opencl_context, opencl_device : objects of PyOpenCL's or addresses, optional
        A cl_context to compute on in place of `device`, and one of its devices, None for the first. Copies,
        pickled and loaded models lie on `device`.

    Attributes
    ----------
    n_features_in_ : int
    kernel_ : str, or a kernel of scikit-learn's with the values found
        The text in place of an object that cannot have these values, as where `bounds` frees what it fixes.
    hyperparameters_ : dict
        scales, signal_stddev, noise_stddev and more, as they are now.
    X_train_, y_train_, alpha_train_ : arrays
        The points in the model and their noise variances, copied out.
    coef_ : array of shape (n_coefficients,) or (n_coefficients, n_targets)
        Of the mean's function, the constant first; of normalised y.
    optimization_ : dict or None
        What the last fit's optimisation did: log_likelihood_at_start, log_likelihood, evaluations, points,
        gradient_norm (nats), on_bound (the hyperparameters that lie on a bound, and on which), and converged, true
        only where gradient_norm is small.

    Examples
    --------
    >>> import numpy as np, egosieve
    >>> X = np.linspace(-1, 1, 50)[:, None]
    >>> gp = egosieve.GaussianProcess(noise_stddev=0.05).fit(X, np.sin(4 * X[:, 0]))
    >>> mean, std = gp.predict([[0.3]], return_std=True)
    """

    def __init__(
        self, kernel="arcsine", *, scales=None, signal_stddev=1.0, noise_stddev=0.1, alpha=0.0, mean="zero",
        approximation="exact", inducing_points=512, tolerance=1e-8, optimize=True, normalize_y=False, subset_size=800,
        n_restarts_optimizer=0, bounds=None, random_state=1, device=None, memory_cap_bytes=0, opencl_context=None,
        opencl_device=None,
    ):  # fmt: skip
        self.__dict__.update({name: value for name, value in locals().items() if name != "self"})

    def fit(self, X, y):
        """Starts anew with the points (X, y) and, if asked for, optimises the hyperparameters.

        Parameters
        ----------
        X : array of shape (n_samples, n_features), at most 256 features
        y : array of shape (n_samples,) or (n_samples, n_targets)
            Any finite numbers; -1 and +1, or between, where predict_proba is wanted. Where every y is 0 or 1,
            predict_proba is refused: 2 * y - 1 are labels.
        """
        names, X = arguments.feature_names(X), arguments.matrix("X", X)
        y = arguments.targets("y", y, len(X))
        alpha = arguments.variances("alpha", self.alpha, len(X))
        offset, scale = self._normalization(y)
        model = self._new_model(X.shape[1])
        model.call("condition_noisy", X, self._normalized(y, offset, scale), alpha)
        search = self._search(X.shape[1]) if self.optimize and len(X) > 1 else None
        self._adopt(model, X.shape[1], offset, scale, names, search and model.optimize("optimize", search=search))
        if model.in_float64:
            model.posterior()  # fit tells whether the iterations converge
        found = model.describe()
        noise = found["noise_stddev"] ** 2 + (0.0 if alpha is None else alpha.min())
        if found["jitter"] > 3.0 * noise:
            warnings.warn(
                f"the covariance matrix is singular to rounding: jitter {found['jitter']:.2g} was added to the noise "
                f"variance {noise:.2g}; a larger noise_stddev or alpha avoids this",
                stacklevel=2,
            )
        return self

    def _fit_labels(self, X, y, weights):
        """As fit, for GaussianProcessClassifier: labels -1 and 1, and Laplace's approximation of f."""
        model = self._new_model(X.shape[1])
        search = self._search(X.shape[1]) if self.optimize and len(X) > 1 else None
        return self._adopt(model, X.shape[1], 0.0, 1.0, None, model.optimize("classify", X, y, weights, search=search))

    def _search(self, n_features):
        of_kernel = {} if isinstance(self.kernel, str) else kernels.translate(self.kernel, n_features).bounds
        bounds = {**of_kernel, **(self.bounds or {})}
        return {"bounds": bounds, "subset_size": self.subset_size, "restarts": self.n_restarts_optimizer,
                "seed": arguments.seed(self.random_state)}  # fmt: skip

    def partial_fit(self, X, y, alpha=0.0):
        """Conditions the model on more points, at the hyperparameters that it has.

        `alpha` is the noise of these points, as that of the constructor is of fit's. A model that was not
        fitted starts from the given hyperparameters. Cost: k n^2 flops for k points.
        """
        names, X = arguments.feature_names(X), arguments.queries(self, X)
        y = arguments.targets("y", y, len(X))
        alpha = arguments.variances("alpha", alpha, len(X))
        if not self._is_fitted():
            model = self._new_model(X.shape[1])
            model.call("condition_noisy", X, y, alpha)
            return self._adopt(model, X.shape[1], *_numbers(np.zeros(y.shape[1:]), np.ones(y.shape[1:])), names)
        if np.shape(y)[1:] != np.shape(self._scale):
            raise ValueError(f"y has shape {y.shape}; the model has {np.size(self._scale)} target(s)")
        self._core.call("condition_noisy", X, self._normalized(y, self._offset, self._scale), alpha)
        return self

    def remove(self, rows):
        """Removes points by their index in X_train_; those behind them move up. Cost: 2 k n^2 flops.

        Negative indices count from the end, and an array of bool names the points where it is true, as
        NumPy's indices do.
        """
        core = self._fitted()
        rows = arguments.indices("rows", rows, core.describe()["size"])
        if len(rows):
            core.call("remove", rows)
        return self

    def freeze(self, devices=None):
        """The posterior as it is now, for threads that predict while this model learns.

        Where every y lies in [-1, 1], probabilities are calibrated first (n^3 / 3 flops after a change).
        Several `devices`, a list of names as `device` is one, share each prediction's queries in place of the
        model's own, in pieces of at least 1,024. A query's result is that of the device that computed it.
        """
        core, labels = self._fitted(), self._are_labels()
        if labels and core.describe()["size"] > 1:
            self._calibrate()
        return FrozenPosterior(core.posterior(devices), self, labels)

    def warm_up(self, n_features):
        """Compiles what predictions with this kernel need, so that the first is as fast as later ones.

        Returns
        -------
        self : what was fitted stays as it is
        """
        model = self._new_model(n_features)
        X = np.random.default_rng(0).uniform(-1.0, 1.0, (n_features + 2, n_features))
        model.call("condition_noisy", X, np.where(np.arange(len(X)) % 2 == 0, 1.0, -1.0), None)
        results = [np.empty(len(X)) for _ in range(3)]
        model.predict("predict", X, mean=results[0])
        model.predict("predict", X, mean=results[0], variance=results[1], probability=results[2])
        return self

    def describe_pixels(self, image, places, order="bgr"):
        """Features of places in an image: u, v, and brightness, red, green and blue around them.

        Parameters
        ----------
        image : array of uint8, (height, width) or (height, width, 3)
        places : array of shape (n, 2), (x, y) in pixels

        Returns
        -------
        X : float32 array of shape (n, 6), what predict_image asks at these places
        """
        places = arguments.matrix("places", places)
        out = np.empty((len(places), 6), dtype=np.float32)
        core = self._core if self._is_fitted() else self._new_model(6)
        core.call("describe_pixels", view("image", np.asarray(image), order), places, out)
        return out

    def save(self, path):
        """Writes the model and these parameters into a file, whole or not at all; numpy.load reads it.

        The factor is rebuilt, so that this model and the loaded one give identical predictions. C and C++ load it, too,
        unless y was normalised or its mean subtracted. The device and OpenCL's objects are not saved.
        """
        core = self._fitted()
        core.save(path, self._annotation(), normalized=bool(np.any(self._offset) or np.any(np.not_equal(self._scale, 1.0))))

    @classmethod
    def load(cls, path, device=None):
        """Reads what save wrote, or any model file of egosieve's."""
        return cls._from_model(Model.load(path, device), device)

    @property
    def hyperparameters_(self):
        """The hyperparameters and what else the model is, as it is now."""
        return self._fitted().describe()

    @property
    def kernel_(self):
        """`kernel` with the hyperparameters of the model: an object of scikit-learn's, or the text."""
        found = self._fitted().describe()
        return found["kernel"] if isinstance(self.kernel, str) else kernels.with_values(self.kernel, found)

    @property
    def X_train_(self):
        """A copy of the inputs of the points in the model, float64."""
        core = self._fitted()
        X = np.empty((core.describe()["size"], self.n_features_in_))
        core.call("points", X, None)
        return X

    @property
    def y_train_(self):
        """A copy of the targets of the points in the model, float64, in the units of y."""
        core = self._fitted()
        y = np.empty(self._shape(core.describe()["size"]))
        core.call("points", None, y)
        return y * self._scale + self._offset

    @property
    def alpha_train_(self):
        """A copy of the noise variances of the points in the model, float64."""
        core = self._fitted()
        variances = np.empty(core.describe()["size"])
        core.call("noise_variances", variances)
        return variances

    @property
    def coef_(self):
        """The coefficients of the mean's function, the constant first; of normalised y."""
        core = self._fitted()
        coefficients = np.empty(self._shape(core.describe()["coefficients"]))
        core.call("mean_coefficients", coefficients)
        return coefficients

    def __getstate__(self):
        state = {name: value for name, value in self.__dict__.items() if name != "_core"}
        state.update(dict.fromkeys(_OF_THE_PROCESS))
        if self._is_fitted():
            state["_bytes"] = self._core.bytes("serialize")
        return state

    def __setstate__(self, state):
        state = dict(state)
        bytes_of_model = state.pop("_bytes", None)
        self.__dict__.update(state)
        if bytes_of_model is not None:
            try:
                self._core = Model.deserialize(bytes_of_model, self.device)
            except (FileNotFoundError, RuntimeError):
                if self.device is None:
                    raise
                self._core = Model.deserialize(bytes_of_model, None)  # this machine has no such device

    @classmethod
    def _from_model(cls, model, device):
        info = model.describe()
        names = ("kernel", "scales", "signal_stddev", "noise_stddev", "mean", "approximation")
        gp = cls(**{name: info[name] for name in names}, inducing_points=info["inducing_points"] or 512,
                 tolerance=info["tolerance"] or 1e-8, optimize=False, device=device)  # fmt: skip
        shape = (info["outputs"],) if info["outputs"] > 1 else ()
        observed, names, offset, scale = False, None, np.zeros(shape), np.ones(shape)
        try:
            kept = json.loads(model.bytes("annotation"), object_hook=kernels.from_json)[_PARAMETERS_KEY]
            offset, scale = (np.reshape(np.array(kept[name], dtype=float), shape) for name in ("offset", "scale"))
            parameters = dict(kept["parameters"])
            if parameters.get("kernel") is None:  # an object, and scikit-learn is not here: all of these are the model's
                parameters = {name: value for name, value in parameters.items() if name not in ("kernel", *_STARTS)}
            gp.set_params(**parameters)
            observed, names = kept["observed"], kept["features"]
        except (ValueError, KeyError, TypeError):
            pass  # a file of another program's
        gp._adopt(model, info["dimension"], *_numbers(offset, scale), None if names is None else np.asarray(names, dtype=object))
        gp._observed = observed
        return gp

    def _annotation(self):
        left_out = ("device", *_OF_THE_PROCESS)
        parameters = {name: value for name, value in self.get_params(deep=False).items() if name not in left_out}
        names = getattr(self, "feature_names_in_", None)
        kept = {"offset": self._offset, "scale": self._scale, "parameters": parameters, "observed": self._observed,
                "features": None if names is None else list(names)}  # fmt: skip
        return json.dumps(kernels.for_json({_PARAMETERS_KEY: kept}))

    def _new_model(self, n_features):
        kernel, scales = self.kernel, self.scales
        signal_stddev = arguments.number("signal_stddev", self.signal_stddev)
        noise_stddev = arguments.number("noise_stddev", self.noise_stddev)
        if not isinstance(kernel, str):
            found = kernels.translate(kernel, n_features)
            for name, default in _STARTS.items():
                given, value = getattr(self, name), getattr(found, name)
                if value is None or np.array_equal(given, default):
                    continue
                if np.size(given) != np.size(value) or not np.allclose(given, value, rtol=1e-9, atol=0.0):
                    raise ValueError(f"{name} = {given}, but the kernel {kernel!r} has {np.asarray(value)}; leave {name} out")
            kernel, scales, signal_stddev = found.text, found.scales, found.signal_stddev
            noise_stddev = found.noise_stddev or noise_stddev
        scales = None if scales is None else [float(scale) for scale in np.ravel(scales)]
        opencl = {name: None if getattr(self, name) is None else arguments.address(name, getattr(self, name))
                  for name in _OF_THE_PROCESS}  # fmt: skip
        return Model.create(kernel, scales, str(self.mean), self.device, self.approximation, dimension=n_features,
                            signal_stddev=signal_stddev, noise_stddev=noise_stddev, inducing_points=self.inducing_points,
                            tolerance=arguments.number("tolerance", self.tolerance),
                            memory_cap_bytes=self.memory_cap_bytes, **opencl)  # fmt: skip

    def _normalization(self, y):
        """Offset and scale of the targets: numbers, or arrays with those of each."""
        offset, scale = y.mean(axis=0, dtype=np.float64), y.std(axis=0, dtype=np.float64)
        if self.normalize_y:
            return _numbers(offset, np.where(scale > 0.0, scale, 1.0))
        varies = scale > 1e-13 * np.abs(offset)  # more than by rounding
        far = (self.mean == "zero") & varies & (np.abs(offset) > _FARTHEST * scale)
        if np.any(far):
            warnings.warn(
                "y is so far from zero that the zero prior mean cannot be computed in float64: its mean is subtracted first; "
                'mean="constant" or normalize_y=True avoid this',
                stacklevel=3,
            )
        return _numbers(np.where(far, offset, 0.0), np.ones(np.shape(scale)))

    def _adopt(self, model, n_features, offset, scale, names, optimization=None):
        self._core, self._offset, self._scale, self.optimization_ = model, offset, scale, optimization
        self._observed = not isinstance(self.kernel, str) and kernels.has_noise(self.kernel)
        self._take_features(n_features, names)
        return self

    @staticmethod
    def _normalized(y, offset, scale):
        return y if not np.any(offset) and np.all(scale == 1.0) else (y - offset) / scale

    def _is_fitted(self):
        return getattr(self, "_core", None) is not None

    def _fitted(self):
        if not self._is_fitted():
            raise arguments.not_fitted(self)
        return self._core

    def _are_labels(self):
        if not self._is_fitted():
            return True
        return not np.any(self._offset) and np.all(self._scale == 1.0) and self._core.describe()["has_labels"]

    def _calibrate(self):
        self._core.call("calibrate")
