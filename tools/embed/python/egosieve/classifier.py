"""Classification of any labels by Gaussian processes on -1 and +1."""

import inspect

import numpy as np

from . import arguments
from .estimator import Estimator
from .gaussian_process import GaussianProcess

_OF_REGRESSION = ("alpha", "normalize_y")


class GaussianProcessClassifier(Estimator):
    """Classes by Gaussian process regression on the labels -1 and +1, one class against the rest where there are more.

    Probabilities are those of probabilistic least squares (Rasmussen & Williams, section 6.5), as
    GaussianProcess.predict_proba gives them; of several classes they are scaled to the sum 1. Parameters are those of
    GaussianProcess, without alpha and normalize_y.

    Attributes
    ----------
    classes_ : array of shape (n_classes,), sorted
    n_features_in_ : int
    models_ : list of GaussianProcess, one for two classes, else one per class

    Examples
    --------
    >>> import numpy as np, egosieve
    >>> X = np.random.default_rng(0).normal(size=(100, 2))
    >>> classifier = egosieve.GaussianProcessClassifier().fit(X, np.where(X[:, 0] > 0, "right", "left"))
    >>> classifier.predict([[1.0, 0.0]])
    array(['right'], dtype='<U5')
    """

    _estimator_type = "classifier"

    def __init__(self, kernel="arcsine", **parameters):
        defaults = self._defaults()
        for name in parameters:
            if name not in defaults:
                raise TypeError(f"GaussianProcessClassifier has no parameter '{name}'")
        for name, value in {**defaults, **parameters, "kernel": kernel}.items():
            setattr(self, name, value)

    def fit(self, X, y):
        """X : array of shape (n_samples, n_features); y : n_samples labels of any kind, at least two different."""
        names = arguments.feature_names(X)
        X = arguments.matrix("X", X)
        y = arguments.labels("y", y, len(X))
        classes, members = np.unique(y, return_inverse=True)
        if len(classes) < 2:
            raise ValueError(f"y holds {len(classes)} class, {classes[0]!r}; the classifier needs at least two")
        wanted = [1] if len(classes) == 2 else range(len(classes))
        self.models_ = [self._model().fit(X, np.where(members == c, 1.0, -1.0)) for c in wanted]
        self.classes_, self.n_features_in_ = classes, X.shape[1]
        self.__dict__.pop("feature_names_in_", None)
        if names is not None:
            self.feature_names_in_ = names
        return self

    def predict_proba(self, X):
        """Probabilities of the classes in the order of classes_, of shape (n_queries, n_classes)."""
        if not self._is_fitted():
            raise arguments.not_fitted(self)
        X = arguments.queries(self, X, self.n_features_in_)
        if len(self.models_) == 1:
            return self.models_[0].predict_proba(X)
        of_each = np.stack([model.predict_proba(X)[:, 1] for model in self.models_], axis=1)
        return of_each / of_each.sum(axis=1, keepdims=True)

    def predict(self, X):
        """The most probable class at each row of X."""
        probabilities = self.predict_proba(X)
        return self.classes_[np.argmax(probabilities, axis=1)]

    def score(self, X, y):
        """The share of rows of X whose class is predicted."""
        return float(np.mean(self.predict(X) == arguments.labels("y", y, np.shape(X)[0])))

    def _model(self):
        return GaussianProcess(**self.get_params())

    def _is_fitted(self):
        return hasattr(self, "models_")

    def _more_tags(self):
        return {**super()._more_tags(), "multioutput": False, "preserves_dtype": [np.float64, np.float32]}

    def __sklearn_tags__(self):
        from sklearn.utils import ClassifierTags, InputTags, Tags, TargetTags

        return Tags(
            estimator_type="classifier",
            target_tags=TargetTags(required=True),
            transformer_tags=None,
            classifier_tags=ClassifierTags(),
            regressor_tags=None,
            input_tags=InputTags(),
        )

    @staticmethod
    def _defaults():
        signature = inspect.signature(GaussianProcess)
        return {name: p.default for name, p in signature.parameters.items() if name not in _OF_REGRESSION}

    @classmethod
    def _parameter_names(cls):
        return sorted(cls._defaults())


GaussianProcessClassifier.__signature__ = inspect.Signature(
    [p for name, p in inspect.signature(GaussianProcess).parameters.items() if name not in _OF_REGRESSION]
)
