"""Egosieve: dense Gaussian processes on a device, and the segmenter built on them.

    GaussianProcess   regression and classification, in scikit-learn's manner
    GaussianProcessClassifier   classes of any labels
    Segmenter         frames of one moving camera in, maps of what moves by itself out
    devices()         what can compute: every OpenCL device, then the float64 reference
    set_threads()     how many threads the host's work may have; threads() tells

All computing is done by the libraries libegosieve and libegosieve_vision, with the interpreter's lock
released. Arrays of float32 and float64 are read and written where they are, whatever their strides.
"""

from ._gaussian_process import devices as devices
from ._library import version as _version
from ._library import set_threads as set_threads
from ._library import threads as threads
from .classifier import GaussianProcessClassifier as GaussianProcessClassifier
from .gaussian_process import GaussianProcess as GaussianProcess
from .predictor import FrozenPosterior as FrozenPosterior

__version__ = _version()
__all__ = ["FrozenPosterior", "FrameReport", "GaussianProcess", "GaussianProcessClassifier", "MovingObject", "SegmentationMap", "Segmenter"]
__all__ += ["devices", "set_threads", "threads"]


def __getattr__(name):
    # Loads OpenCV, which those who only want a Gaussian process should not wait for.
    if name in ("Segmenter", "SegmentationMap", "FrameReport", "MovingObject"):
        from . import segmenter

        return getattr(segmenter, name)
    raise AttributeError(f"module 'egosieve' has no attribute '{name}'")


def __dir__():
    return sorted(__all__)
