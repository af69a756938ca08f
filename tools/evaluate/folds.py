"""Cross-validation over clips: is a change chosen on some clips worth anything on the others?

The clips fall into folds by a hash of their names, the same in every suite. For each fold the
candidate is chosen whose mean over the other folds is the largest, and its values on the fold are
held out. The first candidate is the old state. The change counts if the mean over the held-out
clips rises, and none of the five worst clips, before or after, falls by more than 0.02.
"""

import hashlib
from pathlib import Path

import pandas

from .files import UsageError
from .table import read_table, worst, worst_text

MOST_FALL = 0.02


def fold_of(name, folds):
    """By the last part of a sequence's name."""
    digest = hashlib.sha256(name.rsplit("/", 1)[-1].encode()).digest()
    return int.from_bytes(digest[:8], "big") % folds


def read_candidates(paths, figure):
    """Values by clip and candidate: a column per suite, or per profile of a suite of several."""
    columns = {}
    for path in paths:
        table = read_table(Path(path) / "suite.csv" if Path(path).is_dir() else path)
        if figure not in table:
            raise UsageError(f"{path} has no figure {figure}")
        for profile, rows in table.groupby("profile", sort=False):
            name = f"{path}:{profile}" if table["profile"].nunique() > 1 else str(path)
            columns[name] = rows.set_index("sequence")[figure]
    return pandas.DataFrame(columns)


def cross_validate(values, folds):
    """By clip: fold, the candidate chosen for it, held-out value. values: by clip and candidate."""
    fold = values.index.map(lambda name: fold_of(name, folds))
    if len(set(fold)) < 2:
        raise UsageError("all clips lie in one fold; give more clips, or more --folds")
    chosen = [values[fold != k].mean().idxmax() for k in fold]  # the first of equal ones
    held_out = [values.loc[clip, name] for clip, name in zip(values.index, chosen)]
    return pandas.DataFrame({"fold": fold, "chosen": chosen, "held out": held_out}, values.index)


def report(values, figure, folds):
    """The text, and whether the change counts."""
    if values.shape[1] < 2:
        raise UsageError("one candidate only; give the old state first, then others")
    whole = values.dropna()
    for name, column in values.items():
        if column.isna().all():
            raise UsageError(f"{name} has no value of {figure}; those of masks need a suite without --no-masks")
    clips = cross_validate(whole, folds)
    old, new = whole.iloc[:, 0], clips["held out"]
    text = f"{figure} by {folds} folds; the old state is {values.columns[0]}\n"
    if len(whole) < len(values):
        without = ", ".join(values.index.difference(whole.index))
        text += f"left out, without a value everywhere: {without}\n"
    for (k, name), own in clips.groupby(["fold", "chosen"]):
        others = whole.drop(own.index)
        text += (f"fold {k}: {name} has {others[name].mean():.4f} on the others (old "
                 f"{others.iloc[:, 0].mean():.4f}); held out {', '.join(own.index)}: "
                 f"{new[own.index].mean():.4f} (old {old[own.index].mean():.4f})\n")
    text += f"{'':10} {'mean':>8} {'median':>8}  five worst\n"
    for name, column in (("old", old), ("held out", new)):
        text += f"{name:10} {column.mean():8.4f} {column.median():8.4f}  {worst_text(column)}\n"
    change = new - old
    falls = change[worst(old).index.union(worst(new).index)]
    falls = falls[falls < -MOST_FALL]
    text += f"mean over held-out clips: {new.mean() - old.mean():+.4f}\n"
    for clip, fall in falls.items():
        text += f"{clip} falls by {-fall:.4f}\n"
    counts = bool(new.mean() > old.mean() and falls.empty)
    return text + f"the change {'counts' if counts else 'does not count'}\n", counts
