"""egosieve.GaussianProcess: what it computes, arrays of any layout, and what it refuses."""

import copy
import os
import pickle
import signal
import threading
import unittest
import warnings

import numpy as np

import egosieve


def data(n=60, dimension=3, seed=0):
    random = np.random.default_rng(seed)
    X = random.uniform(-1, 1, (n, dimension))
    return X, np.sin(2 * X[:, 0]) * np.cos(X[:, 1]) + 0.3 * X[:, -1]


def posterior_in_float64(gp, X, y, queries):
    """Mean and variance of f by the textbook, squared exponential."""
    found = gp.hyperparameters_
    lengths, signal, noise = np.array(found["scales"]), found["signal_stddev"], found["noise_stddev"]

    def covariance(a, b):
        squares = (((a[:, None] - b[None]) / lengths) ** 2).sum(-1)
        return signal**2 * np.exp(-0.5 * squares)

    inverse = np.linalg.inv(covariance(X, X) + noise**2 * np.eye(len(X)))
    cross = covariance(queries, X)
    return cross @ inverse @ y, signal**2 - np.einsum("ij,jk,ik->i", cross, inverse, cross)


class Values(unittest.TestCase):
    def test_posterior_is_the_textbooks(self):
        X, y = data()
        queries = data(40, seed=1)[0]
        gp = egosieve.GaussianProcess("squared_exponential", noise_stddev=0.3, optimize=False).fit(X, y)
        mean, variance = gp.predict(queries, return_var=True)
        expected_mean, expected_variance = posterior_in_float64(gp, X, y, queries)
        # Float32 covariances: 1e-6 |alpha|_1 for the mean; 60 of alpha's values are below 10.
        np.testing.assert_allclose(mean, expected_mean, atol=1e-4)
        np.testing.assert_allclose(variance, expected_variance, atol=1e-4)
        std = gp.predict(queries, return_std=True)[1]
        np.testing.assert_array_equal(std, np.sqrt(variance))
        of_y = gp.predict(queries, return_var=True, of_observation=True)[1]
        np.testing.assert_allclose(of_y - variance, 0.09, atol=1e-6)

    def test_optimisation_and_normalisation(self):
        X, y = data(100)
        y = 1000 + 50 * y + np.random.default_rng(5).normal(0, 2, len(y))
        gp = egosieve.GaussianProcess(normalize_y=True).fit(X, y)
        self.assertGreater(gp.optimization_["log_likelihood"], gp.optimization_["log_likelihood_at_start"])
        queries, truth = data(50, seed=2)
        mean, std = gp.predict(queries, return_std=True)
        self.assertLess(np.abs(mean - (1000 + 50 * truth)).max(), 10)  # 5 deviations of the noise
        self.assertGreater(gp.score(X, y), 0.99)
        np.testing.assert_allclose(gp.y_train_, y, rtol=1e-12)
        self.assertTrue((std > 0).all())

    def test_partial_fit_and_remove(self):
        X, y = data()
        whole = egosieve.GaussianProcess(optimize=False).fit(X[10:], y[10:])
        parts = egosieve.GaussianProcess(optimize=False).partial_fit(X[:30], y[:30]).partial_fit(X[30:], y[30:])
        parts.remove(np.arange(10))
        np.testing.assert_array_equal(parts.X_train_, whole.X_train_)
        queries = data(40, seed=1)[0]
        np.testing.assert_allclose(parts.predict(queries), whole.predict(queries), atol=1e-4)
        self.assertAlmostEqual(parts.log_marginal_likelihood(), whole.log_marginal_likelihood(), places=7)

    def test_probabilities(self):
        X, y = data(100)
        gp = egosieve.GaussianProcess(noise_stddev=0.3).fit(X, np.sign(y))
        probabilities = gp.predict_proba(X)
        np.testing.assert_allclose(probabilities.sum(axis=1), 1, atol=1e-12)
        self.assertGreater(((probabilities[:, 1] > 0.5) == (y > 0)).mean(), 0.95)
        self.assertFalse(hasattr(egosieve.GaussianProcess().fit(X, 5 * y), "predict_proba"))
        with self.assertRaisesRegex(AttributeError, r"predict_proba needs every y in \[-1, 1\]"):
            gp.partial_fit(X, 5 * y).predict_proba(X)
        frozen = egosieve.GaussianProcess(noise_stddev=0.3).fit(X, np.sign(y)).freeze()
        np.testing.assert_array_equal(frozen.predict_proba(X), probabilities)

    def test_labels_of_another_convention_are_refused(self):
        X, y = data(100)
        for labels in ((y > 0).astype(int), y > 0):
            gp = egosieve.GaussianProcess(noise_stddev=0.3, optimize=False).fit(X, labels)
            self.assertFalse(hasattr(gp, "predict_proba"))
            with self.assertRaisesRegex(AttributeError, r"2 \* y - 1"):
                gp.predict_proba(X)
            np.testing.assert_array_equal(gp.freeze().predict(X), gp.predict(X))
            self.assertTrue(hasattr(gp.partial_fit(X[:1], [-1]), "predict_proba"))
        self.assertTrue(hasattr(gp.fit(X, np.ones(100)), "predict_proba"))

    def test_calibration_belongs_to_the_points_that_it_saw(self):
        X, y = data(100)
        gp = egosieve.GaussianProcess(noise_stddev=0.3, optimize=False).fit(X[:60], np.sign(y[:60]))
        gp.predict_proba(X)
        before = gp.hyperparameters_["squash"]
        gp.predict_proba(X)
        self.assertEqual(gp.hyperparameters_["squash"], before)
        gp.partial_fit(X[60:], np.sign(y[60:])).predict_proba(X)
        self.assertNotEqual(gp.hyperparameters_["squash"], before)

    def test_calibrating_while_points_come(self):
        # A calibration of fewer points must not pass for one of all: the last one is always made anew.
        X, y = data(300)
        labels = np.sign(y)
        for _ in range(5):
            gp = egosieve.GaussianProcess(noise_stddev=0.3, optimize=False).fit(X[:200], labels[:200])
            thread = threading.Thread(target=lambda: gp.predict_proba(X[:1]))
            thread.start()
            gp.partial_fit(X[200:], labels[200:])
            thread.join()
            gp.predict_proba(X[:1])
            alone = egosieve.GaussianProcess(noise_stddev=0.3, optimize=False).fit(X[:200], labels[:200])
            alone.partial_fit(X[200:], labels[200:]).predict_proba(X[:1])
            self.assertEqual(gp.hyperparameters_["squash"], alone.hyperparameters_["squash"])

    def test_axes_are_their_points(self):
        X, y = data(dimension=2)
        gp = egosieve.GaussianProcess(noise_stddev=0.3, optimize=False).fit(X, y)
        for x_axis, y_axis in (
            (np.linspace(-1, 1, 7), np.linspace(0, 1, 4)),
            (np.array([-1.0, -0.2, 0.9]), np.array([0.5])),
        ):
            mean, std = gp.predict_axes(x_axis, y_axis, return_std=True)
            self.assertEqual(mean.shape, (len(y_axis), len(x_axis)))
            points = np.array([[a, b] for b in y_axis for a in x_axis])
            expected = gp.predict(points.astype(np.float32), return_std=True)
            np.testing.assert_allclose(mean.ravel(), expected[0], atol=1e-5)
            np.testing.assert_allclose(std.ravel(), expected[1], atol=1e-5)
        with self.assertRaisesRegex(ValueError, "x has shape"):
            gp.predict_axes(np.zeros((2, 2)), [0.0])

    def test_arrays_of_other_libraries(self):
        class Tensor:  # what has DLPack and no NumPy
            def __init__(self, array):
                self.array = array

            def __dlpack__(self, **options):
                return self.array.__dlpack__(**options)

            def __dlpack_device__(self):
                return self.array.__dlpack_device__()

        X, y = data()
        gp = egosieve.GaussianProcess(noise_stddev=0.3, optimize=False)
        expected = gp.fit(X, y).predict(X)
        np.testing.assert_array_equal(gp.fit(Tensor(X), Tensor(y)).predict(Tensor(X)), expected)

    def test_warm_up_changes_nothing(self):
        X, y = data()
        for mean in ("zero", "linear"):
            gp = egosieve.GaussianProcess(mean=mean, optimize=False).warm_up(3)
            with self.assertRaisesRegex(ValueError, "not fitted"):
                gp.predict(X)
            expected = gp.fit(X, y).predict(X)
            np.testing.assert_array_equal(gp.warm_up(3).predict(X), expected)

    def test_threads_change_no_result(self):
        X, y = data(300)
        found = []
        for threads in (1, 3):
            egosieve.set_threads(threads)
            self.assertEqual(egosieve.threads(), threads)
            found.append(egosieve.GaussianProcess().fit(X, y).predict(X, return_cov=True)[1])
        egosieve.set_threads(0)
        self.assertGreaterEqual(egosieve.threads(), 1)
        np.testing.assert_array_equal(*found)

    def test_grid_is_its_points(self):
        X, y = data(30, 2)
        gp = egosieve.GaussianProcess(optimize=False).fit(X, y)
        mean, std = gp.predict_grid(-1, -0.5, 0.25, 0.5, 4, 9, return_std=True)
        v, u = np.mgrid[0:4, 0:9]
        points = np.stack([-1 + 0.25 * u, -0.5 + 0.5 * v], axis=-1).reshape(-1, 2)
        expected = gp.predict(points.astype(np.float32), return_std=True)
        np.testing.assert_array_equal(mean.ravel(), expected[0])
        np.testing.assert_array_equal(std.ravel(), expected[1])
        out = np.zeros((9, 4))[:, ::-1].T  # any strides
        self.assertIs(gp.predict_grid(-1, -0.5, 0.25, 0.5, 4, 9, out=out), out)
        np.testing.assert_array_equal(out, mean)

    def test_image(self):
        image = np.random.default_rng(0).integers(0, 256, (20, 31, 3), dtype=np.uint8)
        places = np.array([[0, 0], [30, 19], [15, 10], [5, 15], [10, 5]])
        gp = egosieve.GaussianProcess(optimize=False)
        X = gp.describe_pixels(image, places)
        gp.fit(X, [1, -1, 1, -1, 1])
        mean, std = gp.predict_image(image, stride=5, return_std=True)
        self.assertEqual(mean.shape, (5, 7))
        np.testing.assert_array_equal(mean[2, 3], gp.predict(X[2:3])[0])
        np.testing.assert_array_equal(mean[-1, -1], gp.predict(X[1:2])[0])
        np.testing.assert_array_equal(gp.predict_image(image[..., ::-1], 5, order="rgb"), mean)


class Layouts(unittest.TestCase):
    def test_any_strides_and_types_give_the_same_bits(self):
        X, y = data()
        gp = egosieve.GaussianProcess(optimize=False).fit(X, y)
        queries = data(50, seed=1)[0].astype(np.float32)
        expected = gp.predict(queries)
        self.assertEqual(expected.dtype, np.float32)
        wide = np.zeros((100, 7), dtype=np.float32)
        wide[::2, 1:7:2] = queries
        layouts = {
            "fortran": np.asfortranarray(queries),
            "strided": wide[::2, 1:7:2],
            "reversed": queries[::-1].copy()[::-1],
            "float64": queries.astype(np.float64),
            "swapped": queries.astype(">f4"),
            "field of records": np.rec.fromarrays([queries, queries + 1])["f0"],
        }
        for name, layout in layouts.items():
            np.testing.assert_array_equal(gp.predict(layout), expected, err_msg=name)
        unaligned = np.frombuffer(b"\0" + queries.tobytes(), dtype=np.uint8)[1:].view(np.float32)
        np.testing.assert_array_equal(gp.predict(unaligned.reshape(queries.shape)), expected)
        np.testing.assert_array_equal(
            egosieve.GaussianProcess(optimize=False).fit(X[::-1][::-1], y.astype(np.float64)[::-1][::-1]).predict(queries),
            expected,
        )

    def test_saving_and_copies(self):
        X, y = data()
        gp = egosieve.GaussianProcess(normalize_y=True, noise_stddev=0.2).fit(X, y)
        path = os.path.join(os.getcwd(), "model.npz")
        gp.save(path)
        expected = gp.predict(X)
        loaded = egosieve.GaussianProcess.load(path)
        np.testing.assert_array_equal(loaded.predict(X), expected)
        self.assertEqual(loaded.get_params(), gp.get_params())
        self.assertEqual(list(np.load(path)["normalized"]), [1])  # so that C and C++ refuse it
        for twin in (pickle.loads(pickle.dumps(gp)), copy.deepcopy(gp)):
            np.testing.assert_array_equal(twin.predict(X), expected)
        self.assertEqual(np.load(path)["inputs"].shape, X.shape)
        with open(path, "r+b") as file:
            file.seek(200)
            file.write(b"damage")
        with self.assertRaises(ValueError):
            egosieve.GaussianProcess.load(path)
        with self.assertRaises(FileNotFoundError):
            egosieve.GaussianProcess.load(path + ".none")

    def test_parameters_come_back_as_they_were(self):
        X, y = data()
        gp = egosieve.GaussianProcess(
            normalize_y=np.bool_(False), optimize=np.bool_(False), random_state=np.int64(7)
        ).fit(X, y)
        path = os.path.join(os.getcwd(), "parameters.npz")
        gp.save(path)
        loaded = egosieve.GaussianProcess.load(path).get_params()
        self.assertIs(loaded["normalize_y"], False)
        self.assertIs(loaded["optimize"], False)
        self.assertEqual(loaded["random_state"], 7)
        gp.random_state = object()
        with self.assertRaisesRegex(TypeError, "cannot be saved"):
            gp.save(path)

    def test_too_many_points_are_told_their_memory(self):
        X = np.zeros((2_000_000, 1))
        with self.assertRaisesRegex(MemoryError, r'2000000 points takes 8 n\^2 bytes, 32000\.0 GB; approximation "iterative"'):
            egosieve.GaussianProcess("matern52", optimize=False).fit(X, X[:, 0])

    def test_much_jitter_is_told(self):
        X = np.linspace(0, 5, 200)[:, None]
        gp = egosieve.GaussianProcess("squared_exponential", scales=[1.0], noise_stddev=1e-8, optimize=False)
        with self.assertWarnsRegex(UserWarning, "jitter 1e-10 was added to the noise variance 1e-16"):
            gp.fit(X, np.sin(X[:, 0]))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            gp.set_params(alpha=1e-6).fit(X, np.sin(X[:, 0]))

    def test_serializing_while_points_come(self):
        X, y = data(400)
        gp = egosieve.GaussianProcess(optimize=False).fit(X[:5], y[:5])
        stop = threading.Event()

        def grow():
            for i in range(5, 400):
                if stop.is_set():
                    break
                gp.partial_fit(X[i : i + 1], y[i : i + 1])

        thread = threading.Thread(target=grow)
        thread.start()
        try:
            for _ in range(60):
                pickle.loads(pickle.dumps(gp)).predict(X[:1])
        finally:
            stop.set()
            thread.join()

    def test_rows_as_numpy_takes_them(self):
        X, y = data()
        gp = egosieve.GaussianProcess(optimize=False).fit(X, y)
        gp.remove([-1, 0])
        np.testing.assert_array_equal(gp.X_train_, X[1:-1])
        kept = gp.X_train_[:, 0] > 0
        gp.remove(~kept)
        np.testing.assert_array_equal(gp.X_train_, X[1:-1][kept])
        gp.remove([])
        gp.remove(np.zeros(kept.sum(), bool))
        self.assertEqual(len(gp.X_train_), kept.sum())

    @unittest.skipUnless(hasattr(os, "fork"), "no fork here")
    def test_a_forked_child_is_told(self):
        X, y = data()
        gp = egosieve.GaussianProcess(optimize=False).fit(X, y)
        gp.predict(X)
        if egosieve.devices()[0].startswith("reference") or os.environ.get("EGOSIEVE_DEVICE") == "reference":
            self.skipTest("no OpenCL device")
        child = os.fork()
        if child == 0:
            signal.alarm(60)  # without the check it waits for ever
            told = 0
            try:
                for call in (
                    lambda: gp.predict(X),
                    lambda: egosieve.GaussianProcess(optimize=False).fit(X, y),
                    lambda: egosieve.GaussianProcess().fit(X, y),
                    lambda: egosieve.GaussianProcess(approximation="dtc").fit(X, y),
                    lambda: gp.partial_fit(X + 0.01, y),
                ):
                    with self.assertRaisesRegex(RuntimeError, "^((?!jitter).)*spawn((?!jitter).)*$"):
                        call()
                    told += 1
            finally:
                os._exit(5 - told)
        self.assertEqual(os.waitpid(child, 0)[1], 0)


class BadInput(unittest.TestCase):
    def test_errors_name_the_argument(self):
        X, y = data()
        gp = egosieve.GaussianProcess(optimize=False).fit(X, y)
        nan = X.copy()
        nan[3, 1] = np.nan
        cases = [
            (ValueError, r"X contains NaN, first at \(3, 1\)", lambda: gp.predict(nan)),
            (ValueError, "X contains infinity", lambda: gp.fit(X * np.inf, y)),
            (ValueError, "y contains NaN", lambda: gp.fit(X, np.full(len(X), np.nan))),
            (ValueError, "float32", lambda: gp.predict(X * 1e300)),
            (TypeError, "X holds text", lambda: gp.predict(X.astype(str).astype(object))),
            (TypeError, "y: .* not 'dict'", lambda: gp.fit(X, [{}] * len(X))),
            (TypeError, "X has dtype <U", lambda: gp.predict(X.astype(str))),
            (ValueError, "Complex data not supported: X", lambda: gp.predict(X + 1j)),
            (ValueError, "Expected 2D array, got 1D array instead for X", lambda: gp.predict(X[0])),
            (ValueError, "X: found array with dim 3", lambda: gp.predict(X[None])),
            (ValueError, "X has 2 features", lambda: gp.predict(X[:, :2])),
            (ValueError, "X: found array with 0 sample", lambda: gp.predict(X[:0])),
            (ValueError, "inconsistent numbers of samples: X 60, y 59", lambda: gp.fit(X, y[1:])),
            (ValueError, "y should be a 1d or 2d array", lambda: gp.fit(X, X[None])),
            (ValueError, "requires y", lambda: gp.fit(X, None)),
            (ValueError, 'covariance "cubic": expected a covariance function', lambda: egosieve.GaussianProcess("cubic").fit(X, y)),
            (ValueError, "scale_count = 1", lambda: egosieve.GaussianProcess(scales=[1]).fit(X, y)),
            (ValueError, "noise_stddev", lambda: egosieve.GaussianProcess(noise_stddev=-1).fit(X, y)),
            (ValueError, "nobody has", lambda: egosieve.GaussianProcess(device="nobody has").fit(X, y)),
            (ValueError, "Invalid parameter 'degree'", lambda: gp.set_params(degree=3)),
            (ValueError, "rows: 60", lambda: gp.remove([60])),
            (ValueError, "rows: -61; the model has 60 points", lambda: gp.remove([-61])),
            (ValueError, "rows: 59 is there twice", lambda: gp.remove([-1, 59])),
            (ValueError, "rows has 2 values of bool", lambda: gp.remove([True, False])),
            (ValueError, "noise_stddev has shape", lambda: egosieve.GaussianProcess(noise_stddev=[0.1] * 60).fit(X, y)),
            (ValueError, "rows: 5 is there twice", lambda: gp.remove([5, 5])),
            (TypeError, "rows must be", lambda: gp.remove([0.5])),
            (ValueError, "not fitted", lambda: egosieve.GaussianProcess().predict(X)),
            (ValueError, "not fitted", lambda: egosieve.GaussianProcess().save("none.npz")),
            (RuntimeError, "a grid needs a model of 2 inputs", lambda: gp.predict_grid(0, 0, 1, 1, 2, 2)),
            (ValueError, "image must be height x width", lambda: gp.predict_image(np.zeros(5, np.uint8))),
            (TypeError, "image has dtype float64", lambda: gp.predict_image(np.zeros((5, 5)))),
            (ValueError, "order = 'grb'", lambda: gp.predict_image(np.zeros((5, 5), np.uint8), order="grb")),
        ]
        for kind, words, call in cases:
            with self.subTest(words):
                with self.assertRaisesRegex(kind, words):
                    call()
        read_only = np.zeros((2, 2))
        read_only.flags.writeable = False
        plane = egosieve.GaussianProcess(optimize=False).fit(X[:, :2], y)
        with self.assertRaisesRegex(ValueError, "mean is read-only"):
            plane.predict_grid(0, 0, 1, 1, 2, 2, out=read_only)
        self.assertEqual(len(gp.X_train_), 60)

    def test_everything_public_is_documented(self):
        for owner in (egosieve.GaussianProcess, egosieve.FrozenPosterior, egosieve.Segmenter):
            self.assertGreater(len(owner.__doc__), 100)
            for name in dir(owner):
                if not name.startswith("_"):
                    self.assertTrue(getattr(owner, name).__doc__, f"{owner.__name__}.{name}")


if __name__ == "__main__":
    unittest.main()
