/**
 * @file types.h
 * Types and functions that all calls of the C interface share: status codes, the last error, views
 * of the caller's arrays, handles, devices and versions.
 *
 * Rules that hold for all calls:
 *
 *  - A call returns a status. If it is not #EGOSIEVE_OK, nothing was written and the object is
 *    unchanged; egosieve_last_error() names the argument and says what was wrong with it. No
 *    exception and no abort leaves the library. Two calls are exceptions to this rule: a segmenter
 *    whose device fails in the middle of a frame may have learnt from it
 *    (egosieve_segmenter_process()), and commands of egosieve_posterior_enqueue() may have begun.
 *  - Memory belongs to the caller. Inputs are read only during the call. Outputs are written to
 *    the places that their strides give.
 *  - Handles look like pointers but are not. They carry a generation, so a handle that was freed,
 *    or was never valid, gives #EGOSIEVE_INVALID_HANDLE instead of a crash. Several threads may
 *    use and free a handle at once.
 *  - Structs that may grow begin with `struct_size`, which the `_init` function of the struct sets.
 *    A library accepts the structs of older headers: fields that they lack have their defaults.
 *
 * The header is valid C99 and C++.
 */
#ifndef EGOSIEVE_TYPES_H_
#define EGOSIEVE_TYPES_H_

#include <stddef.h>
#include <stdint.h>

/** Marks the functions that the shared libraries export. */
#if defined(_WIN32)
#define EGOSIEVE_API
#else
#define EGOSIEVE_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** Version of the binary interface in these headers; it is the number in the library's soname. */
#define EGOSIEVE_ABI_VERSION 1

/** Version of the loaded library's binary interface; compare it with #EGOSIEVE_ABI_VERSION. */
EGOSIEVE_API int32_t egosieve_abi_version(void);

/** The library's version, such as "0.1.0". */
EGOSIEVE_API const char* egosieve_version(void);

typedef int32_t egosieve_status; /**< How a call ended: one of these. */
/** The values of #egosieve_status. */
enum {
  EGOSIEVE_OK = 0,                  /**< Done. */
  EGOSIEVE_INVALID_ARGUMENT = 1,    /**< An argument is not allowed; the message names it. */
  EGOSIEVE_INVALID_HANDLE = 2,      /**< Null, freed, of another type, or never a handle. */
  EGOSIEVE_FAILED_PRECONDITION = 3, /**< The object's state does not allow this call. */
  EGOSIEVE_NOT_FOUND = 4,           /**< No such file or device. */
  EGOSIEVE_DATA_LOSS = 5,           /**< A file or its bytes are damaged or of another format. */
  EGOSIEVE_UNIMPLEMENTED = 6,       /**< Not of this model, or written by a later version. */
  EGOSIEVE_UNAVAILABLE = 7,         /**< The system or the device failed. */
  EGOSIEVE_OUT_OF_MEMORY = 8,       /**< Memory ran out. */
  EGOSIEVE_INTERNAL = 9,            /**< A defect of the library; please report it. */
  EGOSIEVE_CANCELLED = 10           /**< The caller stopped the call. */
};

/** "ok", "invalid argument", ...; "unknown status" for other numbers. Never null. */
EGOSIEVE_API const char* egosieve_status_name(egosieve_status status);

/**
 * The message of the last failed call on this thread: what failed, where, and what to do. Empty if
 * none has failed. Valid until the next call on this thread that fails.
 */
EGOSIEVE_API const char* egosieve_last_error(void);

typedef int32_t egosieve_type; /**< Element type of an array: one of these. */
/** The values of #egosieve_type. */
enum {
  EGOSIEVE_FLOAT32 = 1, /**< `float`. */
  EGOSIEVE_FLOAT64 = 2  /**< `double`. */
};

/**
 * A matrix in the caller's memory that is read. Element (i, j) lies at
 * `(const char*)data + i * row_stride + j * column_stride`.
 *
 * Strides are in bytes. They may be negative and need not be multiples of the element's size. If
 * both are 0, the matrix is packed and row-major. Elements of results must not overlap. A set of N points in D
 * dimensions is N x D; a vector of N values is N x 1 or 1 x N.
 */
typedef struct egosieve_const_array {
  const void* data;      /**< Element (0, 0); null only if there are no elements. */
  int64_t rows;          /**< Not negative. */
  int64_t columns;       /**< Not negative. */
  int64_t row_stride;    /**< Bytes from one row to the next. */
  int64_t column_stride; /**< Bytes from one column to the next. */
  egosieve_type type;    /**< Type of the elements. */
} egosieve_const_array;

/** The same for a matrix that is written. If data is null, the result is not computed. */
typedef struct egosieve_array {
  void* data;            /**< Element (0, 0), or null. */
  int64_t rows;          /**< Not negative. */
  int64_t columns;       /**< Not negative. */
  int64_t row_stride;    /**< Bytes from one row to the next. */
  int64_t column_stride; /**< Bytes from one column to the next. */
  egosieve_type type;    /**< Type of the elements. */
} egosieve_array;

typedef int32_t egosieve_channels; /**< Order of an image's channels: one of these. */
/** The values of #egosieve_channels. */
enum {
  EGOSIEVE_GREY = 1, /**< One byte per pixel. */
  EGOSIEVE_BGR = 2,  /**< Blue, green, red: OpenCV's order. */
  EGOSIEVE_RGB = 3   /**< Red, green, blue. */
};

/** An image of 8-bit pixels, channels interleaved. */
typedef struct egosieve_image {
  const uint8_t* data;        /**< The first pixel of the first row. */
  int32_t width;              /**< Pixels, 1 to 16384. */
  int32_t height;             /**< Pixels, 1 to 16384. */
  int64_t row_stride;         /**< Bytes from one row to the next; 0: packed. */
  egosieve_channels channels; /**< #EGOSIEVE_GREY, #EGOSIEVE_BGR or #EGOSIEVE_RGB. */
} egosieve_image;

/**
 * Gives the number of devices: all OpenCL devices and, last, the float64 reference on the host, so
 * there is always at least one.
 */
EGOSIEVE_API egosieve_status egosieve_device_count(int32_t* count);

/**
 * Gives one line of text about a device, such as "cpu: pthread-AMD EPYC", ended by a zero byte.
 * @param index     0 to the count less 1. Its digits may stand for a device's name.
 * @param text      Buffer of `capacity` bytes; a longer line is cut.
 * @param capacity  At least 1.
 */
EGOSIEVE_API egosieve_status egosieve_device_name(int32_t index, char* text, int64_t capacity);

/**
 * Limits the threads that the libraries start in this process, counting the caller's own. A value
 * below 1 restores the initial limit: $EGOSIEVE_THREADS, or else the number of processors that
 * affinity and control groups allow. It holds for the calls that begin afterwards, on the host and
 * on PoCL's CPU. Results do not depend on it. Other drivers and OpenCV have threads of their own.
 */
EGOSIEVE_API void egosieve_set_threads(int32_t threads);

/** The limit of egosieve_set_threads(), at least 1. */
EGOSIEVE_API int32_t egosieve_threads(void);

#ifdef __cplusplus
}
#endif

#endif /* EGOSIEVE_TYPES_H_ */
