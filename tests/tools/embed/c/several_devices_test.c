/* Posteriors on several devices through the C interface, from C99: every result is that of a device
 * alone. */
#include <stdlib.h>

#include "egosieve/device_call.h"
#include "egosieve/gaussian_process.h"
#include "tests/tools/embed/c/check.h"
#include "tests/tools/embed/c/small_model.h"

/* Of two or three devices each has a piece of 1,024 queries at least (device_call.h). */
enum { PIECE = 1024, MANY = 5 * PIECE + 17 };

static double many[MANY][D];

static struct results { float mean[MANY], variance[MANY], probability[MANY]; } single, host, shared;

static egosieve_gp* model_on(const char* device, egosieve_mean mean) {
  egosieve_gp_options options;
  egosieve_gp* gp = NULL;
  const egosieve_const_array inputs = doubles(&x[0][0], N, D), targets = doubles(y, N, 1);
  egosieve_gp_options_init(&options);
  options.dimension = D;
  options.mean = mean;
  options.device = device;
  CHECK_OK(egosieve_gp_create(&options, &gp));
  CHECK_OK(egosieve_gp_condition(gp, &inputs, &targets));
  CHECK_OK(egosieve_gp_calibrate(gp));
  return gp;
}

static egosieve_prediction prediction_into(struct results* results) {
  egosieve_prediction prediction;
  memset(results, 0, sizeof *results);
  egosieve_prediction_init(&prediction);
  prediction.mean = floats_out(results->mean, MANY, 1);
  prediction.variance = floats_out(results->variance, MANY, 1);
  prediction.probability = floats_out(results->probability, MANY, 1);
  return prediction;
}

static void predict(egosieve_gp* gp, struct results* results) {
  const egosieve_const_array points = doubles(&many[0][0], MANY, D);
  egosieve_prediction prediction = prediction_into(results);
  CHECK_OK(egosieve_gp_predict(gp, &points, &prediction));
}

static void predict_on(egosieve_gp* gp, const char* const* devices, int64_t count,
                       struct results* results) {
  const egosieve_const_array points = doubles(&many[0][0], MANY, D);
  egosieve_prediction prediction = prediction_into(results);
  egosieve_posterior* posterior = NULL;
  CHECK_OK(egosieve_gp_posterior_on_devices(gp, devices, count, &posterior));
  CHECK_OK(egosieve_posterior_predict(posterior, &points, &prediction));
  CHECK_OK(egosieve_posterior_free(posterior));
}

static int alike(const struct results* a, const struct results* b, int i) {
  return a->mean[i] == b->mean[i] && a->variance[i] == b->variance[i] &&
         a->probability[i] == b->probability[i];
}

/* The device by its index and by its name is open twice, in two contexts. */
static void test_one_device_more_than_once(const char* name) {
  const char* devices[3] = {"0", NULL, "0"};
  devices[1] = name;
  for (int mean = EGOSIEVE_ZERO_MEAN; mean <= EGOSIEVE_LINEAR_MEAN; ++mean) {
    egosieve_gp* gp = model_on("0", mean);
    predict(gp, &single);
    for (int count = 1; count <= 3; ++count) {
      predict_on(gp, devices, count, &shared);
      CHECK(memcmp(&single, &shared, sizeof single) == 0);
    }
    CHECK_OK(egosieve_gp_free(gp));
  }
}

/* The first piece of each device is its own. */
static void test_devices_of_two_kinds(int is_reference) {
  const char* devices[2] = {"0", "reference"};
  egosieve_gp* gp = model_on("reference", EGOSIEVE_ZERO_MEAN);
  int others = 0, of_neither = 0, different = 0;
  predict(gp, &host);
  predict_on(gp, devices, 1, &single);
  predict_on(gp, devices, 2, &shared);
  for (int i = 0; i < MANY; ++i) {
    const struct results* own = i < PIECE ? &single : &host;
    of_neither += !alike(&shared, &single, i) && !alike(&shared, &host, i);
    others += i < 2 * PIECE && !alike(&shared, own, i);
    different += i < 2 * PIECE && !alike(&single, &host, i);
  }
  CHECK(of_neither == 0 && others == 0);
  CHECK(is_reference || different > 0); /* or the test could not tell them apart */
  CHECK_OK(egosieve_gp_free(gp));
}

static void test_stays_as_it_is(void) {
  const char* devices[2] = {"reference", "reference"};
  const egosieve_const_array points = doubles(&many[0][0], MANY, D);
  const int64_t row = 0;
  egosieve_gp* gp = model_on("reference", EGOSIEVE_ZERO_MEAN);
  egosieve_posterior* posterior = NULL;
  egosieve_prediction prediction = prediction_into(&shared);
  predict(gp, &single);
  CHECK_OK(egosieve_gp_posterior_on_devices(gp, devices, 2, &posterior));
  CHECK_OK(egosieve_gp_remove(gp, &row, 1));
  CHECK_OK(egosieve_gp_free(gp));
  CHECK_OK(egosieve_posterior_predict(posterior, &points, &prediction));
  CHECK(memcmp(&single, &shared, sizeof single) == 0);
  CHECK_OK(egosieve_posterior_free(posterior));
}

static void test_refusals(int is_reference) {
  const char* devices[2] = {"0", "a device that nobody has"};
  egosieve_gp* gp = model_on("0", EGOSIEVE_ZERO_MEAN);
  egosieve_posterior* posterior = NULL;
  egosieve_device_call call;
  void* there = NULL;
  CHECK_CALL(egosieve_gp_posterior_on_devices(gp, devices, 2, &posterior), EGOSIEVE_NOT_FOUND,
             "devices[1]: device \"a device that nobody has\"");
  CHECK_CALL(egosieve_gp_posterior_on_devices(gp, devices, 0, &posterior),
             EGOSIEVE_INVALID_ARGUMENT, "device_count = 0");
  CHECK_CALL(egosieve_gp_posterior_on_devices(gp, devices, -1, &posterior),
             EGOSIEVE_INVALID_ARGUMENT, "device_count = -1");
  CHECK_CALL(egosieve_gp_posterior_on_devices(gp, devices, 1025, &posterior),
             EGOSIEVE_INVALID_ARGUMENT, "device_count = 1025");
  CHECK_CALL(egosieve_gp_posterior_on_devices(gp, NULL, 1, &posterior), EGOSIEVE_INVALID_ARGUMENT,
             "devices is null");
  CHECK_CALL(egosieve_gp_posterior_on_devices(gp, devices, 1, NULL), EGOSIEVE_INVALID_ARGUMENT,
             "posterior is null");
  CHECK_CALL(egosieve_gp_posterior_on_devices(NULL, devices, 1, &posterior),
             EGOSIEVE_INVALID_HANDLE, "gp is null");
  CHECK(posterior == NULL);

  devices[1] = "0";
  egosieve_device_call_init(&call);
  CHECK_OK(egosieve_gp_posterior_on_devices(gp, devices, 2, &posterior));
  CHECK_CALL(egosieve_posterior_opencl(posterior, &there, NULL), EGOSIEVE_FAILED_PRECONDITION,
             "lies on 2");
  CHECK_CALL(egosieve_posterior_enqueue(posterior, &call, NULL), EGOSIEVE_FAILED_PRECONDITION,
             "lies on 2");
  CHECK(there == NULL);
  CHECK_OK(egosieve_posterior_free(posterior));
  if (!is_reference) { /* a single device has a context */
    CHECK_OK(egosieve_gp_posterior_on_devices(gp, devices, 1, &posterior));
    CHECK_OK(egosieve_posterior_opencl(posterior, &there, NULL));
    CHECK(there != NULL);
    CHECK_OK(egosieve_posterior_free(posterior));
  }
  CHECK_OK(egosieve_gp_free(gp));
}

int main(void) {
  char line[256];
  const char* name;
  int is_reference;
  make_data();
  for (int i = 0; i < MANY; ++i) {
    for (int d = 0; d < D; ++d) many[i][d] = sin(0.37 * i + 1.3 * d);
  }
  CHECK_OK(egosieve_device_name(0, line, sizeof line));
  is_reference = strncmp(line, "reference", 9) == 0;
  name = strstr(line, ": ");
  CHECK(name != NULL);
  if (name == NULL) return EXIT_FAILURE;
  test_one_device_more_than_once(name + 2);
  test_devices_of_two_kinds(is_reference);
  test_stays_as_it_is();
  test_refusals(is_reference);
  printf("%d checks failed\n", failures);
  return failures == 0 ? 0 : 1;
}
