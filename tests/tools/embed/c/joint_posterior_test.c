/* The C interface's joint predictions, samples, gradients and left-out points, from C99. */
#include "egosieve/joint_posterior.h"

#include <math.h>

#include "tests/tools/embed/c/check.h"
#include "tests/tools/embed/c/small_model.h"

static egosieve_gp* new_named_model(const char* covariance, int32_t dimension, int32_t mean) {
  egosieve_gp_options options;
  egosieve_gp* gp = NULL;
  egosieve_gp_options_init(&options);
  options.covariance = EGOSIEVE_NAMED_COVARIANCE;
  options.covariance_text = covariance;
  options.dimension = dimension;
  options.mean = mean;
  CHECK_OK(egosieve_gp_create(&options, &gp));
  return gp;
}

/* One point at 0.3, y = 2, k = 2.25, K_y = 2.25 + 0.25 + 0.5; queries there and a length beside it.
 */
static void test_one_point_by_hand(void) {
  egosieve_gp* gp = new_named_model("squared_exponential", 1, EGOSIEVE_ZERO_MEAN);
  const double length = 0.7, at = 0.3, target = 2.0, noise = 0.5, places[2] = {0.3, 1.0};
  const egosieve_const_array point = doubles(&at, 1, 1), value = doubles(&target, 1, 1);
  const egosieve_const_array v = doubles(&noise, 1, 1), both = doubles(places, 2, 1);
  const double k = 2.25, beside = 2.25 * exp(-0.5), k_y = 3.0, pi = 3.14159265358979323846;
  const double theta[3] = {log(0.7), log(1.5), log(0.5)};
  double mean[2], covariance[4], gradient[2], slope[2], left_mean, left_variance, left_density;
  double likelihood, likelihood_slope[3];
  egosieve_array means = doubles_out(mean, 2, 1), joint = doubles_out(covariance, 2, 2);
  egosieve_array of_mean = doubles_out(gradient, 2, 1), of_variance = doubles_out(slope, 2, 1);
  egosieve_array out[3];
  egosieve_prediction prediction;
  CHECK_OK(egosieve_gp_set_hyperparameters(gp, &length, 1, 1.5, 0.5));
  CHECK_OK(egosieve_gp_condition_noisy(gp, &point, &value, &v));
  CHECK_OK(egosieve_gp_predict_joint(gp, &both, 0, &means, &joint));
  CHECK(fabs(mean[0] - k * 2.0 / k_y) < 1e-14 && fabs(mean[1] - beside * 2.0 / k_y) < 1e-14);
  CHECK(fabs(covariance[0] - (k - k * k / k_y)) < 1e-14);
  CHECK(fabs(covariance[1] - (beside - k * beside / k_y)) < 1e-14);
  CHECK(covariance[1] == covariance[2]);
  CHECK(fabs(covariance[3] - (k - beside * beside / k_y)) < 1e-14);
  CHECK_OK(egosieve_gp_predict_joint(gp, &both, 1, &means, &joint));
  CHECK(fabs(covariance[0] - (k - k * k / k_y + 0.25)) < 1e-14);
  egosieve_prediction_init(&prediction);
  prediction.mean = means;
  prediction.variance = of_variance;
  prediction.precision = EGOSIEVE_IN_FLOAT64;
  CHECK_OK(egosieve_gp_predict(gp, &both, &prediction));
  CHECK(fabs(mean[1] - beside * 2.0 / k_y) < 1e-14);
  CHECK(fabs(slope[1] - (k - beside * beside / k_y)) < 1e-14);
  CHECK_OK(egosieve_gp_gradients(gp, &both, &of_mean, &of_variance));
  CHECK(fabs(gradient[0]) < 1e-14 && fabs(slope[0]) < 1e-14);
  CHECK(fabs(gradient[1] + 2.0 / k_y * beside / 0.7) < 1e-14);
  CHECK(fabs(slope[1] - 2.0 * beside * beside / k_y / 0.7) < 1e-14);
  out[0] = doubles_out(&left_mean, 1, 1);
  out[1] = doubles_out(&left_variance, 1, 1);
  out[2] = doubles_out(&left_density, 1, 1);
  CHECK_OK(egosieve_gp_leave_one_out(gp, &out[0], &out[1], &out[2]));
  CHECK(fabs(left_mean) < 1e-14 && fabs(left_variance - k_y) < 1e-14);
  CHECK(fabs(left_density + 0.5 * (log(2.0 * pi * k_y) + 4.0 / k_y)) < 1e-14);
  CHECK_OK(egosieve_gp_likelihood_at(gp, theta, 3, &likelihood, likelihood_slope));
  CHECK(fabs(likelihood - left_density) < 1e-13); /* one point has no others */
  /* d/dlog sigma_f: (y^2 / K_y^2 - 1 / K_y) k; d/dlog sigma_n the same of sigma_n^2. */
  CHECK(fabs(likelihood_slope[0]) < 1e-14);
  CHECK(fabs(likelihood_slope[1] - (4.0 / 9.0 - 1.0 / 3.0) * 2.25) < 1e-13);
  CHECK(fabs(likelihood_slope[2] - (4.0 / 9.0 - 1.0 / 3.0) * 0.25) < 1e-13);
  out[0] = doubles_out(&left_mean, 1, 1);
  CHECK_OK(egosieve_gp_noise_variances(gp, &out[0]));
  CHECK(left_mean == 0.5);
  CHECK_OK(egosieve_gp_free(gp));
}

/* k = 2.25 exp(-1/2 (r / 0.7)^2) between 0.3 and {0.3, 1.0}: its derivatives by log l, log sigma_f, x. */
static void test_covariances(void) {
  egosieve_gp* gp = new_named_model("squared_exponential", 1, EGOSIEVE_ZERO_MEAN);
  const double length = 0.7, at = 0.3, places[2] = {0.3, 1.0}, beside = 2.25 * exp(-0.5);
  const egosieve_const_array x = doubles(&at, 1, 1), z = doubles(places, 2, 1);
  double values[2], logarithms[4], slopes[2];
  egosieve_array k = doubles_out(values, 1, 2), by_x = doubles_out(slopes, 2, 1);
  egosieve_array by_logarithms = doubles_out(logarithms, 2, 2), none = doubles_out(NULL, 0, 0);
  CHECK_OK(egosieve_gp_set_hyperparameters(gp, &length, 1, 1.5, 0.5));
  CHECK_OK(egosieve_gp_covariances(gp, &x, &z, &k, &by_logarithms, &by_x));
  CHECK(fabs(values[0] - 2.25) < 1e-14 && fabs(values[1] - beside) < 1e-14);
  CHECK(fabs(logarithms[0]) < 1e-14 && fabs(logarithms[1] - 4.5) < 1e-14);
  CHECK(fabs(logarithms[2] - beside) < 1e-14 && fabs(logarithms[3] - 2.0 * beside) < 1e-14);
  CHECK(fabs(slopes[0]) < 1e-14 && fabs(slopes[1] - beside / 0.7) < 1e-14);
  k = doubles_out(logarithms, 2, 2);
  CHECK_OK(egosieve_gp_covariances(gp, &z, NULL, &k, &none, &none));
  CHECK(fabs(logarithms[1] - beside) < 1e-14 && logarithms[1] == logarithms[2]);
  CHECK_CALL(egosieve_gp_covariances(gp, &z, &z, &by_x, &none, &none), EGOSIEVE_INVALID_ARGUMENT,
             "k: 2 x 1");
  CHECK_OK(egosieve_gp_free(gp));
}

/* Two points far apart are two classifications of one: p = Phi(m / sqrt(1 + v)) by its own mode. */
static void test_classes(void) {
  egosieve_gp *gp = new_named_model("squared_exponential", 1, EGOSIEVE_ZERO_MEAN), *loaded = NULL;
  const double places[2] = {-100.0, 100.0}, labels[2] = {-1.0, 1.0}, weights[2] = {1.0, 2.0};
  const double wrong[2] = {0.0, 1.0}, length = 1.0, pi = 3.14159265358979323846;
  const egosieve_const_array x = doubles(places, 2, 1), y = doubles(labels, 2, 1);
  const egosieve_const_array w = doubles(weights, 2, 1), bad = doubles(wrong, 2, 1);
  egosieve_optimize_result result;
  egosieve_prediction prediction;
  double probability[2], again[2], expected[2], value = 0.0;
  static char bytes[1 << 16];
  int64_t size = 0;
  int i, step;
  for (i = 0; i < 2; ++i) { /* f = 4 w N(t f), by bisection; k = 4 */
    double low = 0.0, high = 10.0, ratio = 0.0, bend, variance;
    for (step = 0; step < 100; ++step) {
      const double f = 0.5 * (low + high);
      ratio = exp(-0.5 * f * f) / sqrt(2.0 * pi) / (0.5 * erfc(-f / sqrt(2.0)));
      if (f < 4.0 * weights[i] * ratio) {
        low = f;
      } else {
        high = f;
      }
    }
    bend = weights[i] * ratio * (ratio + low);
    variance = 4.0 - 16.0 / (4.0 + 1.0 / bend);
    expected[i] = 0.5 * erfc(-labels[i] * low / sqrt(1.0 + variance) / sqrt(2.0));
    value += weights[i] * log(0.5 * erfc(-low / sqrt(2.0))) - 0.125 * low * low -
             0.5 * log(1.0 + 4.0 * bend);
  }
  CHECK_OK(egosieve_gp_set_hyperparameters(gp, &length, 1, 2.0, 0.5));
  egosieve_optimize_result_init(&result);
  CHECK_CALL(egosieve_gp_classify(gp, &x, &bad, NULL, NULL, NULL), EGOSIEVE_INVALID_ARGUMENT,
             "label 0 is 0");
  CHECK_OK(egosieve_gp_classify(gp, &x, &y, &w, NULL, &result));
  CHECK(fabs(result.log_likelihood - value) < 1e-9);
  egosieve_prediction_init(&prediction);
  prediction.probability = doubles_out(probability, 2, 1);
  prediction.precision = EGOSIEVE_IN_FLOAT64;
  CHECK_OK(egosieve_gp_predict(gp, &x, &prediction));
  CHECK(fabs(probability[0] - expected[0]) < 1e-9 && fabs(probability[1] - expected[1]) < 1e-9);
  CHECK_OK(egosieve_gp_calibrate(gp)); /* there is nothing to fit */
  CHECK_OK(egosieve_gp_serialize(gp, bytes, sizeof bytes, &size));
  CHECK_OK(egosieve_gp_deserialize(bytes, size, NULL, &loaded));
  prediction.probability = doubles_out(again, 2, 1);
  CHECK_OK(egosieve_gp_predict(loaded, &x, &prediction));
  CHECK(again[0] == probability[0] && again[1] == probability[1]);
  CHECK_OK(egosieve_gp_condition(loaded, &x, &y));
  CHECK_CALL(egosieve_gp_predict(loaded, &x, &prediction), EGOSIEVE_FAILED_PRECONDITION,
             "probabilities need");
  CHECK_OK(egosieve_gp_free(loaded));
  CHECK_OK(egosieve_gp_free(gp));
}

/* Samples follow from the seed, and of a model without points come from the prior. */
static void test_samples(void) {
  egosieve_gp* gp = new_conditioned_model(EGOSIEVE_ARCSINE);
  egosieve_gp* prior = new_model(EGOSIEVE_ARCSINE);
  const egosieve_const_array points = doubles(&queries[0][0], M, D);
  static double first[M][4], second[M][2];
  double jitter = -1.0;
  egosieve_array four = doubles_out(&first[0][0], M, 4), two = doubles_out(&second[0][0], M, 2);
  CHECK_OK(egosieve_gp_sample(gp, &points, 5, 0, &four, &jitter));
  CHECK(jitter >= 0.0);
  CHECK_OK(egosieve_gp_sample(gp, &points, 5, 0, &two, NULL));
  for (int i = 0; i < M; ++i) CHECK(first[i][0] == second[i][0] && first[i][1] == second[i][1]);
  CHECK(first[0][0] != first[0][1]);
  CHECK_OK(egosieve_gp_sample(gp, &points, 6, 0, &two, NULL));
  CHECK(first[0][0] != second[0][0]);
  CHECK_OK(egosieve_gp_sample(prior, &points, 5, 1, &two, NULL));
  CHECK_CALL(egosieve_gp_sample(gp, &points, 5, 0, NULL, NULL), EGOSIEVE_INVALID_ARGUMENT,
             "samples is null");
  CHECK_OK(egosieve_gp_free(gp));
  CHECK_OK(egosieve_gp_free(prior));
}

/* A path is the same function whatever it is asked, and goes through the points where there is hardly
   any noise: the posterior's deviation there is below sigma_n, 1e-3, and 10 of them are allowed. */
static void test_sample_paths(void) {
  egosieve_gp* gp = new_named_model("matern52", D, EGOSIEVE_ZERO_MEAN);
  const double lengths[D] = {0.5, 0.5, 0.5};
  const egosieve_const_array inputs = doubles(&x[0][0], N, D), targets = doubles(y, N, 1);
  const egosieve_const_array points = doubles(&queries[0][0], M, D);
  const egosieve_const_array last = doubles(&queries[M - 1][0], 1, D);
  static double first[M][4], own[N][2];
  double second[2];
  egosieve_array four = doubles_out(&first[0][0], M, 4), two = doubles_out(second, 1, 2);
  egosieve_array at_points = doubles_out(&own[0][0], N, 2);
  CHECK_OK(egosieve_gp_set_hyperparameters(gp, lengths, D, 1.0, 1e-3));
  CHECK_OK(egosieve_gp_condition(gp, &inputs, &targets));
  CHECK_OK(egosieve_gp_sample_paths(gp, &points, 5, 256, 0, &four));
  CHECK_OK(egosieve_gp_sample_paths(gp, &last, 5, 256, 0, &two));
  CHECK(second[0] == first[M - 1][0] && second[1] == first[M - 1][1] && second[0] != second[1]);
  CHECK_OK(egosieve_gp_sample_paths(gp, &inputs, 5, 256, 0, &at_points));
  for (int i = 0; i < N; ++i) CHECK(fabs(own[i][0] - y[i]) < 1e-2);
  CHECK_CALL(egosieve_gp_sample_paths(gp, &last, 5, 0, 0, &two), EGOSIEVE_INVALID_ARGUMENT,
             "frequencies is 0");
  CHECK_CALL(egosieve_gp_sample_paths(gp, &points, 5, 9, 0, &two), EGOSIEVE_INVALID_ARGUMENT,
             "samples: 1 x 2");
  CHECK_OK(egosieve_gp_free(gp));
  gp = new_model(EGOSIEVE_ARCSINE);
  CHECK_CALL(egosieve_gp_sample_paths(gp, &last, 5, 9, 0, &two), EGOSIEVE_UNIMPLEMENTED, "arcsine");
  CHECK_OK(egosieve_gp_free(gp));
}

/* Two outputs with a linear mean: y is a plane for the second, which the mean takes whole. */
static void test_outputs_and_mean(void) {
  egosieve_gp* gp = new_named_model("matern52", D, EGOSIEVE_LINEAR_MEAN);
  const egosieve_const_array inputs = doubles(&x[0][0], N, D);
  const egosieve_const_array points = doubles(&queries[0][0], M, D);
  static double both[N][2], mean[M][2], coefficients[D + 1][2];
  float narrow[M][2];
  egosieve_array out = doubles_out(&mean[0][0], M, 2), one = doubles_out(&mean[0][0], M, 1);
  egosieve_array none = {NULL, 0, 0, 0, 0, EGOSIEVE_FLOAT64};
  egosieve_const_array targets = doubles(&both[0][0], N, 2);
  egosieve_prediction prediction;
  egosieve_gp_info info;
  char text[16];
  int64_t size = 0;
  for (int i = 0; i < N; ++i) {
    both[i][0] = y[i];
    both[i][1] = 50.0 + 3.0 * x[i][0] - x[i][2];
  }
  CHECK_CALL(egosieve_gp_predict_joint(gp, &points, 0, &one, &none), EGOSIEVE_FAILED_PRECONDITION,
             "do not determine");
  CHECK_OK(egosieve_gp_condition(gp, &inputs, &targets));
  CHECK_OK(egosieve_gp_predict_joint(gp, &points, 0, &out, &none));
  for (int i = 0; i < M; ++i) {
    CHECK(fabs(mean[i][1] - (50.0 + 3.0 * queries[i][0] - queries[i][2])) < 1e-9);
  }
  egosieve_prediction_init(&prediction);
  prediction.mean = floats_out(&narrow[0][0], M, 2);
  CHECK_OK(egosieve_gp_predict(gp, &points, &prediction));
  for (int i = 0; i < M; ++i) CHECK(fabs(narrow[i][1] - mean[i][1]) < 1e-4);
  out = doubles_out(&coefficients[0][0], D + 1, 2);
  CHECK_OK(egosieve_gp_mean_coefficients(gp, &out));
  CHECK(fabs(coefficients[0][1] - 50.0) < 1e-9 && fabs(coefficients[1][1] - 3.0) < 1e-9);
  egosieve_gp_info_init(&info);
  CHECK_OK(egosieve_gp_describe(gp, &info));
  CHECK(info.outputs == 2 && info.coefficients == D + 1 && info.mean == EGOSIEVE_LINEAR_MEAN);
  CHECK(info.covariance == EGOSIEVE_NAMED_COVARIANCE && !info.has_labels);
  CHECK_OK(egosieve_gp_covariance_text(gp, text, sizeof text, &size));
  CHECK(size == 8 && memcmp(text, "matern52", 8) == 0);
  targets = doubles(y, N, 1);
  CHECK_CALL(egosieve_gp_condition(gp, &inputs, &targets), EGOSIEVE_INVALID_ARGUMENT,
             "1 outputs; the model's points have 2");
  prediction.mean.data = NULL;
  prediction.probability = floats_out(&narrow[0][0], M, 1);
  CHECK_CALL(egosieve_gp_predict(gp, &points, &prediction), EGOSIEVE_FAILED_PRECONDITION,
             "one output");
  CHECK_OK(egosieve_gp_free(gp));
}

/* Noise by point, outputs and mean function are in the file. */
static void test_file(void) {
  egosieve_gp* gp = new_named_model("matern52 + linear", D, EGOSIEVE_CONSTANT_MEAN);
  egosieve_gp* again = NULL;
  const egosieve_const_array inputs = doubles(&x[0][0], N, D), targets = doubles(y, N, 1);
  static double noise[N], back[N], scales[7], more[9] = {0, 0, 0, 0, 0, 0, 0, -7.0, -7.0};
  static char bytes[1 << 16];
  egosieve_const_array v = doubles(noise, N, 1);
  egosieve_array out = doubles_out(back, N, 1);
  float mean[M], mean_again[M];
  int64_t size = 0;
  for (int i = 0; i < N; ++i) noise[i] = 0.01 * i;
  CHECK_OK(egosieve_gp_condition_noisy(gp, &inputs, &targets, &v));
  CHECK_OK(egosieve_gp_serialize(gp, bytes, sizeof bytes, &size));
  CHECK_OK(egosieve_gp_deserialize(bytes, size, NULL, &again));
  CHECK_OK(egosieve_gp_noise_variances(again, &out));
  CHECK(memcmp(noise, back, sizeof noise) == 0);
  CHECK_OK(predict_mean(gp, mean));
  CHECK_OK(predict_mean(again, mean_again));
  CHECK(memcmp(mean, mean_again, sizeof mean) == 0);
  CHECK_OK(egosieve_gp_scales(again, scales, 7)); /* 3 lengths, an amplitude, 3 weights */
  CHECK(scales[0] == 0.5 && scales[6] == 1.0);
  CHECK_OK(egosieve_gp_scales(again, more, 9));
  CHECK(memcmp(more, scales, sizeof scales) == 0 && more[7] == -7.0 && more[8] == -7.0);
  CHECK_CALL(egosieve_gp_scales(again, scales, 6), EGOSIEVE_INVALID_ARGUMENT, "there are 7");
  noise[3] = -1.0;
  CHECK_CALL(egosieve_gp_condition_noisy(gp, &inputs, &targets, &v), EGOSIEVE_INVALID_ARGUMENT,
             "v(3) = -1");
  CHECK_OK(egosieve_gp_free(gp));
  CHECK_OK(egosieve_gp_free(again));
}

/* What else is refused: untouched_results_test.c. */
static void test_refusals(void) {
  egosieve_gp* none = NULL;
  egosieve_gp_options options;
  egosieve_gp_options_init(&options);
  options.dimension = D;
  options.covariance = EGOSIEVE_NAMED_COVARIANCE;
  CHECK_CALL(egosieve_gp_create(&options, &none), EGOSIEVE_INVALID_ARGUMENT,
             "options.covariance_text is null");
  options.covariance_text = "cubic";
  CHECK_CALL(egosieve_gp_create(&options, &none), EGOSIEVE_INVALID_ARGUMENT, "cubic");
  options.covariance_text = "matern52";
  options.mean = 3;
  CHECK_CALL(egosieve_gp_create(&options, &none), EGOSIEVE_INVALID_ARGUMENT, "options.mean = 3");
}

int main(void) {
  make_data();
  test_one_point_by_hand();
  test_covariances();
  test_classes();
  test_samples();
  test_sample_paths();
  test_outputs_and_mean();
  test_file();
  test_refusals();
  printf("%d checks failed\n", failures);
  return failures == 0 ? 0 : 1;
}
