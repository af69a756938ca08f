"""The command line of egosieve-eval."""

import argparse
import json
import os
import shutil
import sys
from pathlib import Path

from .errors import InputError, UsageError

EPILOG = """examples:
  egosieve-eval out/drive --truth=drive/masks
  egosieve-eval out/clip --boxes=boxes.csv
  egosieve-eval suite sequences --out=out/suite --profiles=default --against=old/suite.csv
  egosieve-eval suite streets --out=out/terms --variant=line=--set=evidence=epipolar
  egosieve-eval folds out/old out/new out/newer --folds=5 --figure=mask_j

exit codes: 0 done, 1 the environment, 2 usage, 3 an input cannot be read, 4 some runs failed"""
ROOT = Path(__file__).resolve().parents[2]


def _probability(text):
    if not 0 <= float(text) <= 1:
        raise argparse.ArgumentTypeError(f"{text} is not from 0 to 1")
    return float(text)


def _from_zero(kind):
    def parse(text):
        if kind(text) < 0:
            raise argparse.ArgumentTypeError(f"{text} is negative")
        return kind(text)
    return parse


def _add_scoring(parser):
    add = parser.add_argument
    add("--poses-fps", type=float, default=10.0, metavar="RATE",
        help="rows of the poses per second, where no camera.json gives it")
    add("--true-camera", metavar="FILE", help="the true lens, as in a run's camera.json; "
        "default: camera.json beside the frames")
    add("--pixels", choices=("grid", "full"), default="grid",
        help="grid: those of the maps; full: every one, after refine")
    add("--match", choices=("auto", "name", "number", "order"), default="auto",
        help="how truth finds its frames")
    add("--with-prior", action="store_true",
        help="score the frames before the first that was learnt from, too")
    add("--threshold", type=_probability, default=0.5, metavar="P",
        help="probability from which a pixel is called moving")
    add("--object-low", type=_probability, default=0.25, metavar="P",
        help="probability from which connected pixels are one object")
    add("--object-high", type=_probability, default=0.8, metavar="P",
        help="probability that an object has somewhere")
    add("--object-iou", type=_probability, default=0.5, metavar="IOU",
        help="IoU from which an object counts as found")
    add("--object-area", type=_from_zero(int), default=100, metavar="PIXELS",
        help="of the image, below which an object is not counted")
    add("--no-plots", dest="plots", action="store_false",
        help="no figures, and no page with them, plots/index.html")
    add("--json", action="store_true", help="print the result as a line of JSON")
    add("-q", "--quiet", action="store_true", help="no progress")


def _parser(command):
    make = {"suite": _suite_parser, "folds": _folds_parser}.get(command, _run_parser)
    parser = make()
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    return parser


def _run_parser():
    parser = argparse.ArgumentParser(
        "egosieve-eval", epilog=EPILOG, usage="egosieve-eval RUN... [flags]\n       egosieve-eval "
        "suite DIR --out=DIR [flags]\n       egosieve-eval folds A B... [flags]",
        description="Scores runs of egosieve against truth: writes eval.json, eval.csv and "
        "further.json in their folders.")
    parser.add_argument("runs", nargs="+", metavar="RUN", help="a run's folder")
    parser.add_argument("--truth", help="folder of masks (0 static, 128 void, else dynamic), a "
                        "drive that synthesize wrote, or a file of labelled points (track,label,"
                        "frame,x,y; label 1 static); default: what lies beside frames/")
    parser.add_argument("--boxes", metavar="FILE", help="boxes of things that move or stand "
                        "(frame,id,type,x1,y1,x2,y2,moving ...); default: boxes.csv beside the "
                        "frames")
    parser.add_argument("--poses", metavar="FILE", help="the camera's true poses, 12 numbers per "
                        "frame; default: poses.txt beside the frames")
    _add_scoring(parser)
    return parser


def _suite_parser():
    parser = argparse.ArgumentParser(
        "egosieve-eval suite", description="Segments and scores the sequences of a folder, each "
        "with frames/ and masks/, labels/, tracks.csv or a scene.json: suite.csv, .json and .md.")
    add = parser.add_argument
    add("folder", metavar="DIR", help="folder of sequences")
    add("-o", "--out", required=True, metavar="DIR",
        help="folder for the runs and tables; existing runs are used or continued")
    add("--profiles", default="default", metavar="NAMES", help="profiles of segment, by commas")
    add("--variant", action="append", default=[], metavar="NAME=FLAGS",
        help="one more way to segment: a name and flags, by spaces; may be repeated")
    add("--segment-flags", default="", metavar="FLAGS", help="further flags of segment, by spaces")
    add("-j", "--jobs", type=_from_zero(int), default=0,
        help="sequences at a time; 0: one per core")
    add("--max-seconds", type=_from_zero(float), default=0.0, help="of each sequence; 0: all")
    add("--max-frames", type=_from_zero(int), default=0, help="of each sequence; 0: all")
    add("--no-masks", dest="masks", action="store_false",
        help="do not make masks of each run by refine, and score them")
    add("--against", metavar="TABLE", help="suite.csv of an old state: old and new side by side")
    add("--program", help="egosieve; default: $EGOSIEVE_PROGRAM, else the one beside this program")
    _add_scoring(parser)
    return parser


def _folds_parser():
    parser = argparse.ArgumentParser(
        "egosieve-eval folds", description="Cross-validation: suites of candidates, the old state "
        "first. Per fold of clips the candidate is chosen that is best on the others.")
    parser.add_argument("suites", nargs="+", metavar="SUITE", help="folder or suite.csv")
    parser.add_argument("--folds", type=int, default=5)
    parser.add_argument("--figure", default="mean_auc", help="column of suite.csv; more is better")
    return parser


def _with_hyphens(argument):
    """Flags may have underscores, as those of egosieve."""
    name, equals, value = argument.partition("=")
    return name.replace("_", "-") + equals + value if name.startswith("--") else argument


def _program(given):
    if not (given := given or os.environ.get("EGOSIEVE_PROGRAM")):
        beside = Path(sys.argv[0]).absolute().parent / "egosieve"
        places = (beside, ROOT / "bazel-bin" / "tools" / "egosieve", shutil.which("egosieve") or beside)
        given = next((place for place in places if os.access(place, os.X_OK)), beside)
    if os.access(given, os.X_OK):
        return str(Path(given).absolute())
    raise InputError("there is no egosieve to segment with; give --program=FILE")


def _tell(options, fields, text):
    if options.json:
        print(json.dumps({"command": "evaluate", "schema_version": 1, **fields}))
    else:
        print(text, end="")


def _score_run(path, options):
    from .evaluation import Evaluation
    from .further import find_further_truth, score_further
    from .run_folder import RunFolder
    from .sequences import truth_in
    from .texts import to_json, write_file

    run = RunFolder(path)
    run.scorable_lines()
    given = {"boxes": options.boxes, "poses": options.poses, "camera": options.true_camera}
    given = {name: Path(file) for name, file in given.items() if file}
    further = score_further(run, find_further_truth(run.input) | given, options)
    frames = Path(run.input)
    truth = options.truth or (truth_in(frames.parent) if frames.name == "frames" else None)
    if not truth and further.is_empty():
        raise UsageError("--truth is missing, and no other truth lies beside the frames; give "
                         "masks, tracks or --boxes to score against")
    fields, text = {"run": str(run.path.absolute()), "further": None}, ""
    if not further.is_empty():
        fields["further"], text = further.to_json(), further.table()
        write_file(run.file("further.json"), to_json(fields["further"]))
    if truth:
        evaluation = Evaluation(run, truth, options)
        evaluation.write()
        scores = evaluation.scores
        fields |= {"truth": str(evaluation.truth.path), "pooled_auc": scores.pooled.auc(),
                   "mean_auc": scores.mean("auc"), "frames_scored": len(scores.frames),
                   "scores": str(run.file("eval.json").absolute())}
        text += evaluation.table()
        if options.plots:
            from .pages import write_run_page
            print(f"plots: {write_run_page(evaluation)}", file=sys.stderr)
    _tell(options, fields, text)


def _score_runs(options):
    for path in options.runs:
        if len(options.runs) > 1 and not options.json:
            print(f"{path}:")
        _score_run(path, options)
    return 0


def _run_suite(options):
    from . import suite, table
    from .folds import read_table
    from .sequences import find_sequences
    from .texts import to_json, write_file

    options.program = _program(options.program)
    variants = suite.parse_variants(options.profiles, options.variant)
    old = read_table(options.against) if options.against else None
    sequences, without_truth = find_sequences(options.folder)
    runs = len(sequences) * len(variants)
    options.jobs = min(options.jobs or suite.cores(), runs)
    options.threads = max(1, suite.cores() // options.jobs)
    out = Path(options.out)
    out.mkdir(parents=True, exist_ok=True)
    done = 0

    def after_run():
        nonlocal done
        done += 1
        if not options.quiet:
            print(f"egosieve-eval: {done}/{runs} sequences", file=sys.stderr)

    results = suite.run_suite(sequences, variants, options, after_run)
    frame = table.to_frame(results)
    frame.to_csv(out / "suite.csv", index=False, float_format="%.6f")
    write_file(out / "suite.json", to_json(table.to_json(results, frame, without_truth)))
    markdown = table.to_markdown(results, frame)
    write_file(out / "suite.md", markdown)
    text = table.summary(results, frame, without_truth)
    failed = sum(bool(r.error) for r in results)
    parts = [text + table.object_tables(results) + table.further_tables(results), markdown]
    if old is not None:
        parts.append(table.compare(old, frame))
    _tell(options, {"sequences": len(sequences), "failed": failed,
                    "scores": str(out / "suite.json")}, "\n".join(parts))
    if options.plots:
        from .pages import write_suite_page
        print(f"plots: {write_suite_page(out / 'plots', results, frame, text)}", file=sys.stderr)
    return 4 if failed else 0


def _report_folds(options):
    from .folds import read_candidates, report

    if options.folds < 2:
        raise UsageError(f"--folds={options.folds}; there must be at least 2")
    text, _ = report(read_candidates(options.suites, options.figure), options.figure, options.folds)
    print(text, end="")
    return 0


def main(arguments=None):
    arguments = [_with_hyphens(a) for a in (sys.argv[1:] if arguments is None else arguments)]
    command = arguments[0] if arguments and arguments[0] in ("suite", "folds") else ""
    options = _parser(command).parse_args(arguments[1:] if command else arguments)
    try:
        if not command or command == "suite":
            if options.object_low > options.object_high:
                raise UsageError("--object-low is above --object-high")
        return {"suite": _run_suite, "folds": _report_folds}.get(command, _score_runs)(options)
    except (UsageError, InputError) as error:
        print(f"egosieve-eval: {error}", file=sys.stderr)
        return error.code
    except ModuleNotFoundError as error:
        print(f"egosieve-eval: {error}; on Debian: apt-get install python3-matplotlib "
              "python3-opencv python3-pandas python3-scipy python3-sklearn", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"egosieve-eval: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
