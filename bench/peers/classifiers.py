#!/usr/bin/env python3
"""Gaussian process classifiers of Egosieve and scikit-learn compared: one run, the same folds.

    PYTHONPATH=P/lib/python3.11/site-packages bench/peers/classifiers.py

P: a tree of `./run install`. Inputs are standardised on the training rows; accuracy and log loss are those of all rows,
each predicted by the fold that left it out. Iris, breast cancer and the first 600 digits are scikit-learn's; of the
others "noisy" has the sign of sin(2 x_0) + x_1 + noise with a deviation of 1, 600 rows in 4 dimensions, and "rare" a class
of about one row in ten, 1,000 rows in 3 dimensions. scikit-learn's default kernel is fixed; "trained" is the same one with
the length and amplitude that it optimises.
"""

import sys
import time
import warnings
from pathlib import Path

import numpy as np
import sklearn
from sklearn import datasets, gaussian_process
from sklearn.gaussian_process.kernels import RBF, ConstantKernel
from sklearn.metrics import accuracy_score, log_loss
from sklearn.model_selection import StratifiedKFold, cross_val_predict
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

import egosieve

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from common import RESULTS, markdown  # noqa: E402

FOLDS = 5
CLASSIFIERS = {
    "scikit-learn, default": gaussian_process.GaussianProcessClassifier,
    "scikit-learn, trained": lambda: gaussian_process.GaussianProcessClassifier(ConstantKernel(1.0) * RBF(1.0)),
    "egosieve": egosieve.GaussianProcessClassifier,
    "egosieve, least squares": lambda: egosieve.GaussianProcessClassifier(likelihood="least_squares"),
}


def noisy():
    random = np.random.default_rng(0)
    X = random.normal(size=(600, 4))
    return X, np.sin(2 * X[:, 0]) + X[:, 1] + random.normal(size=600) > 0


def rare():
    random = np.random.default_rng(1)
    X = random.normal(size=(1000, 3))
    share = 1 / (1 + np.exp(4.5 - 2 * X[:, 0] - X[:, 1] * X[:, 2]))
    return X, np.where(random.uniform(size=1000) < share, "rare", "common")


DATA = {
    "iris": lambda: datasets.load_iris(return_X_y=True),
    "breast cancer": lambda: datasets.load_breast_cancer(return_X_y=True),
    "digits": lambda: tuple(values[:600] for values in datasets.load_digits(return_X_y=True)),
    "noisy": noisy,
    "rare": rare,
}


def measure(make, X, y):
    begin = time.perf_counter()
    splits = StratifiedKFold(FOLDS, shuffle=True, random_state=0)
    found = cross_val_predict(make_pipeline(StandardScaler(), make()), X, y, cv=splits, method="predict_proba")
    classes = np.unique(y)
    accuracy = accuracy_score(y, classes[found.argmax(axis=1)])
    return f"{accuracy:.3f} / {log_loss(y, found, labels=classes):.3f} / {(time.perf_counter() - begin) / FOLDS:.1f} s"


def main():
    warnings.simplefilter("ignore")
    rows = []
    for name, load in DATA.items():
        rows.append([name, *(measure(make, *load()) for make in CLASSIFIERS.values())])
        print(*rows[-1], sep=", ", flush=True)
    text = (
        f"# Classifiers\n\n`bench/peers/classifiers.py`: accuracy / log loss / time of fit and prediction of one of {FOLDS} folds;"
        f" Egosieve {egosieve.__version__}, scikit-learn {sklearn.__version__}, {egosieve.threads()} threads, {egosieve.devices()[0]}.\n\n"
    )
    (RESULTS / "classifiers.md").write_text(text + markdown(["", *CLASSIFIERS], rows))


if __name__ == "__main__":
    main()
