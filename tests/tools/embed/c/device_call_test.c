/* Predictions on the caller's command queue through the C interface, from C99. */
#include "egosieve/device_call.h"

#include <CL/cl.h>

#include "tests/tools/embed/c/check.h"
#include "tests/tools/embed/c/small_model.h"

/* Matern 5/2, whose queries the device prepares to the bit as the host does. */
static egosieve_posterior* new_posterior(cl_context context, cl_device_id device,
                                         egosieve_mean mean) {
  egosieve_gp_options options;
  egosieve_gp* gp = NULL;
  egosieve_posterior* posterior = NULL;
  const egosieve_const_array inputs = doubles(&x[0][0], N, D), targets = doubles(y, N, 1);
  egosieve_gp_options_init(&options);
  options.covariance = EGOSIEVE_NAMED_COVARIANCE;
  options.covariance_text = "matern52";
  options.dimension = D;
  options.mean = mean;
  options.opencl_context = context;
  options.opencl_device = device;
  CHECK_OK(egosieve_gp_create(&options, &gp));
  CHECK_OK(egosieve_gp_condition(gp, &inputs, &targets));
  CHECK_OK(egosieve_gp_posterior(gp, &posterior));
  CHECK_OK(egosieve_gp_free(gp));
  return posterior;
}

/* Arguments that are wrong in one field each; `call` is right. */
static void expect_refusals(egosieve_posterior* posterior, egosieve_device_call call) {
  void* event = NULL;
  call.variance.first = M + 1;
  CHECK_CALL(egosieve_posterior_enqueue(posterior, &call, &event), EGOSIEVE_INVALID_ARGUMENT,
             "variance");
  call.wait_count = -1;
  CHECK_CALL(egosieve_posterior_enqueue(posterior, &call, &event), EGOSIEVE_INVALID_ARGUMENT,
             "wait_count");
  call.struct_size = 12;
  CHECK_CALL(egosieve_posterior_enqueue(posterior, &call, &event), EGOSIEVE_INVALID_ARGUMENT,
             "struct_size");
  CHECK_CALL(egosieve_posterior_enqueue(posterior, NULL, &event), EGOSIEVE_INVALID_ARGUMENT,
             "call");
  CHECK_CALL(egosieve_posterior_enqueue(NULL, &call, &event), EGOSIEVE_INVALID_HANDLE, "posterior");
}

static void expect_the_hosts(egosieve_posterior* posterior, cl_context context,
                             cl_device_id device) {
  float packed[M][D], mean[M], variance[M], results[2 * M];
  egosieve_const_array points = {NULL, M, D, 0, 0, EGOSIEVE_FLOAT32};
  egosieve_prediction prediction;
  egosieve_device_call call;
  void* event = NULL;
  cl_event done;
  cl_int error;
  cl_command_queue queue = clCreateCommandQueue(context, device, 0, &error);
  cl_mem at, out;
  CHECK(error == CL_SUCCESS);
  for (int i = 0; i < M; ++i) {
    for (int d = 0; d < D; ++d) packed[i][d] = (float)queries[i][d];
  }
  points.data = packed;
  at = clCreateBuffer(context, CL_MEM_COPY_HOST_PTR, sizeof packed, packed, &error);
  CHECK(error == CL_SUCCESS);
  out = clCreateBuffer(context, CL_MEM_READ_WRITE, sizeof results, NULL, &error);
  CHECK(error == CL_SUCCESS);

  egosieve_prediction_init(&prediction);
  prediction.mean = floats_out(mean, M, 1);
  prediction.variance = floats_out(variance, M, 1);
  prediction.precision = EGOSIEVE_IN_FLOAT32;
  CHECK_OK(egosieve_posterior_predict(posterior, &points, &prediction));

  egosieve_device_call_init(&call);
  call.queue = queue;
  call.queries = at;
  call.query_count = M;
  call.mean.memory = out;
  call.variance.memory = out;
  call.variance.first = M;
  CHECK_OK(egosieve_posterior_enqueue(posterior, &call, &event));
  done = (cl_event)event;
  CHECK(clEnqueueReadBuffer(queue, out, CL_TRUE, 0, sizeof results, results, 1, &done, NULL) ==
        CL_SUCCESS);
  CHECK(memcmp(results, mean, sizeof mean) == 0);
  CHECK(memcmp(results + M, variance, sizeof variance) == 0);

  /* An event that comes first; nobody asks for the last one. */
  call.wait = &event;
  call.wait_count = 1;
  CHECK_OK(egosieve_posterior_enqueue(posterior, &call, NULL));
  CHECK(clFinish(queue) == CL_SUCCESS);

  expect_refusals(posterior, call);
  clReleaseEvent(done);
  clReleaseMemObject(at);
  clReleaseMemObject(out);
  clReleaseCommandQueue(queue);
}

int main(void) {
  egosieve_posterior* posterior;
  void *context = NULL, *device = NULL, *there = NULL;
  cl_context own;
  cl_device_id id;
  cl_int error;
  egosieve_device_call call;
  egosieve_status status;
  make_data();
  egosieve_device_call_init(NULL);
  egosieve_device_call_init(&call);

  posterior = new_posterior(NULL, NULL, EGOSIEVE_ZERO_MEAN);
  status = egosieve_posterior_opencl(posterior, &context, &device);
  if (status == EGOSIEVE_FAILED_PRECONDITION) { /* EGOSIEVE_DEVICE is the reference */
    CHECK_CALL(egosieve_posterior_enqueue(posterior, &call, NULL), EGOSIEVE_FAILED_PRECONDITION,
               "reference");
    CHECK_OK(egosieve_posterior_free(posterior));
    return failures == 0 ? 0 : 1;
  }
  CHECK(status == EGOSIEVE_OK && context != NULL && device != NULL);
  expect_the_hosts(posterior, (cl_context)context, (cl_device_id)device);
  id = (cl_device_id)device;

  own = clCreateContext(NULL, 1, &id, NULL, NULL, &error);
  CHECK(error == CL_SUCCESS);
  CHECK_OK(egosieve_posterior_free(posterior));
  posterior = new_posterior(own, id, EGOSIEVE_ZERO_MEAN);
  CHECK_OK(egosieve_posterior_opencl(posterior, &there, NULL));
  CHECK(there == (void*)own);
  expect_the_hosts(posterior, own, id);
  CHECK_OK(egosieve_posterior_free(posterior));

  posterior = new_posterior(own, NULL, EGOSIEVE_LINEAR_MEAN);
  CHECK_CALL(egosieve_posterior_enqueue(posterior, &call, NULL), EGOSIEVE_FAILED_PRECONDITION,
             "mean function");
  CHECK_OK(egosieve_posterior_free(posterior));
  clReleaseContext(own);
  return failures == 0 ? 0 : 1;
}
