"""Runs many sequences with several variants of segment, such as profiles, and scores them.

    out/runs/VARIANT/NAME       the run folder; an existing one is continued or used as it is
    out/runs/VARIANT/egosieve_logs/NAME.log   output of segmenting; NAME.masks.log: of refine

Each sequence is segmented by a process of its own with its share of the cores; all of them end with
this program. The order of the results does not depend on durations.
"""

import ctypes
import hashlib
import os
import re
import signal
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

from .evaluation import Evaluation
from .figures import figures_of
from .files import InputError, UsageError
from .further import find_further_truth, rate_of, score_further
from .run_folder import RunFolder

FRAMES_FAILED = 4  # exit code: a few unreadable frames do not prevent scoring of the others
LIBC = ctypes.CDLL(None)
PR_SET_PDEATHSIG = 1
KEPT = ("truth_kind", "frames_scored", "pixels", "scores", "masks")  # of eval.json


def parse_variants(profiles, variants):
    """{name: flags of segment}: the profiles, named by commas, then "NAME=FLAGS"."""
    found = {name: [f"--profile={name}"] for name in profiles.split(",") if name}
    for text in variants:
        parsed = re.fullmatch(r"([\w+-]+)=(.*)", text, re.ASCII | re.DOTALL)
        if not parsed or parsed[1] in found:
            raise UsageError(f'variant "{text}" is not NAME=FLAGS, NAME of letters, digits, _, - '
                             'and +, another one each; write, say, "gap=--set=frame_gap=1"')
        found[parsed[1]] = parsed[2].split()
    if not found:
        raise UsageError("no profile; give one at least, as in --profiles=default")
    return found


def _end_with_parent():
    LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGTERM)


def _call(arguments, run, suffix, what, options):
    log = run.parent / "egosieve_logs" / f"{run.name}{suffix}"
    log.parent.mkdir(parents=True, exist_ok=True)
    command = [options.program, *arguments, "--progress=none", f"--threads={options.threads}"]
    with open(log, "wb") as output:
        code = subprocess.run(command, stdout=output, stderr=output, stdin=subprocess.DEVNULL,
                              preexec_fn=_end_with_parent, check=False).returncode
    if code not in (0, FRAMES_FAILED):
        last = (log.read_text(errors="replace").strip().split("\n") or [""])[-1]
        raise InputError(f"{what} ended with code {code}: {last}; see {log}")


def _segment(sequence, flags, run, options):
    rate = rate_of(find_further_truth(sequence.frames))
    arguments = ["segment", str(sequence.frames), f"--out={run}", "--resume", *flags,
                 f"--fps={rate:g}"]
    if options.max_frames:
        arguments.append(f"--max_frames={options.max_frames}")
    _call([*arguments, *options.segment_flags.split()], run, ".log", "segmenting", options)
    if options.masks:
        _call(["refine", str(run)], run, ".masks.log", "making masks", options)


def _score(run, sequence, options):
    evaluation = Evaluation(run, sequence.truth, options)
    evaluation.write()
    scores, js = evaluation.eval, evaluation.masks.js
    further = score_further(run, find_further_truth(sequence.frames), options)
    return {**figures_of(scores), **{name: scores[name] for name in KEPT},
            "further": further,
            # Of each frame with movers: J of its mask, and what the map expects of it.
            "doubts": [(js[line.index], getattr(line, "expected_overlap", None))
                       for line in run.lines if line.index in js]}


def _run_sequence(sequence, profile, flags, options):
    """What suite.json has of it; with an error nothing follows."""
    entry = {"sequence": sequence.name, "group": sequence.name.split("/")[0], "profile": profile,
             "truth": str(sequence.truth), "error": None, "frames": 0, **figures_of({})}
    path = Path(options.out) / "runs" / profile / sequence.name
    try:
        _segment(sequence, flags, path, options)
        run = RunFolder(path)
        entry["frames"] = run.description["frames_answered"]
        return entry | _score(run, sequence, options)
    except (UsageError, InputError, OSError) as error:
        return entry | {"error": str(error)}


def _refuse_other_build(options):
    """Runs that are there already are scored as they are, so they must be of this program."""
    digest = hashlib.sha256(Path(options.program).read_bytes()).hexdigest()
    book = Path(options.out) / "program.sha256"
    if (Path(options.out) / "runs").exists() and (not book.exists() or book.read_text() != digest):
        raise UsageError(f"the runs in {options.out} are of another build of egosieve; give another --out")
    book.write_text(digest)


def run_suite(sequences, variants, options):
    """An entry per sequence and variant, variants within sequences.

    options: those of an evaluation; program, out, jobs, segment_flags, max_frames, masks, quiet.
    """
    _refuse_other_build(options)
    cores = len(os.sched_getaffinity(0))
    tasks = [(sequence, *variant) for sequence in sequences for variant in variants.items()]
    jobs = min(options.jobs or cores, len(tasks))
    options.threads = max(1, cores // jobs)
    with ProcessPoolExecutor(jobs, initializer=_end_with_parent) as pool:
        futures = [pool.submit(_run_sequence, *task, options) for task in tasks]
        try:
            for done, _ in enumerate(as_completed(futures), 1):
                if not options.quiet:
                    print(f"egosieve-eval: {done}/{len(tasks)} sequences", file=sys.stderr)
        except KeyboardInterrupt:
            pool.shutdown(cancel_futures=True)
            raise
        return [future.result() for future in futures]
