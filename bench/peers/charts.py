"""The tables and the plot of peers.py, from its record and nothing else."""

import matplotlib
import numpy as np
import pandas
from common import markdown

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

TITLES = {
    "predict": ("Mean and variance of {queries:,} queries", "queries/s"),
    "mean": ("Mean alone of {queries:,} queries", "queries/s"),
    "joint": ("Mean and joint covariance of {joint_queries:,} queries", "s"),
    "fit": ("Fit at given hyperparameters until the first prediction", "s"),
    "samples": ("1,000 samples of f at {joint_queries:,} queries, the covariance among what is timed", "s"),
    "replace": ("64 points replaced, then mean and variance at 256 queries; libraries without updates fit anew", "s"),
    "append": ("64 points appended, likewise; GPyTorch fast_pred_var by fantasy models", "s"),
}
OWN = "egosieve"


def _cases(record):
    """A row per case, the covariances first, then dimensions and points; a column per library, egosieve first: its results."""
    cases = pandas.DataFrame(record["cases"])
    cases["varied"] = (cases.points != 1000) | (cases.dimension != 6)
    cases["turn"] = cases.dimension.where(cases.dimension != 6, 0)
    cases = cases.sort_values(["varied", "turn", "points"], kind="stable")
    keys = pandas.MultiIndex.from_frame(cases[["covariance", "points", "dimension"]])
    results = pandas.DataFrame(list(cases.results), index=keys)
    return results[[OWN, *results.columns.drop(OWN)]]


def _each(results, read):
    """What is read of each library's results; without empty rows and columns."""
    found = results.applymap(lambda result: read(result) if isinstance(result, dict) else None)
    return found.dropna(how="all").dropna(how="all", axis=1)


def _seconds(results, task):
    """NaN where a library lacks the task."""
    return _each(results, lambda result: result.get("seconds", {}).get(task)).astype(float)


def _table(title, cells, right):
    side = ">" * right
    columns = ["covariance", ">n", ">D", *(side + name for name in cells.columns)]
    return f"## {title}\n\n" + markdown(columns, [[*key, *row] for key, row in zip(cells.index, cells.fillna("").to_numpy())])


def _ratio(value):
    return f"{value:.1f}" if value < 100 else f"{value:,.0f}"


def _times(results, task, unit):
    """egosieve's own time or rate, and how many times as long the others take."""
    seconds = _seconds(results, task)
    cells = seconds.drop(columns=OWN).div(seconds[OWN], axis=0).applymap(_ratio, na_action="ignore")
    own = seconds[OWN].map(lambda s: f"{1 / s:,.0f}" if unit == "queries/s" else f"{s:.3g}")
    cells.insert(0, f"{OWN}, {unit}", own)
    return cells


def _errors(result):
    return f"{result['mean_error']:.0e}, {result['variance_error']:.0e}" if "mean_error" in result else None


def tables(record):
    """Markdown."""
    results, cases = _cases(record), record["cases"]
    loads = [case["machine"]["load"] for case in cases]
    own = (item for case in cases for item in case["results"].items() if "version" in item[1])
    versions = dict.fromkeys(f"{name} {result['version']} ({result['precision']})" for name, result in own)
    text = (
        f"Exact posteriors of f, medians of {record['rounds']} rounds in one run, two cores, "
        f"{cases[0]['machine']['processor']}, load {min(loads):.1f} to {max(loads):.1f}. Under a library's name: how many "
        "times as long as egosieve it takes; empty: it does not have that. Joint covariances, samples and fits are float64 "
        f"in egosieve, all else is as listed.\n\n{', '.join(versions)}.\n\n"
    )
    parts = ["\n".join(f"{name} is absent: {why}" for name, why in record["absent"].items())] if record["absent"] else []
    for task, (title, unit) in TITLES.items():
        if not _seconds(results, task).empty:
            parts.append(_table(title.format(**record), _times(results, task, unit), True))
    note = "Largest errors of mean and of variance\n\nOf 256 queries, against the same covariance's posterior in float64."
    parts.append(_table(note, _each(results, _errors), False))
    memory = _each(results, lambda result: result.get("peak_mib")).applymap("{:,.0f}".format, na_action="ignore")
    parts.append(_table("Memory\n\nPeak of the process in MiB.", memory, True))
    return text + "\n".join(parts)


def draw(record, path):
    """How many times as long as egosieve each peer takes for mean and variance."""
    seconds = _seconds(_cases(record), "predict")[::-1]
    names = [f"{covariance}, n = {points}, D = {dimension}" for covariance, points, dimension in seconds.index]
    fig, axes = plt.subplots(figsize=(8, 5), constrained_layout=True)
    for peer in seconds.columns.drop(OWN):
        axes.semilogx(seconds[peer] / seconds[OWN], np.arange(len(names)), "o", label=peer)
    axes.set_yticks(np.arange(len(names)), names)
    axes.grid(axis="x")
    axes.set_title("time for mean and variance, in that of egosieve")
    axes.legend()
    fig.savefig(path, metadata={"Date": None})
    plt.close(fig)
