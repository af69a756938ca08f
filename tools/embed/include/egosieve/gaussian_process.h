/**
 * @file gaussian_process.h
 * Exact Gaussian process regression and classification by least squares, on an OpenCL device.
 *
 * A model holds n points (x_i, y_i), x in D dimensions, y of k outputs, noise variances v_i:
 *
 *     L L^T = K + diag(sigma_n^2 + v_i),   alpha = (L L^T)^-1 y                            (1)
 *     mean(x)        = k*.alpha                                                            (2)
 *     variance(x)    = k** - |L^-1 k*|^2     of f; of an observation: + sigma_n^2          (3)
 *     probability(x) = Phi( (a mean + b) / sqrt(1 + a^2 variance) )   of y = +1 against -1 (4)
 *
 * The outputs share covariance, noise and factor, and therefore have the same variances. The prior
 * mean is zero or h(x).b with h = (1) or (1, x). There is no prior knowledge about the coefficients
 * b: they are estimated by generalised least squares, and (2), (3) include them and their
 * uncertainty (universal kriging).
 *
 * The covariance k is the arcsine (neural network) function
 *
 *     k(x, x') = sigma_f^2 asin( u.u' / sqrt((1 + u.u)(1 + u'.u')) ),
 *     u = sqrt(2) diag(w) (1, x)                         scales = (w_0, w_1, ..., w_D)
 *
 * or the squared exponential
 *
 *     k(x, x') = sigma_f^2 exp( -1/2 sum_d ((x_d - x'_d) / l_d)^2 )   scales = (l_1, ..., l_D)
 *
 * or any other function given as a text: arcsine, constant, linear, matern12, matern32, matern52,
 * periodic, rational_quadratic, squared_exponential and white, their sums and products, and
 * isotropic(...), in which all inputs share a scale: "matern52 + linear * isotropic(periodic)".
 * Columns restrict a function to some of the inputs, counted from 0: "matern52[0:3] * periodic[3]"
 * is of inputs 0, 1, 2 and of input 3. Such a function has scales for its own inputs alone. The
 * scales are those of the functions in the order of the text; each term of a sum, except the first,
 * has an amplitude before its scales.
 *
 * A sparse model represents the points by m of them, the inducing inputs u. They are chosen by
 * pivoted Cholesky, and again when points change. With k_u(x) = k(u, x), K_uu = k(u, u), S = sum_i
 * k_u(x_i) k_u(x_i)^T / lambda_i:
 *
 *     mean(x) = k_u.(K_uu + S)^-1 sum_i k_u(x_i) y_i / lambda_i
 *     variance(x) = k** - k_u.K_uu^-1 k_u + k_u.(K_uu + S)^-1 k_u                          (5)
 *     lambda_i = sigma_n^2 + v_i                                    DTC
 *     lambda_i = sigma_n^2 + v_i + k(x_i, x_i) - k_u(x_i).K_uu^-1 k_u(x_i)   FITC
 *
 * An iterative model has the exact means (2) of more points than a factor of 8 n^2 bytes allows.
 * Its alpha is found by conjugate gradients, preconditioned by DTC with m inducing inputs, until
 * |y - K_y alpha| <= tolerance |y| for each output, K_y = K + diag(sigma_n^2 + v_i); means are then
 * off by at most tolerance sqrt(k**) |y| / sigma_n. The first call that needs alpha computes it:
 * #EGOSIEVE_FAILED_PRECONDITION if 1,000 iterations do not reach the tolerance. It has the zero
 * mean and no variances: what needs them (joint and left-out predictions, samples, probabilities,
 * likelihoods) is #EGOSIEVE_FAILED_PRECONDITION. egosieve_gp_optimize() takes the exact likelihood
 * of a subset. Its means are computed in float64 unless a prediction asks for float32.
 *
 * A sparse model has one output and the zero mean. Its likelihood, which egosieve_gp_optimize()
 * maximises, is the variational lower bound of the exact likelihood (Titsias) for DTC, and FITC's
 * own for FITC.
 *
 * Cost in flops: conditioning on k points k n^2, removing k points 2 k n^2; each query n (D + 10)
 * for the mean and n^2 / 2 more for the variance. For a sparse model, n is replaced by m, and k
 * points cost 2 k m^2 + m^3 / 3. Memory: 8 n^2 bytes, and 2 n^2 on the device; for a sparse model 24
 * m^2, and 8 n m more while it chooses inducing inputs. For an iterative model n^2 / 2 covariances,
 * 2 k n^2 and 4 k n m flops per iteration, and 8 n (D + m + 7 k) bytes.
 *
 * References: Rasmussen & Williams (2006), 2.2, 2.7 and 6.5, eq. 4.29 (with 2/pi in front), eq.
 * 6.41, 3.4; Quinonero-Candela & Rasmussen (2005); Titsias (2009). Predictions and their errors are in
 * prediction.h; samples, gradients and all else in joint_posterior.h.
 */
#ifndef EGOSIEVE_GAUSSIAN_PROCESS_H_
#define EGOSIEVE_GAUSSIAN_PROCESS_H_

#include "prediction.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef int32_t egosieve_covariance; /**< Covariance function: one of these. */
/** The values of #egosieve_covariance. */
enum {
  EGOSIEVE_ARCSINE = 0,             /**< Neural network covariance, D + 1 weights, bias first. */
  EGOSIEVE_SQUARED_EXPONENTIAL = 1, /**< Gaussian covariance, D length-scales. */
  EGOSIEVE_NAMED_COVARIANCE = 2     /**< The one that a text names. */
};

typedef int32_t egosieve_mean; /**< Mean function: one of these. */
/** The values of #egosieve_mean. */
enum {
  EGOSIEVE_ZERO_MEAN = 0,     /**< No coefficients. */
  EGOSIEVE_CONSTANT_MEAN = 1, /**< One coefficient. */
  EGOSIEVE_LINEAR_MEAN = 2    /**< D + 1 coefficients, the constant first. */
};

typedef int64_t egosieve_approximation; /**< How a model represents its points: one of these. */
/** The values of #egosieve_approximation. */
enum {
  EGOSIEVE_EXACT = 0, /**< None: the exact model. */
  EGOSIEVE_DTC = 1,   /**< Deterministic training conditional, trained by the variational bound. */
  EGOSIEVE_FITC = 2,  /**< Fully independent training conditional. */
  EGOSIEVE_ITERATIVE = 3 /**< The exact means by conjugate gradients, without a factor. */
};

/** The largest D. */
#define EGOSIEVE_MAX_DIMENSION 256

/** Number of scales that fit into #egosieve_gp_info; egosieve_gp_scales() gives all. */
#define EGOSIEVE_INFO_SCALES 33

/** Options for a new model. */
typedef struct egosieve_gp_options {
  uint64_t struct_size;           /**< Set by egosieve_gp_options_init(). */
  egosieve_covariance covariance; /**< Default: #EGOSIEVE_ARCSINE. */
  int32_t dimension;              /**< D, 1 to #EGOSIEVE_MAX_DIMENSION. No default. */
  const double* scales;           /**< Positive; null: default values (w = exp(0.7), l = 0.5). */
  int64_t scale_count;            /**< Number of scales of the covariance; 0 if scales is null. */
  double signal_stddev;           /**< sigma_f, positive. Default: 1. */
  double noise_stddev;            /**< sigma_n, positive. Default: 0.1. */
  const char* device;             /**< Index of a device, part of its name, "cpu", "gpu" or
                                    "reference". Null or empty: the variable EGOSIEVE_DEVICE, else a
                                    GPU, else a CPU. */
  int64_t memory_cap_bytes;       /**< Device memory for tiles. 0, the default, and loaded models:
                                    256 MiB, or an eighth of a GPU's memory if that is more. */
  const char* covariance_text;    /**< The covariance as a text; `covariance` must then be
                                    #EGOSIEVE_NAMED_COVARIANCE or its default. Default: null. */
  egosieve_mean mean;             /**< Default: #EGOSIEVE_ZERO_MEAN. */
  egosieve_approximation approximation; /**< Default: #EGOSIEVE_EXACT. */
  int64_t inducing_points; /**< Largest m, for a sparse or an iterative model. Default: 512. */
  void* opencl_context; /**< The cl_context to compute on, instead of `device` (device_call.h); it
                             is retained. Default: null. */
  void* opencl_device;  /**< A cl_device_id of that context; null: its first. */
  double tolerance; /**< Of an iterative model's residual |y - K_y alpha| / |y|. Default: 1e-8. */
} egosieve_gp_options;

/** Sets every field to its default. Null does nothing. */
EGOSIEVE_API void egosieve_gp_options_init(egosieve_gp_options* options);

/** Creates a model without points: the prior. `*gp` is written only on success. */
EGOSIEVE_API egosieve_status egosieve_gp_create(const egosieve_gp_options* options,
                                                egosieve_gp** gp);

/**
 * Frees a model; null is #EGOSIEVE_OK. Calls in progress on other threads either end first or
 * continue undisturbed; later calls return #EGOSIEVE_INVALID_HANDLE.
 */
EGOSIEVE_API egosieve_status egosieve_gp_free(egosieve_gp* gp);

/**
 * Appends points to the model.
 * @param gp  The model.
 * @param x   N x D, finite.
 * @param y   N x k, finite; for k = 1 also 1 x N. k must be that of the points in the model. For
 *            probabilities, use one output with labels -1 and 1 (soft labels lie between). If every
 *            y is 0 or 1 and at least one is 0, probabilities are refused: pass 2 y - 1 as labels.
 */
EGOSIEVE_API egosieve_status egosieve_gp_condition(egosieve_gp* gp, const egosieve_const_array* x,
                                                   const egosieve_const_array* y);

/** The same with noise per point: v holds N variances >= 0, added to sigma_n^2; null: all 0. */
EGOSIEVE_API egosieve_status egosieve_gp_condition_noisy(egosieve_gp* gp,
                                                         const egosieve_const_array* x,
                                                         const egosieve_const_array* y,
                                                         const egosieve_const_array* v);

/**
 * Removes points; the points after them move up.
 * @param gp     The model.
 * @param rows   Indices of points, each once, in any order.
 * @param count  Number of rows.
 */
EGOSIEVE_API egosieve_status egosieve_gp_remove(egosieve_gp* gp, const int64_t* rows,
                                                int64_t count);

/** Current state of a model. */
typedef struct egosieve_gp_info {
  uint64_t struct_size;                /**< Set by egosieve_gp_info_init(). */
  int64_t size;                        /**< n, the number of points. */
  int32_t dimension;                   /**< D. */
  egosieve_covariance covariance;      /**< Covariance function. */
  int64_t scale_count;                 /**< Number of all scales. */
  double scales[EGOSIEVE_INFO_SCALES]; /**< The first scales. */
  double signal_stddev;                /**< sigma_f. */
  double noise_stddev;                 /**< sigma_n. */
  double jitter;                       /**< Added to sigma_n^2 if (1) was nearly singular. */
  double squash_a;                     /**< a of (4). */
  double squash_b;                     /**< b of (4). */
  int64_t has_labels;   /**< Nonzero: every y is a label, see egosieve_gp_condition(). */
  int64_t outputs;      /**< k. */
  int64_t coefficients; /**< Coefficients of the mean function, per output. */
  egosieve_mean mean;   /**< Mean function. */
  egosieve_approximation approximation; /**< Of a sparse model; otherwise #EGOSIEVE_EXACT. */
  int64_t inducing_points;              /**< Largest m; 0 for an exact model. */
  int64_t inducing_count;               /**< The current m; 0 for an iterative model. */
  double tolerance;                     /**< Of an iterative model; 0 for others. */
  int64_t iterations; /**< That an iterative model's weights took; -1: they are not there yet. */
  double residual;    /**< The largest |y - K_y alpha| / |y| of an output with these weights. */
} egosieve_gp_info;

/** Sets struct_size, and every other field to 0. Null does nothing. */
EGOSIEVE_API void egosieve_gp_info_init(egosieve_gp_info* info);

/** Fills `info`. */
EGOSIEVE_API egosieve_status egosieve_gp_describe(egosieve_gp* gp, egosieve_gp_info* info);

/** Copies all scales; `count` must be at least egosieve_gp_info.scale_count. */
EGOSIEVE_API egosieve_status egosieve_gp_scales(egosieve_gp* gp, double* scales, int64_t count);

/** The covariance as text, without a final zero; arguments as in egosieve_gp_annotation(). */
EGOSIEVE_API egosieve_status egosieve_gp_covariance_text(egosieve_gp* gp, void* text,
                                                         int64_t capacity, int64_t* size);

/** Copies the model's points: x is n x D, y is n x k; an array with null data is skipped. */
EGOSIEVE_API egosieve_status egosieve_gp_points(egosieve_gp* gp, const egosieve_array* x,
                                                const egosieve_array* y);

/** Copies the noise variances of the points: v is n values. */
EGOSIEVE_API egosieve_status egosieve_gp_noise_variances(egosieve_gp* gp, const egosieve_array* v);

/** Sets the hyperparameters and rebuilds the factor. */
EGOSIEVE_API egosieve_status egosieve_gp_set_hyperparameters(egosieve_gp* gp, const double* scales,
                                                             int64_t scale_count,
                                                             double signal_stddev,
                                                             double noise_stddev);

/**
 * log p(y | X) = -1/2 y.alpha - sum_i log L_ii - n/2 log 2 pi, summed over outputs; 0 without
 * points. With a mean function it is the restricted likelihood, from which the coefficients are
 * eliminated. For a sparse model it is the likelihood described at the top of this file.
 */
EGOSIEVE_API egosieve_status egosieve_gp_log_marginal_likelihood(egosieve_gp* gp, double* value);

/** Options of the optimisation of hyperparameters. */
typedef struct egosieve_optimize_options {
  uint64_t struct_size;   /**< Set by egosieve_optimize_options_init(). */
  int64_t subset_size;    /**< Points used at most, drawn at random; 0: all. Default: 800. */
  int32_t restarts;       /**< Random starts after the first. Default: 0. */
  int32_t gradient_steps; /**< Largest number of steps from one start. Default: 500. */
  double tolerance;       /**< Of the largest component of the gradient, nats. Default: 1e-3. */
  uint64_t seed;          /**< Seed of the subset and the restarts. Default: 1. */
  /** Bounds of the scales, sigma_f and sigma_n, in this order; equal ones keep a value fixed. NaN,
   * or a null array: the default, which follows the spread of the data. */
  const double* lower_bounds;
  const double* upper_bounds; /**< As lower_bounds. */
  int64_t bound_count;        /**< Of both arrays: the number of scales + 2. */
  /** Asked before each evaluation; nonzero ends the call with #EGOSIEVE_CANCELLED. Null: never. */
  int32_t (*should_stop)(void* argument);
  void* stop_argument; /**< What should_stop is called with. */
} egosieve_optimize_options;

/** Result of an optimisation; likelihoods are of the subset. */
typedef struct egosieve_optimize_result {
  uint64_t struct_size;           /**< Set by egosieve_optimize_result_init(). */
  double log_likelihood_at_start; /**< Before the optimisation; -infinity if there is none. */
  double log_likelihood;          /**< After it. */
  int64_t evaluations;            /**< Number of evaluations of the likelihood. */
  int64_t points;                 /**< Number of points used. */
  int64_t converged;              /**< Nonzero: gradient_norm is within the tolerance. */
  /** Largest component of the gradient with respect to the logarithms, nats; those that point out of
   * a bound count as 0. */
  double gradient_norm;
  /** Where the caller has set it: gets -1 for a hyperparameter on its lower bound, 1 on its upper
   * bound, else 0. */
  int32_t* on_bound;
  int64_t on_bound_count; /**< Of on_bound: the number of scales + 2. */
} egosieve_optimize_result;

/** Sets every field to its default. Null does nothing. */
EGOSIEVE_API void egosieve_optimize_options_init(egosieve_optimize_options* options);

/** Sets struct_size, and every other field to 0. Null does nothing. */
EGOSIEVE_API void egosieve_optimize_result_init(egosieve_optimize_result* result);

/**
 * Maximises the log marginal likelihood over the scales, sigma_f and sigma_n by projected L-BFGS on
 * their logarithms, within bounds, and then rebuilds the factor. It starts at the current values,
 * or at values that follow the spread of the data where these are more likely; then from as many
 * random ones as `restarts` says, and keeps the best. With the default bounds sigma_n stays above
 * 1e-5 of y's deviation from its mean. Where covariances are not positive definite, jitter is added, as in
 * the model. Cost: n^3 flops per evaluation, where n is the number of points used.
 * @param gp       The model; #EGOSIEVE_FAILED_PRECONDITION with fewer than 2 points.
 * @param options  Null: the defaults.
 * @param result   Null: not wanted.
 */
EGOSIEVE_API egosieve_status egosieve_gp_optimize(egosieve_gp* gp,
                                                  const egosieve_optimize_options* options,
                                                  egosieve_optimize_result* result);

/**
 * Fits a and b of (4) by leave-one-out likelihood. All y must be labels (egosieve_gp_condition())
 * and there must be at least 2 points; otherwise #EGOSIEVE_FAILED_PRECONDITION. Before the first
 * call a = 1 and b = 0. Costs nothing if the model has not changed since the last call.
 */
EGOSIEVE_API egosieve_status egosieve_gp_calibrate(egosieve_gp* gp);

/**
 * Classification with the probit likelihood by Laplace's approximation (Rasmussen & Williams, 3.4),
 * in place of least squares: the model's points become those of the regression that has the same
 * posterior of f, of which all other calls then speak. Probabilities are (4) with a = 1 and b = 0,
 * and sigma_n is 1e-3. They are no longer there once points are added or removed or hyperparameters
 * set. Cost: about 3 n^3 flops per evaluation.
 * @param gp       An exact model with the zero mean; else #EGOSIEVE_FAILED_PRECONDITION. Its own
 *                 points are dropped.
 * @param x        N x D, finite.
 * @param y        N labels, -1 or 1.
 * @param weights  N weights, positive, at most 1e6; a point of weight 2 counts as two. Null: all 1.
 * @param options  As for egosieve_gp_optimize(), with sigma_n fixed; null: the hyperparameters stay.
 * @param result   As there; of the labels' likelihood. Null: not wanted.
 */
EGOSIEVE_API egosieve_status egosieve_gp_classify(egosieve_gp* gp, const egosieve_const_array* x,
                                                  const egosieve_const_array* y,
                                                  const egosieve_const_array* weights,
                                                  const egosieve_optimize_options* options,
                                                  egosieve_optimize_result* result);

/**
 * Stores a text or bytes with the model and in its file; replaces an earlier annotation.
 * @param gp     The model.
 * @param bytes  Null only if size is 0.
 * @param size   In bytes.
 */
EGOSIEVE_API egosieve_status egosieve_gp_set_annotation(egosieve_gp* gp, const void* bytes,
                                                        int64_t size);

/**
 * Copies the annotation.
 * @param gp        The model.
 * @param bytes     Destination; null to ask only for the size.
 * @param capacity  Bytes at the destination. If fewer than the size: #EGOSIEVE_INVALID_ARGUMENT,
 *                  and the last error gives the size.
 * @param size      Out: bytes of the annotation.
 */
EGOSIEVE_API egosieve_status egosieve_gp_annotation(egosieve_gp* gp, void* bytes, int64_t capacity,
                                                    int64_t* size);

/**
 * Writes the model into a file, completely or not at all; numpy.load() reads it. The factor is
 * rebuilt, so that this model and a loaded copy predict identically to the last bit.
 */
EGOSIEVE_API egosieve_status egosieve_gp_save(egosieve_gp* gp, const char* path);

/** The same of a model whose y the caller has normalised; egosieve_gp_load() refuses the file. */
EGOSIEVE_API egosieve_status egosieve_gp_save_normalized(egosieve_gp* gp, const char* path);

/**
 * Reads a model file; `device` as in egosieve_gp_options. The file may come from any source.
 * #EGOSIEVE_FAILED_PRECONDITION where its y are normalised, as by normalize_y in Python.
 */
EGOSIEVE_API egosieve_status egosieve_gp_load(const char* path, const char* device,
                                              egosieve_gp** gp);

/** The same also where y are normalised: its annotation tells its writer how. */
EGOSIEVE_API egosieve_status egosieve_gp_load_normalized(const char* path, const char* device,
                                                         egosieve_gp** gp);

/** The bytes that egosieve_gp_save() would write; arguments as in egosieve_gp_annotation(). */
EGOSIEVE_API egosieve_status egosieve_gp_serialize(egosieve_gp* gp, void* bytes, int64_t capacity,
                                                   int64_t* size);

/** Creates a model from its bytes. The bytes may come from any source. */
EGOSIEVE_API egosieve_status egosieve_gp_deserialize(const void* bytes, int64_t size,
                                                     const char* device, egosieve_gp** gp);

#ifdef __cplusplus
}
#endif

#endif /* EGOSIEVE_GAUSSIAN_PROCESS_H_ */
