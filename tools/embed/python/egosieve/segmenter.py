"""The segmenter: frames of one moving camera in, maps of what moves by itself out."""

from typing import NamedTuple

import numpy as np

from ._segmenter import Session


class FrameReport(NamedTuple):
    """The account of one frame."""

    frame: int
    """From 0."""
    learnt: bool
    """The model learnt from this frame."""
    reason: str
    """Why it did not; empty where it did."""
    matches: int
    """Between this frame and the one that it was paired with."""
    inliers: int
    """Of the camera's motion."""
    static_labels: int
    """Features that move with the scene."""
    dynamic_labels: int
    """Features that do not."""
    model_size: int
    """Points in the model."""
    dynamic_share: float
    """Of the map, probability 1/2 or more."""
    milliseconds: float
    """Spent on this frame."""


class MovingObject(NamedTuple):
    """A region of the map that is likely to move, and somewhere surely does."""

    number: int
    """In SegmentationMap.objects."""
    left: int
    """Its first column in the map."""
    top: int
    """Its first row."""
    width: int
    """Columns."""
    height: int
    """Rows."""
    places: int
    """Of the map."""
    peak: float
    """The largest of its probabilities."""
    mean: float
    """Their mean."""


class SegmentationMap(NamedTuple):
    """The map of one frame: arrays of rows by columns of the grid or of the frame's pixels, float32 but for the last."""

    probability: np.ndarray
    """Of belonging to something that moves."""
    mean: np.ndarray
    """Of the latent function, -1 static, 1 moving."""
    deviation: np.ndarray
    """Its standard deviation: large where nothing like it was seen."""
    report: FrameReport
    """What was seen and learnt."""
    objects: np.ndarray
    """int32: the number of the object that a place belongs to, from 1, in each frame anew; 0: none. Objects are regions
    with a probability of 0.25 and more and somewhere of 0.8 and more."""

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
        if ignore is not None:
            ignore = np.asarray(ignore)
            ignore = ignore.astype(np.uint8) if ignore.dtype == bool else ignore
        self._session = Session(profile, stride, budget, seed, lag, ignore, focal_ratio, device)

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
        frame, time_seconds = self._arguments(frame, time_seconds)
        arrays = self._arrays(*frame.shape[:2], full)
        report = self._session.process(frame, order, time_seconds, arrays)
        return self._map(arrays, report)

    def finish(self, *, full=False):
        """With a lag, the SegmentationMaps of the last frames, which have no later ones: an iterator."""
        while True:
            count, width, height = self._session.waiting()
            if count == 0:
                return
            arrays = self._arrays(height, width, full)
            yield self._map(arrays, self._session.finish(arrays))

    def process_all(self, frames, *, order="bgr", full=False):
        """The SegmentationMap of every frame of an iterable: an iterator."""
        for frame in frames:
            found = self.process(frame, order=order, full=full)
            if found is not None:
                yield found
        yield from self.finish(full=full)

    def learn(self, frame, time_seconds=None, *, order="bgr"):
        """Learns from the next frame without a map, which is cheaper; gives the FrameReport, or as process None."""
        frame, time_seconds = self._arguments(frame, time_seconds)
        report = self._session.process(frame, order, time_seconds, None)
        return None if report is None else FrameReport(**report)

    def grid_size(self, width, height):
        """(rows, columns) of the maps of frames of this size."""
        return self._session.grid_size(width, height)

    def save(self, path):
        """Writes all that the next frame needs into a file, whole or not at all.

        This segmenter and the loaded one continue with identical results.
        """
        self._session.save(str(path))

    @classmethod
    def load(cls, path, device=None):
        """Reads what save wrote."""
        segmenter = cls.__new__(cls)
        segmenter._session = Session.load(str(path), device)
        return segmenter

    def _arrays(self, height, width, full):
        shape = (height, width) if full else self.grid_size(width, height)
        return {name: np.empty(shape, dtype=np.float32) for name in ("probability", "mean", "deviation", "objects")}

    @staticmethod
    def _map(arrays, report):
        if report is None:
            return None
        arrays["objects"] = arrays["objects"].astype(np.int32)
        return SegmentationMap(report=FrameReport(**report), **arrays)

    def _arguments(self, frame, time_seconds):
        frame = np.asarray(frame)
        if frame.ndim < 2:
            raise ValueError(f"frame has shape {frame.shape}; it must be height x width, or height x width x 3")
        return frame, 0.1 * self._session.frame_count() if time_seconds is None else float(time_seconds)
