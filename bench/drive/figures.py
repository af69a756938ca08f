"""Figures of lines, drawn by the program's own tools/plots/plot.py."""

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

PLOT = Path(__file__).resolve().parents[2] / "tools" / "plots" / "plot.py"


def lines(name, title, labels, series, **more):
    """A figure of (name, x, y) series, None in y: no point. labels: of x and y. more: further fields of tools/plots/figure.h."""
    figure = {"id": name, "title": title, "x_label": labels[0], "y_label": labels[1], "categories": [], "diagonal": False,
              "logarithmic_y": False, "x_range": None, "y_range": None}  # fmt: skip
    return figure | {"series": [{"name": s[0], "x": s[1], "y": s[2], "style": "line"} for s in series]} | more


def draw(figures, folder):
    """Writes NAME.svg of each figure; prints a message if there is no plotting library."""
    with tempfile.TemporaryDirectory() as scratch:
        data = Path(scratch) / "figures.json"
        data.write_text(json.dumps(figures))
        done = subprocess.run([sys.executable, str(PLOT), str(data), scratch], capture_output=True, text=True)
        if done.returncode != 0:
            print(f"no figures: {(done.stdout + done.stderr).strip()[-300:]}", file=sys.stderr)
            return
        for figure in figures:
            shutil.copy(Path(scratch) / f"{figure['id']}.svg", folder)
