/* The C interface of the model, from C99: what it computes. */
#include "egosieve/gaussian_process.h"

#include <math.h>
#include <stdlib.h>

#include "egosieve/joint_posterior.h"
#include "tests/tools/embed/c/check.h"
#include "tests/tools/embed/c/small_model.h"

/* A posterior interpolates: at a point of its own, n = 1, the mean is y k / (k + sigma_n^2). */
static void test_one_point_by_hand(void) {
  egosieve_gp_options options;
  egosieve_gp* gp = NULL;
  const double length = 0.7, at = 0.3, target = 2.0;
  const egosieve_const_array point = doubles(&at, 1, 1), value = doubles(&target, 1, 1);
  double mean = 0, variance = 0, log_likelihood = 0;
  egosieve_prediction prediction;
  egosieve_gp_options_init(&options);
  CHECK(options.memory_cap_bytes == 0); /* the device's own */
  options.covariance = EGOSIEVE_SQUARED_EXPONENTIAL;
  options.dimension = 1;
  options.scales = &length;
  options.scale_count = 1;
  options.signal_stddev = 1.5;
  options.noise_stddev = 0.5;
  CHECK_OK(egosieve_gp_create(&options, &gp));
  CHECK_OK(egosieve_gp_condition(gp, &point, &value));
  egosieve_prediction_init(&prediction);
  prediction.mean.data = &mean;
  prediction.mean.rows = prediction.mean.columns = 1;
  prediction.mean.type = EGOSIEVE_FLOAT64;
  prediction.variance = prediction.mean;
  prediction.variance.data = &variance;
  CHECK_OK(egosieve_gp_predict(gp, &point, &prediction));
  /* k = 2.25, k + sigma_n^2 = 2.5. Float32 results: a few roundings of 6e-8. */
  CHECK(fabs(mean - 2.0 * 2.25 / 2.5) < 1e-6);
  CHECK(fabs(variance - (2.25 - 2.25 * 2.25 / 2.5)) < 2e-6);
  prediction.of_observation = 1;
  CHECK_OK(egosieve_gp_predict(gp, &point, &prediction));
  CHECK(fabs(variance - (2.25 - 2.25 * 2.25 / 2.5 + 0.25)) < 2e-6);
  CHECK_OK(egosieve_gp_log_marginal_likelihood(gp, &log_likelihood));
  CHECK(fabs(log_likelihood + 0.5 * 4.0 / 2.5 + 0.5 * log(2.5) +
             0.5 * log(2.0 * 3.14159265358979323846)) < 1e-12);
  CHECK_OK(egosieve_gp_free(gp));
}

/* Conditioning in two parts and removing a third gives the model of the rest: float32 means agree
 * to the bound of the header, for |alpha|_1 under 1000 well below 1e-2; measured 1e-6. */
static void test_condition_and_remove(void) {
  egosieve_gp* whole = new_model(EGOSIEVE_ARCSINE);
  egosieve_gp* parts = new_model(EGOSIEVE_ARCSINE);
  egosieve_const_array inputs = doubles(&x[0][0], 30, D), targets = doubles(y, 30, 1);
  const int64_t last_rows[10] = {39, 38, 37, 36, 35, 34, 33, 32, 31, 30};
  float expected[M], actual[M];
  egosieve_gp_info info;
  CHECK_OK(egosieve_gp_condition(whole, &inputs, &targets));
  inputs.rows = targets.rows = 15;
  CHECK_OK(egosieve_gp_condition(parts, &inputs, &targets));
  inputs = doubles(&x[15][0], 25, D);
  targets = doubles(&y[15], 1, 25); /* a row serves as well */
  CHECK_OK(egosieve_gp_condition(parts, &inputs, &targets));
  CHECK_OK(egosieve_gp_remove(parts, last_rows, 10));
  egosieve_gp_info_init(&info);
  CHECK_OK(egosieve_gp_describe(parts, &info));
  CHECK(info.size == 30 && info.dimension == D && info.scale_count == D + 1);
  CHECK_OK(predict_mean(whole, expected));
  CHECK_OK(predict_mean(parts, actual));
  for (int i = 0; i < M; ++i) CHECK(fabsf(expected[i] - actual[i]) < 1e-4f);
  CHECK_OK(egosieve_gp_free(whole));
  CHECK_OK(egosieve_gp_free(parts));
}

/* Layouts do not change a bit of the result, and nothing outside the arrays is touched. */
static void test_strides(void) {
  egosieve_gp* gp = new_conditioned_model(EGOSIEVE_ARCSINE);
  float packed[M], expected_variance[M];
  static float transposed[D][M], reversed[M][D + 2];
  double spread[M][3];
  egosieve_prediction prediction;
  egosieve_const_array points = doubles(&queries[0][0], M, D);
  for (int i = 0; i < M; ++i) {
    for (int d = 0; d < D; ++d) {
      transposed[d][i] = (float)queries[i][d];
      reversed[M - 1 - i][1 + d] = (float)queries[i][d];
    }
    for (int j = 0; j < 3; ++j) spread[i][j] = -7.0;
  }
  egosieve_prediction_init(&prediction);
  prediction.mean = floats_out(packed, M, 1);
  prediction.variance = floats_out(expected_variance, M, 1);
  CHECK_OK(egosieve_gp_predict(gp, &points, &prediction));

  prediction.mean.data = &spread[0][1];
  prediction.mean.type = EGOSIEVE_FLOAT64;
  prediction.mean.row_stride = sizeof spread[0];
  prediction.mean.column_stride = sizeof(double);
  points.type = EGOSIEVE_FLOAT32;
  points.data = transposed;
  points.row_stride = sizeof(float);
  points.column_stride = sizeof transposed[0];
  CHECK_OK(egosieve_gp_predict(gp, &points, &prediction));
  for (int i = 0; i < M; ++i) {
    CHECK(spread[i][1] == (double)packed[i]);
    CHECK(spread[i][0] == -7.0 && spread[i][2] == -7.0);
    spread[i][1] = 0.0;
  }
  points.data = &reversed[M - 1][1];
  points.row_stride = -(int64_t)sizeof reversed[0];
  points.column_stride = sizeof(float);
  CHECK_OK(egosieve_gp_predict(gp, &points, &prediction));
  for (int i = 0; i < M; ++i) CHECK(spread[i][1] == (double)packed[i]);
  CHECK_OK(egosieve_gp_free(gp));
}

/* A grid is its points; a posterior stays as it was. */
static void test_grid_and_posterior(void) {
  enum { ROWS = 7, COLUMNS = 9 };
  egosieve_gp_options options;
  egosieve_gp* gp = NULL;
  egosieve_posterior* posterior = NULL;
  const double places[3][2] = {{0, 0}, {0.5, -0.5}, {-0.25, 0.75}}, values[3] = {1, -1, 0.5};
  const egosieve_const_array inputs = doubles(&places[0][0], 3, 2), targets = doubles(values, 3, 1);
  const egosieve_grid grid = {-1.0, -0.75, 0.25, 0.25, ROWS, COLUMNS};
  static float points[ROWS * COLUMNS][2];
  float by_grid[ROWS][COLUMNS + 3], by_points[ROWS * COLUMNS], later[ROWS * COLUMNS];
  egosieve_prediction prediction;
  egosieve_const_array queried = {points, ROWS * COLUMNS, 2, 0, 0, EGOSIEVE_FLOAT32};
  for (int r = 0; r < ROWS; ++r) {
    for (int c = 0; c < COLUMNS; ++c) {
      points[r * COLUMNS + c][0] = (float)(-1.0 + 0.25 * c);
      points[r * COLUMNS + c][1] = (float)(-0.75 + 0.25 * r);
    }
  }
  egosieve_gp_options_init(&options);
  options.covariance = EGOSIEVE_SQUARED_EXPONENTIAL;
  options.dimension = 2;
  CHECK_OK(egosieve_gp_create(&options, &gp));
  CHECK_OK(egosieve_gp_condition(gp, &inputs, &targets));
  CHECK_OK(egosieve_gp_posterior(gp, &posterior));
  egosieve_prediction_init(&prediction);
  prediction.variance = floats_out(&by_grid[0][0], ROWS, COLUMNS);
  prediction.variance.row_stride = sizeof by_grid[0];
  prediction.variance.column_stride = sizeof(float);
  CHECK_OK(egosieve_gp_predict_grid(gp, &grid, &prediction));
  prediction.variance = floats_out(by_points, ROWS * COLUMNS, 1);
  CHECK_OK(egosieve_posterior_predict(posterior, &queried, &prediction));
  CHECK_OK(egosieve_gp_condition(gp, &inputs, &targets));
  CHECK_OK(egosieve_gp_free(gp));
  prediction.variance = floats_out(later, ROWS * COLUMNS, 1);
  CHECK_OK(egosieve_posterior_predict(posterior, &queried, &prediction));
  for (int k = 0; k < ROWS * COLUMNS; ++k) {
    CHECK(by_grid[k / COLUMNS][k % COLUMNS] == by_points[k]);
    CHECK(later[k] == by_points[k]);
  }
  CHECK_OK(egosieve_posterior_free(posterior));
}

static int32_t stop_at_third(void* argument) { return ++*(int*)argument > 2; }

/* Where the optimisation ends, the gradient vanishes but for what lies on a bound. */
static void test_optima_are_stationary(void) {
  egosieve_gp* gp = new_conditioned_model(EGOSIEVE_SQUARED_EXPONENTIAL);
  egosieve_optimize_options options;
  egosieve_optimize_result result;
  egosieve_gp_info info;
  double theta[D + 2], gradient[D + 2], lower[D + 2], upper[D + 2], value = 0, first = 0;
  int32_t on_bound[D + 2];
  int calls = 0;
  for (int t = 0; t < D + 2; ++t) lower[t] = upper[t] = NAN;
  upper[D] = 0.5; /* of sigma_f */
  lower[D + 1] = upper[D + 1] = 0.3;
  egosieve_optimize_options_init(&options);
  egosieve_optimize_result_init(&result);
  options.lower_bounds = lower;
  options.upper_bounds = upper;
  options.bound_count = D + 2;
  result.on_bound = on_bound;
  result.on_bound_count = D + 2;
  CHECK_OK(egosieve_gp_optimize(gp, &options, &result));
  first = result.log_likelihood;
  CHECK(result.converged && result.gradient_norm <= options.tolerance);
  egosieve_gp_info_init(&info);
  CHECK_OK(egosieve_gp_describe(gp, &info));
  CHECK(fabs(info.noise_stddev - 0.3) < 1e-12 && fabs(info.signal_stddev - 0.5) < 1e-12);
  CHECK(on_bound[D] == 1 && on_bound[D + 1] == 0);
  for (int d = 0; d < D; ++d) theta[d] = log(info.scales[d]);
  theta[D] = log(info.signal_stddev);
  theta[D + 1] = log(info.noise_stddev);
  CHECK_OK(egosieve_gp_likelihood_at(gp, theta, D + 2, &value, gradient));
  for (int d = 0; d < D; ++d) CHECK(on_bound[d] != 0 || fabs(gradient[d]) <= 2 * options.tolerance);
  CHECK(gradient[D] > 0);
  /* Restarts are never worse. */
  options.restarts = 3;
  CHECK_OK(egosieve_gp_optimize(gp, &options, &result));
  CHECK(result.log_likelihood >= first - 1e-6);
  options.bound_count = D;
  CHECK_CALL(egosieve_gp_optimize(gp, &options, NULL), EGOSIEVE_INVALID_ARGUMENT, "bounds");
  options.bound_count = D + 2;
  lower[0] = 2;
  upper[0] = 1;
  CHECK_CALL(egosieve_gp_optimize(gp, &options, NULL), EGOSIEVE_INVALID_ARGUMENT,
             "hyperparameter 0");
  egosieve_optimize_options_init(&options);
  options.should_stop = stop_at_third;
  options.stop_argument = &calls;
  CHECK_CALL(egosieve_gp_optimize(gp, &options, NULL), EGOSIEVE_CANCELLED, "stopped");
  CHECK(calls == 3);
  CHECK_OK(egosieve_gp_free(gp));
}

static void test_optimize_and_calibrate(void) {
  egosieve_gp* gp = new_conditioned_model(EGOSIEVE_ARCSINE);
  egosieve_optimize_options options;
  egosieve_optimize_result result;
  double before = 0, after = 0;
  float probability[M];
  egosieve_gp_info info;
  const egosieve_const_array points = doubles(&x[0][0], M, D);
  egosieve_prediction prediction;
  CHECK_OK(egosieve_gp_log_marginal_likelihood(gp, &before));
  egosieve_optimize_options_init(&options);
  egosieve_optimize_result_init(&result);
  CHECK_OK(egosieve_gp_optimize(gp, &options, &result));
  CHECK_OK(egosieve_gp_log_marginal_likelihood(gp, &after));
  CHECK(after > before + 0.1);
  /* Summed in another order: n eps |log p| and some more. */
  CHECK(fabs(result.log_likelihood_at_start - before) < 1e-9 * fabs(before));
  CHECK(fabs(result.log_likelihood - after) < 1e-9 * fabs(after));
  CHECK(result.points == N && result.evaluations > 5);
  CHECK_OK(egosieve_gp_calibrate(gp));
  egosieve_gp_info_init(&info);
  CHECK_OK(egosieve_gp_describe(gp, &info));
  CHECK(info.squash_a != 1.0 && info.squash_a > 0.0);
  egosieve_prediction_init(&prediction);
  prediction.probability = floats_out(probability, M, 1);
  CHECK_OK(egosieve_gp_predict(gp, &points, &prediction));
  int right = 0;
  for (int i = 0; i < M; ++i) {
    CHECK(probability[i] >= 0.0f && probability[i] <= 1.0f);
    right += (probability[i] > 0.5f) == (y[i] > 0.0);
  }
  CHECK(right >= M * 9 / 10);
  CHECK_OK(egosieve_gp_free(gp));
}

/* The file, the bytes and the model predict alike to the last bit; annotations come along. */
static void test_save_and_load(const char* folder) {
  egosieve_gp* gp = new_conditioned_model(EGOSIEVE_SQUARED_EXPONENTIAL);
  egosieve_gp *from_file = NULL, *from_bytes = NULL;
  const int64_t rows[2] = {5, 3};
  char path[1024], text[8] = "";
  int64_t size = 0, told = 0;
  float expected[M], actual[M];
  void* bytes;
  snprintf(path, sizeof path, "%s/model.npz", folder);
  CHECK_OK(egosieve_gp_remove(gp, rows, 2));
  CHECK_OK(egosieve_gp_set_annotation(gp, "kriged", 6));
  CHECK_OK(egosieve_gp_save(gp, path));
  CHECK_OK(egosieve_gp_load(path, NULL, &from_file));
  CHECK_OK(egosieve_gp_serialize(gp, NULL, 0, &size));
  bytes = malloc((size_t)size);
  CHECK_CALL(egosieve_gp_serialize(gp, bytes, size - 1, &told), EGOSIEVE_INVALID_ARGUMENT,
             "capacity");
  CHECK(told == 0);
  CHECK_OK(egosieve_gp_serialize(gp, bytes, size, &size));
  CHECK_OK(egosieve_gp_deserialize(bytes, size, NULL, &from_bytes));
  CHECK_OK(predict_mean(gp, expected));
  CHECK_OK(predict_mean(from_file, actual));
  CHECK(memcmp(expected, actual, sizeof expected) == 0);
  CHECK_OK(predict_mean(from_bytes, actual));
  CHECK(memcmp(expected, actual, sizeof expected) == 0);
  CHECK_OK(egosieve_gp_annotation(from_file, text, sizeof text, &size));
  CHECK(size == 6 && memcmp(text, "kriged", 6) == 0);
  ((char*)bytes)[size / 2 + 40] ^= 1;
  egosieve_gp* untouched = NULL;
  CHECK_CALL(egosieve_gp_deserialize(bytes, 100, NULL, &untouched), EGOSIEVE_DATA_LOSS, "");
  CHECK(untouched == NULL);
  CHECK_CALL(egosieve_gp_load("/nowhere/model.npz", NULL, &untouched), EGOSIEVE_NOT_FOUND,
             "/nowhere/model.npz");
  CHECK_OK(egosieve_gp_save_normalized(gp, path));
  CHECK_CALL(egosieve_gp_load(path, NULL, &untouched), EGOSIEVE_FAILED_PRECONDITION, "normalize_y");
  CHECK(untouched == NULL);
  CHECK_OK(egosieve_gp_load_normalized(path, NULL, &untouched));
  CHECK_OK(predict_mean(untouched, actual));
  CHECK(memcmp(expected, actual, sizeof expected) == 0);
  CHECK_OK(egosieve_gp_free(untouched));
  free(bytes);
  CHECK_OK(egosieve_gp_free(gp));
  CHECK_OK(egosieve_gp_free(from_file));
  CHECK_OK(egosieve_gp_free(from_bytes));
}

/* A sparse model takes all calls; with every point as inducing input it is the exact one. */
static void test_sparse_models(void) {
  static const egosieve_approximation kinds[2] = {EGOSIEVE_DTC, EGOSIEVE_FITC};
  egosieve_gp* exact = new_conditioned_model(EGOSIEVE_SQUARED_EXPONENTIAL);
  egosieve_gp *gp = NULL, *again = NULL;
  egosieve_gp_options options;
  egosieve_gp_info info;
  egosieve_optimize_result result;
  const egosieve_const_array inputs = doubles(&x[0][0], N, D), targets = doubles(y, N, 1);
  const int64_t first = 0;
  float expected[M], actual[M];
  char bytes[1 << 15];
  int64_t size = 0;
  CHECK_OK(predict_mean(exact, expected));
  for (int k = 0; k < 2; ++k) {
    egosieve_gp_options_init(&options);
    CHECK(options.inducing_points == 512);
    options.covariance = EGOSIEVE_SQUARED_EXPONENTIAL;
    options.dimension = D;
    options.approximation = kinds[k];
    CHECK_OK(egosieve_gp_create(&options, &gp));
    CHECK_OK(egosieve_gp_condition(gp, &inputs, &targets));
    CHECK_OK(predict_mean(gp, actual));
    /* The jitter, 1e-6 of sigma_n^2, and float32 means. */
    for (int i = 0; i < M; ++i) CHECK(fabsf(expected[i] - actual[i]) < 1e-3f);
    CHECK_OK(egosieve_gp_free(gp));
    options.inducing_points = 10;
    CHECK_OK(egosieve_gp_create(&options, &gp));
    CHECK_OK(egosieve_gp_condition(gp, &inputs, &targets));
    CHECK_OK(egosieve_gp_remove(gp, &first, 1));
    egosieve_optimize_result_init(&result);
    CHECK_OK(egosieve_gp_optimize(gp, NULL, &result));
    CHECK(result.log_likelihood >= result.log_likelihood_at_start);
    CHECK_OK(egosieve_gp_calibrate(gp));
    CHECK_OK(egosieve_gp_serialize(gp, NULL, 0, &size));
    CHECK(size <= (int64_t)sizeof bytes);
    CHECK_OK(egosieve_gp_serialize(gp, bytes, sizeof bytes, &size));
    CHECK_OK(egosieve_gp_deserialize(bytes, size, NULL, &again));
    egosieve_gp_info_init(&info);
    CHECK_OK(egosieve_gp_describe(again, &info));
    CHECK(info.approximation == kinds[k] && info.inducing_points == 10);
    CHECK(info.inducing_count == 10 && info.size == N - 1);
    CHECK_OK(predict_mean(gp, expected));
    CHECK_OK(predict_mean(again, actual));
    CHECK(memcmp(expected, actual, sizeof expected) == 0);
    CHECK_OK(predict_mean(exact, expected));
    CHECK_OK(egosieve_gp_free(again));
    CHECK_OK(egosieve_gp_free(gp));
  }
  options.approximation = 7;
  CHECK_CALL(egosieve_gp_create(&options, &gp), EGOSIEVE_INVALID_ARGUMENT, "options.approximation");
  options.approximation = EGOSIEVE_DTC;
  options.inducing_points = 0;
  CHECK_CALL(egosieve_gp_create(&options, &gp), EGOSIEVE_INVALID_ARGUMENT, "inducing_points");
  egosieve_set_threads(3);
  CHECK(egosieve_threads() == 3);
  egosieve_set_threads(0);
  CHECK(egosieve_threads() >= 1);
  CHECK_OK(egosieve_gp_free(exact));
}

/* y = 5e6 + x with hardly any noise: float32 holds neither its means nor its variances. */
static void test_precision(void) {
  enum { SIDE = 5 };
  static double points[SIDE * SIDE][2], values[SIDE * SIDE], at[2][2] = {{0.3, 0.4}, {0.6, 0.1}};
  const egosieve_const_array inputs = doubles(&points[0][0], SIDE * SIDE, 2);
  const egosieve_const_array targets = doubles(values, SIDE * SIDE, 1);
  const egosieve_const_array both = doubles(&at[0][0], 2, 2);
  const egosieve_grid grid = {0.3, 0.4, 0.3, -0.3, 2, 2}; /* `at` is its diagonal */
  egosieve_gp_options options;
  egosieve_gp* gp = NULL;
  egosieve_posterior* posterior = NULL;
  egosieve_prediction prediction;
  double mean[4], variance[4], expected_mean[2], expected_variance[2];
  double of_mean = 0, of_variance = 0, deviation = 0;
  const char* device = getenv("EGOSIEVE_DEVICE");
  if (device != NULL && strcmp(device, "reference") == 0) return; /* it is in float64 */
  for (int i = 0; i < SIDE * SIDE; ++i) {
    points[i][0] = (double)(i % SIDE) / (SIDE - 1);
    points[i][1] = (double)(i / SIDE) / (SIDE - 1);
    values[i] = 5e6 + points[i][0];
  }
  egosieve_gp_options_init(&options);
  options.covariance_text = "matern52";
  options.dimension = 2;
  options.noise_stddev = 1e-3;
  CHECK_OK(egosieve_gp_create(&options, &gp));
  CHECK_OK(egosieve_gp_condition(gp, &inputs, &targets));
  CHECK_OK(egosieve_gp_posterior(gp, &posterior));
  CHECK_OK(egosieve_posterior_float32_error(posterior, &of_mean, &of_variance, &deviation));
  CHECK(of_mean > deviation && of_variance > 0.02 * deviation * deviation);
  egosieve_prediction_init(&prediction);
  CHECK(prediction.precision == EGOSIEVE_AUTO_PRECISION);
  prediction.mean = doubles_out(expected_mean, 2, 1);
  prediction.variance = doubles_out(expected_variance, 2, 1);
  prediction.precision = EGOSIEVE_IN_FLOAT64;
  CHECK_OK(egosieve_gp_predict(gp, &both, &prediction));
  CHECK(prediction.float64_count == 2);
  prediction.mean = doubles_out(mean, 2, 1);
  prediction.variance = doubles_out(variance, 2, 1);
  prediction.precision = EGOSIEVE_IN_FLOAT32;
  CHECK_OK(egosieve_posterior_predict(posterior, &both, &prediction));
  CHECK(prediction.float64_count == 0);
  CHECK(fabs(mean[0] - expected_mean[0]) > 1e-2);
  prediction.precision = EGOSIEVE_AUTO_PRECISION;
  CHECK_OK(egosieve_posterior_predict(posterior, &both, &prediction));
  CHECK(prediction.float64_count == 2 && prediction.clamped_variances == 0);
  CHECK(mean[0] == expected_mean[0] && mean[1] == expected_mean[1]);
  for (int i = 0; i < 2; ++i) {
    CHECK(fabs(sqrt(variance[i]) - sqrt(expected_variance[i])) < 0.02 * sqrt(expected_variance[i]));
  }
  prediction.mean = doubles_out(mean, 2, 2);
  prediction.variance.data = NULL;
  CHECK_OK(egosieve_posterior_predict_grid(posterior, &grid, &prediction));
  CHECK(prediction.float64_count == 4);
  CHECK(fabs(mean[0] - expected_mean[0]) < 1e-6 && fabs(mean[3] - expected_mean[1]) < 1e-6);
  CHECK_OK(egosieve_posterior_free(posterior));
  CHECK_OK(egosieve_gp_free(gp));
}

static void test_devices(void) {
  int32_t count = 0;
  char name[64], cut[4];
  CHECK_OK(egosieve_device_count(&count));
  CHECK(count >= 1);
  CHECK_OK(egosieve_device_name(count - 1, name, sizeof name));
  CHECK(strncmp(name, "reference", 9) == 0);
  CHECK_OK(egosieve_device_name(count - 1, cut, sizeof cut));
  CHECK(strcmp(cut, "ref") == 0);
  CHECK_CALL(egosieve_device_name(count, name, sizeof name), EGOSIEVE_INVALID_ARGUMENT, "index");
  CHECK(egosieve_abi_version() == EGOSIEVE_ABI_VERSION);
  CHECK(strcmp(egosieve_status_name(99), "unknown status") == 0);
}

int main(void) {
  const char* folder = getenv("TEST_TMPDIR");
  make_data();
  test_one_point_by_hand();
  test_condition_and_remove();
  test_strides();
  test_grid_and_posterior();
  test_optima_are_stationary();
  test_optimize_and_calibrate();
  test_save_and_load(folder != NULL ? folder : "/tmp");
  test_sparse_models();
  test_precision();
  test_devices();
  printf("%d checks failed\n", failures);
  return failures == 0 ? 0 : 1;
}
