"""A suite's results as tables: sequences, means over groups of them, the worst, and failures."""

import numpy as np
import pandas

from . import doubt
from .box_scores import BoxScores
from .drive_scores import THRESHOLDS
from .objects import ObjectTally
from .suite import FIGURES
from .texts import to_text

WORST = 5
MAIN = ("mean_auc", "mean_iou", "mask_j")  # of these the worst are named, old and new compared
HEADINGS = {name: heading for name, (heading, _) in FIGURES.items()}
CAMERA = {"rotation_degrees_per_second": "rotation d/s",
          "rotation_neighbours_degrees_per_second": "neighbours",
          "direction_degrees": "direction d", "focal_error_percent": "focal %",
          "own_vehicle_marked_share": "own marked", "row_shift": "row shift"}


def to_frame(results):
    """suite.csv: a row per result."""
    return pandas.DataFrame([
        {"sequence": r.sequence.name, "group": r.sequence.group, "profile": r.profile,
         "frames": r.frames, "error": r.error, **r.figures} for r in results
    ]).astype(dict.fromkeys(FIGURES, float))


def groups_of(table):
    """((group, profile), rows) of each group and of "all", in alphabetical order."""
    both = pandas.concat([table, table.assign(group="all")])
    return both.groupby(["group", "profile"], sort=True)


def _mean_ious(results, group, profile):
    """Over sequences with masks, by THRESHOLDS; points have no share of the image."""
    rows = [r.scores.mean_ious() for r in results
            if r.scores and r.kind != "tracks" and r.profile == profile
            and group in ("all", r.sequence.group)]
    rows = [row for row in rows if row]
    return np.mean(rows, axis=0).tolist() if rows else None


def _spread(values):
    values = values.dropna()
    if values.empty:
        return None
    return {"sequences": len(values), "mean": values.mean(), "median": values.median(),
            "deviation": values.std() if len(values) > 1 else None, "least": values.min(),
            "most": values.max()}


def to_json(results, table, without_truth):
    groups = [{"group": group, "profile": profile,
               "figures": {name: _spread(rows[name]) for name in FIGURES},
               "mean_iou_at_0.05_to_0.95": _mean_ious(results, group, profile)}
              for (group, profile), rows in groups_of(table)]
    sequences = []
    for r in results:
        entry = {"sequence": r.sequence.name, "group": r.sequence.group, "profile": r.profile,
                 "truth": str(r.sequence.truth), "error": r.error or None, "frames": r.frames,
                 **r.figures}
        if r.scores:
            entry |= {"frames_scored": len(r.scores.frames), "pixels": r.pixels,
                      "scores": r.scores.to_json(), "further": r.further.to_json()}
        sequences.append(entry)
    return {"failed": sum(bool(r.error) for r in results), "without_truth": without_truth,
            "groups": groups, "sequences": sequences}


def worst(values, count=WORST):
    """The lowest values of a series, ascending."""
    return values.dropna().nsmallest(count)


def worst_text(values):
    return ", ".join(f"{name} {value:.3f}" for name, value in worst(values).items())


def summary(results, table, without_truth):
    means = [{"sequence": f"{name} {group}", "profile": profile,
              **rows[list(FIGURES)].agg(name)}
             for (group, profile), rows in groups_of(table) for name in ("mean", "median")]
    shown = pandas.concat([table[table.error == ""], pandas.DataFrame(means)])
    text = to_text(shown[["sequence", "profile", *FIGURES]].rename(columns=HEADINGS))
    for profile, rows in table.groupby("profile", sort=False):
        for figure in MAIN:
            if names := worst_text(rows.set_index("sequence")[figure]):
                text += f"worst {HEADINGS[figure]}, {profile}: {names}\n"
    for (group, profile), _ in groups_of(table):
        if ious := _mean_ious(results, group, profile):
            text += (f"one threshold for {group}, {profile}: {THRESHOLDS[np.argmax(ious)]:.2f} "
                     f"gives a mean IoU of {max(ious):.4f} (0.50: {ious[9]:.4f})\n")
    for profile in dict.fromkeys(r.profile for r in results):
        frames = [frame for r in results if r.profile == profile for frame in r.doubts]
        if line := doubt.describe(frames):
            text += f"{profile}: {line}"
    failed = [r for r in results if r.error]
    for r in failed:
        text += f"failed: {r.sequence.name}, {r.profile}: {r.error}\n"
    if without_truth:
        text += (f"left out: {len(without_truth)} folders with frames, but without truth: "
                 f"{', '.join(without_truth)}\n")
    scored = len(results) - len(failed)
    return text + f"{scored} of {len(results)} runs scored, {len(failed)} failed\n"


def to_markdown(results, table):
    """Per group and profile: mean and least value of the AUC, and of J if the truth is masks."""
    table = table.assign(j=table.mean_iou.mask([r.kind == "tracks" for r in results]),
                         scored=[bool(r.scores) for r in results])
    text = ("| folder | profile | sequences | AUC, mean | AUC, least | J, mean | J, least |\n"
            "|---|---|---|---|---|---|---|\n")
    for (group, profile), rows in groups_of(table):
        figures = (rows.mean_auc.mean(), rows.mean_auc.min(), rows.j.mean(), rows.j.min())
        cells = " | ".join("-" if pandas.isna(value) else f"{value:.3f}" for value in figures)
        text += f"| {group} | {profile} | {rows.scored.sum()} of {len(rows)} | {cells} |\n"
    return text


def _object_table(results, where, tally_of):
    """Movers found by group, variants beside each other; empty without groups."""
    pooled = {}
    for r in results:
        if r.scores and len(tally_of(r).ious) > 1:
            pooled.setdefault(r.profile, ObjectTally(0.5)).merge(tally_of(r))
    if not pooled:
        return ""
    groups = sorted({group for tally in pooled.values() for group in tally.ious})
    columns = {f"movers in {where}": groups, "objects": [
        max(len(tally.ious.get(group, ())) for tally in pooled.values()) for group in groups]}
    for profile, tally in pooled.items():
        for iou in (0.3, 0.5):
            columns[f"{profile}, IoU {iou}"] = [tally.recall(iou, group) for group in groups]
    return to_text(pandas.DataFrame(columns), 3) + "".join(
        f"false objects per frame, {profile}: {tally.false_per_frame():.3f}\n"
        for profile, tally in pooled.items())


def object_tables(results):
    return (_object_table(results, "maps", lambda r: r.scores.objects)
            + _object_table(results, "masks", lambda r: r.masks))


def further_tables(results):
    """Boxes marked by variant, and the errors of the camera."""
    pooled, rows = {}, []
    for r in results:
        if boxes := r.further.boxes:
            pooled.setdefault(r.profile, BoxScores(boxes.threshold)).merge(boxes)
        figures = r.further.figures
        name = {"sequence": r.sequence.name, "profile": r.profile, **figures}
        if any(value is not None for value in figures.values()):
            rows.append(name | figures.get("trajectory", {}) | {"row_shift": 0})
        if "row_shift" in figures:
            rows.append(name | figures["trajectory_with_shifted_rows"])
    text = "".join(f"{variant}, all sequences with boxes\n{boxes.table()}"
                   for variant, boxes in pooled.items())
    if rows:
        camera = pandas.DataFrame(rows).reindex(columns=["sequence", "profile", *CAMERA])
        text += to_text(camera.rename(columns=CAMERA), 3)
    return text


def compare(old, new):
    """Old and new values side by side, by sequence and profile: tables like suite.csv."""
    by = ["sequence", "profile"]
    if old["profile"].nunique() == new["profile"].nunique() == 1:
        by = ["sequence"]
    both = old.merge(new, on=by, suffixes=(" old", " new"))
    if both.empty:
        return "old and new have no sequence in common\n"
    shown, text = pandas.DataFrame(index=both[by].agg(", ".join, axis=1)), ""
    for figure in MAIN:
        values = [both[f"{figure} {side}"].set_axis(shown.index) for side in ("old", "new")]
        heading = HEADINGS[figure]
        shown[f"{heading} old"], shown[f"{heading} new"] = values
        shown[f"{heading} change"] = values[1] - values[0]
        for side, column in zip(("old", "new"), values):
            if names := worst_text(column):
                text += f"worst {heading}, {side}: {names}\n"
    means = pandas.DataFrame([shown.mean(), shown.median()], index=["mean", "median"])
    for heading in (HEADINGS[figure] for figure in MAIN):  # of the medians, not of the changes
        means[f"{heading} change"] = means[f"{heading} new"] - means[f"{heading} old"]
    shown = pandas.concat([shown, means]).dropna(axis=1, how="all")
    return to_text(shown.rename_axis("old and new").reset_index(), 3) + text
