"""Figures drawn by matplotlib as SVG and PNG, and one page with all of them.

A figure is a dictionary: id (the files' name), title, caption, x_label, y_label, series, and
optionally categories (names of places on the x axis), x_range, y_range, diagonal (a faint line from
(0, 0) to (1, 1)), logarithmic_x, logarithmic_y. A series has name, x, y (None: no point) and
optionally style: line, dashed or bars.
"""

import html
import json
import math
import re

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

# Okabe and Ito's colours, told apart with any colour vision, then two greys.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#999999",
           "#7F5F00"]
STYLE = """body{font:16px/1.45 sans-serif;margin:2em auto;max-width:84em;padding:0 1em;color:#222}
figure{margin:2em 0;border-top:1px solid #ccc;padding-top:1em}figure svg{max-width:100%;height:auto}
figcaption{max-width:60em}pre{font-size:11px;overflow-x:auto;background:#f6f6f6;padding:1em}"""


def _numbers(values):
    return [math.nan if value is None else value for value in values]


def _draw_series(axes, series):
    bars = [s for s in series if s.get("style") == "bars"]
    width = 0.8 / max(len(bars), 1)
    for place, s in enumerate(series):
        x, y, colour = _numbers(s["x"]), _numbers(s["y"]), COLOURS[place % len(COLOURS)]
        if s.get("style") == "bars":
            offset = (place - (len(bars) - 1) / 2) * width
            axes.bar([value + offset for value in x], y, width, label=s["name"], color=colour)
        else:
            axes.plot(x, y, color=colour, label=s["name"], linewidth=1.6, markersize=3,
                      linestyle="--" if s.get("style") == "dashed" else "-",
                      marker="o" if len(x) < 20 else None)
    axes.grid(axis="y" if bars else "both", color="#dddddd", linewidth=0.6)
    if len(series) > 1:
        outside = {"loc": "center left", "bbox_to_anchor": (1.01, 0.5)}
        axes.legend(fontsize=8, framealpha=0.9, **(outside if bars or len(series) > 4 else {}))


def draw(figure, folder):
    """Writes ID.svg and ID.png."""
    names = figure.get("categories") or []
    fig, axes = plt.subplots(figsize=(11 if len(names) > 8 else 7, 4.8), constrained_layout=True)
    axes.set_axisbelow(True)
    _draw_series(axes, figure["series"])
    if figure.get("diagonal"):
        axes.plot([0, 1], [0, 1], color="#aaaaaa", linewidth=1, linestyle=":", zorder=0)
    if names:
        is_long = max(map(len, names)) * len(names) > 60
        axes.set_xticks(range(len(names)), names, rotation=30 if is_long else 0,
                        ha="right" if is_long else "center")
    if figure.get("logarithmic_x"):
        axes.set_xscale("log")
        places = sorted({x for s in figure["series"] for x in s["x"]})
        axes.set_xticks(places, [f"{x:g}" for x in places])
        axes.set_xticks([], minor=True)
    if figure.get("logarithmic_y"):
        axes.set_yscale("log")
    if figure.get("x_range"):
        axes.set_xlim(*figure["x_range"])
    if figure.get("y_range"):
        axes.set_ylim(*figure["y_range"])
    axes.set(title=figure["title"], xlabel=figure["x_label"], ylabel=figure["y_label"])
    with matplotlib.rc_context({"svg.hashsalt": "egosieve"}):
        fig.savefig(folder / f"{figure['id']}.svg", metadata={"Date": None})
        fig.savefig(folder / f"{figure['id']}.png", dpi=130)
    plt.close(fig)


def _inline(path, name):
    """The SVG without its head; matplotlib repeats its ids, so each figure gets its own."""
    svg = path.read_text(encoding="utf-8")
    svg = svg[svg.index("<svg"):]
    return re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{name}-", svg)


def write_page(folder, title, paragraph, table, figures):
    """figures.json, the figures that have points, and index.html, which needs no other file."""
    folder.mkdir(parents=True, exist_ok=True)
    figures = [figure for figure in figures
               if any(y is not None for s in figure["series"] for y in s["y"])]
    (folder / "figures.json").write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    page = (f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
            f"<style>{STYLE}</style></head><body><h1>{title}</h1>\n<p>{html.escape(paragraph)}</p>"
            f"\n<pre>{html.escape(table)}</pre>\n")
    for figure in figures:
        draw(figure, folder)
        name = figure["id"]
        page += (f"<figure>{_inline(folder / f'{name}.svg', name)}<figcaption>"
                 f'{html.escape(figure["caption"])} (<a href="{name}.svg">SVG</a>, '
                 f'<a href="{name}.png">PNG</a>)</figcaption></figure>\n')
    (folder / "index.html").write_text(page + "</body></html>\n", encoding="utf-8")
