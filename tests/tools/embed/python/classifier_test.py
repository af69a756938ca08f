"""GaussianProcessClassifier: Laplace's approximation beside an independent one, weights, copies, scikit-learn's tools."""

import os
import pickle
import tempfile
import unittest

import numpy as np
from scipy.linalg import solve
from scipy.optimize import root
from scipy.stats import norm
from sklearn.calibration import CalibratedClassifierCV
from sklearn.gaussian_process import kernels
from sklearn.model_selection import GridSearchCV, cross_val_score

import egosieve


def data(n=80, seed=0):
    random = np.random.default_rng(seed)
    X = random.normal(size=(n, 2))
    return X, (X[:, 0] + X[:, 1] ** 2 + 0.5 * random.normal(size=n) > 0.5).astype(int)


class Laplace(unittest.TestCase):
    def test_probabilities_are_those_of_the_mode_found_otherwise(self):
        X, y = data()
        t = 2.0 * y - 1.0
        queries = data(30, seed=1)[0]
        kernel = kernels.ConstantKernel(4.0) * kernels.RBF(0.8)
        K = kernel(X)

        def stationarity(f):
            return f - K @ (t * np.exp(norm.logpdf(f) - norm.logcdf(t * f)))

        f = root(stationarity, np.zeros(len(X)), tol=1e-13).x
        self.assertLess(np.abs(stationarity(f)).max(), 1e-9)
        ratio = np.exp(norm.logpdf(f) - norm.logcdf(t * f))
        W = ratio * (ratio + t * f)
        cross = kernel(queries, X)
        variance = 4.0 - np.einsum("ij,ji->i", cross, solve(K + np.diag(1.0 / W), cross.T))
        expected = norm.cdf(cross @ (t * ratio) / np.sqrt(1.0 + variance))
        ours = egosieve.GaussianProcessClassifier(kernel, optimize=False).fit(X, y)
        np.testing.assert_allclose(ours.predict_proba(queries)[:, 1], expected, atol=1e-4)
        value = norm.logcdf(t * f).sum() - 0.5 * f @ (t * ratio) - 0.5 * np.linalg.slogdet(np.eye(len(X)) + K * W)[1]
        self.assertAlmostEqual(ours.log_marginal_likelihood_value_, value, delta=1e-8)

    def test_weights_are_repetitions_and_zero_leaves_out(self):
        X, y = data()
        weights = np.random.default_rng(2).integers(0, 4, len(X))
        weighted = egosieve.GaussianProcessClassifier().fit(X, y, sample_weight=weights)
        repeated = egosieve.GaussianProcessClassifier().fit(np.repeat(X, weights, axis=0), np.repeat(y, weights))
        np.testing.assert_array_equal(weighted.predict_proba(X), repeated.predict_proba(X))
        self.assertEqual(len(weighted.models_[0].X_train_), np.count_nonzero(weights))
        plain = egosieve.GaussianProcessClassifier().fit(X, y)
        self.assertGreater(np.abs(weighted.predict_proba(X) - plain.predict_proba(X)).max(), 0.01)
        with self.assertRaisesRegex(ValueError, "need likelihood='laplace'"):
            egosieve.GaussianProcessClassifier(likelihood="least_squares").fit(X, y, weights)
        with self.assertRaisesRegex(ValueError, "at least two"):
            egosieve.GaussianProcessClassifier().fit(X, y, np.zeros(len(X)))

    def test_copies_and_files_predict_alike(self):
        X, y = data()
        classifier = egosieve.GaussianProcessClassifier().fit(X, y)
        expected = classifier.predict_proba(X)
        np.testing.assert_array_equal(pickle.loads(pickle.dumps(classifier)).predict_proba(X), expected)
        model = classifier.models_[0]
        np.testing.assert_allclose(model.freeze().predict_proba(X), expected, atol=1e-6)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "classes.npz")
            model.save(path)
            loaded = egosieve.GaussianProcess.load(path)
        np.testing.assert_array_equal(loaded.predict_proba(X), expected)
        loaded.remove([0])
        self.assertFalse(hasattr(loaded, "predict_proba"))


class WithTheTools(unittest.TestCase):
    def test_of_scikit_learn(self):
        X, y = data(120)
        names = np.array(["no", "yes"])[y]
        classifier = egosieve.GaussianProcessClassifier()
        for scoring in ("accuracy", "roc_auc", "neg_log_loss", "neg_brier_score"):
            self.assertTrue(np.isfinite(cross_val_score(classifier, X, y, scoring=scoring, cv=3)).all(), scoring)
        self.assertTrue(np.isfinite(cross_val_score(classifier, X, names, scoring="neg_log_loss", cv=3)).all())
        calibrated = CalibratedClassifierCV(classifier, cv=3).fit(X, names, sample_weight=np.ones(len(X)))
        self.assertGreater(calibrated.score(X, names), 0.8)
        grid = {"kernel": ["isotropic(squared_exponential)", "matern52"], "likelihood": ["laplace", "least_squares"]}
        self.assertGreater(GridSearchCV(classifier, grid, cv=3).fit(X, y).best_score_, 0.75)
        nested = egosieve.GaussianProcessClassifier(1.0 * kernels.RBF(1.0), optimize=False)
        self.assertIn("kernel__k2__length_scale", nested.get_params())
        search = GridSearchCV(nested, {"kernel__k2__length_scale": [0.01, 1.0]}, cv=3).fit(X, y)
        self.assertEqual(search.best_params_["kernel__k2__length_scale"], 1.0)

    def test_of_pandas(self):
        try:
            import pandas
        except ImportError:
            self.skipTest("pandas is not installed")
        X, y = data()
        frame = pandas.DataFrame({"a": pandas.array(X[:, 0], dtype="Float64"), "b": X[:, 1] > 0, "c": X[:, 1]})
        plain = np.column_stack([X[:, 0], X[:, 1] > 0, X[:, 1]])
        expected = egosieve.GaussianProcessClassifier().fit(plain, y).predict_proba(plain)
        for labels in (pandas.Series(y, dtype="Int64"), pandas.Series(y == 1, dtype="boolean")):
            classifier = egosieve.GaussianProcessClassifier().fit(frame, labels)
            np.testing.assert_array_equal(classifier.predict_proba(frame), expected)
            self.assertEqual(classifier.classes_.dtype, labels.dtype.numpy_dtype)
        with self.assertRaisesRegex(ValueError, "same order"):
            classifier.predict(frame[["b", "a", "c"]])
        with self.assertRaises(ValueError):
            classifier.fit(frame, pandas.Series([None, *y[1:]], dtype="Int64"))

    def test_several_classes(self):
        X, _ = data(150)
        y = np.digitize(X[:, 0], [-0.5, 0.5]) * 10
        for likelihood in ("laplace", "least_squares"):
            classifier = egosieve.GaussianProcessClassifier(likelihood=likelihood).fit(X, y)
            self.assertEqual(list(classifier.classes_), [0, 10, 20])
            self.assertGreater(classifier.score(X, y), 0.95)
            np.testing.assert_allclose(classifier.predict_proba(X).sum(axis=1), 1.0, atol=1e-6)
            self.assertEqual(len(classifier.kernel_), 3)


if __name__ == "__main__":
    unittest.main()
