"""The C interface by ctypes: structs, arrays as arguments without a copy, statuses as exceptions.

ctypes gives the interpreter's lock back during calls. Every struct is compared with the library's own size.
"""

import ctypes
from pathlib import Path

import numpy as np

_TYPES = {
    "int32": ctypes.c_int32, "int64": ctypes.c_int64, "uint64": ctypes.c_uint64, "double": ctypes.c_double,
    "char": ctypes.c_char, "char*": ctypes.c_char_p, "void*": ctypes.c_void_p,
    "should_stop": ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p),
}  # fmt: skip
SHOULD_STOP = _TYPES["should_stop"]


def _type(name):
    """A C type by its name: one of the above, a struct, a pointer "double*" or an array "char[256]"."""
    if name not in _TYPES:
        element, _, count = name.partition("[")
        _TYPES[name] = _type(element) * int(count[:-1]) if count else ctypes.POINTER(_type(name[:-1]))
    return _TYPES[name]


def _in_c(kind, _):
    """The C types of a parameter of Library's."""
    if kind.endswith("[]"):
        return [_type(kind[:-2] + "*"), ctypes.c_int64]
    return [_type("Array*" if kind in ("in", "out") else kind.replace("&", "*"))]


def _struct(name, fields, init=None):
    """A struct with fields as in C, "int32 width height, int64 row_stride"; `init` names the call of its defaults."""
    fields = [(field, _type(kind)) for kind, *names in map(str.split, fields.split(",")) for field in names]
    if init is not None:
        fields.insert(0, ("struct_size", ctypes.c_uint64))
    _TYPES[name] = type(name, (ctypes.Structure,), {"_fields_": fields, "init": init})
    return _TYPES[name]


# egosieve_array, and egosieve_const_array, which has the same fields.
Array = _struct("Array", "void* data, int64 rows columns row_stride column_stride, int32 type")
Image = _struct("Image", "void* data, int32 width height, int64 row_stride, int32 channels")
Grid = _struct("Grid", "double x0 y0 dx dy, int64 rows columns")
GpOptions = _struct("GpOptions", """
    int32 covariance dimension, double* scales, int64 scale_count, double signal_stddev noise_stddev, char* device,
    int64 memory_cap_bytes, char* covariance_text, int32 mean, int64 approximation inducing_points,
    void* opencl_context opencl_device, double tolerance""", "gp_options_init")  # fmt: skip
GpInfo = _struct("GpInfo", """
    int64 size, int32 dimension covariance, int64 scale_count, double[33] scales, double signal_stddev noise_stddev jitter
    squash_a squash_b, int64 has_labels outputs coefficients, int32 mean,
    int64 approximation inducing_points inducing_count, double tolerance, int64 iterations, double residual""", "gp_info_init")  # fmt: skip
OptimizeOptions = _struct("OptimizeOptions", """
    int64 subset_size, int32 restarts gradient_steps, double tolerance, uint64 seed, double* lower_bounds upper_bounds,
    int64 bound_count, should_stop should_stop, void* stop_argument""", "optimize_options_init")  # fmt: skip
OptimizeResult = _struct("OptimizeResult", """
    double log_likelihood_at_start log_likelihood, int64 evaluations points converged, double gradient_norm,
    int32* on_bound, int64 on_bound_count""", "optimize_result_init")  # fmt: skip
Prediction = _struct("Prediction", """
    Array mean variance probability, int32 of_observation, int64 clamped_variances precision float64_count""",
    "prediction_init")  # fmt: skip
DeviceArray = _struct("DeviceArray", "void* memory, int64 first")
DeviceMatrix = _struct("DeviceMatrix", "void* memory, int64 first rows stride")
DeviceCall = _struct("DeviceCall", """
    void* queue, void** wait, int64 wait_count, void* queries, int64 query_count query_first query_stride,
    DeviceArray mean variance probability clamped""", "device_call_init")  # fmt: skip
SegmenterOptions = _struct("SegmenterOptions", """
    int32 profile stride, int64 budget, uint64 seed, char* device, int64 lag, Image* ignore, double focal_ratio""",
    "segmenter_options_init")  # fmt: skip
Map = _struct("Map", "Array probability mean deviation objects", "map_init")
FrameReport = _struct("FrameReport", """
    int64 frame, int32 learnt, char[256] reason, int64 matches inliers static_labels dynamic_labels model_size,
    double dynamic_share milliseconds""", "frame_report_init")  # fmt: skip


def _load(name):
    # Beside this file in a wheel, in lib/ above lib/python3.*/site-packages/egosieve where installed.
    here = Path(__file__).resolve().parent
    paths = [folder / f"lib{name}.so.1" for folder in (here, here.parents[2])]
    for path in paths:
        if path.exists():
            return ctypes.CDLL(str(path))
    raise ImportError(f"lib{name}.so.1 is neither of {', '.join(map(str, paths))}")


class Library:
    """Calls of a shared library, declared as in C without "egosieve_" and the status that they return.

    "in x" and "out x" are matrices that are read and written: NumPy arrays, or None. "int64[] rows" is a list, with its
    length as the next argument in C. "double& value" is a pointer to a result, which `call` gives.
    """

    def __init__(self, name, calls):
        self._library = _load(name)
        self._parameters = {}
        for line in calls.strip().splitlines():
            names, _, parameters = line.strip(" )").partition("(")
            for call in names.split():
                self._parameters[call] = [parameter.split() for parameter in parameters.split(", ")]
                function = getattr(self._library, "egosieve_" + call)
                function.argtypes = [kind for parameter in self._parameters[call] for kind in _in_c(*parameter)]
                function.restype = ctypes.c_int32

    def status(self, call, *arguments):
        return getattr(self._library, "egosieve_" + call)(*arguments)

    def call(self, call, *arguments, not_found=FileNotFoundError):
        """The result, or a list of several.

        ValueError (bad arguments, damaged files), FileNotFoundError, NotImplementedError, MemoryError, RuntimeError for the rest.
        """
        views, given, passed, results = {"in": _read, "out": written}, iter(arguments), [], []
        for kind, name in self._parameters[call]:
            if kind.endswith("&"):
                results.append(_type(kind[:-1])())
                passed.append(results[-1])
            elif kind.endswith("[]"):
                values = list(next(given))
                passed += [(_type(kind[:-2]) * len(values))(*values), len(values)]
            else:
                value = next(given)
                passed.append(views[kind](name, value) if kind in views else value)
        check(self.status(call, *passed), not_found)
        return results[0].value if len(results) == 1 else [result.value for result in results]

    def new(self, struct, **values):
        """A struct with the library's defaults but these values; integers that do not fit are ValueError."""
        made = struct()
        init = getattr(self._library, "egosieve_" + struct.init)
        init.restype = None
        init(ctypes.byref(made))
        if made.struct_size != ctypes.sizeof(struct):
            raise ImportError(f"{struct.__name__} has {ctypes.sizeof(struct)} bytes here and {made.struct_size} in the library")
        return fill(made, **values)


class Handle:
    """An object of the library's, whose `_prefix` is that of its calls."""

    _library = _prefix = None

    def __init__(self, handle):
        self._handle = handle

    def __del__(self):
        if getattr(self, "_handle", None):
            self._library.status(self._prefix + "free", self._handle)

    def call(self, call, *arguments, **wishes):
        return self._library.call(self._prefix + call, self._handle, *arguments, **wishes)


def fill(struct, **values):
    """Sets fields; integers that do not fit, which ctypes would cut, are ValueError."""
    for name, value in values.items():
        setattr(struct, name, value)
        if isinstance(value, int) and getattr(struct, name) != value:
            raise ValueError(f"{name} = {value} is out of range")
    return struct


def choice(name, value, choices):
    """The index of `value` in `choices`."""
    if value not in choices:
        raise ValueError(f"{name} = {value!r}; it must be one of {', '.join(map(repr, choices))}")
    return choices.index(value)


_status_library = _load("egosieve")
_status_library.egosieve_last_error.restype = _status_library.egosieve_version.restype = ctypes.c_char_p
_status_library.egosieve_set_threads.restype = None
_EXCEPTIONS = {1: ValueError, 5: ValueError, 6: NotImplementedError, 8: MemoryError}


def check(status, not_found=FileNotFoundError):
    if status != 0:
        message = _status_library.egosieve_last_error().decode(errors="replace")
        raise {**_EXCEPTIONS, 4: not_found}.get(status, RuntimeError)(message)


def set_threads(threads):
    """Limits the threads of the host's work in this process; 0: as at first. Results do not depend on it.

    At first there are EGOSIEVE_THREADS, or as many as the process may use processors. PoCL's threads are not among
    them: it takes their number from POCL_MAX_PTHREAD_COUNT when a device is first used.
    """
    _status_library.egosieve_set_threads(ctypes.c_int32(threads))


def threads():
    """The limit."""
    return _status_library.egosieve_threads()


def version():
    return _status_library.egosieve_version().decode()


def encoded(text):
    return None if text is None else str(text).encode()


_ELEMENTS = {np.dtype(np.float32): 1, np.dtype(np.float64): 2}


def _view(name, array):
    """A view of an array of one (a column) or two dimensions, which it keeps."""
    if array.ndim not in (1, 2):
        raise ValueError(f"{name} has {array.ndim} dimensions; it must have 1 or 2")
    if array.dtype not in _ELEMENTS:
        raise TypeError(f"{name} has dtype {array.dtype}; it must be float32 or float64 in the machine's byte order")
    if array.size > 1 and not any(array.strides):  # one value for all: the library's strides of 0 mean packed rows
        array = np.ascontiguousarray(array)
    columns, column_stride = (array.shape[1], array.strides[1]) if array.ndim == 2 else (1, array.itemsize)
    view = Array(array.ctypes.data, array.shape[0], columns, array.strides[0], column_stride, _ELEMENTS[array.dtype])
    view.array = array
    return view


def _read(name, array):
    return None if array is None else _view(name, array)


def written(name, array):
    """A view of an array that is written, or of None, which is not wanted."""
    if array is None:
        return Array()
    if not isinstance(array, np.ndarray):
        raise TypeError(f"{name} is no numpy array")
    if not array.flags.writeable:
        raise ValueError(f"{name} is read-only")
    if array.size > 0 and any(step == 0 and count > 1 for step, count in zip(array.strides, array.shape)):
        raise ValueError(f"{name}: its elements lie on each other")
    return _view(name, array)


def image(name, pixels, order="bgr"):
    """A view of an image, which it keeps: a copy where pixels are not neighbours."""
    if pixels.dtype != np.uint8:
        raise TypeError(f"{name} has dtype {pixels.dtype}; it must be uint8")
    colour = pixels.ndim == 3 and pixels.shape[2] == 3
    if not colour and pixels.ndim != 2:
        raise ValueError(f"{name} has shape {pixels.shape}; it must be height x width, or height x width x 3")
    if order not in ("bgr", "rgb"):
        raise ValueError(f"order = '{order}'; it must be 'bgr' or 'rgb'")
    pixel = 3 if colour else 1
    if pixels.strides[1] != pixel or (colour and pixels.strides[2] != 1) or pixels.strides[0] < pixels.shape[1] * pixel:
        pixels = np.ascontiguousarray(pixels)
    if max(pixels.shape) >= 2**31:
        raise ValueError(f"{name} is too large")
    channels = 1 if not colour else 2 if order == "bgr" else 3
    view = Image(pixels.ctypes.data, pixels.shape[1], pixels.shape[0], pixels.strides[0], channels)
    view.array = pixels
    return view
