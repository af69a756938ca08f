"""The sequences of a suite: every folder in it that holds frames and a truth for them.

    frames   frames/, a folder of images
    truth    scene.json beside masks/ (a synthetic drive), else masks/, else labels/ (masks), else
             tracks.csv; none in a synthetic drive that is not complete (it has `unfinished`)

A sequence's name is its path below the suite. Its group is the first part of that path.
"""

from collections import namedtuple
from pathlib import Path

from .files import InputError

DEPTH = 3
Sequence = namedtuple("Sequence", "name frames truth")  # davis/cows, paths


def truth_in(folder):
    """The truth in a folder; None if there is none, and in a drive that is not complete."""
    if (folder / "scene.json").is_file() and (folder / "masks").is_dir():
        return folder
    if (folder / "unfinished").exists():
        return None
    places = (folder / name for name in ("masks", "labels", "tracks.csv"))
    return next((place for place in places if place.exists()), None)


def _folders_with_frames(folder, depth):
    if (folder / "frames").is_dir():
        yield folder
    elif depth > 0:
        for entry in sorted(folder.iterdir()):
            if entry.is_dir():
                yield from _folders_with_frames(entry, depth - 1)


def find_sequences(suite):
    """(sequences, names of folders with frames but no truth), by name."""
    root = Path(suite).absolute()
    if not root.is_dir():
        raise InputError(f"no folder {suite}; give the suite's folder")
    truths = {folder.relative_to(root).as_posix() if folder != root else root.name:
              (folder / "frames", truth_in(folder)) for folder in _folders_with_frames(root, DEPTH)}
    sequences = [Sequence(name, *both) for name, both in sorted(truths.items()) if both[1]]
    without = sorted(name for name, (_, truth) in truths.items() if not truth)
    if not sequences:
        beside = f" (frames without truth: {', '.join(without)})" if without else ""
        raise InputError(f"no sequence in {suite}: none of its folders has frames/ and masks/, "
                         f"labels/ or tracks.csv beside it{beside}")
    return sequences, without
