"""scikit-learn's own checks of egosieve's estimators."""

import unittest
import warnings

import egosieve
from sklearn.base import clone
from sklearn.exceptions import SkipTestWarning
from sklearn.model_selection import cross_val_score
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.utils import estimator_checks


def checks_of(estimator):
    if hasattr(estimator_checks, "estimator_checks_generator"):  # scikit-learn 1.6 and later
        return estimator_checks.estimator_checks_generator(estimator)
    return estimator_checks.check_estimator(estimator, generate_only=True)


class CheckEstimator(unittest.TestCase):
    def test_every_check_that_applies(self):
        skipped, passed, failed = [], 0, []
        estimators = (egosieve.GaussianProcess(), egosieve.GaussianProcessClassifier())
        for estimator, check in (pair for one in estimators for pair in checks_of(one)):
            name = getattr(getattr(check, "func", check), "__name__", str(check))
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                try:
                    check(estimator)
                    passed += 1
                except unittest.SkipTest as reason:
                    skipped.append((name, str(reason)))
                except Exception as error:  # all failures in one report
                    failed.append(f"{name}: {type(error).__name__}: {error}")
        print(f"{passed} checks passed, skipped: {skipped}")
        self.assertEqual(failed, [])
        self.assertGreater(passed, 60)
        for skip in skipped:
            expected = ("pandas is not installed", "SCIPY_ARRAY_API is not set")
            self.assertTrue(any(words in " ".join(skip) for words in expected), skip)

    def test_works_in_pipelines_and_searches(self):
        import numpy as np

        X = np.random.default_rng(0).uniform(-1, 1, (90, 2))
        y = X[:, 0] * X[:, 1]
        model = make_pipeline(StandardScaler(), clone(egosieve.GaussianProcess(noise_stddev=0.05)))
        self.assertGreater(cross_val_score(model, X, y, cv=3).min(), 0.9)


if __name__ == "__main__":
    warnings.simplefilter("ignore", SkipTestWarning)
    unittest.main()
