"""The pages of figures of a run and of a suite."""

from .drive_scores import THRESHOLDS
from .plots import write_page

UNIT = (0, 1)


def score_figures(scores):
    """scores: DriveScores by name."""
    def figure(name, title, caption, labels, columns, **more):
        """columns: (x, y) of a series from scores, or several by a suffix of its name."""
        series = []
        for own, drive in scores.items():
            found = columns(drive)
            for suffix, style, x, y in found if isinstance(found, list) else [("", "line", *found)]:
                series.append({"name": own + suffix, "style": style, "x": list(x), "y": list(y)})
        return {"id": name, "title": title, "caption": caption, "x_label": labels[0],
                "y_label": labels[1], "series": series, **more}

    def curve(x, y):
        return lambda drive: (([row[x] for row in drive.pooled.curve()],
                               [row[y] for row in drive.pooled.curve()]))

    def reliability(drive):
        bins = [b for b in drive.pooled.calibration()["reliability"] if b["pixels"]]
        return [b["mean_stated"] for b in bins], [b["positive_share"] for b in bins]

    def sparsification(drive):
        removed, ranked, oracle = zip(*(drive.uncertainty.curve() or [(0, None, None)]))
        return [("", "line", removed, ranked), (", by error", "dashed", removed, oracle)]

    return [
        figure("roc", "Receiver operating characteristic",
               "Share of the dynamic pixels that are called dynamic (recall) against the share of "
               "the static ones that are, as the threshold falls; all scored pixels together. "
               "Higher is better; the dotted diagonal is guessing.",
               ("false-positive rate", "recall"), curve(1, 2), x_range=UNIT, y_range=UNIT,
               diagonal=True),
        figure("precision_recall", "Precision and recall",
               "Share of the pixels called dynamic that are (precision) against the share of the "
               "dynamic pixels that are found (recall); all scored pixels together. Higher is "
               "better.", ("recall", "precision"), curve(2, 3), x_range=UNIT, y_range=UNIT),
        figure("iou_by_threshold", "IoU by threshold",
               "Mean over the frames with movers of the intersection over union, when pixels from "
               "this probability on are called dynamic.", ("threshold", "mean IoU"),
               lambda drive: (THRESHOLDS[:len(drive.mean_ious())], drive.mean_ious()),
               x_range=UNIT),
        figure("reliability", "Reliability of the probabilities",
               "Of the pixels whose stated probability falls into a bin, the share that is "
               "dynamic, against the mean stated probability. On the dotted diagonal probabilities "
               "mean what they say; below it they are too high.",
               ("stated probability", "share that is dynamic"), reliability, x_range=UNIT,
               y_range=UNIT, diagonal=True),
        figure("sparsification", "Does the deviation know where the map is wrong?",
               "Mean error of the pixels that remain when those with the largest deviation are "
               "taken away, as a share of the mean error of all; dashed, when those with the "
               "largest error are. The nearer to the dashed line, the better; flat is guessing.",
               ("share taken away", "remaining error"), sparsification, x_range=UNIT),
    ]


def write_run_page(evaluation):
    """plots/ in the run's folder."""
    frames = evaluation.scores.frames
    by_frame = {"id": "auc_by_frame", "title": "AUC by frame", "x_label": "frame", "y_label": "AUC",
                "caption": "Area under the ROC curve of each frame alone. Frames whose truth has "
                           "one class have none.",
                "series": [{"name": "map", "x": [frame["index"] for frame in frames],
                            "y": [frame["auc"] for frame in frames]}]}
    truth = evaluation.truth
    paragraph = (f"Scored against {truth.path} ({truth.kind}, matched by {truth.matched_by}); "
                 f"pixels: {evaluation.pixels}; {len(frames)} frames.")
    folder = evaluation.run.file("plots")
    write_page(folder, "Evaluation of a run", paragraph, evaluation.table(),
               [*score_figures({"map": evaluation.scores}), by_frame])
    return folder / "index.html"


def write_suite_page(folder, results, table, text):
    def bars(name, title, caption):
        sequences = list(dict.fromkeys(table.sequence))
        series = [{"name": profile, "style": "bars", "x": list(range(len(sequences))),
                   "y": rows.set_index("sequence")[name].reindex(sequences)
                        .astype(object).where(lambda v: v.notna(), None).tolist()}
                  for profile, rows in table.groupby("profile", sort=False)]
        return {"id": f"by_sequence_{name}", "title": title, "caption": caption, "x_label": "",
                "y_label": title, "categories": sequences, "series": series, "y_range": UNIT}

    pooled = {}
    for r in results:
        if r.scores and r.kind != "tracks":
            if r.profile in pooled:
                pooled[r.profile].merge(r.scores)
            else:
                pooled[r.profile] = type(r.scores)(r.scores.options, r.scores.min_area)
                pooled[r.profile].merge(r.scores)
    figures = [bars("mean_auc", "AUC",
                    "Mean over frames of the area under the ROC curve; 0.5 is guessing."),
               bars("mean_iou", "mean IoU, declared threshold",
                    "Mean over the frames with movers of the intersection over union, when pixels "
                    "from the declared threshold on are called dynamic. No bar: 0, or none.")]
    failed = sum(bool(r.error) for r in results)
    paragraph = (f"{len(results) - failed} runs scored, {failed} failed. Curves are over all "
                 "scored pixels of all sequences with masks; tracks are points, and have a bar "
                 "only.")
    write_page(folder, "Egosieve on many sequences", paragraph, text,
               figures + score_figures(pooled))
    return folder / "index.html"
