"""Figures of lines, drawn by the program's own tools/evaluate/plots.py."""

import shutil
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.append(str(Path(__file__).resolve().parents[2] / "tools"))


def lines(name, title, labels, series, **more):
    """A figure of (name, x, y) series, None in y: no point. labels: of x and y. more: further fields of tools/evaluate/plots.py."""
    figure = {"id": name, "title": title, "x_label": labels[0], "y_label": labels[1]}
    return figure | {"series": [{"name": s[0], "x": s[1], "y": s[2]} for s in series]} | more


def draw(figures, folder):
    """Writes NAME.svg of each figure; prints a message if there is no plotting library."""
    try:
        from evaluate import plots
    except ImportError as error:
        print(f"no figures: {error}", file=sys.stderr)
        return
    with tempfile.TemporaryDirectory() as scratch:
        for figure in figures:
            plots.draw(figure, Path(scratch))
            shutil.copy(Path(scratch) / f"{figure['id']}.svg", folder)
