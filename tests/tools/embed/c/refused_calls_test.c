/* The C interface of the model, from C99: what it refuses, and that nothing is changed then. */
#include <math.h>

#include "egosieve/gaussian_process.h"
#include "tests/tools/embed/c/check.h"
#include "tests/tools/embed/c/small_model.h"

static void test_handles(void) {
  egosieve_gp* gp = new_conditioned_model(EGOSIEVE_ARCSINE);
  egosieve_gp* next = NULL;
  egosieve_posterior* posterior = NULL;
  double value = 0;
  int on_the_stack = 0;
  CHECK_CALL(egosieve_gp_log_marginal_likelihood(NULL, &value), EGOSIEVE_INVALID_HANDLE,
             "gp is null");
  CHECK_CALL(egosieve_gp_log_marginal_likelihood((egosieve_gp*)&on_the_stack, &value),
             EGOSIEVE_INVALID_HANDLE, "gp is no handle");
  CHECK_OK(egosieve_gp_posterior(gp, &posterior));
  CHECK_CALL(egosieve_gp_log_marginal_likelihood((egosieve_gp*)posterior, &value),
             EGOSIEVE_INVALID_HANDLE, "gp is a handle of another type");
  CHECK_OK(egosieve_gp_free(gp));
  CHECK_CALL(egosieve_gp_free(gp), EGOSIEVE_INVALID_HANDLE, "gp was freed");
  next = new_model(EGOSIEVE_ARCSINE); /* takes the slot */
  CHECK(next != gp);
  CHECK_CALL(egosieve_gp_log_marginal_likelihood(gp, &value), EGOSIEVE_INVALID_HANDLE,
             "gp was freed");
  CHECK_OK(egosieve_gp_log_marginal_likelihood(next, &value));
  CHECK_OK(egosieve_gp_free(next));
  CHECK_OK(egosieve_gp_free(NULL));
  CHECK_OK(egosieve_posterior_free(posterior));
  CHECK_CALL(egosieve_posterior_free(posterior), EGOSIEVE_INVALID_HANDLE, "posterior was freed");
}

static void test_bad_arrays(void) {
  egosieve_gp* gp = new_conditioned_model(EGOSIEVE_ARCSINE);
  const egosieve_const_array inputs = doubles(&x[0][0], N, D), targets = doubles(y, N, 1);
  egosieve_const_array bad;
  double broken[2][D] = {{0, 0, 0}, {0, NAN, 0}};

  CHECK_CALL(egosieve_gp_condition(gp, NULL, &targets), EGOSIEVE_INVALID_ARGUMENT, "x is null");
  CHECK_CALL(egosieve_gp_condition(gp, &inputs, NULL), EGOSIEVE_INVALID_ARGUMENT, "y is null");
  bad = inputs;
  bad.data = NULL;
  CHECK_CALL(egosieve_gp_condition(gp, &bad, &targets), EGOSIEVE_INVALID_ARGUMENT, "x.data");
  bad = inputs;
  bad.columns = D - 1;
  CHECK_CALL(egosieve_gp_condition(gp, &bad, &targets), EGOSIEVE_INVALID_ARGUMENT, "x: 2 columns");
  bad = inputs;
  bad.rows = -1;
  CHECK_CALL(egosieve_gp_condition(gp, &bad, &targets), EGOSIEVE_INVALID_ARGUMENT, "x: -1 x 3");
  bad = inputs;
  bad.type = 9;
  CHECK_CALL(egosieve_gp_condition(gp, &bad, &targets), EGOSIEVE_INVALID_ARGUMENT, "x.type");
  bad = inputs;
  bad.row_stride = INT64_MIN;
  CHECK_CALL(egosieve_gp_condition(gp, &bad, &targets), EGOSIEVE_INVALID_ARGUMENT, "x: strides");
  bad = targets;
  bad.rows = N - 1;
  CHECK_CALL(egosieve_gp_condition(gp, &inputs, &bad), EGOSIEVE_INVALID_ARGUMENT, "y: 39 values");
  bad = doubles(&broken[0][0], 2, D);
  {
    const egosieve_const_array two = doubles(y, 2, 1);
    CHECK_CALL(egosieve_gp_condition(gp, &bad, &two), EGOSIEVE_INVALID_ARGUMENT, "x(1, 1)");
    broken[1][1] = 1e39; /* finite in float64 alone */
    CHECK_CALL(egosieve_gp_condition(gp, &bad, &two), EGOSIEVE_INVALID_ARGUMENT, "x(1, 1)");
  }
  CHECK_OK(egosieve_gp_free(gp));
}

static void test_bad_predictions(void) {
  egosieve_gp* gp = new_conditioned_model(EGOSIEVE_ARCSINE);
  egosieve_const_array bad;
  egosieve_prediction prediction;
  float mean[M], untouched = -5.0f;
  double broken[2][D] = {{0, 0, 0}, {0, NAN, 0}};
  egosieve_gp_info info;
  const int64_t twice[2] = {1, 1}, beyond[1] = {N};

  bad = doubles(&broken[0][0], 2, D);
  egosieve_prediction_init(&prediction);
  prediction.mean = floats_out(mean, M, 1);
  mean[0] = untouched;
  prediction.mean.rows = 2;
  CHECK_CALL(egosieve_gp_predict(gp, &bad, &prediction), EGOSIEVE_INVALID_ARGUMENT, "x(1, 1)");
  CHECK(mean[0] == untouched);
  bad = doubles(&queries[0][0], M, D);
  prediction.mean.rows = M - 1;
  CHECK_CALL(egosieve_gp_predict(gp, &bad, &prediction), EGOSIEVE_INVALID_ARGUMENT,
             "prediction.mean: 29 x 1");
  prediction.mean.rows = M;
  prediction.mean.row_stride = 2;
  prediction.mean.column_stride = 4;
  CHECK_CALL(egosieve_gp_predict(gp, &bad, &prediction), EGOSIEVE_INVALID_ARGUMENT,
             "prediction.mean: row_stride");
  CHECK_CALL(egosieve_gp_predict(gp, &bad, NULL), EGOSIEVE_INVALID_ARGUMENT, "prediction is null");
  prediction.struct_size = 0;
  CHECK_CALL(egosieve_gp_predict(gp, &bad, &prediction), EGOSIEVE_INVALID_ARGUMENT,
             "prediction.struct_size");
  CHECK_CALL(egosieve_gp_remove(gp, twice, 2), EGOSIEVE_INVALID_ARGUMENT, "rows: 1 is there twice");
  CHECK_CALL(egosieve_gp_remove(gp, beyond, 1), EGOSIEVE_INVALID_ARGUMENT, "rows: 40");
  CHECK_CALL(egosieve_gp_remove(gp, NULL, 1), EGOSIEVE_INVALID_ARGUMENT, "rows is null");
  CHECK_CALL(egosieve_gp_remove(gp, beyond, -1), EGOSIEVE_INVALID_ARGUMENT, "count = -1");
  egosieve_gp_info_init(&info);
  CHECK_OK(egosieve_gp_describe(gp, &info));
  CHECK(info.size == N);
  CHECK_OK(egosieve_gp_free(gp));
}

static void test_bad_options(void) {
  egosieve_gp_options options;
  egosieve_gp* gp = NULL;
  const double scales[2] = {1.0, -1.0};
  const egosieve_grid empty = {0, 0, 1, 1, 0, 5};
  egosieve_prediction prediction;
  uint8_t pixels[12] = {0};
  egosieve_image image = {pixels, 2, 2, 0, EGOSIEVE_BGR};
  egosieve_prediction_init(&prediction);
  egosieve_gp_options_init(&options);
  CHECK_CALL(egosieve_gp_create(&options, &gp), EGOSIEVE_INVALID_ARGUMENT, "dimension = 0");
  options.dimension = 1;
  options.covariance = 5;
  CHECK_CALL(egosieve_gp_create(&options, &gp), EGOSIEVE_INVALID_ARGUMENT, "covariance = 5");
  options.covariance = EGOSIEVE_SQUARED_EXPONENTIAL;
  options.covariance_text = "matern52";
  CHECK_CALL(egosieve_gp_create(&options, &gp), EGOSIEVE_INVALID_ARGUMENT, "set one");
  options.covariance = EGOSIEVE_ARCSINE; /* the default: the text counts */
  options.covariance_text = "matern53";
  CHECK_CALL(egosieve_gp_create(&options, &gp), EGOSIEVE_INVALID_ARGUMENT, "matern53");
  options.covariance_text = NULL;
  options.scales = scales;
  options.scale_count = 1;
  CHECK_CALL(egosieve_gp_create(&options, &gp), EGOSIEVE_INVALID_ARGUMENT, "scale_count = 1");
  options.scale_count = 2;
  CHECK_CALL(egosieve_gp_create(&options, &gp), EGOSIEVE_INVALID_ARGUMENT, "scales");
  options.scales = NULL;
  options.scale_count = 0;
  options.noise_stddev = NAN;
  CHECK_CALL(egosieve_gp_create(&options, &gp), EGOSIEVE_INVALID_ARGUMENT, "noise_stddev");
  options.noise_stddev = 0.1;
  options.memory_cap_bytes = -1;
  CHECK_CALL(egosieve_gp_create(&options, &gp), EGOSIEVE_INVALID_ARGUMENT, "memory_cap_bytes = -1");
  options.memory_cap_bytes = 0;
  options.device = "a device that nobody has";
  CHECK_CALL(egosieve_gp_create(&options, &gp), EGOSIEVE_NOT_FOUND, "a device that nobody has");
  options.device = NULL;
  CHECK_CALL(egosieve_gp_create(&options, NULL), EGOSIEVE_INVALID_ARGUMENT, "gp is null");
  CHECK_CALL(egosieve_gp_create(NULL, &gp), EGOSIEVE_INVALID_ARGUMENT, "options is null");
  CHECK(gp == NULL);
  CHECK_OK(egosieve_gp_create(&options, &gp));
  CHECK_CALL(egosieve_gp_predict_grid(gp, &empty, &prediction), EGOSIEVE_INVALID_ARGUMENT,
             "grid: 0 rows");
  CHECK_CALL(egosieve_gp_predict_image(gp, &image, 1, &prediction), EGOSIEVE_FAILED_PRECONDITION,
             "6 inputs");
  image.row_stride = 5;
  CHECK_CALL(egosieve_gp_predict_image(gp, &image, 1, &prediction), EGOSIEVE_INVALID_ARGUMENT,
             "image.row_stride");
  CHECK_CALL(egosieve_gp_optimize(gp, NULL, NULL), EGOSIEVE_FAILED_PRECONDITION, "2 points");
  CHECK_CALL(egosieve_gp_calibrate(gp), EGOSIEVE_FAILED_PRECONDITION, "2 points");
  CHECK_OK(egosieve_gp_free(gp));
}

/* A struct of an older header is shorter, one of a newer header longer. */
static void test_struct_sizes(void) {
  egosieve_gp_options options;
  egosieve_gp* gp = NULL;
  egosieve_gp_info info;
  egosieve_prediction prediction;
  float mean[M];
  const egosieve_const_array inputs = doubles(&x[0][0], N, D), targets = doubles(y, N, 1);
  const egosieve_const_array points = doubles(&queries[0][0], M, D);
  egosieve_gp_options_init(&options);
  options.dimension = D;
  options.device = "a device that nobody has"; /* beyond what the older caller knows of */
  options.noise_stddev = -1.0;
  options.struct_size = 16;
  CHECK_OK(egosieve_gp_create(&options, &gp));
  CHECK_OK(egosieve_gp_condition(gp, &inputs, &targets));
  egosieve_gp_info_init(&info);
  info.struct_size = 24;
  info.squash_a = -3.0;
  CHECK_OK(egosieve_gp_describe(gp, &info));
  CHECK(info.struct_size == 24 && info.size == N && info.dimension == D && info.squash_a == -3.0);
  egosieve_prediction_init(&prediction);
  prediction.mean = floats_out(mean, M, 1);
  prediction.clamped_variances = -7;
  prediction.struct_size = sizeof prediction - 24;
  CHECK_OK(egosieve_gp_predict(gp, &points, &prediction));
  CHECK(prediction.clamped_variances == -7);
  prediction.struct_size = sizeof prediction;
  CHECK_OK(egosieve_gp_predict(gp, &points, &prediction));
  CHECK(prediction.clamped_variances == 0);
  CHECK_OK(egosieve_gp_free(gp));
  gp = NULL;
  options.struct_size = sizeof options + 8;
  CHECK_CALL(egosieve_gp_create(&options, &gp), EGOSIEVE_INVALID_ARGUMENT, "options.struct_size");
  options.struct_size = 20;
  CHECK_CALL(egosieve_gp_create(&options, &gp), EGOSIEVE_INVALID_ARGUMENT, "options.struct_size");
  options.struct_size = 8;
  CHECK_CALL(egosieve_gp_create(&options, &gp), EGOSIEVE_INVALID_ARGUMENT, "options.struct_size");
  CHECK(gp == NULL);
}

/* Labels are -1 and 1: of 0 and 1 the probabilities would be wrong. */
static void test_labels(void) {
  egosieve_gp* gp = new_model(EGOSIEVE_ARCSINE);
  const egosieve_const_array inputs = doubles(&x[0][0], N, D);
  const egosieve_const_array points = doubles(&queries[0][0], M, D);
  double others[N];
  float results[M];
  egosieve_gp_info info;
  egosieve_prediction prediction;
  egosieve_const_array targets = doubles(others, N, 1);
  for (int i = 0; i < N; ++i) others[i] = y[i] > 0.0;
  CHECK_OK(egosieve_gp_condition(gp, &inputs, &targets));
  CHECK_CALL(egosieve_gp_calibrate(gp), EGOSIEVE_FAILED_PRECONDITION, "2 y - 1");
  egosieve_prediction_init(&prediction);
  prediction.probability = floats_out(results, M, 1);
  CHECK_CALL(egosieve_gp_predict(gp, &points, &prediction), EGOSIEVE_FAILED_PRECONDITION,
             "2 y - 1");
  egosieve_gp_info_init(&info);
  CHECK_OK(egosieve_gp_describe(gp, &info));
  CHECK(!info.has_labels);
  egosieve_prediction_init(&prediction);
  prediction.mean = floats_out(results, M, 1); /* regression on them is sound */
  CHECK_OK(egosieve_gp_predict(gp, &points, &prediction));
  targets = doubles(y, N, 1);
  CHECK_OK(egosieve_gp_condition(gp, &inputs, &targets));
  CHECK_OK(egosieve_gp_calibrate(gp));
  CHECK_OK(egosieve_gp_describe(gp, &info));
  CHECK(info.has_labels);
  CHECK_OK(egosieve_gp_free(gp));
}

int main(void) {
  make_data();
  test_handles();
  test_bad_arrays();
  test_bad_predictions();
  test_bad_options();
  test_struct_sizes();
  test_labels();
  printf("%d checks failed\n", failures);
  return failures == 0 ? 0 : 1;
}
