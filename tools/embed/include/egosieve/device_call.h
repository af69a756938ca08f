/**
 * @file device_call.h
 * Predictions from and to OpenCL buffers, on a command queue of the caller's, without waiting.
 *
 * OpenCL's handles are `void*` here, so that the header needs none of OpenCL's: pass cl_context,
 * cl_device_id, cl_command_queue, cl_event and cl_mem as they are.
 *
 * Buffers and queues belong to the OpenCL context of the model: that of
 * egosieve_posterior_opencl(), or the one that `opencl_context` of egosieve_gp_options named.
 */
#ifndef EGOSIEVE_DEVICE_CALL_H_
#define EGOSIEVE_DEVICE_CALL_H_

#include "gaussian_process.h"

#ifdef __cplusplus
extern "C" {
#endif

/** float32 values that lie next to each other in an OpenCL buffer. */
typedef struct egosieve_device_array {
  void* memory;  /**< A cl_mem; null: this result is not wanted and not paid for. */
  int64_t first; /**< The element of the first value. */
} egosieve_device_array;

/** A prediction on a queue. */
typedef struct egosieve_device_call {
  uint64_t struct_size;              /**< Set by egosieve_device_call_init(). */
  void* queue;                       /**< A cl_command_queue, in order or not. */
  void* const* wait;                 /**< cl_events that come first; null where wait_count is 0. */
  int64_t wait_count;                /**< Default: 0. */
  void* queries;                     /**< A cl_mem of float32. */
  int64_t query_count;               /**< M. */
  int64_t query_first;               /**< The element where the first query begins. Default: 0. */
  int64_t query_stride;              /**< Elements from one query to the next; 0, the default: D. */
  egosieve_device_array mean;        /**< Of f, M values. */
  egosieve_device_array variance;    /**< Of f, M values. */
  egosieve_device_array probability; /**< M values; of labels only. */
  egosieve_device_array clamped;     /**< One int32: variances that were set to 0. */
} egosieve_device_call;

/** No queries and no result. Null does nothing. */
EGOSIEVE_API void egosieve_device_call_init(egosieve_device_call* call);

/**
 * The OpenCL context and device that a posterior lies on; they stay while it does. On "reference":
 * #EGOSIEVE_FAILED_PRECONDITION.
 * @param posterior       The posterior.
 * @param opencl_context  Out: a cl_context; null: not wanted.
 * @param opencl_device   Out: a cl_device_id; null: not wanted.
 */
EGOSIEVE_API egosieve_status egosieve_posterior_opencl(egosieve_posterior* posterior,
                                                       void** opencl_context, void** opencl_device);

/**
 * Enqueues a prediction and returns. Results are those of egosieve_posterior_predict(), but for a
 * rounding of the queries where the device prepares them otherwise than the host; nothing crosses
 * between host and device. A query with NaN or infinities has the mean NaN and the variance 0. The
 * posterior, and any handle of the call, may be freed before the commands have ended.
 *
 * For models of one output with the zero mean, on devices with float64:
 * #EGOSIEVE_FAILED_PRECONDITION otherwise. After an error, commands enqueued before it may still
 * write into the results.
 * @param posterior  The posterior.
 * @param call       What, from where, to where.
 * @param event      Out: a cl_event that ends with the last command, and that the caller releases;
 *                   null: not wanted.
 */
EGOSIEVE_API egosieve_status egosieve_posterior_enqueue(egosieve_posterior* posterior,
                                                        const egosieve_device_call* call,
                                                        void** event);

#ifdef __cplusplus
}
#endif

#endif /* EGOSIEVE_DEVICE_CALL_H_ */
