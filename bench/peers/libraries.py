"""The libraries that are measured, one class each with the same calls, and the packages that they need.

`kernels` makes a library's covariance with lengths `length`, alpha 1, weights WEIGHT and periods PERIOD, by the covariance's name.
"""

import importlib
import math

import numpy as np
from problem import NOISE, PERIOD, UPDATE, WEIGHT, length_of

SAMPLES = 1000


class Library:
    """The operations that a worker measures. Libraries without updates fit again."""

    packages, module_name, precision = (), "", "float64"

    def __init__(self, covariance, dimension):
        self.covariance, self.dimension, self.length = covariance, dimension, length_of(dimension)
        self.module = importlib.import_module(self.module_name)
        self.version = self.module.__version__
        kernels = self.kernels(dimension, self.length)
        if covariance not in kernels:
            raise ValueError(f"has no {covariance}")
        self.kernel = kernels[covariance]

    def replace(self, X, y, new_X, new_y):
        self.fit(np.vstack([X[UPDATE:], new_X]), np.concatenate([y[UPDATE:], new_y]))
        return self

    def append(self, X, y, new_X, new_y):
        self.fit(np.vstack([X, new_X]), np.concatenate([y, new_y]))
        return self

    def undo_append(self, count):
        pass


class ScikitLearn(Library):
    """GaussianProcessRegressor."""

    module_name = "sklearn"

    def kernels(self, dimension, length):
        from sklearn.gaussian_process import kernels

        return {
            "squared_exponential": lambda: kernels.RBF(length),
            "matern12": lambda: kernels.Matern(length, nu=0.5),
            "matern32": lambda: kernels.Matern(length, nu=1.5),
            "matern52": lambda: kernels.Matern(length, nu=2.5),
            "rational_quadratic": lambda: kernels.RationalQuadratic(length, 1.0),
            "linear": lambda: kernels.DotProduct(0.0),
        }

    def new(self):
        from sklearn.gaussian_process import GaussianProcessRegressor

        return GaussianProcessRegressor(self.kernel(), alpha=NOISE**2, optimizer=None)

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


class Egosieve(ScikitLearn):
    """This library, whose calls are scikit-learn's; float32 on its device."""

    module_name, precision = "egosieve", "float32"

    def kernels(self, dimension, length):
        lengths = [length] * dimension
        scales = dict.fromkeys(("squared_exponential", "matern12", "matern32", "matern52"), lengths) | {
            "arcsine": [WEIGHT] * (dimension + 1),
            "linear": [1.0] * dimension,
            "rational_quadratic": [1.0, *lengths],
            "periodic": lengths + [PERIOD] * dimension,
        }
        return {name: lambda own=own: own for name, own in scales.items()}

    def new(self):
        return self.module.GaussianProcess(self.covariance, scales=self.kernel(), noise_stddev=NOISE, optimize=False)

    def mean(self, queries):
        return self.gp.predict(queries.astype(np.float32))

    def predict(self, queries):
        return self.gp.predict(queries.astype(np.float32), return_var=True)

    def replace(self, X, y, new_X, new_y):
        self.gp.partial_fit(new_X, new_y).remove(np.arange(UPDATE))
        return self

    def append(self, X, y, new_X, new_y):
        self.gp.partial_fit(new_X, new_y)
        return self

    def undo_append(self, count):
        self.gp.remove(np.arange(count, count + UPDATE))


class GPyTorchExact(Library):
    """ExactGP in float32, by Cholesky."""

    packages, module_name, precision = ("torch", "gpytorch"), "gpytorch", "float32"
    fast = False

    def kernels(self, dimension, length):
        import torch

        torch.set_num_threads(2)
        self.torch = torch
        self.version += f" (torch {torch.__version__})"
        kernels = self.module.kernels

        def made(kind, parameters=(("lengthscale", length),), **arguments):
            def make():
                kernel = kind(**arguments)
                for name, value in dict(parameters).items():
                    setattr(kernel, name, value)
                return kernel

            return make

        return {
            "squared_exponential": made(kernels.RBFKernel),
            "matern12": made(kernels.MaternKernel, nu=0.5),
            "matern32": made(kernels.MaternKernel, nu=1.5),
            "matern52": made(kernels.MaternKernel, nu=2.5),
            "rational_quadratic": made(kernels.RQKernel, {"lengthscale": length, "alpha": 1.0}),
            # The length has no square there.
            "periodic": made(kernels.PeriodicKernel, {"lengthscale": length**2, "period_length": PERIOD}),
            "linear": made(kernels.LinearKernel, {"variance": 1.0}),
        }

    def tensor(self, array):
        return self.torch.as_tensor(array, dtype=self.torch.float32)

    def fit(self, X, y):
        gpytorch = self.module

        class Model(gpytorch.models.ExactGP):
            def forward(self, x):
                return gpytorch.distributions.MultivariateNormal(x.new_zeros(len(x)), self.kernel(x))

        likelihood = gpytorch.likelihoods.GaussianLikelihood()
        likelihood.noise = NOISE**2
        self.gp = Model(self.tensor(X), self.tensor(y), likelihood)
        self.gp.kernel = self.kernel()
        self.gp.eval()

    def posterior(self, queries, read):
        settings = self.module.settings
        with self.torch.no_grad(), settings.fast_pred_var(self.fast), settings.max_cholesky_size(10**6):
            return read(self.gp(self.tensor(queries)))

    def mean(self, queries):
        with self.module.settings.skip_posterior_variances(True):
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
        settings = self.module.settings
        grown = GPyTorchFast.__new__(GPyTorchFast)
        grown.__dict__.update(self.__dict__)
        with self.torch.no_grad(), settings.fast_pred_var(True), settings.max_cholesky_size(10**6):
            grown.gp = self.gp.get_fantasy_model(self.tensor(new_X), self.tensor(new_y))
        return grown


class GPy(Library):
    """GPRegression; its mean comes with the variance always."""

    packages, module_name = ("GPy", "matplotlib<3.9"), "GPy"

    def kernels(self, d, length):
        kern, lengths = self.module.kern, {"variance": 1.0, "lengthscale": length}
        return {
            "squared_exponential": lambda: kern.RBF(d, **lengths),
            "matern12": lambda: kern.Exponential(d, **lengths),
            "matern32": lambda: kern.Matern32(d, **lengths),
            "matern52": lambda: kern.Matern52(d, **lengths),
            "rational_quadratic": lambda: kern.RatQuad(d, power=1.0, **lengths),
            "periodic": lambda: kern.StdPeriodic(d, variance=1.0, period=PERIOD, lengthscale=length / 2),
            "linear": lambda: kern.Linear(d, variances=1.0),
            # The arcsine with 2 / pi in front.
            "arcsine": lambda: kern.MLP(d, math.pi / 2, weight_variance=2 * WEIGHT**2, bias_variance=2 * WEIGHT**2),
        }

    def fit(self, X, y):
        self.gp = self.module.models.GPRegression(X, y[:, None], self.kernel(), noise_var=NOISE**2)

    def predict(self, queries, full_cov=False):
        mean, variance = self.gp.predict_noiseless(queries, full_cov=full_cov)
        return mean[:, 0], variance if full_cov else variance[:, 0]

    def joint(self, queries):
        return self.predict(queries, full_cov=True)


class OpenTurns(Library):
    """Gaussian process regression at given hyperparameters; its covariances are those of the observation."""

    packages, module_name = ("openturns",), "openturns"

    def kernels(self, dimension, length):
        ot, lengths = self.module, [length] * dimension
        return {"squared_exponential": lambda: ot.SquaredExponential(lengths, [1.0])} | {
            name: lambda nu=nu: ot.MaternModel(lengths, [1.0], nu) for name, nu in (("matern12", 0.5), ("matern32", 1.5), ("matern52", 2.5))
        }

    def fit(self, X, y):
        ot, covariance = self.module, self.kernel()
        covariance.setNuggetFactor(NOISE**2)
        fitter = ot.GaussianProcessFitter(ot.Sample(X), ot.Sample(np.ascontiguousarray(y[:, None])), covariance)
        fitter.setOptimizeParameters(False)
        fitter.setKeepCholeskyFactor(True)
        fitter.run()
        regression = ot.GaussianProcessRegression(fitter.getResult())
        regression.run()
        self.conditional = ot.GaussianProcessConditionalCovariance(regression.getResult())

    def mean(self, queries):
        return np.asarray(self.conditional.getConditionalMean(self.module.Sample(queries))).ravel()

    def predict(self, queries):
        of_observation = self.conditional.getConditionalMarginalVariance(self.module.Sample(queries))
        return self.mean(queries), np.asarray(of_observation).ravel() - NOISE**2

    def joint(self, queries):
        of_observation = np.array(self.conditional.getConditionalCovariance(self.module.Sample(queries)))
        return self.mean(queries), of_observation - NOISE**2 * np.eye(len(queries))


LIBRARIES = {
    "egosieve": Egosieve,
    "scikit-learn": ScikitLearn,
    "GPyTorch exact": GPyTorchExact,
    "GPyTorch fast_pred_var": GPyTorchFast,
    "GPy": GPy,
    "OpenTURNS": OpenTurns,
}
