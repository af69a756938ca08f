"""The libraries that workers.py measures, one class each with the same calls."""

import math

import numpy as np
from problem import NOISE, PERIOD, UPDATE, WEIGHT, length_of

SAMPLES = 1000


class Absent(Exception):
    """The library does not have the covariance."""


def chosen(kernels, covariance):
    """The entry of a library's kernels."""
    if covariance not in kernels:
        raise Absent(f"has no {covariance}")
    return kernels[covariance]


class Library:
    """The operations that a worker measures. Libraries without updates fit again."""

    precision = "float64"

    def __init__(self, covariance, dimension):
        self.covariance, self.dimension, self.length = covariance, dimension, length_of(dimension)
        self.load()

    def replace(self, X, y, new_X, new_y):
        self.fit(np.vstack([X[UPDATE:], new_X]), np.concatenate([y[UPDATE:], new_y]))
        return self

    def append(self, X, y, new_X, new_y):
        self.fit(np.vstack([X, new_X]), np.concatenate([y, new_y]))
        return self

    def undo_append(self, count):
        pass


class Egosieve(Library):
    """This library, float32 on its device."""

    precision = "float32"

    def load(self):
        import egosieve

        lengths = [self.length] * self.dimension
        scales = {
            "arcsine": [WEIGHT] * (self.dimension + 1),
            "linear": [1.0] * self.dimension,
            "rational_quadratic": [1.0, *lengths],
            "periodic": lengths + [PERIOD] * self.dimension,
        }.get(self.covariance, lengths)
        self.version = egosieve.__version__
        self.new = lambda: egosieve.GaussianProcess(self.covariance, scales=scales, noise_stddev=NOISE, optimize=False)

    def fit(self, X, y):
        self.gp = self.new().fit(X, y)

    def mean(self, queries):
        return self.gp.predict(queries.astype(np.float32))

    def predict(self, queries):
        return self.gp.predict(queries.astype(np.float32), return_var=True)

    def joint(self, queries):
        return self.gp.predict(queries, return_cov=True)

    def samples(self, queries):
        return self.gp.sample_y(queries, SAMPLES)

    def replace(self, X, y, new_X, new_y):
        self.gp.partial_fit(new_X, new_y).remove(np.arange(UPDATE))
        return self

    def append(self, X, y, new_X, new_y):
        self.gp.partial_fit(new_X, new_y)
        return self

    def undo_append(self, count):
        self.gp.remove(np.arange(count, count + UPDATE))


class ScikitLearn(Library):
    """GaussianProcessRegressor."""

    def load(self):
        import sklearn
        from sklearn.gaussian_process import GaussianProcessRegressor, kernels

        available = {
            "squared_exponential": lambda: kernels.RBF(self.length),
            "matern12": lambda: kernels.Matern(self.length, nu=0.5),
            "matern32": lambda: kernels.Matern(self.length, nu=1.5),
            "matern52": lambda: kernels.Matern(self.length, nu=2.5),
            "rational_quadratic": lambda: kernels.RationalQuadratic(self.length, 1.0),
            "linear": lambda: kernels.DotProduct(0.0),
        }
        kernel = chosen(available, self.covariance)()
        self.version = sklearn.__version__
        self.new = lambda: GaussianProcessRegressor(kernel, alpha=NOISE**2, optimizer=None)

    def fit(self, X, y):
        self.gp = self.new().fit(X, y)

    def mean(self, queries):
        return self.gp.predict(queries)

    def predict(self, queries):
        mean, std = self.gp.predict(queries, return_std=True)
        return mean, std**2

    def joint(self, queries):
        return self.gp.predict(queries, return_cov=True)

    def samples(self, queries):
        return self.gp.sample_y(queries, SAMPLES)


class GPyTorchExact(Library):
    """ExactGP in float32, by Cholesky."""

    precision = "float32"
    fast = False

    def kernel(self):
        kernels = self.gpytorch.kernels
        made = chosen({
            "squared_exponential": kernels.RBFKernel,
            "matern12": lambda: kernels.MaternKernel(nu=0.5),
            "matern32": lambda: kernels.MaternKernel(nu=1.5),
            "matern52": lambda: kernels.MaternKernel(nu=2.5),
            "rational_quadratic": kernels.RQKernel,
            "periodic": kernels.PeriodicKernel,
            "linear": kernels.LinearKernel,
        }, self.covariance)()  # fmt: skip
        if self.covariance == "linear":
            made.variance = 1.0
            return made
        made.lengthscale = self.length
        if self.covariance == "rational_quadratic":
            made.alpha = 1.0
        if self.covariance == "periodic":
            made.lengthscale, made.period_length = self.length**2, PERIOD  # lengthscale has no square there
        return made

    def load(self):
        import gpytorch
        import torch

        torch.set_num_threads(2)
        self.torch, self.gpytorch = torch, gpytorch
        self.version = f"{gpytorch.__version__} (torch {torch.__version__})"
        kernel = self.kernel()

        class Model(gpytorch.models.ExactGP):
            def __init__(self, X, y, likelihood):
                super().__init__(X, y, likelihood)
                self.mean_module = gpytorch.means.ZeroMean()
                self.covar_module = kernel

            def forward(self, x):
                return gpytorch.distributions.MultivariateNormal(self.mean_module(x), self.covar_module(x))

        self.Model = Model

    def tensor(self, array):
        return self.torch.as_tensor(array, dtype=self.torch.float32)

    def fit(self, X, y):
        likelihood = self.gpytorch.likelihoods.GaussianLikelihood()
        likelihood.noise = NOISE**2
        self.gp = self.Model(self.tensor(X), self.tensor(y), likelihood).eval()
        likelihood.eval()

    def posterior(self, queries, read):
        settings = self.gpytorch.settings
        with self.torch.no_grad(), settings.fast_pred_var(self.fast), settings.max_cholesky_size(10**6):
            return read(self.gp(self.tensor(queries)))

    def mean(self, queries):
        with self.gpytorch.settings.skip_posterior_variances(True):
            return self.posterior(queries, lambda f: f.mean.numpy())

    def predict(self, queries):
        return self.posterior(queries, lambda f: (f.mean.numpy(), f.variance.numpy()))

    def joint(self, queries):
        return self.posterior(queries, lambda f: (f.mean.numpy(), f.covariance_matrix.numpy()))

    def samples(self, queries):
        return self.posterior(queries, lambda f: f.sample(self.torch.Size([SAMPLES])).numpy())


class GPyTorchFast(GPyTorchExact):
    """The same with fast_pred_var (LOVE), and updates by fantasy models where points only arrive."""

    fast = True

    def append(self, X, y, new_X, new_y):
        settings = self.gpytorch.settings
        grown = GPyTorchFast.__new__(GPyTorchFast)
        grown.__dict__.update(self.__dict__)
        with self.torch.no_grad(), settings.fast_pred_var(True), settings.max_cholesky_size(10**6):
            grown.gp = self.gp.get_fantasy_model(self.tensor(new_X), self.tensor(new_y))
        return grown


class GPy(Library):
    """GPRegression; its mean comes with the variance always."""

    def load(self):
        import GPy

        kern, d = GPy.kern, self.dimension
        lengths = {"variance": 1.0, "lengthscale": self.length}
        self.kernel = chosen({
            "squared_exponential": lambda: kern.RBF(d, **lengths),
            "matern12": lambda: kern.Exponential(d, **lengths),
            "matern32": lambda: kern.Matern32(d, **lengths),
            "matern52": lambda: kern.Matern52(d, **lengths),
            "rational_quadratic": lambda: kern.RatQuad(d, power=1.0, **lengths),
            "periodic": lambda: kern.StdPeriodic(d, variance=1.0, period=PERIOD, lengthscale=self.length / 2),
            "linear": lambda: kern.Linear(d, variances=1.0),
            # The arcsine with 2 / pi in front.
            "arcsine": lambda: kern.MLP(d, math.pi / 2, weight_variance=2 * WEIGHT**2, bias_variance=2 * WEIGHT**2),
        }, self.covariance)  # fmt: skip
        self.module, self.version = GPy, GPy.__version__

    def fit(self, X, y):
        self.gp = self.module.models.GPRegression(X, y[:, None], self.kernel(), noise_var=NOISE**2)

    def predict(self, queries):
        mean, variance = self.gp.predict_noiseless(queries)
        return mean[:, 0], variance[:, 0]

    def joint(self, queries):
        mean, covariance = self.gp.predict_noiseless(queries, full_cov=True)
        return mean[:, 0], covariance


class OpenTurns(Library):
    """Gaussian process regression at given hyperparameters; its covariances are those of the observation."""

    def load(self):
        import openturns

        self.ot, self.version = openturns, openturns.__version__
        nu = {"matern12": 0.5, "matern32": 1.5, "matern52": 2.5}.get(self.covariance)
        lengths = [self.length] * self.dimension
        self.kernel = chosen({
            "squared_exponential": lambda: openturns.SquaredExponential(lengths, [1.0]),
            **dict.fromkeys(("matern12", "matern32", "matern52"), lambda: openturns.MaternModel(lengths, [1.0], nu)),
        }, self.covariance)  # fmt: skip

    def fit(self, X, y):
        ot = self.ot
        covariance = self.kernel()
        covariance.setNuggetFactor(NOISE**2)
        fitter = ot.GaussianProcessFitter(ot.Sample(X), ot.Sample(np.ascontiguousarray(y[:, None])), covariance)
        fitter.setOptimizeParameters(False)
        fitter.setKeepCholeskyFactor(True)
        fitter.run()
        regression = ot.GaussianProcessRegression(fitter.getResult())
        regression.run()
        self.conditional = ot.GaussianProcessConditionalCovariance(regression.getResult())

    def mean(self, queries):
        return np.asarray(self.conditional.getConditionalMean(self.ot.Sample(queries))).ravel()

    def predict(self, queries):
        of_observation = self.conditional.getConditionalMarginalVariance(self.ot.Sample(queries))
        return self.mean(queries), np.asarray(of_observation).ravel() - NOISE**2

    def joint(self, queries):
        of_observation = np.array(self.conditional.getConditionalCovariance(self.ot.Sample(queries)))
        return self.mean(queries), of_observation - NOISE**2 * np.eye(len(queries))


LIBRARIES = {
    "egosieve": Egosieve,
    "scikit-learn": ScikitLearn,
    "GPyTorch exact": GPyTorchExact,
    "GPyTorch fast_pred_var": GPyTorchFast,
    "GPy": GPy,
    "OpenTURNS": OpenTurns,
}
