/**
 * @file device_call.h
 * Posteriors on several devices, and predictions from and to OpenCL buffers, enqueued on the
 * caller's command queue without waiting.
 *
 * OpenCL's handles are `void*` here, so that this header does not depend on OpenCL's headers: pass
 * cl_context, cl_device_id, cl_command_queue, cl_event and cl_mem as they are.
 *
 * Buffers and queues must belong to the model's OpenCL context: that of
 * egosieve_posterior_opencl(), which is `opencl_context` of egosieve_gp_options if that was set.
 */
#ifndef EGOSIEVE_DEVICE_CALL_H_
#define EGOSIEVE_DEVICE_CALL_H_

#include "gaussian_process.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Gives a posterior of the model's current state, as egosieve_gp_posterior(), that lies on these
 * devices instead of the model's own. They share the queries of each prediction: the queries are
 * divided into pieces of at least 1,024, and each device that has finished takes the next piece.
 *
 * Which device computes a query can differ from call to call. Devices of one kind give the same
 * bits as one alone; results of devices of different kinds differ within the error in prediction.h.
 * An image's inputs, and what several outputs or a mean function need in float64, are computed on
 * the first. If a device fails, nothing is written.
 *
 * Memory: the model on every device, and the results once more on the host.
 * @param gp            The model.
 * @param devices       Names, each as `device` of egosieve_gp_options. A device that is named twice
 *                      holds the model twice. Of a name that no device has: #EGOSIEVE_NOT_FOUND.
 * @param device_count  1 to 1024.
 * @param posterior     Out. If there are several devices, egosieve_posterior_opencl() and
 *                      egosieve_posterior_enqueue() are #EGOSIEVE_FAILED_PRECONDITION.
 */
EGOSIEVE_API egosieve_status egosieve_gp_posterior_on_devices(egosieve_gp* gp,
                                                              const char* const* devices,
                                                              int64_t device_count,
                                                              egosieve_posterior** posterior);

/** Consecutive float32 values in an OpenCL buffer. */
typedef struct egosieve_device_array {
  void* memory;  /**< A cl_mem; null: this result is not computed. */
  int64_t first; /**< Index of the first value, in elements. */
} egosieve_device_array;

/** Inputs and outputs of a prediction on a queue. */
typedef struct egosieve_device_call {
  uint64_t struct_size;              /**< Set by egosieve_device_call_init(). */
  void* queue;                       /**< A cl_command_queue, in order or not. */
  void* const* wait;                 /**< cl_events to wait for; null if wait_count is 0. */
  int64_t wait_count;                /**< Default: 0. */
  void* queries;                     /**< A cl_mem of float32. */
  int64_t query_count;               /**< M. */
  int64_t query_first;               /**< Index of the first query's first element. Default: 0. */
  int64_t query_stride;              /**< Elements from one query to the next; 0, the default: D. */
  egosieve_device_array mean;        /**< Of f, M values. */
  egosieve_device_array variance;    /**< Of f, M values. */
  egosieve_device_array probability; /**< M values; only with labels. */
  egosieve_device_array clamped;     /**< One int32: number of variances that were set to 0. */
} egosieve_device_call;

/** Sets no queries and no results. Null does nothing. */
EGOSIEVE_API void egosieve_device_call_init(egosieve_device_call* call);

/**
 * Gives the OpenCL context and device of a posterior; they live as long as it does. On "reference",
 * and on several devices: #EGOSIEVE_FAILED_PRECONDITION.
 * @param posterior       The posterior.
 * @param opencl_context  Out: a cl_context; null: not wanted.
 * @param opencl_device   Out: a cl_device_id; null: not wanted.
 */
EGOSIEVE_API egosieve_status egosieve_posterior_opencl(egosieve_posterior* posterior,
                                                       void** opencl_context, void** opencl_device);

/**
 * Enqueues a prediction and returns. The results are those of egosieve_posterior_predict() with
 * #EGOSIEVE_IN_FLOAT32, except for rounding where the device prepares the queries differently from
 * the host: nothing is computed in float64, since nothing waits for the results. Whether float32
 * suffices for this posterior: see egosieve_posterior_float32_error(). No data move between host
 * and device. A query with NaN or infinities gets the mean NaN and the variance 0. The posterior,
 * and any handle of the call, may be freed before the commands have ended.
 *
 * Works for models of one output with the zero mean, on devices with float64; otherwise
 * #EGOSIEVE_FAILED_PRECONDITION. After an error, earlier commands may still write results.
 * @param posterior  The posterior.
 * @param call       Queries, results and queue.
 * @param event      Out: a cl_event of the last command, which the caller releases; or null.
 */
EGOSIEVE_API egosieve_status egosieve_posterior_enqueue(egosieve_posterior* posterior,
                                                        const egosieve_device_call* call,
                                                        void** event);

/** A matrix of float64 in an OpenCL buffer: element (i, j) is at first + i stride + j. */
typedef struct egosieve_device_matrix {
  void* memory;   /**< A cl_mem. */
  int64_t first;  /**< Index of the first element. */
  int64_t rows;   /**< Number of rows. */
  int64_t stride; /**< Elements from one row to the next; 0: the number of columns. */
} egosieve_device_matrix;

/**
 * The kernel matrix k(x_i, z_j) as egosieve_gp_covariances(), enqueued, from and to buffers of the
 * model's OpenCL context, which is `opencl_context` of egosieve_gp_options, or that of
 * egosieve_posterior_opencl(). Computed in float64; inputs are not checked, NaN gives NaN. The model
 * may change, and any handle be freed, before the commands have ended. On "reference" and on devices
 * without float64: #EGOSIEVE_FAILED_PRECONDITION.
 * @param gp          The model; its points play no part.
 * @param x           N x D.
 * @param z           M x D; null: x.
 * @param k           Out: N x M.
 * @param queue       A cl_command_queue, in order or not.
 * @param wait        cl_events to wait for; null if wait_count is 0.
 * @param wait_count  At most 2^20.
 * @param event       Out: a cl_event of the last command, which the caller releases; or null.
 */
EGOSIEVE_API egosieve_status egosieve_gp_enqueue_covariances(egosieve_gp* gp,
                                                             const egosieve_device_matrix* x,
                                                             const egosieve_device_matrix* z,
                                                             const egosieve_device_matrix* k,
                                                             void* queue, void* const* wait,
                                                             int64_t wait_count, void** event);

#ifdef __cplusplus
}
#endif

#endif /* EGOSIEVE_DEVICE_CALL_H_ */
