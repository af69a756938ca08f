"""Draws figures.json (tools/plots/figure.h) as SVG and PNG: plot.py FIGURES.JSON FOLDER.

Exits with 3 where the plotting library is missing.
"""
import json
import math
import sys

try:
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot as plt
except ImportError as error:
    print(error)
    sys.exit(3)

# Okabe and Ito's colours, told apart with any colour vision, then two greys.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#999999",
           "#7F5F00"]


def numbers(values):
    return [math.nan if value is None else value for value in values]


def draw_bars(axes, figure, series):
    count = sum(s["style"] == "bars" for s in series)
    width = 0.8 / max(count, 1)
    for place, s in enumerate(series):
        offset = (place - (count - 1) / 2) * width
        axes.bar([x + offset for x in numbers(s["x"])], numbers(s["y"]), width, label=s["name"],
                 color=COLOURS[place % len(COLOURS)])
    axes.grid(axis="y", color="#dddddd", linewidth=0.6)


def draw_line(axes, s, colour):
    x, y = numbers(s["x"]), numbers(s["y"])
    if s["style"] == "intervals":
        low = [value - bound for value, bound in zip(y, numbers(s["low"]))]
        high = [bound - value for value, bound in zip(y, numbers(s["high"]))]
        axes.errorbar(x, y, yerr=[low, high], fmt="o", capsize=4, color=colour, label=s["name"])
    elif s["style"] == "steps":
        axes.step(x, y, where="post", color=colour, label=s["name"])
    else:
        axes.plot(x, y, color=colour, label=s["name"], linewidth=1.6,
                  linestyle="--" if s["style"] == "dashed" else "-",
                  marker="o" if len(x) < 20 else None, markersize=3)


def draw(figure, folder):
    wide = len(figure["categories"]) > 8
    fig, axes = plt.subplots(figsize=(11 if wide else 7, 4.8), constrained_layout=True)
    series = figure["series"]
    axes.set_axisbelow(True)
    if any(s["style"] == "bars" for s in series):
        draw_bars(axes, figure, series)
    else:
        axes.grid(color="#dddddd", linewidth=0.6)
        for place, s in enumerate(series):
            draw_line(axes, s, COLOURS[place % len(COLOURS)])
    if figure["diagonal"]:
        axes.plot([0, 1], [0, 1], color="#aaaaaa", linewidth=1, linestyle=":", zorder=0)
    if figure["categories"]:
        names = figure["categories"]
        long = max(map(len, names)) * len(names) > 60
        axes.set_xticks(range(len(names)))
        axes.set_xticklabels(names, rotation=30 if long else 0, ha="right" if long else "center")
    if any(s["style"] == "intervals" for s in series):
        axes.axhline(0.0, color="#666666", linewidth=1)
        axes.margins(x=0.1)
    if figure.get("logarithmic_x"):
        axes.set_xscale("log")
        places = sorted({x for s in series for x in s["x"]})
        axes.set_xticks(places, [f"{x:g}" for x in places])
        axes.set_xticks([], minor=True)
    if figure["logarithmic_y"]:
        axes.set_yscale("log")
    if figure["x_range"]:
        axes.set_xlim(*figure["x_range"])
    if figure["y_range"]:
        axes.set_ylim(*figure["y_range"])
    axes.set_title(figure["title"])
    axes.set_xlabel(figure["x_label"])
    axes.set_ylabel(figure["y_label"])
    if len(series) > 1:
        outside = len(series) > 4 or any(s["style"] == "bars" for s in series)
        axes.legend(fontsize=8, framealpha=0.9,
                    **({"loc": "center left", "bbox_to_anchor": (1.01, 0.5)} if outside else {}))
    for kind in ("svg", "png"):
        fig.savefig(f"{folder}/{figure['id']}.{kind}", dpi=130,
                    metadata={"Date": None} if kind == "svg" else None)
    plt.close(fig)


def main():
    matplotlib.rcParams["svg.hashsalt"] = "egosieve"
    with open(sys.argv[1], encoding="utf-8") as file:
        figures = json.load(file)
    for figure in figures:
        draw(figure, sys.argv[2])


main()
