/**
 * @file types.h
 * What every call of the C interface shares: status codes, the last error, views of the caller's
 * arrays, handles, devices and versions.
 *
 * Rules that hold for all calls:
 *
 *  - A call returns a status. On any other than #EGOSIEVE_OK nothing was written and the object is
 *    as it was; egosieve_last_error() says what was wrong, naming the argument. No exception and no
 *    abort leaves the library. One exception: a segmenter whose device fails in the middle of a
 *    frame may have learnt from it (egosieve_segmenter_process()).
 *  - Memory belongs to the caller. Inputs are read during the call only; outputs are written where
 *    their strides say.
 *  - Handles look like pointers and are none: they carry a generation, so that a handle that was
 *    freed, or never was one, gives #EGOSIEVE_INVALID_HANDLE instead of a crash. A handle may be
 *    used, and freed, by several threads at once.
 *  - Structs that may grow begin with `struct_size`, which the `_init` function of the struct sets.
 * A library takes the structs of older headers: fields that they lack have their defaults.
 *
 * The header is C99 and C++.
 */
#ifndef EGOSIEVE_TYPES_H_
#define EGOSIEVE_TYPES_H_

#include <stddef.h>
#include <stdint.h>

/** Marks what the shared libraries export. */
#if defined(_WIN32)
#define EGOSIEVE_API
#else
#define EGOSIEVE_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** The binary interface that these headers describe; it is the number in the library's soname. */
#define EGOSIEVE_ABI_VERSION 1

/** The binary interface of the library that is loaded; compare with #EGOSIEVE_ABI_VERSION. */
EGOSIEVE_API int32_t egosieve_abi_version(void);

/** The library's version, such as "0.1.0". */
EGOSIEVE_API const char* egosieve_version(void);

/** How a call ended: one of the constants below. */
typedef int32_t egosieve_status;

/** The values of #egosieve_status. */
enum {
  EGOSIEVE_OK = 0,                  /**< Done. */
  EGOSIEVE_INVALID_ARGUMENT = 1,    /**< An argument breaks its rule; the text names it. */
  EGOSIEVE_INVALID_HANDLE = 2,      /**< Null, freed, of another type, or no handle at all. */
  EGOSIEVE_FAILED_PRECONDITION = 3, /**< The object cannot do this as it is. */
  EGOSIEVE_NOT_FOUND = 4,           /**< No such file or device. */
  EGOSIEVE_DATA_LOSS = 5,           /**< A file or its bytes are damaged or are something else. */
  EGOSIEVE_UNIMPLEMENTED = 6,       /**< A later version wrote this. */
  EGOSIEVE_UNAVAILABLE = 7,         /**< The system or the device failed. */
  EGOSIEVE_OUT_OF_MEMORY = 8,       /**< Memory ran out. */
  EGOSIEVE_INTERNAL = 9             /**< A defect of the library; please report it. */
};

/** "ok", "invalid argument", ...; "unknown status" for other numbers. Never null. */
EGOSIEVE_API const char* egosieve_status_name(egosieve_status status);

/**
 * What the last failed call on this thread had to say: what, where and what to do. Empty where none
 * failed. Valid until the thread's next call that fails.
 */
EGOSIEVE_API const char* egosieve_last_error(void);

/** Element type of an array: one of the constants below. */
typedef int32_t egosieve_type;

/** The values of #egosieve_type. */
enum {
  EGOSIEVE_FLOAT32 = 1, /**< `float`. */
  EGOSIEVE_FLOAT64 = 2  /**< `double`. */
};

/**
 * A matrix in the caller's memory that is read: element (i, j) lies at
 * `(const char*)data + i * row_stride + j * column_stride`.
 *
 * Strides are in bytes, may be negative, and need not be multiples of the element's size. Both 0
 * means packed and row-major. Elements must not overlap. A set of N points in D dimensions is
 * N x D; a vector of N values is N x 1 or 1 x N.
 */
typedef struct egosieve_const_array {
  const void* data;      /**< Element (0, 0); null only where there are no elements. */
  int64_t rows;          /**< Not negative. */
  int64_t columns;       /**< Not negative. */
  int64_t row_stride;    /**< Bytes from one row to the next. */
  int64_t column_stride; /**< Bytes from one column to the next. */
  egosieve_type type;    /**< Of the elements. */
} egosieve_const_array;

/** The same for a matrix that is written; data null: this result is not wanted and not paid for. */
typedef struct egosieve_array {
  void* data;            /**< Element (0, 0), or null. */
  int64_t rows;          /**< Not negative. */
  int64_t columns;       /**< Not negative. */
  int64_t row_stride;    /**< Bytes from one row to the next. */
  int64_t column_stride; /**< Bytes from one column to the next. */
  egosieve_type type;    /**< Of the elements. */
} egosieve_array;

/** Order of an image's channels: one of the constants below. */
typedef int32_t egosieve_channels;

/** The values of #egosieve_channels. */
enum {
  EGOSIEVE_GREY = 1, /**< One byte a pixel. */
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
 * How many devices there are: every OpenCL device, then the float64 reference on the host, so that
 * there is always one.
 */
EGOSIEVE_API egosieve_status egosieve_device_count(int32_t* count);

/**
 * One line on a device, such as "cpu: pthread-AMD EPYC", ended by a zero byte.
 * @param index     0 to the count less 1; its decimal digits are also a name of the device wherever
 *                  one is asked for.
 * @param text      `capacity` bytes of the caller's; a longer line is cut.
 * @param capacity  At least 1.
 */
EGOSIEVE_API egosieve_status egosieve_device_name(int32_t index, char* text, int64_t capacity);

/**
 * Limits the threads that the libraries start in this process, the caller's included; under 1: as
 * at first, $EGOSIEVE_THREADS or the processors that affinity and control groups allow. Results do
 * not depend on it. Drivers and OpenCV have threads of their own: PoCL takes its number from
 * $POCL_MAX_PTHREAD_COUNT (since version 4 $POCL_CPU_MAX_CU_COUNT) when it is first used.
 */
EGOSIEVE_API void egosieve_set_threads(int32_t threads);

/** The limit, at least 1. */
EGOSIEVE_API int32_t egosieve_threads(void);

#ifdef __cplusplus
}
#endif

#endif /* EGOSIEVE_TYPES_H_ */
