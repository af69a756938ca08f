"""Handles of egosieve's C interface; use egosieve.GaussianProcess.

Arguments are checked for what they mean by gaussian_process.py and the library itself.
"""

import ctypes
import warnings
from ctypes import c_double, c_int32, c_int64, c_void_p

from . import optimization
from ._library import SHOULD_STOP, DeviceArray, DeviceCall, DeviceMatrix, GpInfo, GpOptions, Handle, Library
from ._library import OptimizeOptions, OptimizeResult, Prediction, choice, encoded, fill, written

_NAMED_COVARIANCE = 2
_MEANS = ("zero", "constant", "linear")
_APPROXIMATIONS = ("exact", "dtc", "fitc", "iterative")
_PRECISIONS = ("auto", "float64", "float32")

_egosieve = Library("egosieve", """
device_count(int32& count)
device_name(int32 index, char* text, int64 capacity)
gp_create(GpOptions* options, void*& gp)
gp_load_normalized(char* path, char* device, void*& gp)
gp_deserialize(void* bytes, int64 size, char* device, void*& gp)
gp_free gp_calibrate posterior_free(void* handle)
gp_condition_noisy(void* gp, in x, in y, in alpha)
gp_remove(void* gp, int64[] rows)
gp_describe(void* gp, GpInfo* info)
gp_scales(void* gp, double* scales, int64 count)
gp_covariance_text gp_annotation gp_serialize(void* gp, void* bytes, int64 capacity, int64* size)
gp_points(void* gp, out x, out y)
gp_noise_variances(void* gp, out v)
gp_log_marginal_likelihood(void* gp, double& value)
gp_optimize(void* gp, OptimizeOptions* options, OptimizeResult* result)
gp_classify(void* gp, in x, in y, in sample_weight, OptimizeOptions* options, OptimizeResult* result)
gp_predict posterior_predict(void* handle, in x, Prediction* prediction)
gp_predict_grid posterior_predict_grid(void* handle, Grid* grid, Prediction* prediction)
gp_predict_image posterior_predict_image(void* handle, Image* image, int32 stride, Prediction* prediction)
gp_describe_pixels(void* gp, Image* image, in places, out out)
gp_posterior(void* gp, void*& posterior)
gp_posterior_on_devices(void* gp, char*[] devices, void*& posterior)
posterior_float32_error(void* posterior, double& mean, double& variance, double& deviation)
posterior_opencl(void* posterior, void*& context, void*& device)
posterior_enqueue(void* posterior, DeviceCall* call, void*& event)
gp_set_annotation(void* gp, void* bytes, int64 size)
gp_save gp_save_normalized(void* gp, char* path)
gp_predict_joint(void* gp, in x, int32 of_observation, out mean, out covariance)
gp_covariances(void* gp, in x, in z, out k, out by_logarithms, out by_x)
gp_enqueue_covariances(void* gp, DeviceMatrix* x, DeviceMatrix* z, DeviceMatrix* k, void* queue, void*[] wait, void*& event)
gp_sample(void* gp, in x, uint64 seed, int32 of_observation, out samples, double* jitter)
gp_sample_paths(void* gp, in x, uint64 seed, int64 frequencies, int32 of_observation, out samples)
gp_gradients(void* gp, in x, out mean, out variance)
gp_leave_one_out(void* gp, out mean, out variance, out log_density)
gp_mean_coefficients(void* gp, out coefficients)
gp_likelihood_at(void* gp, double[] theta, double& value, double* gradient)
""")  # fmt: skip


def devices():
    """A line on each device, by its index."""
    name, names = ctypes.create_string_buffer(256), []
    for index in range(_egosieve.call("device_count")):
        _egosieve.call("device_name", index, name, len(name))
        names.append(name.value.decode(errors="replace"))
    return names


def _doubles(values):
    return (c_double * len(values))(*values)


class _Predictor(Handle):
    """Predictions, which are the same for a model and its posterior but for the names of the calls."""

    _library = _egosieve
    _told = False  # that float32 does not suffice
    in_float64 = False  # which is the rule for an iterative model
    # Of the last prediction.
    clamped_variances = float64_count = 0

    def predict(self, call, *place, precision="auto", mean=None, variance=None, probability=None, of_observation=False):
        prediction = _egosieve.new(
            Prediction, mean=written("mean", mean), variance=written("variance", variance),
            probability=written("probability", probability), of_observation=bool(of_observation),
            precision=choice("precision", precision, _PRECISIONS),
        )  # fmt: skip
        self.call(call, *place, prediction)
        self.clamped_variances, self.float64_count = prediction.clamped_variances, prediction.float64_count
        if precision == "auto" and self.float64_count and probability is None and not (self._told or self.in_float64):
            self._told = True
            warnings.warn(
                "float32 does not suffice for this model: its errors exceed a hundredth of the posterior's deviation. "
                "Results that need it are computed in float64, which is slower; precision=\"float32\" leaves them",
                stacklevel=4,
            )


class Posterior(_Predictor):
    _prefix = "posterior_"

    def enqueue(self, queue, queries, count, first, stride, wait, **results):
        results = {name: fill(DeviceArray(memory), first=offset) for name, (memory, offset) in results.items()}
        call = _egosieve.new(DeviceCall, queue=queue, queries=queries, query_count=count, query_first=first, query_stride=stride,
                             wait=(c_void_p * len(wait))(*wait), wait_count=len(wait), **results)  # fmt: skip
        return self.call("enqueue", call)


class Model(_Predictor):
    _prefix = "gp_"

    def __init__(self, handle):
        super().__init__(handle)
        self.in_float64 = self.describe()["approximation"] == "iterative"

    @classmethod
    def create(cls, kernel, scales, mean, device, approximation, **options):
        """The other options have the names of egosieve_gp_options."""
        if scales is not None:
            options.update(scales=_doubles(scales), scale_count=len(scales))
        return cls(_egosieve.call("gp_create", _egosieve.new(
            GpOptions, covariance=_NAMED_COVARIANCE, covariance_text=encoded(kernel), mean=choice("mean", mean, _MEANS),
            approximation=choice("approximation", approximation, _APPROXIMATIONS), device=encoded(device), **options,
        ), not_found=ValueError))  # fmt: skip

    @classmethod
    def load(cls, path, device):
        return cls(_egosieve.call("gp_load_normalized", encoded(path), encoded(device)))

    @classmethod
    def deserialize(cls, content, device):
        return cls(_egosieve.call("gp_deserialize", content, len(content), encoded(device)))

    def optimize(self, call, *points, search):
        """`search`: subset_size, restarts, seed, and bounds as GaussianProcess takes them; None to keep all."""
        now = self.describe()
        kept, search = search is None, dict(search or {"bounds": None})
        lower, upper = optimization.bounds(search.pop("bounds"), now["scales"], now["signal_stddev"], now["noise_stddev"])
        on_bound = (c_int32 * len(lower))()
        result = _egosieve.new(OptimizeResult, on_bound=on_bound, on_bound_count=len(lower))
        with optimization.Interruptible() as interruption:
            options = _egosieve.new(OptimizeOptions, lower_bounds=_doubles(lower), upper_bounds=_doubles(upper),
                                    bound_count=len(lower), should_stop=SHOULD_STOP(interruption.stops), **search)  # fmt: skip
            self.call(call, *points, None if kept else options, result)
        account = {name: getattr(result, name) for name, _ in OptimizeResult._fields_[1:-2]}
        ends = {-1: "lower", 1: "upper"}
        reached = {name: ends[end] for name, end in zip(optimization.names(len(lower) - 2), on_bound) if end}
        return {**account, "converged": bool(result.converged), "on_bound": reached}

    def describe(self):
        info = _egosieve.new(GpInfo)
        self.call("describe", info)
        scales = (c_double * info.scale_count)()
        self.call("scales", scales, info.scale_count)
        names = ("size", "dimension", "outputs", "coefficients", "signal_stddev", "noise_stddev", "jitter",
                 "inducing_points", "inducing_count", "tolerance", "iterations", "residual")  # fmt: skip
        return {
            **{name: getattr(info, name) for name in names},
            "kernel": self.bytes("covariance_text").decode(),
            "scales": list(scales),
            "mean": _MEANS[info.mean],
            "approximation": _APPROXIMATIONS[info.approximation],
            "squash": (info.squash_a, info.squash_b),
            "has_labels": bool(info.has_labels),
        }

    def likelihood_at(self, theta, with_gradient):
        gradient = _doubles([0.0] * len(theta)) if with_gradient else None
        return self.call("likelihood_at", theta, gradient), list(gradient or [])

    def posterior(self, devices=None):
        if not isinstance(devices, (list, tuple, type(None))):
            raise TypeError(f"devices is a {type(devices).__name__}; it must be a list of names")
        made = Posterior(self.call("posterior") if devices is None else
                         self.call("posterior_on_devices", map(encoded, devices), not_found=ValueError))  # fmt: skip
        made.in_float64 = self.in_float64
        return made

    def enqueue_covariances(self, x, z, k, queue, wait):
        matrices = [fill(DeviceMatrix(), memory=memory, first=first, rows=rows) for memory, first, rows in (x, z, k)]
        return self.call("enqueue_covariances", *matrices, queue, wait)

    def save(self, path, annotation, normalized):
        content = annotation.encode()
        self.call("set_annotation", content, len(content))
        self.call("save_normalized" if normalized else "save", encoded(path))

    def bytes(self, call):
        """What `call` gives, again where another thread has made it more since the size was asked."""
        size = c_int64()
        self.call(call, None, 0, size)
        while True:
            content = ctypes.create_string_buffer(size.value)
            try:
                self.call(call, content, len(content), size)
                return content.raw[: size.value]
            except ValueError:
                self.call(call, None, 0, size)
                if size.value <= len(content):
                    raise
