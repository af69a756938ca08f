/**
 * @file gaussian_process.hpp
 * Gaussian process regression and classification, exact and sparse, in C++17. The classes own the
 * handles of gaussian_process.h and joint_posterior.h, which give equations, costs and errors.
 *
 *     auto gp = egosieve::GaussianProcess::Create(options).value();
 *     gp.Condition({x, n, d}, {y, n}).ThrowIfError();
 *     gp.Predict({queries, m, d}, {{mean, m}, {variance, m}}).ThrowIfError();
 */
#ifndef EGOSIEVE_GAUSSIAN_PROCESS_HPP_
#define EGOSIEVE_GAUSSIAN_PROCESS_HPP_

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "gaussian_process.h"
#include "joint_posterior.h"
#include "posterior.hpp"
#include "result.hpp"

namespace egosieve {

/** Covariance function. */
enum class Covariance : int32_t {
  kArcsine = EGOSIEVE_ARCSINE,                        /**< Neural network, D + 1 weights. */
  kSquaredExponential = EGOSIEVE_SQUARED_EXPONENTIAL, /**< Gaussian, D length-scales. */
  kNamed = EGOSIEVE_NAMED_COVARIANCE,                 /**< The function of covariance_text. */
};

/** Mean function; its coefficients are estimated from the data. */
enum class Mean : int32_t {
  kZero = EGOSIEVE_ZERO_MEAN,         /**< No coefficients. */
  kConstant = EGOSIEVE_CONSTANT_MEAN, /**< One coefficient. */
  kLinear = EGOSIEVE_LINEAR_MEAN,     /**< D + 1 coefficients, the constant first. */
};

/** How a model represents its points. */
enum class Approximation : int64_t {
  kExact = EGOSIEVE_EXACT,         /**< None. */
  kDtc = EGOSIEVE_DTC,             /**< Deterministic training conditional. */
  kFitc = EGOSIEVE_FITC,           /**< Fully independent training conditional. */
  kIterative = EGOSIEVE_ITERATIVE, /**< Exact means by conjugate gradients, without a factor. */
};

/** Options for a new model. */
struct GaussianProcessOptions {
  Covariance covariance = Covariance::kArcsine;        /**< Covariance function. */
  std::string covariance_text;                         /**< As in #egosieve_gp_options. */
  Mean mean = Mean::kZero;                             /**< Mean function. */
  int32_t dimension = 0;                               /**< D, 1 to 256; must be set. */
  std::vector<double> scales;                          /**< Positive; empty: default values. */
  double signal_stddev = 1.0;                          /**< sigma_f, positive. */
  double noise_stddev = 0.1;                           /**< sigma_n, positive. */
  std::string device;                                  /**< As in #egosieve_gp_options. */
  void* opencl_context = nullptr;                      /**< As in #egosieve_gp_options. */
  void* opencl_device = nullptr;                       /**< As in #egosieve_gp_options. */
  int64_t memory_cap_bytes = 0;                        /**< As in #egosieve_gp_options. */
  Approximation approximation = Approximation::kExact; /**< Exact or sparse. */
  int64_t inducing_points = 512;                       /**< Largest m, if not exact. */
  double tolerance = 1e-8;                             /**< Of an iterative model's residual. */
};

/** Current state of a model. */
struct GaussianProcessInfo {
  int64_t size = 0;                                    /**< n, the number of points. */
  int32_t dimension = 0;                               /**< D. */
  Covariance covariance = Covariance::kArcsine;        /**< Covariance function. */
  std::string covariance_text;                         /**< The function as text. */
  Mean mean = Mean::kZero;                             /**< Mean function. */
  int64_t outputs = 1;                                 /**< k. */
  std::vector<double> scales;                          /**< Weights, length-scales and so on. */
  double signal_stddev = 0.0;                          /**< sigma_f. */
  double noise_stddev = 0.0;                           /**< sigma_n. */
  double jitter = 0.0;                                 /**< Added to sigma_n^2 to factor K. */
  double squash_a = 1.0;                               /**< a of the probability. */
  double squash_b = 0.0;                               /**< b of the probability. */
  Approximation approximation = Approximation::kExact; /**< Exact or sparse. */
  int64_t inducing_points = 0;                         /**< Largest m; 0 for an exact model. */
  int64_t inducing_count = 0;                          /**< The current m. */
  double tolerance = 0.0;                              /**< Of an iterative model's residual. */
  int64_t iterations = 0;                              /**< As in #egosieve_gp_info. */
  double residual = 0.0;                               /**< As in #egosieve_gp_info. */
};

/** Options of the optimisation of hyperparameters; see egosieve_gp_optimize(). */
struct OptimizeOptions {
  int64_t subset_size = 800;    /**< Largest number of points used; 0: all. */
  int32_t restarts = 0;         /**< Random starts after the first. */
  int32_t gradient_steps = 500; /**< Largest number of steps from one start. */
  double tolerance = 1e-3;      /**< Of the largest component of the gradient, nats. */
  uint64_t seed = 1;            /**< Seed of the subset and the restarts. */
  std::vector<double> lower;    /**< Of scales, sigma_f, sigma_n; empty or NaN: the default. */
  std::vector<double> upper;    /**< As lower; equal bounds keep a value fixed. */
};

/** Result of an optimisation; likelihoods are of the points used. */
struct OptimizeResult {
  double log_likelihood_at_start = 0.0; /**< Before the optimisation. */
  double log_likelihood = 0.0;          /**< After it. */
  int64_t evaluations = 0;              /**< Number of evaluations of the likelihood. */
  int64_t points = 0;                   /**< Number of points used. */
  bool converged = false;               /**< gradient_norm is within the tolerance. */
  double gradient_norm = 0.0;           /**< Largest component of the gradient, nats. */
  std::vector<int32_t> on_bound;        /**< Of each: -1 on its lower, 1 on its upper bound. */
};

/** Destinations of leave-one-out predictions; a default Array is not wanted. */
struct LeftOut {
  Array mean{};        /**< Of y, n x k. */
  Array variance{};    /**< Of y, n. */
  Array log_density{}; /**< log p(y_i | others), n x k. */
};

/** The likelihood at given hyperparameters. */
struct Likelihood {
  double value = 0.0;           /**< log p(y | X). */
  std::vector<double> gradient; /**< By the logarithms; empty if not asked for. */
};

/** A model that learns. Calls on one model wait for each other. */
class GaussianProcess : public Predictor<egosieve_gp, egosieve_gp_free, egosieve_gp_predict,
                                         egosieve_gp_predict_grid, egosieve_gp_predict_image> {
 public:
  using Predictor::Predictor;

  /** Creates a model without points: the prior. */
  static Result<GaussianProcess> Create(const GaussianProcessOptions& options) {
    egosieve_gp_options c;
    egosieve_gp_options_init(&c);
    c.covariance = static_cast<egosieve_covariance>(options.covariance);
    c.covariance_text = options.covariance_text.c_str();
    c.mean = static_cast<egosieve_mean>(options.mean);
    c.dimension = options.dimension;
    c.scales = options.scales.empty() ? nullptr : options.scales.data();
    c.scale_count = static_cast<int64_t>(options.scales.size());
    c.signal_stddev = options.signal_stddev;
    c.noise_stddev = options.noise_stddev;
    c.device = options.device.c_str();
    c.opencl_context = options.opencl_context;
    c.opencl_device = options.opencl_device;
    c.memory_cap_bytes = options.memory_cap_bytes;
    c.approximation = static_cast<egosieve_approximation>(options.approximation);
    c.inducing_points = options.inducing_points;
    c.tolerance = options.tolerance;
    egosieve_gp* handle = nullptr;
    return internal::Own<GaussianProcess>(egosieve_gp_create(&c, &handle), handle);
  }
  /** Reads a model file; an error where its y are normalised, as by normalize_y in Python. */
  static Result<GaussianProcess> Load(const std::string& path, const std::string& device = "") {
    egosieve_gp* handle = nullptr;
    return internal::Own<GaussianProcess>(egosieve_gp_load(path.c_str(), device.c_str(), &handle),
                                          handle);
  }
  /** Creates a model from the bytes of Serialize(). */
  static Result<GaussianProcess> Deserialize(const std::string& bytes,
                                             const std::string& device = "") {
    egosieve_gp* handle = nullptr;
    const auto size = static_cast<int64_t>(bytes.size());
    return internal::Own<GaussianProcess>(
        egosieve_gp_deserialize(bytes.data(), size, device.c_str(), &handle), handle);
  }

  /** Adds N points: x is N x D, y is N x k. */
  Status Condition(const ConstArray& x, const ConstArray& y) {
    return Call(egosieve_gp_condition, x.c(), y.c());
  }
  /** The same with a noise variance for each point, on top of sigma_n^2. */
  Status Condition(const ConstArray& x, const ConstArray& y, const ConstArray& noise_variances) {
    return Call(egosieve_gp_condition_noisy, x.c(), y.c(), noise_variances.c());
  }
  /** Removes points by index, each once, in any order; the points after them move up. */
  Status Remove(const std::vector<int64_t>& rows) {
    return Call(egosieve_gp_remove, rows.data(), static_cast<int64_t>(rows.size()));
  }
  /** Sets the hyperparameters and rebuilds the factor. */
  Status SetHyperparameters(const std::vector<double>& scales, double signal_stddev,
                            double noise_stddev) {
    return Call(egosieve_gp_set_hyperparameters, scales.data(), static_cast<int64_t>(scales.size()),
                signal_stddev, noise_stddev);
  }
  /** Maximises the log marginal likelihood over the hyperparameters. */
  Result<OptimizeResult> Optimize(const OptimizeOptions& options = {}) {
    return Search(&options,
                  [this](const egosieve_optimize_options* c, egosieve_optimize_result* result) {
                    return egosieve_gp_optimize(handle_, c, result);
                  });
  }
  /**
   * Classification by Laplace's approximation, see egosieve_gp_classify(): y holds N labels -1 or
   * 1, a default weights counts each row once; options null: the hyperparameters stay.
   */
  Result<OptimizeResult> Classify(const ConstArray& x, const ConstArray& y,
                                  const ConstArray& weights = {},
                                  const OptimizeOptions* options = nullptr) {
    return Search(
        options, [&](const egosieve_optimize_options* c, egosieve_optimize_result* result) {
          return egosieve_gp_classify(handle_, x.c(), y.c(),
                                      weights.c()->data == nullptr ? nullptr : weights.c(),
                                      options == nullptr ? nullptr : c, result);
        });
  }
  /** Fits the probabilities by leave-one-out likelihood; every y must be a label. */
  Status Calibrate() { return Call(egosieve_gp_calibrate); }

  /** The current state of the model. */
  Result<GaussianProcessInfo> Describe() const {
    egosieve_gp_info c;
    egosieve_gp_info_init(&c);
    Status status = Call(egosieve_gp_describe, &c);
    if (!status.ok()) return status;
    GaussianProcessInfo info;
    info.size = c.size;
    info.dimension = c.dimension;
    info.covariance = static_cast<Covariance>(c.covariance);
    info.mean = static_cast<Mean>(c.mean);
    info.outputs = c.outputs;
    info.scales.resize(static_cast<size_t>(c.scale_count));
    status = Call(egosieve_gp_scales, info.scales.data(), c.scale_count);
    if (!status.ok()) return status;
    Result<std::string> text = Bytes(egosieve_gp_covariance_text);
    if (!text.ok()) return text.status();
    info.covariance_text = *std::move(text);
    info.signal_stddev = c.signal_stddev;
    info.noise_stddev = c.noise_stddev;
    info.jitter = c.jitter;
    info.squash_a = c.squash_a;
    info.squash_b = c.squash_b;
    info.approximation = static_cast<Approximation>(c.approximation);
    info.inducing_points = c.inducing_points;
    info.inducing_count = c.inducing_count;
    info.tolerance = c.tolerance;
    info.iterations = c.iterations;
    info.residual = c.residual;
    return info;
  }
  /** Copies the noise variances of the points, n values. */
  Status NoiseVariances(const Array& v) const { return Call(egosieve_gp_noise_variances, &v.c()); }
  /** Copies the points: x is n x D, y is n x k; a default Array is not wanted. */
  Status Points(const Array& x, const Array& y) const {
    return Call(egosieve_gp_points, &x.c(), &y.c());
  }
  /** log p(y | X). */
  Result<double> LogMarginalLikelihood() const {
    double value = 0.0;
    return internal::Given(egosieve_gp_log_marginal_likelihood(handle_, &value), value);
  }

  /** The inputs of PredictImage() at N places (x, y) in pixels: out is N x 6. */
  Status DescribePixels(const Image& image, const ConstArray& places, const Array& out) const {
    const egosieve_image c_image = image.c();
    return Call(egosieve_gp_describe_pixels, &c_image, places.c(), &out.c());
  }
  /** Mean (M x k) and joint covariance (M x M) at M x D points; a default Array is not wanted. */
  Status PredictJoint(const ConstArray& x, const Array& mean, const Array& covariance,
                      bool of_observation = false) const {
    return Call(egosieve_gp_predict_joint, x.c(), of_observation, &mean.c(), &covariance.c());
  }
  /**
   * k(x_i, z_j), N x M, at the model's hyperparameters, and its derivatives, see
   * egosieve_gp_covariances(); a default z is x, and a default Array is not wanted.
   */
  Status Covariances(const ConstArray& x, const ConstArray& z, const Array& k,
                     const Array& by_logarithms = {}, const Array& by_x = {}) const {
    return Call(egosieve_gp_covariances, x.c(), z.c()->data == nullptr ? nullptr : z.c(), &k.c(),
                &by_logarithms.c(), &by_x.c());
  }
  /**
   * Enqueues the kernel matrix from and to OpenCL buffers, see egosieve_gp_enqueue_covariances().
   * The value: a cl_event, which the caller releases.
   */
  Result<void*> EnqueueCovariances(const DeviceMatrix& x, const DeviceMatrix& z,
                                   const DeviceMatrix& k, void* queue,
                                   const std::vector<void*>& wait = {}) const {
    void* event = nullptr;
    return internal::Given(
        egosieve_gp_enqueue_covariances(handle_, &x, &z, &k, queue, wait.data(),
                                        static_cast<int64_t>(wait.size()), &event),
        event);
  }
  /** Samples, (M k) x S, from the joint distribution at M x D points. The value: the jitter. */
  Result<double> Sample(const ConstArray& x, uint64_t seed, const Array& samples,
                        bool of_observation = false) const {
    double jitter = 0.0;
    return internal::Given(
        egosieve_gp_sample(handle_, x.c(), seed, of_observation, &samples.c(), &jitter), jitter);
  }
  /** Samples as functions, (M k) x S, of F frequencies: egosieve_gp_sample_paths(). */
  Status SamplePaths(const ConstArray& x, uint64_t seed, const Array& samples,
                     bool of_observation = false, int64_t frequencies = 1024) const {
    return Call(egosieve_gp_sample_paths, x.c(), seed, frequencies, of_observation, &samples.c());
  }
  /** Gradients with respect to the inputs: of the mean (M k) x D, of the variance M x D. */
  Status Gradients(const ConstArray& x, const Array& mean, const Array& variance = {}) const {
    return Call(egosieve_gp_gradients, x.c(), &mean.c(), &variance.c());
  }
  /** Leave-one-out: predicts each point's y from all others. */
  Status LeaveOneOut(const LeftOut& out) const {
    return Call(egosieve_gp_leave_one_out, &out.mean.c(), &out.variance.c(), &out.log_density.c());
  }
  /** The mean function's coefficients, q x k. */
  Status MeanCoefficients(const Array& coefficients) const {
    return Call(egosieve_gp_mean_coefficients, &coefficients.c());
  }
  /** The likelihood at theta, the logarithms of scales, sigma_f and sigma_n. */
  Result<Likelihood> LikelihoodAt(const std::vector<double>& theta, bool with_gradient) const {
    Likelihood likelihood;
    likelihood.gradient.resize(with_gradient ? theta.size() : 0);
    return internal::Given(
        egosieve_gp_likelihood_at(handle_, theta.data(), static_cast<int64_t>(theta.size()),
                                  &likelihood.value,
                                  with_gradient ? likelihood.gradient.data() : nullptr),
        likelihood);
  }
  /** A posterior of the model's current state, for threads that predict while the model learns. */
  Result<Posterior> MakePosterior() const {
    egosieve_posterior* posterior = nullptr;
    return internal::Own<Posterior>(egosieve_gp_posterior(handle_, &posterior), posterior);
  }
  /** The same on devices by name, which share the queries: egosieve_gp_posterior_on_devices(). */
  Result<Posterior> MakePosterior(const std::vector<std::string>& devices) const {
    std::vector<const char*> names;
    for (const std::string& device : devices) names.push_back(device.c_str());
    egosieve_posterior* posterior = nullptr;
    return internal::Own<Posterior>(
        egosieve_gp_posterior_on_devices(handle_, names.data(), static_cast<int64_t>(names.size()),
                                         &posterior),
        posterior);
  }

  /** Stores bytes with the model and in its file. */
  Status SetAnnotation(const std::string& bytes) {
    return Call(egosieve_gp_set_annotation, bytes.data(), static_cast<int64_t>(bytes.size()));
  }
  /** The bytes of SetAnnotation(). */
  Result<std::string> Annotation() const { return Bytes(egosieve_gp_annotation); }
  /** Writes the model into a file, completely or not at all; rebuilds the factor. */
  Status Save(const std::string& path) { return Call(egosieve_gp_save, path.c_str()); }
  /** The bytes that Save() would write. */
  Result<std::string> Serialize() { return Bytes(egosieve_gp_serialize); }

 private:
  // Calls `run` with the options, null for the defaults, and gives its result.
  template <typename Run>
  Result<OptimizeResult> Search(const OptimizeOptions* given, const Run& run) {
    const OptimizeOptions options = given == nullptr ? OptimizeOptions{} : *given;
    const Result<GaussianProcessInfo> info = Describe();
    if (!info.ok()) return info.status();
    std::vector<int32_t> on_bound(info.value().scales.size() + 2);
    egosieve_optimize_options c;
    egosieve_optimize_result result;
    egosieve_optimize_options_init(&c);
    egosieve_optimize_result_init(&result);
    result.on_bound = on_bound.data();
    result.on_bound_count = static_cast<int64_t>(on_bound.size());
    if (!options.lower.empty() && !options.upper.empty() &&
        options.lower.size() != options.upper.size()) {
      return Status(Code::kInvalidArgument, "lower and upper differ in size");
    }
    c.lower_bounds = options.lower.empty() ? nullptr : options.lower.data();
    c.upper_bounds = options.upper.empty() ? nullptr : options.upper.data();
    c.bound_count = static_cast<int64_t>(std::max(options.lower.size(), options.upper.size()));
    c.subset_size = options.subset_size;
    c.restarts = options.restarts;
    c.gradient_steps = options.gradient_steps;
    c.tolerance = options.tolerance;
    c.seed = options.seed;
    Status status = Status::FromC(run(&c, &result));
    if (!status.ok()) return status;
    return OptimizeResult{result.log_likelihood_at_start,
                          result.log_likelihood,
                          result.evaluations,
                          result.points,
                          result.converged != 0,
                          result.gradient_norm,
                          on_bound};
  }

  Result<std::string> Bytes(egosieve_status (*call)(egosieve_gp*, void*, int64_t, int64_t*)) const {
    int64_t size = 0;
    std::string bytes;
    Status status = Call(call, nullptr, 0, &size);
    while (status.ok()) {
      bytes.resize(static_cast<size_t>(size));
      Status given = Call(call, &bytes[0], size, &size);
      if (given.ok()) return bytes.substr(0, static_cast<size_t>(size));
      status = Call(call, nullptr, 0, &size);
      if (size <= static_cast<int64_t>(bytes.size())) return given;  // not longer in between
    }
    return status;
  }
};

}  // namespace egosieve

#endif  // EGOSIEVE_GAUSSIAN_PROCESS_HPP_
