"""Predictions of a model or of a posterior that was made from one."""

import functools

import numpy as np

from . import arguments
from ._library import Grid, fill
from ._library import image as view


class _OnlyWithLabels:
    """A method that is there unless the model holds a y outside [-1, 1], as scikit-learn's available_if."""

    def __init__(self, method):
        self._method = method
        self.__doc__ = method.__doc__

    def __get__(self, owner, kind=None):
        if owner is None:
            return self._method
        if not owner._are_labels():
            raise AttributeError(
                f"{self._method.__name__} needs every y in [-1, 1], -1 and 1 for the classes: "
                "labels 0 and 1 become these by 2 * y - 1"
            )
        return functools.partial(self._method, owner)


class Predictor:
    """Predictions of a model or of a frozen posterior; `_core` computes, `_offset` and `_scale` (numbers, or
    an array of each output's) undo the normalisation of y; `_observed`: predictions include the noise by default."""

    _observed = False

    def predict(self, X, return_std=False, return_cov=False, return_var=False, of_observation=None,
                precision="auto", float64=False):  # fmt: skip
        """Mean of f at the rows of X, and on request its deviation, variance or joint covariance.

        Parameters
        ----------
        X : array of shape (n_queries, n_features)
            float32 rows that lie packed are read in place; others are copied in pieces.
        return_std, return_var : bool
            Also return the standard deviation, or the variance, of f.
        return_cov : bool
            Also return the covariance of all queries, computed in float64; not together with the others.
        of_observation : bool, optional
            Those of an observation y instead of f: the noise is added. Default: true where `kernel` is an object of
            scikit-learn's with a WhiteKernel, as there, else false.
        precision : "auto", "float64" or "float32"
            Arithmetic of means, deviations and variances. "auto": float32 on the device where its errors are below a
            hundredth of the posterior's deviation, else float64, n^2 flops per query with variances; the first
            prediction that needs it says so in a warning. "float32": whatever its errors.
        float64 : bool
            The same as precision="float64".

        Returns
        -------
        mean : array of shape (n_queries,) or (n_queries, n_targets), float32 where X is, else float64
        std or variance : array of the mean's shape, only if asked for
        covariance : array of shape (n_queries, n_queries) or (n_queries, n_queries, n_targets), only if asked for
        """
        self._fitted()
        X = arguments.queries(self, X)
        if return_cov:
            if return_std or return_var:
                raise RuntimeError("At most one of return_std or return_cov can be requested.")
            return self._predict_joint(X, self._with_noise(of_observation))
        mean, variance = np.empty(self._shape(len(X)), X.dtype), np.empty(len(X), X.dtype)
        return self._filled("predict", [X], mean, variance, return_std, return_var, of_observation,
                            "float64" if float64 else precision)  # fmt: skip

    def predict_grid(
        self, x0, y0, dx, dy, rows, columns, return_std=False, return_var=False, of_observation=None, out=None,
        precision="auto",
    ):  # fmt: skip
        """Mean of f on a regular grid in the plane, for models of two features.

        Element (r, c) of the results is at (x0 + c dx, y0 + r dy). The points need no memory, so that a grid of
        a million is as easy as one.

        Parameters
        ----------
        x0, y0, dx, dy : float
            First point and steps.
        rows, columns : int
            Shape of the results.
        return_std, return_var, of_observation, precision
            As in predict.
        out : array of shape (rows, columns), float32 or float64, optional
            Where the mean goes, in any strides.

        Returns
        -------
        mean : array of shape (rows, columns), float32 unless `out` is given
        std or variance : array of shape (rows, columns), only if asked for
        """
        mean = np.empty((rows, columns), dtype=np.float32) if out is None else out
        grid = fill(Grid(float(x0), float(y0), float(dx), float(dy)), rows=rows, columns=columns)
        return self._filled("predict_grid", [grid], mean, np.empty((rows, columns), dtype=mean.dtype), return_std, return_var,
                            of_observation, precision)  # fmt: skip

    def predict_axes(self, x, y, return_std=False, return_var=False, of_observation=None, precision="auto"):
        """Mean of f where two axes cross, for models of two features: element (r, c) is at (x[c], y[r]).

        Parameters
        ----------
        x, y : arrays of shape (columns,) and (rows,)
            In steps of any size; even ones need no memory for the points.
        return_std, return_var, of_observation, precision
            As in predict.

        Returns
        -------
        mean : float32 array of shape (rows, columns)
        std or variance : array of that shape, only if asked for
        """
        x, y = (arguments.axis(name, values) for name, values in (("x", x), ("y", y)))
        wishes = {"return_std": return_std, "return_var": return_var, "of_observation": of_observation, "precision": precision}
        steps = [arguments.even_step(values) for values in (x, y)]
        if None not in steps:
            return self.predict_grid(x[0], y[0], *steps, len(y), len(x), **wishes)
        self._fitted()
        if np.ndim(self._scale):  # as predict_grid says it
            raise RuntimeError(f"a grid needs a model of one output; this one has {len(self._scale)}")
        found = self.predict(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2), **wishes)

        def shaped(values):
            return values.reshape(len(y), len(x)).astype(np.float32)

        return tuple(shaped(values) for values in found) if isinstance(found, tuple) else shaped(found)

    def predict_image(self, image, stride=1, order="bgr", return_std=False, precision="auto"):
        """Mean of f over an image, for models of six features (see GaussianProcess.describe_pixels).

        Parameters
        ----------
        image : array of uint8, (height, width) or (height, width, 3)
        stride : int
            Pixels between the places that are asked for; the image's border is always among them.
        order : "bgr" or "rgb"
        return_std : bool
            Also return the standard deviation of f.
        precision : "auto", "float64" or "float32"
            As in predict.

        Returns
        -------
        mean : float32 array of shape (ceil((height - 1) / stride) + 1, ceil((width - 1) / stride) + 1)
        std : array of that shape, only if asked for
        """
        image = np.asarray(image)
        if image.ndim < 2 or stride < 1:
            raise ValueError("image must be height x width (x 3), and stride at least 1")
        shape = tuple(-(-(side - 1) // stride) + 1 for side in image.shape[:2])
        mean, variance = np.empty(shape, np.float32), np.empty(shape, np.float32)
        return self._filled("predict_image", [view("image", image, order), stride], mean, variance, return_std, False, False, precision)

    @property
    def clamped_variances_(self):
        """How many variances of the last prediction were negative from rounding and are 0."""
        return self._fitted().clamped_variances

    @property
    def float64_count_(self):
        """How many places of the last prediction have a result that was computed in float64."""
        return self._fitted().float64_count

    @_OnlyWithLabels
    def predict_proba(self, X):
        """Probabilities of the classes y = -1 and y = +1 at the rows of X.

        Probabilistic least squares: Phi((a mean + b) / sqrt(1 + a^2 variance)), where a and b are fitted by
        leave-one-out likelihood the first time after a change of the model. Only there where every y lies in
        [-1, 1], not all of them are 0 or 1, and normalize_y is false.

        Returns
        -------
        probabilities : array of shape (n_queries, 2), columns for -1 and +1
        """
        core, X = self._fitted(), arguments.queries(self, X)
        self._calibrate()
        probabilities = np.empty((len(X), 2), dtype=X.dtype)
        core.predict("predict", X, probability=probabilities[:, 1])
        np.subtract(1, probabilities[:, 1], out=probabilities[:, 0])
        return probabilities

    def _with_noise(self, of_observation):
        return self._observed if of_observation is None else of_observation

    def _shape(self, count):
        """Of the means at `count` places."""
        return count if np.ndim(self._scale) == 0 else (count, len(self._scale))

    def _filled(self, call, place, mean, variance, return_std, return_var, of_observation, precision):
        """The results of a prediction, in these arrays."""
        variance = variance if return_std or return_var else None
        self._fitted().predict(call, *place, mean=mean, variance=variance, of_observation=self._with_noise(of_observation),
                               precision=precision)  # fmt: skip
        return self._denormalized(mean, variance, return_std, return_var)

    def _denormalized(self, mean, variance, return_std, return_var):
        if np.any(self._scale != 1.0) or np.any(self._offset != 0.0):
            mean *= self._scale
            mean += self._offset
        if variance is None:
            return mean
        if np.ndim(self._scale):
            variance = (variance[:, None] * self._scale**2).astype(variance.dtype)
        elif self._scale != 1.0:
            variance *= self._scale**2
        if return_std and return_var:
            return mean, np.sqrt(variance), variance
        return mean, (np.sqrt(variance, out=variance) if return_std else variance)


class FrozenPosterior(Predictor):
    """What a model believed at one moment: made by GaussianProcess.freeze, never changes.

    Any number of threads may predict while the model that made it goes on learning.
    """

    def __init__(self, core, model, labels):
        self._core, self._labels = core, labels
        of_model = ("_offset", "_scale", "_observed", "n_features_in_", "feature_names_in_")
        self.__dict__.update({name: value for name, value in vars(model).items() if name in of_model})

    def opencl(self):
        """Addresses of the cl_context and the cl_device_id that the posterior lies on.

        With PyOpenCL: ``pyopencl.Context.from_int_ptr(address)`` and ``pyopencl.Device.from_int_ptr(address)``.
        """
        return tuple(self._core.call("opencl"))

    def float32_error(self):
        """The errors of results in float32, which those of `enqueue` always are.

        Four times their root mean square at 16 places, which the first call that needs them compares with float64.

        Returns
        -------
        errors : dict of float
            "mean", "variance" (infinite where rounding makes one negative) and "deviation", the least of f at these
            places. In units of y and its square, of normalised y where there is normalize_y.
        """
        return dict(zip(("mean", "variance", "deviation"), self._core.call("float32_error")))

    def enqueue(self, queue, queries, count, mean=None, variance=None, probability=None, clamped=None,
                first=0, stride=0, wait_for=()):
        """Predicts from and to OpenCL buffers on a command queue, without waiting.

        OpenCL objects are PyOpenCL's, or anything else with their `int_ptr`, or addresses; they belong to the context
        of `opencl()`. Results are in float32, whatever their errors (`float32_error`). For one output with the zero mean
        and without normalize_y.

        Parameters
        ----------
        queue : a cl_command_queue
        queries : a cl_mem of float32
            `count` queries; the first begins at element `first`, the next `stride` elements on (0: n_features).
        mean, variance, probability : a cl_mem of float32, or (cl_mem, first element), optional
        clamped : the same of int32
            One value: how many variances were negative from rounding and set to 0.
        wait_for : cl_events that come first

        Returns
        -------
        event : pyopencl.Event where PyOpenCL has been imported, else the address of a cl_event, which the
            caller releases
        """
        if np.any(self._scale != 1.0) or np.any(self._offset != 0.0):
            raise RuntimeError("models with normalize_y=True are not evaluated on a queue")
        results = {"mean": mean, "variance": variance, "probability": probability, "clamped": clamped}
        pairs = {name: value if isinstance(value, tuple) else (value, 0) for name, value in results.items() if value is not None}
        pairs = {name: (arguments.address(name, memory), element) for name, (memory, element) in pairs.items()}
        wait = [arguments.address("wait_for", event) for event in wait_for]
        queue, queries = arguments.address("queue", queue), arguments.address("queries", queries)
        return arguments.event(self._core.enqueue(queue, queries, count, first, stride, wait, **pairs))

    def _fitted(self):
        return self._core

    def _is_fitted(self):
        return True

    def _predict_joint(self, X, of_observation):
        raise RuntimeError("return_cov needs the model; this is a posterior that was frozen from one")

    def _are_labels(self):
        return self._labels

    def _calibrate(self):
        pass  # as the model was when this was made
