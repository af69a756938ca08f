#!/usr/bin/env python3
"""Kriging in Python: as ../cpp/kriging.cc, to the last bit, with a plot.

    kriging.py [--wells N] [--side PIXELS] [--device NAME] [--out FILE] [--plot FILE.png]

A field in the plane, known at scattered wells, is estimated with its uncertainty on a dense grid: --side 1000 is
a million points. Reads like a notebook: run it cell by cell where your editor knows "# %%".
"""

# %% What is asked for
import argparse
import math
import time

import numpy as np

import egosieve

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--wells", type=int, default=400)
parser.add_argument("--side", type=int, default=200)
parser.add_argument("--device", default=None)
parser.add_argument("--out", default=None, help="mean, then standard deviation, float32")
parser.add_argument("--plot", default=None, help="a picture of truth, estimate and uncertainty; needs matplotlib")
options = parser.parse_args()


# %% The wells: places in [-1, 1]^2 and what was measured there
def field(x, y):
    """The truth: hills of two sizes."""
    return math.sin(3.0 * x) * math.cos(2.0 * y) + 0.4 * math.sin(7.0 * x + 4.0 * y)


def uniform(state=[1]):
    """Numbers in [0, 1) that are the same on every machine and in every language."""
    state[0] = (state[0] * 6364136223846793005 + 1442695040888963407) % 2**64
    return (state[0] >> 11) / 9007199254740992.0


places = np.empty((options.wells, 2))
values = np.empty(options.wells)
for i in range(options.wells):
    x = 2.0 * uniform() - 1.0
    y = 2.0 * uniform() - 1.0
    noise = uniform()
    noise = 0.1 * (noise + uniform() - 1.0)
    places[i] = x, y
    values[i] = field(x, y) + noise

# %% The model: hyperparameters by maximum likelihood
gp = egosieve.GaussianProcess("squared_exponential", device=options.device).fit(places, values)
found = gp.hyperparameters_
print(
    f"{options.wells} wells: log likelihood {gp.log_marginal_likelihood():.3f}, length-scales "
    f"{found['scales'][0]:.3f} and {found['scales'][1]:.3f}, noise {found['noise_stddev']:.3f}"
)

# %% The estimate on the grid
side = options.side
step = 2.0 / (side - 1)
start = time.perf_counter()
mean, deviation = gp.predict_grid(-1.0, -1.0, step, step, side, side, return_std=True)
seconds = time.perf_counter() - start
axis = -1.0 + step * np.arange(side)
truth = np.sin(3.0 * axis)[None, :] * np.cos(2.0 * axis)[:, None] + 0.4 * np.sin(
    7.0 * axis[None, :] + 4.0 * axis[:, None]
)
error = math.sqrt(float(np.mean((mean - truth) ** 2)))
print(f"{side * side} points in {seconds:.2f} s, error {error:.4f} (root mean square)")
if options.out:
    with open(options.out, "wb") as file:
        mean.tofile(file)
        deviation.tofile(file)

# %% The plot
if options.plot:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, 3, figsize=(12, 4), constrained_layout=True)
    for panel, (title, picture) in zip(
        panels, [("truth", truth), ("estimate", mean), ("standard deviation", deviation)]
    ):
        drawn = panel.imshow(picture, origin="lower", extent=(-1, 1, -1, 1))
        panel.set_title(title)
        figure.colorbar(drawn, ax=panel, shrink=0.8)
    panels[1].plot(places[:, 0], places[:, 1], "k.", markersize=2)
    figure.savefig(options.plot, dpi=100)
    print(f"plot in {options.plot}")
