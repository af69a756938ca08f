"""Runs many sequences with several variants of segment, such as profiles, and scores them.

    out/runs/VARIANT/NAME       the run folder; an existing one is continued or used as it is
    out/runs/VARIANT/egosieve_logs/NAME.log   output of segmenting; NAME.masks.log: of refine

Each sequence is segmented by a process of its own with its share of the cores; all of them end with
this program. The order of the results does not depend on durations.
"""

import ctypes
import os
import re
import signal
import subprocess
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path

from .drive_scores import DriveScores
from .errors import InputError, UsageError
from .evaluation import Evaluation
from .further import FurtherScores, find_further_truth, score_further
from .objects import ObjectTally
from .run_folder import RunFolder
from .sequences import Sequence
from .trajectory import read_camera

NOMINAL_RATE = 10.0  # frames per second of a folder of images, as for segment
FRAMES_FAILED = 4  # exit code: a few unreadable frames do not prevent scoring of the others
LIBC = ctypes.CDLL(None)
PR_SET_PDEATHSIG = 1

# Columns of the table: name in files, heading, value of an evaluation.
FIGURES = {
    "mean_auc": ("AUC", lambda e: e.scores.mean("auc")),
    "pooled_auc": ("pooled", lambda e: e.scores.pooled.auc()),
    "mean_average_precision": ("AP", lambda e: e.scores.mean("average_precision")),
    "mean_iou": ("IoU", lambda e: e.scores.mean("iou")),
    "mean_f": ("F", lambda e: e.scores.mean("f")),
    "mean_iou_best_threshold": ("IoU best", lambda e: max(e.scores.mean_ious(), default=None)),
    "mean_boundary_f": ("bound. F", lambda e: e.scores.mean("boundary_f")),
    "object_recall": ("recall", lambda e: e.scores.objects.recall()),
    "false_objects_per_frame": ("false o.", lambda e: e.scores.objects.false_per_frame()),
    "expected_calibration_error": (
        "ECE", lambda e: e.scores.pooled.calibration()["expected_calibration_error"]),
    "brier": ("Brier", lambda e: e.scores.mean("brier")),
    "log_loss": ("log loss", lambda e: e.scores.mean("log_loss")),
    "area_under_sparsification_error": ("AUSE", lambda e: e.scores.uncertainty.ause()),
    "error_auc": ("err. AUC", lambda e: e.scores.uncertainty.error_auc()),
    "class_error_auc": ("by class", lambda e: e.scores.class_uncertainty.error_auc()),
    "mask_j": ("mask J", lambda e: e.mask_figures["j"]),
    "mask_boundary_f": ("mask F", lambda e: e.mask_figures["boundary_f"]),
    "mask_temporal_instability": ("mask T", lambda e: e.mask_figures["temporal_instability"]),
    "truth_temporal_instability": (
        "true T", lambda e: e.mask_figures["temporal_instability_of_truth"]),
    "mask_object_recall": ("m. rec.", lambda e: e.masks.objects.recall(0.5)),
    "mask_false_objects_per_frame": ("m. false", lambda e: e.masks.objects.false_per_frame()),
    "idf1": ("IDF1", lambda e: (e.mask_figures["identity"] or {}).get("idf1")),
    "hota": ("HOTA", lambda e: (e.mask_figures["identity"] or {}).get("hota")),
    "seconds_per_frame": ("s/frame", lambda e: _seconds_per_frame(e.run)),
}


@dataclass
class Result:
    sequence: Sequence
    profile: str  # name of the variant
    error: str = ""  # of segmenting or evaluating; the fields below are then empty
    frames: int = 0  # of the run
    figures: dict = field(default_factory=lambda: dict.fromkeys(FIGURES))
    kind: str = ""  # of the truth
    pixels: str = ""
    scores: DriveScores = None
    masks: ObjectTally = None  # the objects of the masks
    doubts: list = field(default_factory=list)  # frames of doubt.py
    further: FurtherScores = field(default_factory=FurtherScores)


def parse_variants(profiles, variants):
    """{name: flags of segment}: the profiles, named by commas, then "NAME=FLAGS"."""
    pairs = [(name, [f"--profile={name}"]) for name in profiles.split(",") if name]
    for text in variants:
        parsed = re.fullmatch(r"([\w+-]+)=(.*)", text, re.ASCII | re.DOTALL)
        if not parsed:
            raise UsageError(f'variant "{text}" is not NAME=FLAGS, NAME of letters, digits, _, - '
                             'and +; write, say, "line=--set=evidence=epipolar"')
        pairs.append((parsed[1], parsed[2].split()))
    names = [name for name, _ in pairs]
    if not names:
        raise UsageError("no profile; give one at least, as in --profiles=default")
    if twice := [name for name in names if names.count(name) > 1]:
        raise UsageError(f"two variants have the name {twice[0]}; give each its own")
    return dict(pairs)


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


def rate_of(sequence):
    """Frames per second, from camera.json beside the frames."""
    camera = find_further_truth(sequence.frames).get("camera")
    rate = read_camera(camera).get("frames_per_second", 0) if camera else 0
    return rate if rate > 0 else NOMINAL_RATE


def _segment(sequence, flags, run, options):
    rate = rate_of(sequence)
    arguments = ["segment", str(sequence.frames), f"--out={run}", "--resume", *flags,
                 f"--fps={rate:g}"]
    limits = [options.max_frames] if options.max_frames else []
    if options.max_seconds:
        limits.append(max(1, round(options.max_seconds * rate)))
    if limits:
        arguments.append(f"--max_frames={min(limits)}")
    _call([*arguments, *options.segment_flags.split()], run, ".log", "segmenting", options)
    if options.masks:
        _call(["refine", str(run)], run, ".masks.log", "making masks", options)


def _seconds_per_frame(run):
    frames = run.description["frames_answered"]
    return run.description["seconds"] / frames if frames else None


def _score(run, sequence, options, result):
    result.frames = run.description["frames_answered"]
    evaluation = Evaluation(run, sequence.truth, options)
    evaluation.write()
    truth = find_further_truth(sequence.frames)
    if "poses" in truth and options.true_camera:
        truth.setdefault("camera", options.true_camera)
    result.further = score_further(run, truth, options)
    result.figures = {name: value(evaluation) for name, (_, value) in FIGURES.items()}
    result.kind, result.pixels = evaluation.truth.kind, evaluation.pixels
    result.scores, result.masks = evaluation.scores, evaluation.masks.objects
    result.doubts = [(evaluation.masks.js[line.index], line.expected_overlap)
                     for line in run.lines if line.index in evaluation.masks.js]


def _run_sequence(sequence, profile, flags, options):
    result = Result(sequence, profile)
    path = Path(options.out) / "runs" / profile / sequence.name
    try:
        _segment(sequence, flags, path, options)
        _score(RunFolder(path), sequence, options, result)
    except (UsageError, InputError, OSError) as error:
        result.error = str(error)
    return result


def run_suite(sequences, variants, options, after_run):
    """A result per sequence and variant, variants within sequences. after_run: called after each.

    options: those of an evaluation; program, out, jobs, threads, segment_flags, max_frames,
    max_seconds, masks, true_camera.
    """
    tasks = [(sequence, *variant) for sequence in sequences for variant in variants.items()]
    with ProcessPoolExecutor(options.jobs, initializer=_end_with_parent) as pool:
        futures = [pool.submit(_run_sequence, *task, options) for task in tasks]
        try:
            for _ in as_completed(futures):
                after_run()
        except KeyboardInterrupt:
            pool.shutdown(cancel_futures=True)
            raise
        return [future.result() for future in futures]


def cores():
    return len(os.sched_getaffinity(0))
