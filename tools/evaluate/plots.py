"""The pages of figures of a run and of a suite: index.html and an SVG per figure, by matplotlib."""

import html
import json
from functools import partial

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

from .drive_scores import THRESHOLDS  # noqa: E402
from .figures import value_at  # noqa: E402

STYLE = """body{font:16px/1.45 sans-serif;margin:2em auto;max-width:84em;padding:0 1em;color:#222}
figure{margin:2em 0;border-top:1px solid #ccc;padding-top:1em}figure img{max-width:100%}
figcaption{max-width:60em}pre{font-size:11px;overflow-x:auto;background:#f6f6f6;padding:1em}"""
# Of a run, by name: place in eval.json; title; names of the axes; lines (x, y) of the data there;
# caption.
OF_RUN = {
    "roc": (
        "scores/curve_threshold_fpr_recall_precision", "Receiver operating characteristic",
        ("false-positive rate", "recall"), lambda curve: [curve.T[1:3], DIAGONAL],
        "Share of the dynamic pixels that are called dynamic (recall) against the share of the "
        "static ones that are, as the threshold falls; all scored pixels together. Higher is "
        "better; the diagonal is guessing."),
    "precision_recall": (
        "scores/curve_threshold_fpr_recall_precision", "Precision and recall",
        ("recall", "precision"), lambda curve: [curve.T[2:4]],
        "Share of the pixels called dynamic that are (precision) against the share of the dynamic "
        "pixels that are found (recall); all scored pixels together. Higher is better."),
    "iou_by_threshold": (
        "scores/mean_iou_at_0.05_to_0.95", "IoU by threshold", ("threshold", "mean IoU"),
        lambda ious: [(THRESHOLDS, ious)],
        "Mean over the frames with movers of the intersection over union, when pixels from this "
        "probability on are called dynamic."),
    "reliability": (
        "scores/calibration/reliability", "Reliability of the probabilities",
        ("stated probability", "share that is dynamic"),
        lambda bins: [np.transpose([(b["mean_stated"], b["positive_share"]) for b in bins
                                    if b["pixels"]]), DIAGONAL],
        "Of the pixels whose stated probability falls into a bin, the share that is dynamic, "
        "against the mean stated probability. On the diagonal probabilities mean what they say; "
        "below it they are too high."),
    "sparsification": (
        "scores/uncertainty/sparsification", "Does the deviation know where the map is wrong?",
        ("share taken away", "remaining error"), lambda curve: [curve.T[[0, 1]], curve.T[[0, 2]]],
        "Mean error of the pixels that remain when those with the largest deviation are taken "
        "away, as a share of the mean error of all; dashed, when those with the largest error are. "
        "The nearer to the dashed line, the better; flat is guessing."),
    "auc_by_frame": (
        "frames", "AUC by frame", ("frame", "AUC"),
        lambda frames: [np.transpose([(frame["index"], frame["auc"]) for frame in frames])],
        "Area under the ROC curve of each frame alone. Frames whose truth has one class have "
        "none."),
}
DIAGONAL = [0, 1], [0, 1]


def _draw(axes, lines, title, names):
    """The second line is dashed."""
    for (x, y), style in zip(lines, (".-", "--")):
        axes.plot(x, np.array(y, float), style)
    axes.set(title=title, xlabel=names[0], ylabel=names[1])


def _write_page(folder, title, paragraph, table, figures):
    """figures: (name, caption, what draws it on axes). figures.json has the names of all."""
    folder.mkdir(parents=True, exist_ok=True)
    page = (f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
            f"<style>{STYLE}</style></head><body><h1>{title}</h1>\n<p>{html.escape(paragraph)}</p>"
            f"\n<pre>{html.escape(table)}</pre>\n")
    for name, caption, draw in figures:
        fig, axes = plt.subplots(figsize=(9, 4.8), constrained_layout=True)
        draw(axes)
        axes.grid(color="#dddddd", linewidth=0.6)
        axes.set_axisbelow(True)
        fig.savefig(folder / f"{name}.svg", metadata={"Date": None})
        plt.close(fig)
        page += (f'<figure><img src="{name}.svg"><figcaption>{html.escape(caption)}'
                 "</figcaption></figure>\n")
    (folder / "figures.json").write_text(json.dumps([name for name, _, _ in figures]) + "\n")
    (folder / "index.html").write_text(page + "</body></html>\n", encoding="utf-8")
    return folder / "index.html"


def write_run_page(folder, evaluation, text):
    """plots/ in the run's folder. evaluation: eval.json."""
    paragraph = ("Scored against {truth} ({truth_kind}, matched by {matched_by}); pixels: "
                 "{pixels}; {frames_scored} frames.").format(**evaluation)
    figures = []
    for name, (place, title, axes, lines_of, caption) in OF_RUN.items():
        if data := value_at(place, evaluation):
            lines = lines_of(data if isinstance(data[0], dict) else np.array(data))
            figures.append((name, caption, partial(_draw, lines=lines, title=title, names=axes)))
    return _write_page(folder, "Evaluation of a run", paragraph, text, figures)


def write_suite_page(folder, table, text):
    """Bars by sequence and profile of the table of a suite."""
    def bars(figure, title, caption):
        values = table.pivot(index="sequence", columns="profile", values=figure)
        return f"by_sequence_{figure}", caption, lambda axes: values.plot.bar(
            ax=axes, title=title, ylabel=title, xlabel="", ylim=(0, 1), width=0.8)

    figures = [bars("mean_auc", "AUC",
                    "Mean over frames of the area under the ROC curve; 0.5 is guessing."),
               bars("mean_iou", "mean IoU, declared threshold",
                    "Mean over the frames with movers of the intersection over union, when pixels "
                    "from the declared threshold on are called dynamic. No bar: 0, or none.")]
    return _write_page(folder, "Egosieve on many sequences", "", text, figures)
