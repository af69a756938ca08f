"""What the optimisation of hyperparameters takes and tells: bounds, names, interruption."""

import math
import signal
import threading


class Interruptible:
    """Notes SIGINT while it is entered, and raises KeyboardInterrupt at the end.

    `stops` tells whether one came: the library asks it before each evaluation. Python runs signal handlers in
    the main thread alone, so elsewhere nothing is changed.
    """

    def __enter__(self):
        self._came, self._former = False, None
        if threading.current_thread() is threading.main_thread():
            self._former = signal.signal(signal.SIGINT, self._note)
        return self

    def __exit__(self, *_):
        if self._former is not None:
            signal.signal(signal.SIGINT, self._former)
        if self._came:
            raise KeyboardInterrupt from None

    def _note(self, *_):
        self._came = True

    def stops(self, _=None):
        return int(self._came)


def names(scale_count):
    """Of all hyperparameters, in the library's order."""
    return [*(f"scales[{i}]" for i in range(scale_count)), "signal_stddev", "noise_stddev"]


def _pair(name, bound, value):
    if isinstance(bound, str):
        if bound != "fixed":
            raise ValueError(f"bounds: {name} has {bound!r}; give (lower, upper) or 'fixed'")
        return value, value
    lower, upper = bound
    return tuple(math.nan if end is None else float(end) for end in (lower, upper))


def bounds(given, scales, signal_stddev, noise_stddev):
    """(lower, upper), each a list over scales, signal_stddev and noise_stddev; NaN where the default holds.

    given : dict with any of "scales", "signal_stddev", "noise_stddev". A value is (lower, upper), None in place of
    an end for the default, or "fixed"; "scales" may also be a list of these, one per scale.
    """
    given = dict(given or {})
    of_scales = given.pop("scales", (None, None))
    several = not isinstance(of_scales, str) and any(isinstance(entry, (str, tuple, list)) for entry in of_scales)
    of_scales = list(of_scales) if several else [of_scales] * len(scales)
    if len(of_scales) != len(scales):
        raise ValueError(f"bounds: {len(of_scales)} for scales; there are {len(scales)}")
    values = [*scales, signal_stddev, noise_stddev]
    wishes = [*of_scales, given.pop("signal_stddev", (None, None)), given.pop("noise_stddev", (None, None))]
    if given:
        raise ValueError(f"bounds: no hyperparameter is called {', '.join(map(repr, given))}")
    return tuple(map(list, zip(*map(_pair, names(len(scales)), wishes, values))))
