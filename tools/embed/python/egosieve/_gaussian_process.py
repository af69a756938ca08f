"""Handles of egosieve's C interface; use egosieve.GaussianProcess.

Arguments are checked for what they mean by gaussian_process.py and the library itself.
"""

import ctypes
import warnings
from ctypes import POINTER, byref, c_char_p, c_double, c_int32, c_int64, c_uint64, c_void_p

from . import _library, optimization
from ._library import Array, DeviceArray, DeviceCall, Grid, GpInfo, GpOptions, Image, OptimizeOptions, OptimizeResult, Prediction
from ._library import encoded, fill, image, input_array, output_array

_NAMED_COVARIANCE = 2
_MEANS = ("zero", "constant", "linear")
_APPROXIMATIONS = ("exact", "dtc", "fitc")
_PRECISIONS = ("auto", "float64", "float32")
_ARRAY, _PREDICTION = POINTER(Array), POINTER(Prediction)
_BYTES = [c_void_p, c_void_p, c_int64, POINTER(c_int64)]

_egosieve = _library.Library("egosieve", {
    "egosieve_device_count": [POINTER(c_int32)],
    "egosieve_device_name": [c_int32, c_char_p, c_int64],
    "egosieve_gp_create": [POINTER(GpOptions), POINTER(c_void_p)],
    "egosieve_gp_free": [c_void_p],
    "egosieve_gp_condition_noisy": [c_void_p, _ARRAY, _ARRAY, _ARRAY],
    "egosieve_gp_remove": [c_void_p, POINTER(c_int64), c_int64],
    "egosieve_gp_describe": [c_void_p, POINTER(GpInfo)],
    "egosieve_gp_scales": [c_void_p, POINTER(c_double), c_int64],
    "egosieve_gp_covariance_text": _BYTES,
    "egosieve_gp_points": [c_void_p, _ARRAY, _ARRAY],
    "egosieve_gp_noise_variances": [c_void_p, _ARRAY],
    "egosieve_gp_log_marginal_likelihood": [c_void_p, POINTER(c_double)],
    "egosieve_gp_optimize": [c_void_p, POINTER(OptimizeOptions), POINTER(OptimizeResult)],
    "egosieve_gp_classify": [c_void_p, _ARRAY, _ARRAY, _ARRAY, POINTER(OptimizeOptions), POINTER(OptimizeResult)],
    "egosieve_gp_calibrate": [c_void_p],
    "egosieve_gp_predict": [c_void_p, _ARRAY, _PREDICTION],
    "egosieve_gp_predict_grid": [c_void_p, POINTER(Grid), _PREDICTION],
    "egosieve_gp_predict_image": [c_void_p, POINTER(Image), c_int32, _PREDICTION],
    "egosieve_gp_describe_pixels": [c_void_p, POINTER(Image), _ARRAY, _ARRAY],
    "egosieve_gp_posterior": [c_void_p, POINTER(c_void_p)],
    "egosieve_gp_posterior_on_devices": [c_void_p, POINTER(c_char_p), c_int64, POINTER(c_void_p)],
    "egosieve_posterior_predict": [c_void_p, _ARRAY, _PREDICTION],
    "egosieve_posterior_predict_grid": [c_void_p, POINTER(Grid), _PREDICTION],
    "egosieve_posterior_predict_image": [c_void_p, POINTER(Image), c_int32, _PREDICTION],
    "egosieve_posterior_free": [c_void_p],
    "egosieve_posterior_float32_error": [c_void_p, *3 * [POINTER(c_double)]],
    "egosieve_posterior_opencl": [c_void_p, POINTER(c_void_p), POINTER(c_void_p)],
    "egosieve_posterior_enqueue": [c_void_p, POINTER(DeviceCall), POINTER(c_void_p)],
    "egosieve_gp_set_annotation": [c_void_p, c_void_p, c_int64],
    "egosieve_gp_annotation": _BYTES,
    "egosieve_gp_save": [c_void_p, c_char_p],
    "egosieve_gp_load": [c_char_p, c_char_p, POINTER(c_void_p)],
    "egosieve_gp_serialize": _BYTES,
    "egosieve_gp_deserialize": [c_void_p, c_int64, c_char_p, POINTER(c_void_p)],
    "egosieve_gp_predict_joint": [c_void_p, _ARRAY, c_int32, _ARRAY, _ARRAY],
    "egosieve_gp_covariances": [c_void_p, *5 * [_ARRAY]],
    "egosieve_gp_sample": [c_void_p, _ARRAY, c_uint64, c_int32, _ARRAY, POINTER(c_double)],
    "egosieve_gp_gradients": [c_void_p, _ARRAY, _ARRAY, _ARRAY],
    "egosieve_gp_leave_one_out": [c_void_p, _ARRAY, _ARRAY, _ARRAY],
    "egosieve_gp_mean_coefficients": [c_void_p, _ARRAY],
    "egosieve_gp_likelihood_at": [c_void_p, POINTER(c_double), c_int64, POINTER(c_double), POINTER(c_double)],
})  # fmt: skip
_call = _egosieve.call


def version():
    """The library's."""
    return _library.version()


def devices():
    """A line on each device, by its index."""
    count = c_int32()
    _call("egosieve_device_count", byref(count))
    names = []
    for index in range(count.value):
        name = ctypes.create_string_buffer(256)
        _call("egosieve_device_name", index, name, len(name))
        names.append(name.value.decode(errors="replace"))
    return names


def _call_by_name(function, *args):
    """A call with devices' names: a name that no device has is ValueError."""
    status = _egosieve.status(function, *args)
    if status == _library.NOT_FOUND:
        raise ValueError(_library.last_error())
    _library.check(status)


def _doubles(values):
    return (c_double * len(values))(*values)


class _Predictor:
    """Predictions, which are the same for a model and its posterior but for the names of the calls."""

    _prefix = None  # of the calls' names
    _told = False  # that float32 does not suffice
    # Of the last prediction.
    clamped_variances = float64_count = 0

    def __init__(self, handle):
        self._handle = handle
        self._status = _egosieve.status  # for __del__, when this module may be gone

    def __del__(self):
        if getattr(self, "_handle", None):
            self._status(self._prefix + "_free", self._handle)

    def _predict(self, call, place, precision="auto", mean=None, variance=None, probability=None, of_observation=False):
        if precision not in _PRECISIONS:
            raise ValueError(f"precision = {precision!r}; it must be one of {', '.join(map(repr, _PRECISIONS))}")
        prediction = _egosieve.new(Prediction, "egosieve_prediction_init")
        prediction.mean = output_array("mean", mean)
        prediction.variance = output_array("variance", variance)
        prediction.probability = output_array("probability", probability)
        prediction.of_observation, prediction.precision = bool(of_observation), _PRECISIONS.index(precision)
        _call(self._prefix + call, self._handle, *place, byref(prediction))
        self.clamped_variances, self.float64_count = prediction.clamped_variances, prediction.float64_count
        if precision == "auto" and self.float64_count and probability is None and not self._told:
            self._told = True
            warnings.warn(
                "float32 does not suffice for this model: its errors exceed a hundredth of the posterior's deviation. "
                "Results that need it are computed in float64, which is slower; precision=\"float32\" leaves them",
                stacklevel=4,
            )

    def predict(self, x, **wishes):
        self._predict("_predict", [byref(input_array("x", x))], **wishes)

    def predict_grid(self, x0, y0, dx, dy, rows, columns, **wishes):
        self._predict("_predict_grid", [byref(fill(Grid(x0, y0, dx, dy), rows=rows, columns=columns))], **wishes)

    def predict_image(self, pixels, stride, order, **wishes):
        view, kept = image("image", pixels, order)
        self._predict("_predict_image", [byref(view), stride], **wishes)


class Posterior(_Predictor):
    _prefix = "egosieve_posterior"

    def float32_error(self):
        mean, variance, deviation = c_double(), c_double(), c_double()
        _call("egosieve_posterior_float32_error", self._handle, byref(mean), byref(variance), byref(deviation))
        return {"mean": mean.value, "variance": variance.value, "deviation": deviation.value}

    def opencl(self):
        context, device = c_void_p(), c_void_p()
        _call("egosieve_posterior_opencl", self._handle, byref(context), byref(device))
        return context.value, device.value

    def enqueue(self, queue, queries, count, first, stride, wait, **results):
        call = fill(_egosieve.new(DeviceCall, "egosieve_device_call_init"), queue=queue, queries=queries,
                    query_count=count, query_first=first, query_stride=stride, wait_count=len(wait))  # fmt: skip
        call.wait = (c_void_p * len(wait))(*wait)
        for name, (memory, offset) in results.items():
            setattr(call, name, fill(DeviceArray(memory), first=offset))
        event = c_void_p()
        _call("egosieve_posterior_enqueue", self._handle, byref(call), byref(event))
        return event.value


class Model(_Predictor):
    _prefix = "egosieve_gp"

    @classmethod
    def create(cls, kernel, dimension, scales, signal_stddev, noise_stddev, mean, device, approximation, inducing_points,
               memory_cap_bytes, opencl_context, opencl_device):  # fmt: skip
        for name, value, choices in (("mean", mean, _MEANS), ("approximation", approximation, _APPROXIMATIONS)):
            if value not in choices:
                raise ValueError(f"{name} = {value!r}; it must be one of {', '.join(map(repr, choices))}")
        options = _egosieve.new(GpOptions, "egosieve_gp_options_init")
        fill(options, covariance=_NAMED_COVARIANCE, covariance_text=encoded(kernel), mean=_MEANS.index(mean),
             dimension=dimension, signal_stddev=signal_stddev, noise_stddev=noise_stddev, device=encoded(device),
             approximation=_APPROXIMATIONS.index(approximation), inducing_points=inducing_points,
             memory_cap_bytes=memory_cap_bytes, opencl_context=opencl_context, opencl_device=opencl_device)  # fmt: skip
        if scales is not None:
            options.scales, options.scale_count = _doubles(scales), len(scales)
        handle = c_void_p()
        _call_by_name("egosieve_gp_create", byref(options), byref(handle))
        return cls(handle)

    @classmethod
    def load(cls, path, device):
        handle = c_void_p()
        _call("egosieve_gp_load", encoded(path), encoded(device), byref(handle))
        return cls(handle)

    @classmethod
    def deserialize(cls, content, device):
        handle = c_void_p()
        _call("egosieve_gp_deserialize", content, len(content), encoded(device), byref(handle))
        return cls(handle)

    def condition(self, x, y, noise_variances):
        inputs, targets = input_array("x", x), input_array("y", y)
        noise = None if noise_variances is None else byref(input_array("alpha", noise_variances))
        _call("egosieve_gp_condition_noisy", self._handle, byref(inputs), byref(targets), noise)

    def remove(self, rows):
        _call("egosieve_gp_remove", self._handle, (c_int64 * len(rows))(*rows), len(rows))

    def optimize(self, **search):
        return self._optimize("egosieve_gp_optimize", [], search)

    def classify(self, x, labels, weights, search):
        """`search`: None to keep the hyperparameters."""
        inputs, targets = input_array("x", x), input_array("y", labels)
        weights = None if weights is None else byref(input_array("sample_weight", weights))
        return self._optimize("egosieve_gp_classify", [byref(inputs), byref(targets), weights], search)

    def _optimize(self, function, points, search):
        """`search`: subset_size, restarts, seed, and bounds as GaussianProcess takes them."""
        now = self.describe()
        search = dict(search or {"bounds": None})
        lower, upper = optimization.bounds(search.pop("bounds"), now["scales"], now["signal_stddev"], now["noise_stddev"])
        on_bound = (c_int32 * len(lower))()
        result = _egosieve.new(OptimizeResult, "egosieve_optimize_result_init")
        result.on_bound, result.on_bound_count = on_bound, len(lower)
        with optimization.Interruptible() as interruption:
            options = fill(
                _egosieve.new(OptimizeOptions, "egosieve_optimize_options_init"), lower_bounds=_doubles(lower),
                upper_bounds=_doubles(upper), bound_count=len(lower),
                should_stop=_library.SHOULD_STOP(interruption.stops), **search,
            )  # fmt: skip
            status = _egosieve.status(function, self._handle, *points, byref(options) if search else None, byref(result))
            if not interruption.stops():
                _library.check(status)
        account = {name: getattr(result, name) for name, _ in OptimizeResult._fields_[1:-2]}
        ends = {-1: "lower", 1: "upper"}
        reached = {name: ends[end] for name, end in zip(optimization.names(len(lower) - 2), on_bound) if end}
        return {**account, "converged": bool(result.converged), "on_bound": reached}

    def calibrate(self):
        _call("egosieve_gp_calibrate", self._handle)

    def log_marginal_likelihood(self):
        value = c_double()
        _call("egosieve_gp_log_marginal_likelihood", self._handle, byref(value))
        return value.value

    def describe(self):
        info = _egosieve.new(GpInfo, "egosieve_gp_info_init")
        _call("egosieve_gp_describe", self._handle, byref(info))
        scales = (c_double * info.scale_count)()
        _call("egosieve_gp_scales", self._handle, scales, info.scale_count)
        names = ("size", "dimension", "outputs", "coefficients", "signal_stddev", "noise_stddev", "jitter",
                 "inducing_points", "inducing_count")  # fmt: skip
        return {
            **{name: getattr(info, name) for name in names},
            "kernel": self._bytes("egosieve_gp_covariance_text").decode(),
            "scales": list(scales),
            "mean": _MEANS[info.mean],
            "approximation": _APPROXIMATIONS[info.approximation],
            "squash": (info.squash_a, info.squash_b),
            "has_labels": bool(info.has_labels),
        }

    def points(self, x, y):
        inputs, targets = output_array("x", x), output_array("y", y)
        _call("egosieve_gp_points", self._handle, byref(inputs), byref(targets))

    def noise_variances(self, v):
        _call("egosieve_gp_noise_variances", self._handle, byref(output_array("v", v)))

    def predict_joint(self, x, mean, covariance, of_observation):
        points, means, joint = input_array("x", x), output_array("mean", mean), output_array("covariance", covariance)
        _call("egosieve_gp_predict_joint", self._handle, byref(points), of_observation, byref(means), byref(joint))

    def covariances(self, x, z, k, by_logarithms, by_x):
        points, others = input_array("x", x), None if z is None else byref(input_array("z", z))
        results = output_array("k", k), output_array("by_logarithms", by_logarithms), output_array("by_x", by_x)
        _call("egosieve_gp_covariances", self._handle, byref(points), others, *map(byref, results))

    def sample(self, x, seed, samples, of_observation):
        points, out, jitter = input_array("x", x), output_array("samples", samples), c_double()
        _call("egosieve_gp_sample", self._handle, byref(points), seed, of_observation, byref(out), byref(jitter))
        return jitter.value

    def gradients(self, x, mean, variance):
        points, of_mean, of_variance = input_array("x", x), output_array("mean", mean), output_array("variance", variance)
        _call("egosieve_gp_gradients", self._handle, byref(points), byref(of_mean), byref(of_variance))

    def leave_one_out(self, mean, variance, log_density):
        results = [output_array("mean", mean), output_array("variance", variance), output_array("log_density", log_density)]
        _call("egosieve_gp_leave_one_out", self._handle, *map(byref, results))

    def mean_coefficients(self, coefficients):
        _call("egosieve_gp_mean_coefficients", self._handle, byref(output_array("coefficients", coefficients)))

    def likelihood_at(self, theta, with_gradient):
        value, gradient = c_double(), _doubles([0.0] * len(theta)) if with_gradient else None
        _call("egosieve_gp_likelihood_at", self._handle, _doubles(theta), len(theta), byref(value), gradient)
        return value.value, list(gradient or [])

    def describe_pixels(self, pixels, order, places, out):
        view, kept = image("image", pixels, order)
        points, output = input_array("places", places), output_array("out", out)
        _call("egosieve_gp_describe_pixels", self._handle, byref(view), byref(points), byref(output))

    def posterior(self, devices=None):
        handle = c_void_p()
        if devices is None:
            _call("egosieve_gp_posterior", self._handle, byref(handle))
            return Posterior(handle)
        if not isinstance(devices, (list, tuple)):
            raise TypeError(f"devices is a {type(devices).__name__}; it must be a list of names")
        names = (c_char_p * len(devices))(*map(encoded, devices))
        _call_by_name("egosieve_gp_posterior_on_devices", self._handle, names, len(devices), byref(handle))
        return Posterior(handle)

    def set_annotation(self, text):
        content = text.encode()
        _call("egosieve_gp_set_annotation", self._handle, content, len(content))

    def annotation(self):
        return self._bytes("egosieve_gp_annotation")

    def save(self, path):
        _call("egosieve_gp_save", self._handle, encoded(path))

    def serialize(self):
        return self._bytes("egosieve_gp_serialize")

    def _bytes(self, function):
        """What `function` gives, again where another thread has made it more since the size was asked."""
        size = c_int64()
        while True:
            _call(function, self._handle, None, 0, byref(size))
            content = ctypes.create_string_buffer(size.value)
            capacity = size.value
            status = _egosieve.status(function, self._handle, content, capacity, byref(size))
            if status == 0:
                return content.raw[: size.value]
            _call(function, self._handle, None, 0, byref(size))
            if size.value <= capacity:
                _library.check(status)
