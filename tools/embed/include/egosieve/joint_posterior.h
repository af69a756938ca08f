/**
 * @file joint_posterior.h
 * Joint predictions of a model (gaussian_process.h) at several places: prior and joint covariances, samples,
 * gradients with respect to the inputs, and leave-one-out predictions.
 *
 *     cov(x, x') = k(x, x') - (L^-1 k*).(L^-1 k*')                                         (6)
 *     f = mean + C z,   C C^T = cov + jitter I,   z ~ N(0, I)                              (7)
 *     y_i without point i:  mean y_i - alpha_i / [K_y^-1]_ii,  variance 1 / [K_y^-1]_ii    (8)
 *
 * and the terms that a mean function adds to each. A sparse model uses its covariance (5) between
 * two places instead of (6), and that of its points instead of K_y. All is computed in float64 from
 * the model's factor. If a covariance is singular to working precision, the jitter of (7) is raised
 * in factors of ten from 1e-10 to 1e-4 of the largest prior variance.
 *
 * References: Rasmussen & Williams (2006), eqs. 2.24, 2.42, 5.10 to 5.12, and A.2.
 */
#ifndef EGOSIEVE_JOINT_POSTERIOR_H_
#define EGOSIEVE_JOINT_POSTERIOR_H_

#include "gaussian_process.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Predicts jointly. Cost: M n^2 + M^2 n flops; memory: 8 (M n + 2 M^2) bytes.
 * @param gp              The model.
 * @param x               M x D, finite.
 * @param of_observation  Nonzero: sigma_n^2 is added to the diagonal.
 * @param mean            M x k; data null: not wanted.
 * @param covariance      M x M, (6), the same for every output; data null: not wanted.
 */
EGOSIEVE_API egosieve_status egosieve_gp_predict_joint(egosieve_gp* gp,
                                                       const egosieve_const_array* x,
                                                       int32_t of_observation,
                                                       const egosieve_array* mean,
                                                       const egosieve_array* covariance);

/**
 * The kernel matrix itself, k(x_i, z_j) at the model's hyperparameters, without noise, and its
 * derivatives. Points of the model play no part. k is computed on the device in float64, if it has
 * that; derivatives on the host.
 * @param gp             The model.
 * @param x              N x D, finite.
 * @param z              M x D, finite; null: x.
 * @param k              N x M; data null: not wanted.
 * @param by_logarithms  (N M) x (scale_count + 1): row i M + j has the derivatives of k(x_i, z_j)
 *                       by the logarithms of the scales and of sigma_f; data null: not wanted.
 * @param by_x           (N M) x D, those with respect to x_i; 0 at a cusp; data null: not wanted.
 */
EGOSIEVE_API egosieve_status egosieve_gp_covariances(egosieve_gp* gp, const egosieve_const_array* x,
                                                     const egosieve_const_array* z,
                                                     const egosieve_array* k,
                                                     const egosieve_array* by_logarithms,
                                                     const egosieve_array* by_x);

/**
 * Draws samples (7) from the joint distribution at M places. For a model without points, this is
 * the prior. Sample s depends on seed, M and k, but not on the number of samples.
 * @param gp              The model.
 * @param x               M x D, finite.
 * @param seed            The same seed gives the same samples.
 * @param of_observation  Nonzero: samples of y; of f otherwise.
 * @param samples         (M k) x S: sample s of output c at place i lies in row i k + c, column s.
 * @param jitter          Out: the jitter of (7); null: not wanted.
 */
EGOSIEVE_API egosieve_status egosieve_gp_sample(egosieve_gp* gp, const egosieve_const_array* x,
                                                uint64_t seed, int32_t of_observation,
                                                const egosieve_array* samples, double* jitter);

/**
 * Samples as functions, by Matheron's rule: a sample has the same value at the same place whatever
 * else is in x, and the cost is linear in M. With a sample g of the prior from F random frequencies
 * w_j (Wilson et al. (2020); Rahimi & Recht (2007)):
 *
 *     g(x) = sigma_f (m / F)^1/2 sum_j (a_j cos w_j.x + b_j sin w_j.x),   a_j, b_j ~ N(0, 1)
 *     f(x) = g(x) + k(x, X).K_y^-1 (y - g(X) - e),   e_i of the noise's variance           (9)
 *
 * and for sparse models the same through the inducing inputs. Mean and covariance of samples are
 * those of the posterior for any F. For squared_exponential, matern12, matern32, matern52 and
 * constant, with columns and isotropic(...), and their sums and products; other covariances are
 * #EGOSIEVE_UNIMPLEMENTED. Cost: 2 k S n^2 flops, and F k S sines and cosines and n (D + k S)
 * flops for each place; memory: 8 k S (F (D + 2) + n + M) bytes.
 * @param gp              The model.
 * @param x               M x D, finite.
 * @param seed            The same seed gives the same functions, the first ones whatever S.
 * @param frequencies     F, from 1 to 2^20; 1024 is enough for most uses.
 * @param of_observation  Nonzero: y(x), whose noise depends on x and the seed; f(x) otherwise.
 * @param samples         (M k) x S, as of egosieve_gp_sample().
 */
EGOSIEVE_API egosieve_status egosieve_gp_sample_paths(egosieve_gp* gp,
                                                      const egosieve_const_array* x, uint64_t seed,
                                                      int64_t frequencies, int32_t of_observation,
                                                      const egosieve_array* samples);

/**
 * Gradients of mean and variance of f with respect to the inputs. At a cusp of the covariance
 * (matern12 at a point of the model) the derivative counts as 0. Cost: M n D k; variance: 2 M n^2.
 * @param gp        The model.
 * @param x         M x D, finite.
 * @param mean      (M k) x D, row i k + c is that of output c at place i; data null: not wanted.
 * @param variance  M x D; data null: not wanted.
 */
EGOSIEVE_API egosieve_status egosieve_gp_gradients(egosieve_gp* gp, const egosieve_const_array* x,
                                                   const egosieve_array* mean,
                                                   const egosieve_array* variance);

/**
 * Leave-one-out: predicts each point's y from all others (8). Cost: n^3 / 3 flops.
 * @param gp           The model.
 * @param mean         n x k; data null: not wanted.
 * @param variance     Of y, n values; data null: not wanted.
 * @param log_density  log p(y_i | others), n x k; data null: not wanted.
 */
EGOSIEVE_API egosieve_status egosieve_gp_leave_one_out(egosieve_gp* gp, const egosieve_array* mean,
                                                       const egosieve_array* variance,
                                                       const egosieve_array* log_density);

/** The mean function's coefficients, egosieve_gp_info.coefficients x k, the constant first. */
EGOSIEVE_API egosieve_status egosieve_gp_mean_coefficients(egosieve_gp* gp,
                                                           const egosieve_array* coefficients);

/**
 * The log marginal likelihood of the model's points at other hyperparameters; the model is not
 * changed. Cost: n^3 / 3 flops, n^3 with the gradient.
 * @param gp        The model.
 * @param theta     Logarithms of the scales, sigma_f and sigma_n.
 * @param count     Length of theta: egosieve_gp_info.scale_count + 2.
 * @param value     Out.
 * @param gradient  Out: `count` derivatives with respect to theta; null: not wanted.
 */
EGOSIEVE_API egosieve_status egosieve_gp_likelihood_at(egosieve_gp* gp, const double* theta,
                                                       int64_t count, double* value,
                                                       double* gradient);

#ifdef __cplusplus
}
#endif

#endif /* EGOSIEVE_JOINT_POSTERIOR_H_ */
