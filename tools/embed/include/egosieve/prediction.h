/**
 * @file prediction.h
 * Predictions of a model (gaussian_process.h, (2) to (5)) and of a posterior that is made from one.
 *
 * Errors of the results: the factor is float64, and queries are centred and scaled in float64. Then
 * predictions are computed in float32 on a device, or in float64 on the host: #egosieve_precision.
 * By default float32 is used where its errors are below a hundredth of the posterior's deviation;
 * they are measured once per posterior (egosieve_posterior_float32_error()). The deviation that
 * counts is the least at 16 places for means, and the query's own for its variance. Means are
 * computed in float64 all or none, variances and probabilities for the queries that need it, at n^2
 * flops each. Results in float32 are float32 values; those in float64 are rounded only if the
 * caller's array is float32. A query's result depends on no other query and on no threads.
 */
#ifndef EGOSIEVE_PREDICTION_H_
#define EGOSIEVE_PREDICTION_H_

#include "types.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Handle of a model that learns. Calls on one model wait for each other. */
typedef struct egosieve_gp egosieve_gp;

/** Handle of a model's posterior at one moment. Immutable: any number of threads may predict. */
typedef struct egosieve_posterior egosieve_posterior;

typedef int64_t egosieve_precision; /**< Arithmetic of a prediction: one of these. */
/** The values of #egosieve_precision. */
enum {
  EGOSIEVE_AUTO_PRECISION = 0, /**< Float32 where it suffices, otherwise float64; see above. */
  EGOSIEVE_IN_FLOAT64 = 1,     /**< Float64 throughout. */
  EGOSIEVE_IN_FLOAT32 = 2      /**< Float32, whatever its errors; on "reference" float64. */
};

/**
 * Results of a prediction. Each array has the shape that the call names. With k > 1 outputs the
 * mean has k columns per place, and is available only from egosieve_gp_predict() and
 * egosieve_posterior_predict().
 */
typedef struct egosieve_prediction {
  uint64_t struct_size;         /**< Set by egosieve_prediction_init(). */
  egosieve_array mean;          /**< (2); data null: not wanted. */
  egosieve_array variance;      /**< (3); data null: not wanted. */
  egosieve_array probability;   /**< (4), only with labels; data null: not wanted. */
  int32_t of_observation;       /**< Nonzero: variance is that of an observation. Default: 0. */
  int64_t clamped_variances;    /**< Out: how many were negative from rounding and set to 0. */
  egosieve_precision precision; /**< Default: #EGOSIEVE_AUTO_PRECISION. */
  int64_t float64_count;        /**< Out: places with a result that was computed in float64. */
} egosieve_prediction;

/** Sets all results to not wanted, the variance to that of f. Null does nothing. */
EGOSIEVE_API void egosieve_prediction_init(egosieve_prediction* prediction);

/**
 * Predicts at points.
 * @param gp          The model.
 * @param x           M x D, finite in float32. Packed rows of float32 are read in place.
 * @param prediction  Arrays of M values; the mean M x k.
 */
EGOSIEVE_API egosieve_status egosieve_gp_predict(egosieve_gp* gp, const egosieve_const_array* x,
                                                 egosieve_prediction* prediction);

/** A regular grid in the plane: point (r, c) is (x0 + c dx, y0 + r dy). */
typedef struct egosieve_grid {
  double x0;       /**< First input of the first column. */
  double y0;       /**< Second input of the first row. */
  double dx;       /**< Step between columns. */
  double dy;       /**< Step between rows. */
  int64_t rows;    /**< At least 1. */
  int64_t columns; /**< At least 1. */
} egosieve_grid;

/** Predicts on a grid; its points need no memory. Needs D = 2; arrays are rows x columns. */
EGOSIEVE_API egosieve_status egosieve_gp_predict_grid(egosieve_gp* gp, const egosieve_grid* grid,
                                                      egosieve_prediction* prediction);

/**
 * Predicts over an image. At every `stride`-th pixel and on the image's border, the input is
 *
 *     x = (u, v, I_M, I_R, I_G, I_B),
 *
 * where u, v are the pixel's coordinates, mapped so that the longer side spans [-1, 1], and I are
 * the means over 7 x 7 pixels of brightness, red, green and blue, mapped to [-1, 1]. Needs D = 6;
 * arrays are ceil((height - 1) / stride) + 1 rows by ceil((width - 1) / stride) + 1 columns.
 */
EGOSIEVE_API egosieve_status egosieve_gp_predict_image(egosieve_gp* gp, const egosieve_image* image,
                                                       int32_t stride,
                                                       egosieve_prediction* prediction);

/** The inputs of egosieve_gp_predict_image() at N places (x, y) in pixels: out is N x 6. */
EGOSIEVE_API egosieve_status egosieve_gp_describe_pixels(egosieve_gp* gp,
                                                         const egosieve_image* image,
                                                         const egosieve_const_array* places,
                                                         const egosieve_array* out);

/**
 * Gives a posterior of the model's current state; later changes of the model do not affect it. It
 * shares the model's factor. If points are removed later, the model copies it: 8 n^2 bytes.
 */
EGOSIEVE_API egosieve_status egosieve_gp_posterior(egosieve_gp* gp, egosieve_posterior** posterior);

/** As egosieve_gp_predict(), with the model's state when the posterior was made. */
EGOSIEVE_API egosieve_status egosieve_posterior_predict(egosieve_posterior* posterior,
                                                        const egosieve_const_array* x,
                                                        egosieve_prediction* prediction);

/** As egosieve_gp_predict_grid(). */
EGOSIEVE_API egosieve_status egosieve_posterior_predict_grid(egosieve_posterior* posterior,
                                                             const egosieve_grid* grid,
                                                             egosieve_prediction* prediction);

/** As egosieve_gp_predict_image(). */
EGOSIEVE_API egosieve_status egosieve_posterior_predict_image(egosieve_posterior* posterior,
                                                              const egosieve_image* image,
                                                              int32_t stride,
                                                              egosieve_prediction* prediction);

/**
 * The errors of a posterior's float32 results: four times their root mean square at 16 places, in
 * the units of y and of its square. The first call that needs them measures them: 16 n^2 flops.
 * @param posterior  The posterior.
 * @param mean       Out: of the means; null: not wanted.
 * @param variance   Out: of the variances, infinite where rounding makes one negative; times s /
 *                   deviation where the deviation s of f is larger than `deviation`; null: not
 *                   wanted.
 * @param deviation  Out: the least deviation of f at these places; null: not wanted.
 */
EGOSIEVE_API egosieve_status egosieve_posterior_float32_error(egosieve_posterior* posterior,
                                                              double* mean, double* variance,
                                                              double* deviation);

/** Frees a posterior, as egosieve_gp_free() does a model. */
EGOSIEVE_API egosieve_status egosieve_posterior_free(egosieve_posterior* posterior);

#ifdef __cplusplus
}
#endif

#endif /* EGOSIEVE_PREDICTION_H_ */
