"""The command line of egosieve-eval."""

import argparse
import json
import os
import sys
from pathlib import Path

from .files import InputError, UsageError

EPILOG = """examples:
  egosieve-eval out/drive --truth=drive/masks
  egosieve-eval out/clip --boxes=boxes.csv
  egosieve-eval suite sequences --out=out/suite --profiles=default --against=old/suite.csv
  egosieve-eval suite streets --out=out/gaps --variant=gap=--set=frame_gap=1
  egosieve-eval folds out/old out/new out/newer --folds=5 --figure=mask_j

exit codes: 0 done, 1 the environment, 2 usage, 3 an input cannot be read, 4 some runs failed"""
MISSING = ("; on Debian: apt-get install python3-matplotlib python3-opencv python3-pandas "
           "python3-scipy python3-sklearn")
ROOT = Path(__file__).resolve().parents[2]


def _probability(text):
    if not 0 <= float(text) <= 1:
        raise argparse.ArgumentTypeError(f"{text} is not from 0 to 1")
    return float(text)


def _scoring():
    """The flags of runs and suites."""
    parser = argparse.ArgumentParser(add_help=False)
    add = parser.add_argument
    add("--pixels", choices=("grid", "full"), default="grid",
        help="grid: those of the maps; full: every one, after refine --what=probability")
    add("--with-prior", action="store_true",
        help="score the frames before the first that was learnt from, too")
    for name, value, text in (
            ("--threshold", 0.5, "probability from which a pixel is called moving"),
            ("--object-low", 0.25, "probability from which connected pixels are one object"),
            ("--object-high", 0.8, "probability that an object has somewhere"),
            ("--object-iou", 0.5, "IoU from which an object counts as found")):
        add(name, type=_probability, default=value, metavar="SHARE", help=text)
    add("--object-area", type=int, default=100, metavar="PIXELS",
        help="of the image, below which an object is not counted")
    add("--no-plots", dest="plots", action="store_false",
        help="no figures, and no page with them, plots/index.html")
    add("--json", action="store_true", help="print the result as a line of JSON")
    add("-q", "--quiet", action="store_true", help="no progress")
    return parser


def _parser(command):
    prog = f"egosieve-eval {command}".strip()
    parents = [] if command == "folds" else [_scoring()]
    parser = argparse.ArgumentParser(prog, parents=parents,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    {"suite": _suite_flags, "folds": _folds_flags}.get(command, _run_flags)(parser)
    return parser


def _run_flags(parser):
    parser.epilog = EPILOG
    parser.usage = ("egosieve-eval RUN... [flags]\n       egosieve-eval suite DIR --out=DIR "
                    "[flags]\n       egosieve-eval folds A B... [flags]")
    parser.description = ("Scores runs of egosieve against truth: writes eval.json, eval.csv and "
                          "further.json in their folders.")
    add = parser.add_argument
    add("runs", nargs="+", metavar="RUN", help="a run's folder")
    add("--truth", help="folder of masks (0 static, 128 void, else dynamic), a drive that "
        "synthesize wrote, or a file of labelled points (track,label,frame,x,y; label 1 static); "
        "default: what lies beside frames/")
    add("--boxes", metavar="FILE", help="boxes of things that move or stand "
        "(frame,id,type,x1,y1,x2,y2,moving ...); default: boxes.csv beside the frames")


def _suite_flags(parser):
    parser.description = ("Segments and scores the sequences of a folder, each with frames/ and "
                          "masks/, labels/, tracks.csv or a scene.json: suite.csv, .json and .md.")
    add = parser.add_argument
    add("folder", metavar="DIR", help="folder of sequences")
    add("-o", "--out", required=True, metavar="DIR",
        help="folder for the runs and tables; runs of the same program are used or continued")
    add("--profiles", default="default", metavar="NAMES", help="profiles of segment, by commas")
    add("--variant", action="append", default=[], metavar="NAME=FLAGS",
        help="one more way to segment: a name and flags, by spaces; may be repeated")
    add("--segment-flags", default="", metavar="FLAGS", help="further flags of segment, by spaces")
    add("-j", "--jobs", type=int, default=0, help="sequences at a time; default: one per core")
    add("--max-frames", type=int, default=0, help="of each sequence; 0: all")
    add("--no-masks", dest="masks", action="store_false",
        help="do not make masks of each run by refine, and score them")
    add("--against", metavar="TABLE", help="suite.csv of an old state: old and new side by side")
    add("--program", help="egosieve; default: $EGOSIEVE_PROGRAM, else the one beside this program")


def _folds_flags(parser):
    parser.description = ("Cross-validation: suites of candidates, the old state first. Per fold "
                          "of clips the candidate is chosen that is best on the others.")
    parser.add_argument("suites", nargs="+", metavar="SUITE", help="folder or suite.csv")
    parser.add_argument("--folds", type=int, default=5, help="number of folds; default: 5")
    parser.add_argument("--figure", default="mean_auc", help="column of suite.csv, more is better; default: mean_auc")


def _with_hyphens(argument):
    """Flags may have underscores, as those of egosieve."""
    name, equals, value = argument.partition("=")
    return name.replace("_", "-") + equals + value if name.startswith("--") else argument


def _program(given):
    beside, built = Path(sys.argv[0]).absolute().parent, ROOT / "bazel-bin" / "tools"
    there = [folder / "egosieve" for folder in (beside, built) if (folder / "egosieve").exists()]
    program = given or os.environ.get("EGOSIEVE_PROGRAM") or next(iter(there), "egosieve")
    if os.access(program, os.X_OK):
        return str(Path(program).absolute())
    raise InputError("there is no egosieve to segment with; give --program=FILE")


def _tell(options, fields, text):
    if options.json:
        print(json.dumps({"command": "evaluate", "schema_version": 1, **fields}))
    else:
        print(text, end="")


def _score_run(path, options):
    from .box_scores import box_table
    from .evaluation import Evaluation
    from .files import to_json, write_file
    from .further import camera_table, find_further_truth, score_further
    from .run_folder import RunFolder
    from .sequences import truth_in

    run = RunFolder(path)
    run.scorable_lines()
    known = find_further_truth(run.input) | ({"boxes": options.boxes} if options.boxes else {})
    further = score_further(run, known, options)
    beside = truth_in(run.input.parent) if run.input.name == "frames" else None
    truth = options.truth or beside
    if not truth and not further:
        raise UsageError("--truth is missing, and no other truth lies beside the frames; give "
                         "masks, tracks or --boxes to score against")
    fields = {"run": str(run.path.absolute()), "further": further or None}
    text = f"{path}:\n" if len(options.runs) > 1 else ""
    if further:
        text += box_table([further["boxes"]]) if "boxes" in further else ""
        text += camera_table([({"run": path}, further)])
        write_file(run.path / "further.json", to_json(further))
    if truth:
        evaluation = Evaluation(run, truth, options)
        evaluation.write()
        names = ("truth", "pooled_auc", "mean_auc", "frames_scored")
        fields |= {name: evaluation.eval[name] for name in names}
        fields["scores"] = str((run.path / "eval.json").absolute())
        text += evaluation.table()
        if options.plots:
            from .plots import write_run_page
            page = write_run_page(run.path / "plots", evaluation.eval, evaluation.table())
            print(f"plots: {page}", file=sys.stderr)
    _tell(options, fields, text)


def _score_runs(options):
    for path in options.runs:
        _score_run(path, options)
    return 0


def _run_suite(options):
    from . import suite, table
    from .files import to_json, write_file
    from .sequences import find_sequences

    options.program = _program(options.program)
    variants = suite.parse_variants(options.profiles, options.variant)
    old = table.read_table(options.against) if options.against else None
    sequences, without_truth = find_sequences(options.folder)
    out = Path(options.out)
    out.mkdir(parents=True, exist_ok=True)
    entries = suite.run_suite(sequences, variants, options)
    frame = table.to_frame(entries)
    results = table.to_json(entries, frame, without_truth)
    frame.to_csv(out / "suite.csv", index=False, float_format="%.6f")
    write_file(out / "suite.json", to_json(results))
    markdown = table.to_markdown(entries, frame)
    write_file(out / "suite.md", markdown)
    text = table.summary(entries, frame, without_truth)
    parts = [text + table.further_tables(entries), markdown]
    if old is not None:
        parts.append(table.compare(old, frame))
    _tell(options, {"sequences": len(sequences), "failed": results["failed"],
                    "scores": str(out / "suite.json")}, "\n".join(parts))
    if options.plots:
        from .plots import write_suite_page
        print(f"plots: {write_suite_page(out / 'plots', frame, text)}", file=sys.stderr)
    return 4 if results["failed"] else 0


def _report_folds(options):
    from .folds import read_candidates, report

    values = read_candidates(options.suites, options.figure)
    print(report(values, options.figure, options.folds)[0], end="")
    return 0


def main(arguments=None):
    arguments = [_with_hyphens(a) for a in (sys.argv[1:] if arguments is None else arguments)]
    command = arguments[0] if arguments and arguments[0] in ("suite", "folds") else ""
    options = _parser(command).parse_args(arguments[1:] if command else arguments)
    try:
        if command != "folds" and options.object_low > options.object_high:
            raise UsageError("--object-low is above --object-high")
        return {"suite": _run_suite, "folds": _report_folds}.get(command, _score_runs)(options)
    except (UsageError, InputError, OSError, ModuleNotFoundError) as error:
        hint = MISSING if isinstance(error, ModuleNotFoundError) else ""
        print(f"egosieve-eval: {error}{hint}", file=sys.stderr)
        return getattr(error, "code", 1)
    except KeyboardInterrupt:
        return 130
