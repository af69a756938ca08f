"""What scikit-learn and its users ask of any estimator: its own base classes where it is installed, else a few methods."""

import inspect

import numpy as np

try:
    from sklearn.base import BaseEstimator, ClassifierMixin, RegressorMixin
except ImportError:

    class BaseEstimator:
        def get_params(self, deep=True):
            """The parameters of the constructor by name."""
            return {name: getattr(self, name) for name in sorted(inspect.signature(type(self)).parameters)}

        def set_params(self, **params):
            """Sets parameters of the constructor; they hold from the next fit on."""
            names = list(self.get_params())
            for name in set(params) - set(names):
                raise ValueError(f"Invalid parameter '{name}' for {type(self).__name__}. Valid parameters are: {names}.")
            self.__dict__.update(params)
            return self

        def __repr__(self):
            defaults = {name: p.default for name, p in inspect.signature(type(self)).parameters.items()}
            changed = [f"{name}={value!r}" for name, value in self.get_params().items() if value is not defaults[name]]
            return f"{type(self).__name__}({', '.join(changed)})"

    class RegressorMixin:
        def score(self, X, y, sample_weight=None):
            """Coefficient of determination, 1 - sum (y - mean)^2 / sum (y - average y)^2, the mean over targets."""
            mean = self.predict(X)
            y = np.asarray(y, dtype=np.float64)
            residual = np.average((y - mean) ** 2, axis=0, weights=sample_weight)
            total = np.average((y - np.average(y, axis=0, weights=sample_weight)) ** 2, axis=0, weights=sample_weight)
            explained = 1.0 - residual / np.where(total > 0.0, total, 1.0)
            return float(np.where(total > 0.0, explained, residual == 0.0).mean())

    class ClassifierMixin:
        def score(self, X, y, sample_weight=None):
            """The share of rows of X whose class is predicted."""
            return float(np.average(self.predict(X) == np.asarray(y), weights=sample_weight))


class Estimator(BaseEstimator):
    """`_is_fitted` tells whether fit was called."""

    _several_targets = False

    def __sklearn_is_fitted__(self):
        return self._is_fitted()

    def _take_features(self, count, names):
        self.n_features_in_ = count
        self.__dict__.pop("feature_names_in_", None)
        if names is not None:
            self.feature_names_in_ = names

    def _more_tags(self):
        """What scikit-learn's check_estimator should know, before version 1.6."""
        types = [np.float64, np.float32]
        return {"requires_y": True, "multioutput": self._several_targets, "preserves_dtype": types}

    def __sklearn_tags__(self):
        """The same since version 1.6."""
        tags = super().__sklearn_tags__()
        tags.target_tags.required, tags.target_tags.multi_output = True, self._several_targets
        return tags


class Classifier(ClassifierMixin, Estimator):
    pass


class Regressor(RegressorMixin, Estimator):
    _several_targets = True
