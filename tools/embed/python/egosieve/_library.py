"""The C interface by ctypes: structs, arrays as arguments without a copy, statuses as exceptions.

ctypes gives the interpreter's lock back during calls. Every struct is compared with the library's own size.
"""

import ctypes
from ctypes import POINTER, c_char, c_char_p, c_double, c_int32, c_int64, c_uint64, c_void_p
from pathlib import Path

import numpy as np

_INFO_SCALES = 33  # EGOSIEVE_INFO_SCALES


class Array(ctypes.Structure):
    """egosieve_array, and egosieve_const_array, which has the same fields."""

    _fields_ = [("data", c_void_p), ("rows", c_int64), ("columns", c_int64), ("row_stride", c_int64),
                ("column_stride", c_int64), ("type", c_int32)]  # fmt: skip


class Image(ctypes.Structure):
    _fields_ = [("data", c_void_p), ("width", c_int32), ("height", c_int32), ("row_stride", c_int64), ("channels", c_int32)]


class Grid(ctypes.Structure):
    _fields_ = [("x0", c_double), ("y0", c_double), ("dx", c_double), ("dy", c_double), ("rows", c_int64), ("columns", c_int64)]


class GpOptions(ctypes.Structure):
    _fields_ = [("struct_size", c_uint64), ("covariance", c_int32), ("dimension", c_int32), ("scales", POINTER(c_double)),
                ("scale_count", c_int64), ("signal_stddev", c_double), ("noise_stddev", c_double), ("device", c_char_p),
                ("memory_cap_bytes", c_int64), ("covariance_text", c_char_p), ("mean", c_int32),
                ("approximation", c_int64), ("inducing_points", c_int64), ("opencl_context", c_void_p),
                ("opencl_device", c_void_p)]  # fmt: skip


class DeviceArray(ctypes.Structure):
    _fields_ = [("memory", c_void_p), ("first", c_int64)]


class DeviceCall(ctypes.Structure):
    _fields_ = [("struct_size", c_uint64), ("queue", c_void_p), ("wait", POINTER(c_void_p)), ("wait_count", c_int64),
                ("queries", c_void_p), ("query_count", c_int64), ("query_first", c_int64), ("query_stride", c_int64),
                ("mean", DeviceArray), ("variance", DeviceArray), ("probability", DeviceArray),
                ("clamped", DeviceArray)]  # fmt: skip


class GpInfo(ctypes.Structure):
    _fields_ = [("struct_size", c_uint64), ("size", c_int64), ("dimension", c_int32), ("covariance", c_int32),
                ("scale_count", c_int64), ("scales", c_double * _INFO_SCALES), ("signal_stddev", c_double),
                ("noise_stddev", c_double), ("jitter", c_double), ("squash_a", c_double), ("squash_b", c_double),
                ("has_labels", c_int64), ("outputs", c_int64), ("coefficients", c_int64), ("mean", c_int32),
                ("approximation", c_int64), ("inducing_points", c_int64), ("inducing_count", c_int64)]  # fmt: skip


SHOULD_STOP = ctypes.CFUNCTYPE(c_int32, c_void_p)


class OptimizeOptions(ctypes.Structure):
    _fields_ = [("struct_size", c_uint64), ("subset_size", c_int64), ("restarts", c_int32),
                ("gradient_steps", c_int32), ("tolerance", c_double), ("seed", c_uint64),
                ("lower_bounds", POINTER(c_double)), ("upper_bounds", POINTER(c_double)), ("bound_count", c_int64),
                ("should_stop", SHOULD_STOP), ("stop_argument", c_void_p)]  # fmt: skip


class OptimizeResult(ctypes.Structure):
    _fields_ = [("struct_size", c_uint64), ("log_likelihood_at_start", c_double), ("log_likelihood", c_double),
                ("evaluations", c_int64), ("points", c_int64), ("converged", c_int64),
                ("gradient_norm", c_double), ("on_bound", POINTER(c_int32)), ("on_bound_count", c_int64)]  # fmt: skip


class Prediction(ctypes.Structure):
    _fields_ = [("struct_size", c_uint64), ("mean", Array), ("variance", Array), ("probability", Array),
                ("of_observation", c_int32), ("clamped_variances", c_int64), ("precision", c_int64),
                ("float64_count", c_int64)]  # fmt: skip


class SegmenterOptions(ctypes.Structure):
    _fields_ = [("struct_size", c_uint64), ("profile", c_int32), ("stride", c_int32), ("budget", c_int64),
                ("seed", c_uint64), ("device", c_char_p), ("lag", c_int64), ("ignore", POINTER(Image)),
                ("focal_ratio", c_double)]  # fmt: skip


class Map(ctypes.Structure):
    _fields_ = [("struct_size", c_uint64), ("probability", Array), ("mean", Array), ("deviation", Array),
                ("objects", Array)]  # fmt: skip


class FrameReport(ctypes.Structure):
    _fields_ = [("struct_size", c_uint64), ("frame", c_int64), ("learnt", c_int32), ("reason", c_char * 256),
                ("matches", c_int64), ("inliers", c_int64), ("static_labels", c_int64), ("dynamic_labels", c_int64),
                ("model_size", c_int64), ("dynamic_share", c_double), ("milliseconds", c_double)]  # fmt: skip


def _load(name):
    # Beside this file in a wheel, in lib/ above lib/python3.*/site-packages/egosieve where installed.
    here = Path(__file__).resolve().parent
    paths = [folder / f"lib{name}.so.1" for folder in (here, here.parents[2])]
    for path in paths:
        if path.exists():
            return ctypes.CDLL(str(path))
    raise ImportError(f"lib{name}.so.1 is neither of {', '.join(map(str, paths))}")


class Library:
    """Functions of a shared library that return a status: `call` raises where it is none of success."""

    def __init__(self, name, signatures):
        self._library = _load(name)
        for function, arguments in signatures.items():
            getattr(self._library, function).argtypes = arguments
            getattr(self._library, function).restype = c_int32

    def call(self, function, *arguments):
        check(getattr(self._library, function)(*arguments))

    def status(self, function, *arguments):
        return getattr(self._library, function)(*arguments)

    def new(self, struct, init):
        """A struct with the library's defaults."""
        value = struct()
        getattr(self._library, init).restype = None
        getattr(self._library, init)(ctypes.byref(value))
        if value.struct_size != ctypes.sizeof(struct):
            raise ImportError(f"{struct.__name__} has {ctypes.sizeof(struct)} bytes here and {value.struct_size} in the library")
        return value


def fill(struct, **values):
    """Sets fields; integers that do not fit, which ctypes would cut, are ValueError."""
    for name, value in values.items():
        setattr(struct, name, value)
        if isinstance(value, int) and getattr(struct, name) != value:
            raise ValueError(f"{name} = {value} is out of range")
    return struct


_STATUS_LIBRARY = _load("egosieve")
_STATUS_LIBRARY.egosieve_last_error.restype = c_char_p
_STATUS_LIBRARY.egosieve_version.restype = c_char_p
_STATUS_LIBRARY.egosieve_set_threads.restype = None
_STATUS_LIBRARY.egosieve_threads.restype = c_int32
_EXCEPTIONS = {1: ValueError, 4: FileNotFoundError, 5: ValueError, 8: MemoryError}
NOT_FOUND = 4


def check(status):
    """ValueError for bad arguments and damaged files, FileNotFoundError, MemoryError, RuntimeError for the rest."""
    if status != 0:
        raise _EXCEPTIONS.get(status, RuntimeError)(last_error())


def last_error():
    return _STATUS_LIBRARY.egosieve_last_error().decode(errors="replace")


def set_threads(threads):
    """Limits the threads of the host's work in this process; 0: as at first. Results do not depend on it.

    At first there are EGOSIEVE_THREADS, or as many as the process may use processors. PoCL's threads are not among
    them: it takes their number from POCL_MAX_PTHREAD_COUNT when a device is first used.
    """
    _STATUS_LIBRARY.egosieve_set_threads(c_int32(threads))


def threads():
    """The limit."""
    return _STATUS_LIBRARY.egosieve_threads()


def version():
    return _STATUS_LIBRARY.egosieve_version().decode()


def encoded(text):
    return None if text is None else str(text).encode()


_TYPES = {np.dtype(np.float32): 1, np.dtype(np.float64): 2}


def input_array(name, array):
    """A view of an array of one (a column) or two dimensions, which must outlive it."""
    if array.ndim not in (1, 2):
        raise ValueError(f"{name} has {array.ndim} dimensions; it must have 1 or 2")
    if array.dtype not in _TYPES:
        raise TypeError(f"{name} has dtype {array.dtype}; it must be float32 or float64 in the machine's byte order")
    if array.size > 1 and not any(array.strides):  # one value for all: the library's strides of 0 mean packed rows
        array = np.ascontiguousarray(array)
    columns, column_stride = (array.shape[1], array.strides[1]) if array.ndim == 2 else (1, array.itemsize)
    view = Array(array.ctypes.data, array.shape[0], columns, array.strides[0], column_stride, _TYPES[array.dtype])
    view.array = array  # lives as long
    return view


def output_array(name, array):
    """The same of an array that is written, or of None, which is not wanted."""
    if array is None:
        return Array()
    if not isinstance(array, np.ndarray):
        raise TypeError(f"{name} is no numpy array")
    if not array.flags.writeable:
        raise ValueError(f"{name} is read-only")
    if any(step == 0 and count > 1 for step, count in zip(array.strides, array.shape)):
        raise ValueError(f"{name}: its elements lie on each other")
    return input_array(name, array)


def image(name, pixels, order):
    """An image and the array that it is a view of: a copy where pixels are not neighbours."""
    if pixels.dtype != np.uint8:
        raise TypeError(f"{name} has dtype {pixels.dtype}; it must be uint8")
    colour = pixels.ndim == 3 and pixels.shape[2] == 3
    if not colour and pixels.ndim != 2:
        raise ValueError(f"{name} must be height x width, or height x width x 3")
    if order not in ("bgr", "rgb"):
        raise ValueError(f"order = '{order}'; it must be 'bgr' or 'rgb'")
    pixel = 3 if colour else 1
    if pixels.strides[1] != pixel or (colour and pixels.strides[2] != 1) or pixels.strides[0] < pixels.shape[1] * pixel:
        pixels = np.ascontiguousarray(pixels)
    if max(pixels.shape) >= 2**31:
        raise ValueError(f"{name} is too large")
    channels = 1 if not colour else 2 if order == "bgr" else 3
    return Image(pixels.ctypes.data, pixels.shape[1], pixels.shape[0], pixels.strides[0], channels), pixels
