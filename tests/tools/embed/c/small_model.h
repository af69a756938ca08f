/* A model of 40 points in three dimensions, and 30 queries: what the C tests of the model share. */
#ifndef EGOSIEVE_TESTS_TOOLS_EMBED_C_SMALL_MODEL_H_
#define EGOSIEVE_TESTS_TOOLS_EMBED_C_SMALL_MODEL_H_

#include <math.h>

#include "egosieve/gaussian_process.h"
#include "tests/tools/embed/c/check.h"

enum { N = 40, M = 30, D = 3 };

static double x[N][D], y[N], queries[M][D];

/* Reproducible points in [-1, 1] and a smooth function of them. */
static inline void make_data(void) {
  uint32_t state = 7;
  for (int i = 0; i < N + M; ++i) {
    double* row = i < N ? x[i] : queries[i - N];
    for (int d = 0; d < D; ++d) {
      state = state * 1664525u + 1013904223u;
      row[d] = (double)(state >> 8) / 8388608.0 - 1.0;
    }
    if (i < N) y[i] = sin(2.0 * row[0]) * cos(row[1]) > 0.2 * row[2] ? 1.0 : -1.0;
  }
}

static inline egosieve_gp* new_model(int32_t covariance) {
  egosieve_gp_options options;
  egosieve_gp* gp = NULL;
  egosieve_gp_options_init(&options);
  options.covariance = covariance;
  options.dimension = D;
  CHECK_OK(egosieve_gp_create(&options, &gp));
  return gp;
}

static inline egosieve_gp* new_conditioned_model(int32_t covariance) {
  egosieve_gp* gp = new_model(covariance);
  const egosieve_const_array inputs = doubles(&x[0][0], N, D), targets = doubles(y, N, 1);
  CHECK_OK(egosieve_gp_condition(gp, &inputs, &targets));
  return gp;
}

static inline egosieve_status predict_mean(egosieve_gp* gp, float* mean) {
  const egosieve_const_array points = doubles(&queries[0][0], M, D);
  egosieve_prediction prediction;
  egosieve_prediction_init(&prediction);
  prediction.mean = floats_out(mean, M, 1);
  return egosieve_gp_predict(gp, &points, &prediction);
}

#endif /* EGOSIEVE_TESTS_TOOLS_EMBED_C_SMALL_MODEL_H_ */
