/* The C interface of the model, from C99: a call that ends with an error has written nothing, also
 * where one of its results is right and another one wrong, and the model is as it was. */
#include <math.h>

#include "egosieve/gaussian_process.h"
#include "egosieve/joint_posterior.h"
#include "tests/tools/embed/c/check.h"
#include "tests/tools/embed/c/small_model.h"

/* Everything that a call may write to, and what it held before. */
static struct results {
  double values[3][M * N];
  double number;
  int64_t size;
  char bytes[64];
  egosieve_gp_info info;
  egosieve_optimize_result result;
  egosieve_gp* gp;
  egosieve_posterior* posterior;
  egosieve_prediction prediction;
} results, before;

/* The k-th array, float64. */
static egosieve_array values_out(int k, int64_t rows, int64_t columns) {
  egosieve_array array = {NULL, 0, 0, 0, 0, EGOSIEVE_FLOAT64};
  array.data = results.values[k];
  array.rows = rows;
  array.columns = columns;
  return array;
}

/* A prediction of M values each, with one of the three of a value less. */
static egosieve_prediction* prediction_with_a_wrong(const char* name) {
  egosieve_prediction* prediction = &results.prediction;
  prediction->mean = values_out(0, M - (strcmp(name, "mean") == 0), 1);
  prediction->variance = values_out(1, M - (strcmp(name, "variance") == 0), 1);
  prediction->probability = values_out(2, M - (strcmp(name, "probability") == 0), 1);
  return prediction;
}

static void fill(void) {
  memset(&results, 0x5a, sizeof results);
  results.info.struct_size = sizeof results.info;
  results.result.struct_size = sizeof results.result;
  results.result.on_bound = NULL;
  egosieve_prediction_init(&results.prediction);
  results.prediction.clamped_variances = results.prediction.float64_count = -7;
}

/* `prepare` comes after the results were filled; the call then ends with `code` and leaves them. */
#define CHECK_REFUSED(prepare, call, code, words)          \
  do {                                                     \
    fill();                                                \
    prepare;                                               \
    memcpy(&before, &results, sizeof results);             \
    CHECK_CALL(call, code, words);                         \
    CHECK(memcmp(&before, &results, sizeof results) == 0); \
  } while (0)

static void test_predictions(egosieve_gp* gp) {
  const egosieve_const_array points = doubles(&queries[0][0], M, D);
  double broken[M][D];
  const egosieve_const_array bad = doubles(&broken[0][0], M, D);
  const char* names[3] = {"mean", "variance", "probability"};
  egosieve_posterior* posterior = NULL;
  CHECK_OK(egosieve_gp_posterior(gp, &posterior));
  memcpy(broken, queries, sizeof broken);
  broken[M - 1][D - 1] = NAN;
  for (int k = 0; k < 3; ++k) {
    CHECK_REFUSED(prediction_with_a_wrong(names[k]),
                  egosieve_gp_predict(gp, &points, &results.prediction), EGOSIEVE_INVALID_ARGUMENT,
                  names[k]);
    CHECK_REFUSED(prediction_with_a_wrong(names[k]),
                  egosieve_posterior_predict(posterior, &points, &results.prediction),
                  EGOSIEVE_INVALID_ARGUMENT, names[k]);
  }
  CHECK_REFUSED(prediction_with_a_wrong("none"), egosieve_gp_predict(gp, &bad, &results.prediction),
                EGOSIEVE_INVALID_ARGUMENT, "x(29, 2)");
  CHECK_REFUSED(prediction_with_a_wrong("none")->precision = 3,
                egosieve_gp_predict(gp, &points, &results.prediction), EGOSIEVE_INVALID_ARGUMENT,
                "prediction.precision = 3");
  CHECK_REFUSED(prediction_with_a_wrong("none")->precision = EGOSIEVE_IN_FLOAT64,
                egosieve_gp_predict(gp, &bad, &results.prediction), EGOSIEVE_INVALID_ARGUMENT,
                "x(29, 2)");
  CHECK_OK(egosieve_posterior_free(posterior));
}

static void test_matrices(egosieve_gp* gp) {
  const egosieve_const_array points = doubles(&queries[0][0], M, D);
  egosieve_array first = values_out(0, M, 1), second = values_out(1, M, M - 1), third;
  CHECK_REFUSED(, egosieve_gp_predict_joint(gp, &points, 0, &first, &second),
                EGOSIEVE_INVALID_ARGUMENT, "covariance: 30 x 29");
  CHECK_REFUSED(, egosieve_gp_predict_joint(gp, &points, 0, &first, NULL),
                EGOSIEVE_INVALID_ARGUMENT, "covariance is null");
  first = values_out(0, M - 1, 2);
  CHECK_REFUSED(, egosieve_gp_sample(gp, &points, 5, 0, &first, &results.number),
                EGOSIEVE_INVALID_ARGUMENT, "samples: 29 x 2");
  first = values_out(0, M, D);
  second = values_out(1, M, D - 1);
  CHECK_REFUSED(, egosieve_gp_gradients(gp, &points, &first, &second), EGOSIEVE_INVALID_ARGUMENT,
                "variance: 30 x 2");
  first = values_out(0, N, 1);
  second = values_out(1, N, 1);
  third = values_out(2, N - 1, 1);
  CHECK_REFUSED(, egosieve_gp_leave_one_out(gp, &first, &second, &third), EGOSIEVE_INVALID_ARGUMENT,
                "log_density: 39 x 1");
  CHECK_REFUSED(, egosieve_gp_noise_variances(gp, &third), EGOSIEVE_INVALID_ARGUMENT, "v: 39 x 1");
  CHECK_REFUSED(, egosieve_gp_mean_coefficients(gp, &third), EGOSIEVE_INVALID_ARGUMENT,
                "coefficients: 39 x 1");
  first = values_out(0, N, D);
  CHECK_REFUSED(, egosieve_gp_points(gp, &first, &third), EGOSIEVE_INVALID_ARGUMENT, "y: 39 x 1");
}

static void test_pixels(egosieve_gp* gp) {
  static const uint8_t pixels[8 * 8 * 3] = {0};
  const egosieve_image image = {pixels, 8, 8, 0, EGOSIEVE_BGR};
  const double places[2][2] = {{1, 1}, {8, 1}};
  const egosieve_const_array at = doubles(&places[0][0], 2, 2);
  const egosieve_array out = values_out(0, 2, 6);
  CHECK_REFUSED(, egosieve_gp_describe_pixels(gp, &image, &at, &out), EGOSIEVE_INVALID_ARGUMENT,
                "places: points row 1");
}

static void test_values_and_bytes(egosieve_gp* gp) {
  double theta[6] = {0, 0, 0, 0, 0, NAN};
  egosieve_optimize_options options;
  CHECK_REFUSED(, egosieve_gp_log_marginal_likelihood(NULL, &results.number),
                EGOSIEVE_INVALID_HANDLE, "gp is null");
  CHECK_REFUSED(, egosieve_gp_likelihood_at(gp, theta, 5, &results.number, results.values[0]),
                EGOSIEVE_INVALID_ARGUMENT, "theta has 6 values");
  CHECK_REFUSED(, egosieve_gp_likelihood_at(gp, theta, 6, &results.number, results.values[0]),
                EGOSIEVE_INVALID_ARGUMENT, "");
  CHECK_REFUSED(, egosieve_gp_scales(gp, results.values[0], 3), EGOSIEVE_INVALID_ARGUMENT,
                "there are 4");
  CHECK_REFUSED(, egosieve_gp_covariance_text(gp, results.bytes, 3, &results.size),
                EGOSIEVE_INVALID_ARGUMENT, "capacity = 3");
  CHECK_REFUSED(, egosieve_gp_covariance_text(gp, results.bytes, sizeof results.bytes, NULL),
                EGOSIEVE_INVALID_ARGUMENT, "size is null");
  CHECK_REFUSED(, egosieve_gp_annotation(gp, results.bytes, 3, &results.size),
                EGOSIEVE_INVALID_ARGUMENT, "capacity = 3");
  CHECK_REFUSED(, egosieve_gp_serialize(gp, results.bytes, sizeof results.bytes, &results.size),
                EGOSIEVE_INVALID_ARGUMENT, "capacity = 64");
  CHECK_REFUSED(results.info.struct_size = 12, egosieve_gp_describe(gp, &results.info),
                EGOSIEVE_INVALID_ARGUMENT, "info.struct_size");
  egosieve_optimize_options_init(&options);
  options.tolerance = NAN;
  CHECK_REFUSED(, egosieve_gp_optimize(gp, &options, &results.result), EGOSIEVE_INVALID_ARGUMENT,
                "tolerance");
  egosieve_optimize_options_init(&options);
  CHECK_REFUSED(results.result.struct_size = 12,
                egosieve_gp_optimize(gp, &options, &results.result), EGOSIEVE_INVALID_ARGUMENT,
                "result.struct_size");
}

static void test_new_handles(void) {
  egosieve_gp_options options;
  egosieve_gp_options_init(&options);
  CHECK_REFUSED(, egosieve_gp_create(&options, &results.gp), EGOSIEVE_INVALID_ARGUMENT,
                "dimension");
  CHECK_REFUSED(, egosieve_gp_load("/nowhere/at/all", NULL, &results.gp), EGOSIEVE_NOT_FOUND,
                "/nowhere/at/all");
  CHECK_REFUSED(, egosieve_gp_deserialize("a model", 7, NULL, &results.gp), EGOSIEVE_DATA_LOSS, "");
  CHECK_REFUSED(, egosieve_gp_posterior(NULL, &results.posterior), EGOSIEVE_INVALID_HANDLE,
                "gp is null");
}

/* What changes a model fails in its last value. */
static void test_changes(egosieve_gp* gp) {
  double inputs[N][D], targets[N], noise[N] = {0.0};
  const double scales[4] = {1.0, 1.0, 1.0, 1.0};
  const int64_t rows[3] = {0, 1, N};
  egosieve_const_array at = doubles(&inputs[0][0], N, D), of = doubles(targets, N, 1);
  egosieve_const_array v = doubles(noise, N, 1);
  memcpy(inputs, x, sizeof inputs);
  memcpy(targets, y, sizeof targets);
  noise[N - 1] = -1.0;
  CHECK_CALL(egosieve_gp_condition_noisy(gp, &at, &of, &v), EGOSIEVE_INVALID_ARGUMENT, "v(39)");
  targets[N - 1] = NAN;
  CHECK_CALL(egosieve_gp_condition(gp, &at, &of), EGOSIEVE_INVALID_ARGUMENT, "y(39, 0)");
  of = doubles(y, N, 1);
  inputs[N - 1][D - 1] = NAN;
  CHECK_CALL(egosieve_gp_condition(gp, &at, &of), EGOSIEVE_INVALID_ARGUMENT, "x(39, 2)");
  CHECK_CALL(egosieve_gp_remove(gp, rows, 3), EGOSIEVE_INVALID_ARGUMENT, "rows: 40");
  CHECK_CALL(egosieve_gp_set_hyperparameters(gp, scales, 4, 2.0, -1.0), EGOSIEVE_INVALID_ARGUMENT,
             "noise_stddev");
  CHECK_CALL(egosieve_gp_set_annotation(gp, "else", -1), EGOSIEVE_INVALID_ARGUMENT, "size = -1");
}

int main(void) {
  static char first[1 << 16], last[1 << 16];
  int64_t first_size = 0, last_size = 0;
  egosieve_gp* gp;
  make_data();
  gp = new_conditioned_model(EGOSIEVE_ARCSINE);
  CHECK_OK(egosieve_gp_set_annotation(gp, "kriged", 6));
  CHECK_OK(egosieve_gp_serialize(gp, first, sizeof first, &first_size));
  test_predictions(gp);
  test_matrices(gp);
  test_pixels(gp);
  test_values_and_bytes(gp);
  test_new_handles();
  test_changes(gp);
  CHECK_OK(egosieve_gp_serialize(gp, last, sizeof last, &last_size));
  CHECK(first_size == last_size && memcmp(first, last, (size_t)first_size) == 0);
  CHECK_OK(egosieve_gp_free(gp));
  printf("%d checks failed\n", failures);
  return failures == 0 ? 0 : 1;
}
