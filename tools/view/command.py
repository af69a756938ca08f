"""The command line of egosieve-view."""

import argparse
import os
import sys
from pathlib import Path

from evaluate.files import InputError, UsageError
from evaluate.run_folder import RunFolder

from .pictures import pictures

MISSING = "pip install rerun-sdk opencv-python-headless, in an environment of Python 3.11 or later; ./run view makes one"


def parser():
    """Flags."""
    flags = argparse.ArgumentParser(
        "egosieve-view",
        description="Writes a run as a recording for the viewer Rerun: pictures, masks, boxes with numbers, probability, the camera's path "
        "and what is doubtful, over frames and seconds. RUN is a folder of egosieve run, or of segment; refine gives it masks and numbers.",
        epilog="exit codes: 0 done, 1 the environment, 2 usage, 3 an input cannot be read",
    )
    flags.add_argument("run", metavar="RUN", type=Path, help="the run folder")
    flags.add_argument("-o", "--out", metavar="FILE", type=Path, help="the recording, .rrd; default: RUN/view.rrd")
    flags.add_argument("--input", metavar="PATH", type=Path, help="where the run's input is now, if it was moved")
    flags.add_argument("--every", metavar="N", type=int, default=1, help="write every Nth frame alone; default: 1")
    return flags


def viewer():
    """Rerun's own program: beside this interpreter where it is there."""
    beside = Path(sys.executable).parent / "rerun"
    return beside if beside.exists() else "rerun"


def view(options):
    """Writes the recording, whole or not at all, and tells its size."""
    out = options.out or options.run / "view.rrd"
    if out.suffix != ".rrd" or out.is_dir():
        raise UsageError(f"--out={out} is no file .rrd; name one")
    if options.every < 1:
        raise UsageError(f"--every={options.every} is below 1")
    run = RunFolder(options.run)
    lines = run.scorable_lines()[:: options.every]
    frames = pictures(options.input or run.input, lines)
    first = next(frames)  # an input that is not there is told before anything is written
    from .recording import write

    scratch = Path(f"{out}.{os.getpid()}.tmp")
    try:
        count = write(run, (frame for some in ([first], frames) for frame in some), scratch)
        size = scratch.stat().st_size
        scratch.replace(out)
    finally:
        scratch.unlink(missing_ok=True)
    hint = "" if (run.path / "tracks.csv").exists() else f"no masks and numbers: egosieve refine {run.path} makes them\n"
    print(f"{hint}{out}: {count} frames, {size / 1e6:.1f} MB; look at it with: {viewer()} {out}")
    return 0


def main(arguments=None):
    """The exit code."""
    options = parser().parse_args(arguments)
    try:
        return view(options)
    except (UsageError, InputError, OSError, RuntimeError, ModuleNotFoundError) as error:  # RuntimeError: of rerun, a full disk
        hint = f"; {MISSING}" if isinstance(error, ModuleNotFoundError) else ""
        print(f"egosieve-view: {error}{hint}", file=sys.stderr)
        return getattr(error, "code", 1)
    except KeyboardInterrupt:
        return 130
