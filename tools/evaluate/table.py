"""A suite's results as tables: sequences, means over groups of them, the worst, and failures."""

import pandas

from . import doubt
from .box_scores import box_table
from .figures import FIGURES, HEADINGS
from .files import InputError, to_text
from .further import camera_table
from .objects import object_tables

WORST = 5
MAIN = ("mean_auc", "mean_iou", "mask_j")  # of these the worst are named, old and new compared
SPREAD = {"mean": "mean", "median": "median", "min": "least"}  # of the figures of a group


def to_frame(entries):
    """suite.csv: a row per entry."""
    table = pandas.DataFrame(entries)[["sequence", "group", "profile", "frames", "error", *FIGURES]]
    return table.astype(dict.fromkeys(FIGURES, float))


def read_table(path):
    """A suite.csv."""
    try:
        return pandas.read_csv(path, dtype={"sequence": str, "group": str, "profile": str})
    except (OSError, ValueError) as error:
        raise InputError(f"{path} is no table of a suite: {error}") from None


def groups_of(table):
    """((group, profile), rows) of each group of several sequences and of "all", in alphabetical order."""
    count = table.groupby("group").sequence.transform("nunique")
    both = pandas.concat([table[count > 1], table.assign(group="all")])
    return both.groupby(["group", "profile"], sort=True)


def to_json(entries, table, without_truth):
    groups = []
    for (group, profile), rows in groups_of(table):
        spread = rows[list(FIGURES)].agg(list(SPREAD)).rename(index=SPREAD)
        spread = spread.dropna(axis=1)
        groups.append({"group": group, "profile": profile, "figures": spread.to_dict()})
    return {"failed": int(table.error.notna().sum()), "without_truth": without_truth,
            "groups": groups, "sequences": entries}


def worst(values):
    """The lowest values of a series, ascending."""
    return values.dropna().nsmallest(WORST)


def worst_text(values):
    return ", ".join(f"{name} {value:.3f}" for name, value in worst(values).items())


def summary(entries, table, without_truth):
    means = [{"sequence": f"{name} {group}", "profile": profile,
              **rows[list(FIGURES)].agg(name)}
             for (group, profile), rows in groups_of(table) for name in ("mean", "median")]
    failed = table[table.error.notna()]
    shown = pandas.concat([table.drop(failed.index), pandas.DataFrame(means)])
    text = to_text(shown[["sequence", "profile", *FIGURES]].rename(columns=HEADINGS))
    for profile, rows in table.groupby("profile", sort=False):
        for figure in MAIN:
            if names := worst_text(rows.set_index("sequence")[figure]):
                text += f"worst {HEADINGS[figure]}, {profile}: {names}\n"
        frames = [frame for entry in entries if entry["profile"] == profile
                  for frame in entry.get("doubts", ())]
        if line := doubt.describe(frames):
            text += f"{profile}: {line}"
    for row in failed.itertuples():
        text += f"failed: {row.sequence}, {row.profile}: {row.error}\n"
    if without_truth:
        text += (f"left out: {len(without_truth)} folders with frames, but without truth: "
                 f"{', '.join(without_truth)}\n")
    scored = len(table) - len(failed)
    return text + f"{scored} of {len(table)} runs scored, {len(failed)} failed\n"


def to_markdown(entries, table):
    """Per group and profile: means and least values; the maps' IoU if the truth is masks."""
    points = [entry.get("truth_kind") == "tracks" for entry in entries]
    table = table.assign(mean_iou=table.mean_iou.mask(points))
    text = ("| folder | profile | sequences | AUC, mean | AUC, least | IoU of the maps, mean | least "
            "| J of the masks, mean | least |\n|---|---|---|---|---|---|---|---|---|\n")
    for (group, profile), rows in groups_of(table):
        figures = [value for name in MAIN for value in (rows[name].mean(), rows[name].min())]
        cells = " | ".join("-" if pandas.isna(value) else f"{value:.3f}" for value in figures)
        scored = rows.error.isna().sum()
        text += f"| {group} | {profile} | {scored} of {len(rows)} | {cells} |\n"
    return text


def further_tables(entries):
    """Movers found by group; boxes; the camera's errors."""
    scored = [entry for entry in entries if not entry["error"]]
    text = object_tables([(entry["profile"], entry) for entry in scored])
    for profile in dict.fromkeys(entry["profile"] for entry in scored):
        boxes = [entry["further"]["boxes"] for entry in scored
                 if entry["profile"] == profile and "boxes" in entry["further"]]
        if boxes:
            text += f"{profile}, all sequences with boxes\n{box_table(boxes)}"
    return text + camera_table([({name: entry[name] for name in ("sequence", "profile")},
                                 entry["further"]) for entry in scored])


def compare(old, new):
    """Old and new values side by side, by sequence and profile: tables like suite.csv."""
    by = ["sequence", "profile"]
    if old["profile"].nunique() == new["profile"].nunique() == 1:
        by = ["sequence"]
    both = old.merge(new, on=by, suffixes=(" old", " new"))
    if both.empty:
        return "old and new have no sequence in common\n"
    both = both.set_index(both[by].agg(", ".join, axis=1)).rename_axis("old and new")
    values = both[[f"{figure} {side}" for figure in MAIN for side in ("old", "new")]]
    shown = pandas.concat([values, values.agg(["mean", "median"])]).rename_axis(both.index.name)
    for place, figure in enumerate(MAIN):
        change = shown[f"{figure} new"] - shown[f"{figure} old"]
        shown.insert(3 * place + 2, f"{figure} change", change)
    text = to_text(shown.dropna(axis=1, how="all").reset_index(), 3)
    for column in values:
        if names := worst_text(values[column]):
            text += f"worst {column}: {names}\n"
    return text
