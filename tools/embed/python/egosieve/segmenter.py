"""The segmenter: frames of one moving camera in, maps of what moves by itself out."""

from ctypes import pointer
from typing import NamedTuple

import numpy as np

from ._library import FrameReport as _Report
from ._library import Handle, Library, Map, SegmenterOptions, choice, encoded, image, written

_PROFILES = ("default", "paper", "fast")

_vision = Library("egosieve_vision", """
segmenter_create(SegmenterOptions* options, void*& segmenter)
segmenter_load(char* path, char* device, void*& segmenter)
segmenter_free(void* segmenter)
segmenter_grid_size(void* segmenter, int32 width, int32 height, int64& rows, int64& columns)
segmenter_frame_count(void* segmenter, int64& frames)
segmenter_waiting(void* segmenter, int64& frames, int32& width, int32& height)
segmenter_finish(void* segmenter, Map* map, FrameReport* report)
segmenter_process(void* segmenter, Image* image, double time_seconds, Map* map, FrameReport* report)
segmenter_save(void* segmenter, char* path)
""")  # fmt: skip


class _Session(Handle):
    _library, _prefix = _vision, "segmenter_"


class FrameReport(NamedTuple):
    """The account of one frame.

    `frame` counts from 0. `learnt` tells whether the model learnt from this frame, `reason` why it did not. `matches`
    are those with the frame that it was paired with, `inliers` those of the camera's motion. `static_labels` are
    features that move with the scene, `dynamic_labels` those that do not. `model_size` is in points,
    `dynamic_share` the share of the map with probability 1/2 or more, `milliseconds` the time spent.
    """

    frame: int
    learnt: bool
    reason: str
    matches: int
    inliers: int
    static_labels: int
    dynamic_labels: int
    model_size: int
    dynamic_share: float
    milliseconds: float


class MovingObject(NamedTuple):
    """A region of the map that is likely to move, and somewhere surely does.

    `number` is that in SegmentationMap.objects; `left` and `top` are its first column and row in the map, `width` and
    `height` its columns and rows. It has so many `places`; `peak` and `mean` are of their probabilities.
    """

    number: int
    left: int
    top: int
    width: int
    height: int
    places: int
    peak: float
    mean: float


class SegmentationMap(NamedTuple):
    """The map of one frame: arrays of rows by columns of the grid or of the frame's pixels, float32 but for the last.

    `probability` is that of belonging to something that moves; `mean` and `deviation` are those of the latent
    function, -1 static, 1 moving: the deviation is large where nothing like it was seen. `report` tells what was seen
    and learnt. `objects`, int32, holds the number of the object that a place belongs to, from 1, in each frame anew;
    0: none. Objects are regions with a probability of 0.25 and more and somewhere of 0.8 and more.
    """

    probability: np.ndarray
    mean: np.ndarray
    deviation: np.ndarray
    report: FrameReport
    objects: np.ndarray

    @property
    def mask(self):
        """True where an object is."""
        return self.objects > 0

    def list_objects(self):
        """The frame's MovingObject tuples, by number."""
        found = []
        for number in range(1, int(self.objects.max(initial=0)) + 1):
            inside = self.objects == number
            rows, columns = (np.flatnonzero(inside.any(axis)) for axis in (1, 0))
            values = self.probability[inside]
            found.append(MovingObject(
                number, int(columns[0]), int(rows[0]), int(columns[-1] - columns[0]) + 1,
                int(rows[-1] - rows[0]) + 1, values.size, float(values.max()), float(values.mean()),
            ))  # fmt: skip
        return found


class Segmenter:
    """Learns online, from frames of one moving, uncalibrated camera, what moves by itself.

    Nothing has to be labelled or trained before. The first frame gets the prior's map. No frame is an error for
    what it shows: where nothing can be learnt, the report says why.

    Parameters
    ----------
    profile : "default", "paper" or "fast"
        "fast" is "default" with labels from smaller, neighbouring frames and with fewer inducing points.
    stride : int
        Pixels between the map's columns and rows, 1 to 64.
    budget : int
        Points that the model holds at most; 0: the profile's.
    seed : int
        Seed of all random numbers.
    lag : int
        Frames behind a frame that its labels rest on, 0 to 100: its map comes so many frames later, and what moves
        is told better once the focal length is known. Needs frames of one size.
    focal_ratio : float
        The camera's focal length over the longer side of the frames, at most 100: motion is then told from the
        camera's rotation and step, in depth. 0: learnt from the frames and their times.
    ignore : array of bool or uint8, (height, width), optional
        Not 0 where the frames do not show the world: the own vehicle, captions. No motion is estimated from there,
        and there are no objects.
    device : str, optional
        A device's index, part of its name, "cpu", "gpu" or "reference". A segmenter takes no OpenCL context and no
        queue of the caller's; its results are NumPy arrays.

    Examples
    --------
    >>> segmenter = egosieve.Segmenter()
    >>> for frame in frames:                       # uint8, height x width x 3
    ...     moving = segmenter.process(frame, full=True).probability > 0.5
    >>> segmenter = egosieve.Segmenter(lag=5, focal_ratio=0.8)
    >>> for found in segmenter.process_all(frames):
    ...     print(found.report.frame, found.list_objects())
    """

    def __init__(self, profile="default", *, stride=5, budget=0, seed=1, lag=0, focal_ratio=0.0, ignore=None,
                 device=None):  # fmt: skip
        options = {"stride": stride, "budget": budget, "seed": seed, "lag": lag, "focal_ratio": focal_ratio}
        if ignore is not None:
            ignore = np.asarray(ignore)
            ignore = ignore.astype(np.uint8) if ignore.dtype == bool else ignore
            options["ignore"] = pointer(image("ignore", ignore))
        self._session = _Session(_vision.call("segmenter_create", _vision.new(
            SegmenterOptions, profile=choice("profile", profile, _PROFILES), device=encoded(device), **options,
        ), not_found=ValueError))  # fmt: skip

    def process(self, frame, time_seconds=None, *, order="bgr", full=False):
        """Learns from the next frame and gives its map.

        Parameters
        ----------
        frame : array of uint8, (height, width) or (height, width, 3)
            Rows may have any stride; frames whose pixels are not neighbours are copied.
        time_seconds : float, optional
            Default: frames processed so far, also before `save`, at ten a second.
        order : "bgr" or "rgb"
        full : bool
            The map has every pixel, interpolated from the grid's values.

        Returns
        -------
        SegmentationMap
            With a lag that of the frame so far before; None while there is none.
        """
        frame, time_seconds = self._arguments(frame, time_seconds, order)
        return self._map("process", frame, time_seconds, shape=(frame.height, frame.width), full=full)

    def finish(self, *, full=False):
        """With a lag, the SegmentationMaps of the last frames, which have no later ones: an iterator."""
        while True:
            count, width, height = self._session.call("waiting")
            if count == 0:
                return
            yield self._map("finish", shape=(height, width), full=full)

    def process_all(self, frames, *, order="bgr", full=False):
        """The SegmentationMap of every frame of an iterable: an iterator."""
        for frame in frames:
            found = self.process(frame, order=order, full=full)
            if found is not None:
                yield found
        yield from self.finish(full=full)

    def learn(self, frame, time_seconds=None, *, order="bgr"):
        """Learns from the next frame without a map, which is cheaper; gives the FrameReport, or as process None."""
        return self._report("process", *self._arguments(frame, time_seconds, order), None)

    def grid_size(self, width, height):
        """(rows, columns) of the maps of frames of this size."""
        return tuple(self._session.call("grid_size", width, height))

    def save(self, path):
        """Writes all that the next frame needs into a file, whole or not at all.

        This segmenter and the loaded one continue with identical results.
        """
        self._session.call("save", encoded(path))

    @classmethod
    def load(cls, path, device=None):
        """Reads what save wrote."""
        segmenter = cls.__new__(cls)
        segmenter._session = _Session(_vision.call("segmenter_load", encoded(path), encoded(device)))
        return segmenter

    def _report(self, call, *arguments):
        report = _vision.new(_Report)
        self._session.call(call, *arguments, report)
        account = {name: getattr(report, name) for name in FrameReport._fields}
        account.update(learnt=bool(report.learnt), reason=report.reason.decode(errors="replace"))
        return None if report.frame < 0 else FrameReport(**account)

    def _map(self, call, *arguments, shape, full):
        shape = shape if full else self.grid_size(*shape[::-1])
        arrays = {name: np.empty(shape, dtype=np.float32) for name in ("probability", "mean", "deviation", "objects")}
        wishes = _vision.new(Map, **{name: written(name, array) for name, array in arrays.items()})
        report = self._report(call, *arguments, wishes)
        arrays["objects"] = arrays["objects"].astype(np.int32) if report else None
        return None if report is None else SegmentationMap(report=report, **arrays)

    def _arguments(self, frame, time_seconds, order="bgr"):
        count = self._session.call("frame_count")
        return image("frame", np.asarray(frame), order), 0.1 * count if time_seconds is None else float(time_seconds)
