"""What users of data frames, class labels, broadcast arrays and copies of models rely on."""

import copy
import os
import pickle
import tempfile
import unittest
import warnings

import numpy as np

import egosieve


class Frame:
    """A data frame as far as the library looks: columns, and values as an array."""

    def __init__(self, values, columns):
        self.values, self.columns = np.asarray(values), columns
        self.shape = self.values.shape

    def __array__(self, dtype=None, copy=None):
        return self.values if dtype is None else self.values.astype(dtype)

    def to_numpy(self, dtype, na_value):
        return np.array([[na_value if value is None else value for value in row] for row in self.values], dtype=dtype)


def data(n=60, features=2):
    random = np.random.default_rng(n)
    X = random.normal(size=(n, features))
    return X, X[:, 0] - 2 * X[:, 1] + 0.1 * random.normal(size=n)


class Columns(unittest.TestCase):
    def test_their_names_and_order_are_those_of_fit(self):
        X, y = data()
        gp = egosieve.GaussianProcess("squared_exponential", optimize=False).fit(Frame(X, ["a", "b"]), y)
        self.assertEqual(list(gp.feature_names_in_), ["a", "b"])
        expected = gp.predict(Frame(X, ["a", "b"]))
        for model in (gp, gp.freeze(), pickle.loads(pickle.dumps(gp))):
            np.testing.assert_array_equal(model.predict(Frame(X, ["a", "b"])), expected)
            for names in (["b", "a"], ["a", "c"]):
                with self.assertRaisesRegex(ValueError, "feature names should match"):
                    model.predict(Frame(X, names))
            with self.assertWarnsRegex(UserWarning, "does not have valid feature names"):
                np.testing.assert_array_equal(model.predict(X), expected)
        self.assertFalse(hasattr(gp.fit(X, y), "feature_names_in_"))

    def test_of_bool_and_nullable_numbers_are_numbers(self):
        X, y = data()
        mixed = np.array([[bool(row[0] > 0), float(row[1])] for row in X], dtype=object)
        gp = egosieve.GaussianProcess("squared_exponential", optimize=False).fit(Frame(mixed, ["a", "b"]), y)
        np.testing.assert_array_equal(gp.X_train_[:, 0], X[:, 0] > 0)
        mixed[3, 1] = None
        with self.assertRaisesRegex(ValueError, "NaN"):
            gp.fit(Frame(mixed, ["a", "b"]), y)
        mixed[3, 1] = "text"
        with self.assertRaises(TypeError):
            gp.fit(Frame(mixed, ["a", "b"]), y)


class Classes(unittest.TestCase):
    def test_of_any_kind_are_found(self):
        X, _ = data(150)
        for names in ((0, 1), ("no", "yes"), (False, True), (-7, 3)):
            y = np.where(X[:, 0] > 0, names[1], names[0])
            classifier = egosieve.GaussianProcessClassifier("squared_exponential").fit(X, y)
            self.assertEqual(list(classifier.classes_), list(names))
            self.assertGreater(classifier.score(X, y), 0.95)
            probabilities = classifier.predict_proba(X)
            np.testing.assert_allclose(probabilities.sum(axis=1), 1.0, atol=1e-6)
            np.testing.assert_array_equal(classifier.predict(X), classifier.classes_[probabilities.argmax(axis=1)])

    def test_are_not_measured_numbers_nor_one_alone(self):
        X, y = data()
        with self.assertRaisesRegex(ValueError, "Unknown label type"):
            egosieve.GaussianProcessClassifier().fit(X, y)
        for other in (None, 1):
            with self.assertRaisesRegex(ValueError, "y holds labels that cannot be sorted"):
                egosieve.GaussianProcessClassifier().fit(X, np.array(["a", other] * (len(X) // 2), dtype=object))
        with self.assertRaisesRegex(ValueError, "at least two"):
            egosieve.GaussianProcessClassifier().fit(X, np.zeros(len(X)))
        with self.assertRaises(TypeError):
            egosieve.GaussianProcessClassifier(normalize_y=True)


class Copies(unittest.TestCase):
    def test_predict_alike(self):
        X, y = data()
        labels = np.sign(y)
        gp = egosieve.GaussianProcess("matern52").fit(X, labels)
        expected = gp.predict_proba(X)
        for twin in (pickle.loads(pickle.dumps(gp)), copy.deepcopy(gp)):
            np.testing.assert_array_equal(twin.predict_proba(X), expected)
            self.assertEqual(twin.hyperparameters_["squash"], gp.hyperparameters_["squash"])

    def test_of_a_device_that_is_not_here_use_another(self):
        X, y = data()
        gp = egosieve.GaussianProcess("matern52", optimize=False, device="reference").fit(X, y)
        state = gp.__getstate__()
        state["device"] = "a device of another machine"
        twin = egosieve.GaussianProcess.__new__(egosieve.GaussianProcess)
        twin.__setstate__(state)
        np.testing.assert_allclose(twin.predict(X), gp.predict(X), atol=1e-5)

    def test_of_a_fitted_model_do_not_follow_later_parameters(self):
        X, y = data()
        gp = egosieve.GaussianProcess("matern52", optimize=False).fit(X, np.sign(y))
        expected = gp.predict_proba(X)
        gp.normalize_y = True
        np.testing.assert_array_equal(gp.predict_proba(X), expected)

    def test_of_more_than_20000_points_load(self):
        random = np.random.default_rng(0)
        X, y = random.uniform(size=(20001, 1)), np.zeros(20001)
        gp = egosieve.GaussianProcess("matern52", approximation="dtc", inducing_points=5, optimize=False).fit(X, y)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "large.npz")
            gp.save(path)
            self.assertEqual(egosieve.GaussianProcess.load(path).hyperparameters_["size"], 20001)


class Broadcast(unittest.TestCase):
    def test_arrays_are_read_as_their_copies(self):
        X, y = data(20)
        gp = egosieve.GaussianProcess("matern52", optimize=False).fit(X, y)
        one = np.float64(0.3)
        for queries in (np.broadcast_to(one, (1000, 2)), np.broadcast_to(X[:1], (1000, 2)),
                        np.broadcast_to(X[:5, :1], (5, 2)), np.broadcast_to(np.float32(0.3), (7, 2))):  # fmt: skip
            np.testing.assert_array_equal(gp.predict(queries), gp.predict(np.array(queries)))
        flat = egosieve.GaussianProcess("matern52", optimize=False).fit(X, np.broadcast_to(one, 20))
        np.testing.assert_array_equal(flat.y_train_, np.full(20, 0.3))

    def test_the_zero_mean_has_no_coefficients(self):
        X, y = data(20)
        for targets, shape in ((y, (0,)), (np.stack([y, -y], axis=1), (0, 2))):
            gp = egosieve.GaussianProcess("matern52", optimize=False).fit(X, targets)
            self.assertEqual(gp.coef_.shape, shape)

    def test_results_are_not_written_to_one_place(self):
        X, y = data(20)
        gp = egosieve.GaussianProcess("matern52", optimize=False).fit(X, y)
        out = np.lib.stride_tricks.as_strided(np.zeros(1, np.float32), (4, 4), (0, 0))
        with self.assertRaisesRegex(ValueError, "lie on each other"):
            gp.predict_grid(0, 0, 1, 1, 4, 4, out=out)


class FarFromZero(unittest.TestCase):
    def test_targets_are_centred(self):
        X = np.linspace(0, 1, 100)[:, None]
        y = 5e6 + np.sin(6 * X[:, 0])
        with self.assertWarnsRegex(UserWarning, "far from zero"):
            gp = egosieve.GaussianProcess("squared_exponential").fit(X, y)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            self.assertLess(np.abs(gp.predict(X) - y).max(), 0.01)
            self.assertLess(np.abs(pickle.loads(pickle.dumps(gp)).predict(X) - y).max(), 0.01)


if __name__ == "__main__":
    unittest.main()
