"""A suite's results as tables: sequences, means over groups of them, the worst, and failures."""

import numpy as np
import pandas

from .box_scores import BoxScores
from .drive_scores import THRESHOLDS
from .evaluation import cell
from .objects import ObjectTally
from .suite import FIGURES

WORST = 5
MAIN = ("mean_auc", "mean_iou", "mask_j")  # of these the worst are named, old and new compared


def to_frame(results):
    """suite.csv: a row per result."""
    return pandas.DataFrame([
        {"sequence": r.sequence.name, "group": r.sequence.group, "profile": r.profile,
         "frames": r.frames, "error": r.error, **r.figures} for r in results
    ]).astype(dict.fromkeys(FIGURES, float))  # fmt: skip


def groups_of(table):
    """((group, profile), rows) of each group and of "all", in alphabetical order."""
    both = pandas.concat([table, table.assign(group="all")])
    return both.groupby(["group", "profile"], sort=True)


def _mean_ious(results, group, profile):
    """Over sequences with masks, by THRESHOLDS; points have no share of the image."""
    rows = [r.scores.mean_ious() for r in results
            if r.scores and r.kind != "tracks" and r.profile == profile
            and group in ("all", r.sequence.group)]  # fmt: skip
    rows = [row for row in rows if row]
    return np.mean(rows, axis=0).tolist() if rows else None


def _spread(values):
    values = values.dropna()
    if values.empty:
        return None
    spread = {"sequences": len(values), "mean": values.mean(), "median": values.median(),
              "deviation": values.std() if len(values) > 1 else None, "least": values.min(),
              "most": values.max()}  # fmt: skip
    return {name: value if value is None else type(value).__call__(value)
            for name, value in spread.items()}  # fmt: skip


def to_json(results, table, without_truth):
    groups = [{"group": group, "profile": profile,
               "figures": {name: _spread(rows[name]) for name in FIGURES},
               "mean_iou_at_0.05_to_0.95": _mean_ious(results, group, profile)}
              for (group, profile), rows in groups_of(table)]  # fmt: skip
    sequences = []
    for r in results:
        entry = {"sequence": r.sequence.name, "group": r.sequence.group, "profile": r.profile,
                 "truth": str(r.sequence.truth), "error": r.error or None, "frames": r.frames,
                 **r.figures}  # fmt: skip
        if r.scores:
            entry |= {"frames_scored": len(r.scores.frames), "pixels": r.pixels,
                      "scores": r.scores.to_json(), "further": r.further.to_json()}  # fmt: skip
        sequences.append(entry)
    return {"failed": sum(bool(r.error) for r in results), "without_truth": without_truth,
            "groups": groups, "sequences": sequences}


def worst(values, count=WORST):
    """The lowest values of a series, ascending."""
    return values.dropna().nsmallest(count)


def worst_text(values):
    return ", ".join(f"{name} {value:.3f}" for name, value in worst(values).items())


def to_text(results, table, without_truth):
    def row(name, profile, frames, figures):
        cells = "".join(cell(None if pandas.isna(figures[f]) else figures[f]) for f in FIGURES)
        return f"{name:32} {profile:10} {frames:>7}{cells}\n"

    text = f"{'sequence':32} {'profile':10} {'frames':>7}"
    text += "".join(f" {heading:>8}" for heading, _ in FIGURES.values()) + "\n"
    for r in results:
        if r.scores:
            text += row(r.sequence.name, r.profile, len(r.scores.frames), pandas.Series(r.figures))
    for (group, profile), rows in groups_of(table):
        for name in ("mean", "median"):
            text += row(f"{name} {group}", profile, "", rows[list(FIGURES)].agg(name))
    for profile, rows in table.groupby("profile", sort=False):
        for figure in MAIN:
            if names := worst_text(rows.set_index("sequence")[figure]):
                text += f"worst {FIGURES[figure][0]}, {profile}: {names}\n"
    for (group, profile), _ in groups_of(table):
        if ious := _mean_ious(results, group, profile):
            text += (f"one threshold for {group}, {profile}: {THRESHOLDS[np.argmax(ious)]:.2f} "
                     f"gives a mean IoU of {max(ious):.4f} (0.50: {ious[9]:.4f})\n")
    failed = [r for r in results if r.error]
    for r in failed:
        text += f"failed: {r.sequence.name}, {r.profile}: {r.error}\n"
    if without_truth:
        text += (f"left out: {len(without_truth)} folders with frames, but without truth: "
                 f"{', '.join(without_truth)}\n")
    return text + f"{len(results) - len(failed)} of {len(results)} runs scored, {len(failed)} failed\n"


def to_markdown(results, table):
    """Per group and profile: mean and least value of the AUC, and of J if the truth is masks."""
    def number(value):
        return "-" if pandas.isna(value) else f"{value:.3f}"

    tracks = [r.kind == "tracks" for r in results]
    table = table.assign(j=table.mean_iou.mask(tracks), scored=table.mean_iou.notna() | [
        bool(r.scores) for r in results])  # fmt: skip
    text = ("| folder | profile | sequences | AUC, mean | AUC, least | J, mean | J, least |\n"
            "|---|---|---|---|---|---|---|\n")  # fmt: skip
    for (group, profile), rows in groups_of(table):
        figures = [rows.mean_auc.mean(), rows.mean_auc.min(), rows.j.mean(), rows.j.min()]
        text += (f"| {group} | {profile} | {rows.scored.sum()} of {len(rows)} | "
                 f"{' | '.join(map(number, figures))} |\n")
    return text


def _object_table(results, title, tally_of):
    """Movers found by group, variants beside each other; empty without groups."""
    pooled = {}
    for r in results:
        if r.scores and len(tally_of(r).ious) > 1:
            pooled.setdefault(r.profile, ObjectTally(0.5)).merge(tally_of(r))
    if not pooled:
        return ""
    text = f"{title:32} {'objects':>8}" + "".join(f" {name:>12}" for name in pooled) + "\n"
    for group in sorted({group for tally in pooled.values() for group in tally.ious}):
        count = max(len(tally.ious.get(group, ())) for tally in pooled.values())
        text += f"{group:32} {count:8}"
        for tally in pooled.values():
            shares = [tally.recall(iou, group) for iou in (0.3, 0.5)]
            text += f" {'-':>12}" if shares[0] is None else "  {:.3f} {:.3f}".format(*shares)
        text += "\n"
    text += f"{'false objects per frame':32} {'':8}"
    return text + "".join(f" {t.false_per_frame():12.3f}" for t in pooled.values()) + "\n"


def object_tables(results):
    tables = (_object_table(results, "movers in maps, IoU 0.3 and 0.5", lambda r: r.scores.objects),
              _object_table(results, "movers in masks, IoU 0.3 and 0.5", lambda r: r.masks))
    return "\n".join(filter(None, tables))


def further_tables(results):
    """Boxes marked by variant, and the errors of the camera."""
    pooled, rows = {}, ""
    for r in results:
        if r.further.boxes:
            pooled.setdefault(r.profile, BoxScores(r.further.boxes.threshold)).merge(r.further.boxes)
        figures = r.further.figures
        shown = [(figures.get("trajectory", {}), 0)]
        if "row_shift" in figures:
            shown.append((figures["trajectory_with_shifted_rows"], figures["row_shift"]))
        if all(value is None for value in figures.values()):
            continue
        for errors, shift in shown:
            cells = [errors.get(name) for name in (
                "rotation_degrees_per_second", "rotation_neighbours_degrees_per_second",
                "direction_degrees")]  # fmt: skip
            cells += [figures["focal_error_percent"], figures["own_vehicle_marked_share"]]
            rows += f"{r.sequence.name:32} {r.profile:10}"
            rows += "".join(cell(value, 12, 3) for value in cells) + f" {shift:12}\n"
    text = "".join(f"{variant}, all sequences with boxes\n{boxes.table()}"
                   for variant, boxes in pooled.items())  # fmt: skip
    headings = ("rotation d/s", "neighbours", "direction d", "focal %", "own marked", "row shift")
    if rows:
        text += f"{'camera':32} {'profile':10}" + "".join(f" {h:>12}" for h in headings) + "\n"
    return text + rows


def compare(old, new):
    """Old and new values side by side, by sequence and profile: tables like suite.csv."""
    by = ["sequence", "profile"]
    if old["profile"].nunique() == new["profile"].nunique() == 1:
        by = ["sequence"]
    both = old.merge(new, on=by, suffixes=("_old", "_new"))
    if both.empty:
        return "old and new have no sequence in common\n"
    names = both[by].agg(", ".join, axis=1)
    figures = [f for f in MAIN if both[[f"{f}_old", f"{f}_new"]].notna().all(axis=1).any()]
    text = f"{'old and new':40}"
    for figure in figures:
        heading = FIGURES[figure][0]
        text += f" {heading + ' old':>10} {'new':>8} {'change':>8}"
    text += "\n"

    def row(name, value_of):
        cells = ""
        for figure in figures:
            values = [value_of(both[f"{figure}_{side}"]) for side in ("old", "new")]
            values = [None if pandas.isna(v) else v for v in values]
            change = None if None in values else values[1] - values[0]
            cells += cell(values[0], 10, 3) + cell(values[1], 8, 3)
            cells += f" {'-':>8}" if change is None else f" {change:+8.3f}"
        return f"{name:40}{cells}\n"

    for place, name in enumerate(names):
        text += row(name, lambda column, place=place: column.iloc[place])
    text += row("mean", lambda c: c.mean()) + row("median", lambda c: c.median())
    for figure in figures:
        for side in ("old", "new"):
            values = both[f"{figure}_{side}"].set_axis(names)
            text += f"worst {FIGURES[figure][0]}, {side}: {worst_text(values)}\n"
    return text
