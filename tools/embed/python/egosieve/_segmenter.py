"""Handles of egosieve's C interface; use egosieve.Segmenter."""

from ctypes import POINTER, byref, c_char_p, c_double, c_int32, c_int64, c_void_p, pointer

from . import _library
from ._library import FrameReport, Image, Map, SegmenterOptions, encoded, fill, image, output_array

_PROFILES = ("default", "paper", "fast")

_vision = _library.Library("egosieve_vision", {
    "egosieve_segmenter_create": [POINTER(SegmenterOptions), POINTER(c_void_p)],
    "egosieve_segmenter_free": [c_void_p],
    "egosieve_segmenter_grid_size": [c_void_p, c_int32, c_int32, POINTER(c_int64), POINTER(c_int64)],
    "egosieve_segmenter_frame_count": [c_void_p, POINTER(c_int64)],
    "egosieve_segmenter_waiting": [c_void_p, POINTER(c_int64), POINTER(c_int32), POINTER(c_int32)],
    "egosieve_segmenter_finish": [c_void_p, POINTER(Map), POINTER(FrameReport)],
    "egosieve_segmenter_process": [c_void_p, POINTER(Image), c_double, POINTER(Map), POINTER(FrameReport)],
    "egosieve_segmenter_save": [c_void_p, c_char_p],
    "egosieve_segmenter_load": [c_char_p, c_char_p, POINTER(c_void_p)],
})  # fmt: skip


class Session:
    def __init__(self, profile, stride, budget, seed, lag, ignore, focal_ratio, device):
        if profile not in _PROFILES:
            raise ValueError(f"profile = {profile!r}; it must be one of {', '.join(map(repr, _PROFILES))}")
        options = _vision.new(SegmenterOptions, "egosieve_segmenter_options_init")
        fill(options, profile=_PROFILES.index(profile), stride=stride, budget=budget, seed=seed, lag=lag,
             focal_ratio=focal_ratio, device=encoded(device))  # fmt: skip
        if ignore is not None:
            view, kept = image("ignore", ignore, "bgr")
            options.ignore = pointer(view)
        handle = c_void_p()
        status = _vision.status("egosieve_segmenter_create", byref(options), byref(handle))
        if status == _library.NOT_FOUND:
            raise ValueError(_library.last_error())
        _library.check(status)
        self._adopt(handle)

    @classmethod
    def load(cls, path, device):
        handle = c_void_p()
        _vision.call("egosieve_segmenter_load", encoded(path), encoded(device), byref(handle))
        session = cls.__new__(cls)
        session._adopt(handle)
        return session

    def _adopt(self, handle):
        self._handle = handle
        self._status = _vision.status  # for __del__, when this module may be gone

    def __del__(self):
        if getattr(self, "_handle", None):
            self._status("egosieve_segmenter_free", self._handle)

    def grid_size(self, width, height):
        rows, columns = c_int64(), c_int64()
        _vision.call("egosieve_segmenter_grid_size", self._handle, width, height, byref(rows), byref(columns))
        return rows.value, columns.value

    def frame_count(self):
        frames = c_int64()
        _vision.call("egosieve_segmenter_frame_count", self._handle, byref(frames))
        return frames.value

    def waiting(self):
        frames, width, height = c_int64(), c_int32(), c_int32()
        _vision.call("egosieve_segmenter_waiting", self._handle, byref(frames), byref(width), byref(height))
        return frames.value, width.value, height.value

    def process(self, frame, order, time_seconds, arrays):
        view, kept = image("frame", frame, order)
        return self._report("egosieve_segmenter_process", arrays, byref(view), time_seconds)

    def finish(self, arrays):
        return self._report("egosieve_segmenter_finish", arrays)

    def _report(self, function, arrays, *inputs):
        # The account as a dictionary, None where there was no frame; `arrays` of a map by their names, or None.
        wishes = _vision.new(Map, "egosieve_map_init")
        for name, array in (arrays or {}).items():
            setattr(wishes, name, output_array(name, array))
        report = _vision.new(FrameReport, "egosieve_frame_report_init")
        _vision.call(function, self._handle, *inputs, byref(wishes) if arrays else None, byref(report))
        if report.frame < 0:
            return None
        account = {name: getattr(report, name) for name, _ in FrameReport._fields_[1:]}
        return {**account, "learnt": bool(report.learnt), "reason": report.reason.decode(errors="replace")}

    def save(self, path):
        _vision.call("egosieve_segmenter_save", self._handle, encoded(path))
