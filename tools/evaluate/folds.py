"""Cross-validation over clips: is a change chosen on some clips worth anything on the others?

The clips fall into folds by a hash of their names, the same in every suite. For each fold the
candidate is chosen whose mean over the other folds is the largest, and its values on the fold are
held out. The first candidate is the old state. The change counts if the mean over the held-out
clips rises, and none of the five worst clips, before or after, falls by more than 0.02.
"""

import hashlib
from pathlib import Path

import pandas

from .errors import InputError, UsageError
from .table import worst, worst_text

MOST_FALL = 0.02


def fold_of(name, folds):
    """By the last part of a sequence's name."""
    digest = hashlib.sha256(name.rsplit("/", 1)[-1].encode()).digest()
    return int.from_bytes(digest[:8], "big") % folds


def read_table(path):
    """A suite.csv, or that of a suite's folder."""
    path = Path(path) / "suite.csv" if Path(path).is_dir() else Path(path)
    try:
        return pandas.read_csv(path, dtype={"sequence": str, "group": str, "profile": str})
    except (FileNotFoundError, pandas.errors.ParserError, pandas.errors.EmptyDataError) as error:
        raise InputError(f"{path} is no table of a suite: {error}") from None


def read_candidates(paths, figure):
    """Values by clip and candidate: a column per suite, or per profile of a suite of several."""
    columns = {}
    for path in paths:
        table = read_table(path)
        if figure not in table:
            raise UsageError(f"{path} has no figure {figure}")
        for profile, rows in table.groupby("profile", sort=False):
            name = f"{path}:{profile}" if table["profile"].nunique() > 1 else str(path)
            columns[name] = rows.set_index("sequence")[figure]
    return pandas.DataFrame(columns)


def cross_validate(values, folds):
    """(the candidate chosen by fold, held-out value by clip). values: by clip and candidate."""
    fold = values.index.map(lambda name: fold_of(name, folds))
    chosen, held_out = {}, []
    for k in sorted(set(fold)):
        others = values[fold != k]
        if others.empty:
            raise UsageError("all clips lie in one fold; give more clips")
        chosen[k] = others.mean().idxmax()  # the first of equal ones
        held_out.append(values.loc[fold == k, chosen[k]])
    return chosen, pandas.concat(held_out)[values.index]


def report(values, figure, folds):
    """The text, and whether the change counts."""
    if values.shape[1] < 2:
        raise UsageError("one candidate only; give the old state first, then others")
    whole = values.dropna()
    chosen, new = cross_validate(whole, folds)
    old = whole.iloc[:, 0]
    text = f"{figure} by {folds} folds; the old state is {values.columns[0]}\n"
    if len(whole) < len(values):
        without = ", ".join(values.index.difference(whole.index))
        text += f"left out, without a value everywhere: {without}\n"
    for k, name in chosen.items():
        clips = [clip for clip in whole.index if fold_of(clip, folds) == k]
        others = whole.drop(clips)
        text += (f"fold {k}: {name} has {others[name].mean():.4f} on the others (old "
                 f"{others.iloc[:, 0].mean():.4f}); held out {', '.join(clips)}: "
                 f"{new[clips].mean():.4f} (old {old[clips].mean():.4f})\n")
    text += f"{'':10} {'mean':>8} {'median':>8}  five worst\n"
    for name, column in (("old", old), ("held out", new)):
        text += f"{name:10} {column.mean():8.4f} {column.median():8.4f}  {worst_text(column)}\n"
    rises = new.mean() > old.mean()
    low = worst(old).index.union(worst(new).index)
    falls = (new - old)[low]
    falls = falls[falls < -MOST_FALL]
    text += f"mean over held-out clips: {new.mean() - old.mean():+.4f}\n"
    for clip, fall in falls.items():
        text += f"{clip} falls by {-fall:.4f}\n"
    counts = bool(rises and falls.empty)
    return text + f"the change {'counts' if counts else 'does not count'}\n", counts
