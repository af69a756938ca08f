/* Iterative models, from C99. */
#include <math.h>
#include <string.h>

#include "egosieve/gaussian_process.h"
#include "tests/tools/embed/c/check.h"
#include "tests/tools/embed/c/small_model.h"

/* An iterative model has the exact means, tells how it found them, and refuses what needs a factor. */
static void test_iterative_models(void) {
  egosieve_gp* exact = new_conditioned_model(EGOSIEVE_SQUARED_EXPONENTIAL);
  egosieve_gp *gp = NULL, *again = NULL;
  egosieve_gp_options options;
  egosieve_gp_info info;
  egosieve_optimize_options search;
  const egosieve_const_array inputs = doubles(&x[0][0], N, D), targets = doubles(y, N, 1);
  float expected[M], actual[M];
  char bytes[1 << 15];
  int64_t size = 0;
  double value = 0.0;
  CHECK_OK(predict_mean(exact, expected));
  egosieve_gp_options_init(&options);
  CHECK(options.tolerance == 1e-8);
  options.covariance = EGOSIEVE_SQUARED_EXPONENTIAL;
  options.dimension = D;
  options.approximation = EGOSIEVE_ITERATIVE;
  options.inducing_points = 5;
  CHECK_OK(egosieve_gp_create(&options, &gp));
  CHECK_OK(egosieve_gp_condition(gp, &inputs, &targets));
  egosieve_gp_info_init(&info);
  CHECK_OK(egosieve_gp_describe(gp, &info));
  CHECK(info.approximation == EGOSIEVE_ITERATIVE && info.iterations == -1);
  CHECK_OK(predict_mean(gp, actual));
  for (int i = 0; i < M; ++i) CHECK(fabsf(expected[i] - actual[i]) < 1e-4f);
  CHECK_OK(egosieve_gp_describe(gp, &info));
  CHECK(info.iterations > 0 && info.residual > 0.0 && info.residual <= 1e-8);
  CHECK(info.tolerance == 1e-8 && info.inducing_points == 5 && info.size == N);
  CHECK_CALL(egosieve_gp_log_marginal_likelihood(gp, &value), EGOSIEVE_FAILED_PRECONDITION,
             "means alone");
  CHECK_CALL(egosieve_gp_calibrate(gp), EGOSIEVE_FAILED_PRECONDITION, "means alone");
  egosieve_optimize_options_init(&search);
  search.subset_size = 0;
  CHECK_CALL(egosieve_gp_optimize(gp, &search, NULL), EGOSIEVE_INVALID_ARGUMENT, "subset_size");
  CHECK_OK(egosieve_gp_serialize(gp, NULL, 0, &size));
  CHECK(size <= (int64_t)sizeof bytes);
  CHECK_OK(egosieve_gp_serialize(gp, bytes, sizeof bytes, &size));
  CHECK_OK(egosieve_gp_deserialize(bytes, size, NULL, &again));
  CHECK_OK(predict_mean(again, expected));
  CHECK(memcmp(expected, actual, sizeof expected) == 0);
  CHECK_OK(egosieve_gp_describe(again, &info));
  CHECK(info.iterations == 0 && info.residual <= 1e-8);
  CHECK_OK(egosieve_gp_optimize(again, NULL, NULL));
  CHECK_OK(egosieve_gp_describe(again, &info));
  CHECK(info.iterations == -1);
  CHECK_OK(egosieve_gp_free(again));
  CHECK_OK(egosieve_gp_free(gp));
  CHECK_OK(egosieve_gp_free(exact));
  options.tolerance = 0.0;
  CHECK_CALL(egosieve_gp_create(&options, &gp), EGOSIEVE_INVALID_ARGUMENT, "tolerance");
  options.tolerance = 1e-8;
  options.mean = EGOSIEVE_CONSTANT_MEAN;
  CHECK_CALL(egosieve_gp_create(&options, &gp), EGOSIEVE_UNIMPLEMENTED, "zero mean");
}

int main(void) {
  make_data();
  test_iterative_models();
  printf("%d checks failed\n", failures);
  return failures == 0 ? 0 : 1;
}
