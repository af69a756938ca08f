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


class SegmentationMap(NamedTuple):
    """The map of one frame: arrays of float32, rows by columns of the grid or the frame's pixels."""

    probability: np.ndarray
    """Of belonging to something that moves."""
    mean: np.ndarray
    """Of the latent function, -1 static, 1 moving."""
    deviation: np.ndarray
    """Its standard deviation: large where nothing like it was seen."""
    report: FrameReport
    """What was seen and learnt."""


class Segmenter:
    """Learns online, from frames of one moving, uncalibrated camera, what moves by itself.

    Nothing has to be labelled or trained before. The first frame gets the prior's map. No frame is an error for
    what it shows: where nothing can be learnt, the report says why.

    Parameters
    ----------
    profile : "default", "paper" or "fast"
    stride : int
        Pixels between the map's columns and rows, 1 to 64.
    budget : int
        Points that the model holds at most; 0: the profile's.
    seed : int
        Of everything that is random.
    device : str, optional
        A device's index, part of its name, "cpu", "gpu" or "reference".

    Examples
    --------
    >>> segmenter = egosieve.Segmenter()
    >>> for frame in frames:                       # uint8, height x width x 3
    ...     moving = segmenter.process(frame, full=True).probability > 0.5
    """

    def __init__(self, profile="default", *, stride=5, budget=0, seed=1, device=None):
        self._session = Session(profile, stride, budget, seed, device)
        self._processed = 0

    def process(self, frame, time_seconds=None, *, order="bgr", full=False):
        """Learns from the next frame and gives its map.

        Parameters
        ----------
        frame : array of uint8, (height, width) or (height, width, 3)
            Rows may have any stride; frames whose pixels are not neighbours are copied.
        time_seconds : float, optional
            Default: frames processed so far, at ten a second.
        order : "bgr" or "rgb"
        full : bool
            The map has every pixel, interpolated from the grid's values.

        Returns
        -------
        SegmentationMap
        """
        frame, time_seconds = self._arguments(frame, time_seconds)
        height, width = frame.shape[:2]
        shape = (height, width) if full else self.grid_size(width, height)
        maps = [np.empty(shape, dtype=np.float32) for _ in range(3)]
        report = self._session.process(frame, order, time_seconds, *maps)
        self._processed += 1
        return SegmentationMap(*maps, FrameReport(**report))

    def learn(self, frame, time_seconds=None, *, order="bgr"):
        """Learns from the next frame without a map, which is cheaper; gives the FrameReport."""
        frame, time_seconds = self._arguments(frame, time_seconds)
        report = self._session.process(frame, order, time_seconds, None, None, None)
        self._processed += 1
        return FrameReport(**report)

    def grid_size(self, width, height):
        """(rows, columns) of the maps of frames of this size."""
        return self._session.grid_size(width, height)

    def save(self, path):
        """Writes all that the next frame needs into a file, whole or not at all.

        This segmenter and one that is loaded go on alike to the last bit.
        """
        self._session.save(str(path))

    @classmethod
    def load(cls, path, device=None):
        """Reads what save wrote."""
        segmenter = cls.__new__(cls)
        segmenter._session = Session.load(str(path), device)
        segmenter._processed = 0
        return segmenter

    def _arguments(self, frame, time_seconds):
        frame = np.asarray(frame)
        if frame.ndim < 2:
            raise ValueError(f"frame has shape {frame.shape}; it must be height x width, or height x width x 3")
        return frame, 0.1 * self._processed if time_seconds is None else float(time_seconds)
