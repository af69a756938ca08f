/**
 * @file segmenter.h
 * The segmenter: takes frames of one moving, uncalibrated camera and gives maps of moving objects.
 *
 * The matches between a frame and an earlier one give the camera's motion. Features are labelled
 * static or moving by their agreement with it. An online Gaussian process learns the labels and is
 * evaluated over the frame:
 *
 *     probability  of moving, in [0, 1]
 *     mean         of the latent function, whose labels are -1 (static) and 1 (moving)
 *     deviation    its standard deviation: large at places unlike all that was learnt
 *
 * The first frame gets the map of the prior. The content of a frame never causes an error: if
 * nothing can be learnt from it, the map comes from the current model, and the report says why.
 *
 * Needs the library egosieve_vision. Reference: Guizilini & Ramos, "Online Self-Supervised
 * Segmentation of Dynamic Objects".
 */
#ifndef EGOSIEVE_SEGMENTER_H_
#define EGOSIEVE_SEGMENTER_H_

#include "types.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Handle of a segmenter with its learnt state. Calls on one segmenter wait for each other. */
typedef struct egosieve_segmenter egosieve_segmenter;

typedef int32_t egosieve_profile; /**< Set of options to start from: one of these. */
/** The values of #egosieve_profile. */
enum {
  EGOSIEVE_PROFILE_DEFAULT = 0, /**< Most accurate on handheld and driving video. */
  EGOSIEVE_PROFILE_PAPER = 1,   /**< Faithful to the paper. */
  EGOSIEVE_PROFILE_FAST = 2 /**< Default with smaller, nearer frames and fewer inducing points. */
};

/** Options for a new segmenter. */
typedef struct egosieve_segmenter_options {
  uint64_t struct_size;     /**< Set by egosieve_segmenter_options_init(). */
  egosieve_profile profile; /**< Default: #EGOSIEVE_PROFILE_DEFAULT. */
  int32_t stride;           /**< Pixels between the grid's columns and rows, 1 to 64. Default: 5. */
  int64_t budget;           /**< Largest number of model points, 10 to 20000; 0: the profile's. */
  uint64_t seed;            /**< Seed of all random numbers. Default: 1. */
  const char* device;       /**< As in egosieve_gp_options. A segmenter takes no OpenCL context and
                              no queue of the caller's. */
  /** Number of later frames that a frame's labels use, 0 to 100. The frame's map comes this many
   * frames later, better once the focal length is known. Needs frames of one size. Default: 0. */
  int64_t lag;
  /** Grey image of the frames' size, not 0 on pixels that do not show the scene: own vehicle,
   * captions. No motion is estimated there, and nothing counts as moving. Copied. Default: null. */
  const egosieve_image* ignore;
  /** The camera's focal length divided by the longer side of the frames, at most 100. If it is
   * known, motion is judged with the camera's rotation and translation and with depth. 0, the
   * default: learnt from the frames and their times, after 0.6 to 2 seconds of motion. */
  double focal_ratio;
} egosieve_segmenter_options;

/** Sets every field to its default. Null does nothing. */
EGOSIEVE_API void egosieve_segmenter_options_init(egosieve_segmenter_options* options);

/** Creates a segmenter without learnt state. `*segmenter` is written only on success. */
EGOSIEVE_API egosieve_status egosieve_segmenter_create(const egosieve_segmenter_options* options,
                                                       egosieve_segmenter** segmenter);

/** Frees a segmenter; null is #EGOSIEVE_OK. */
EGOSIEVE_API egosieve_status egosieve_segmenter_free(egosieve_segmenter* segmenter);

/** Rows and columns of the grid for frames of this size. */
EGOSIEVE_API egosieve_status egosieve_segmenter_grid_size(egosieve_segmenter* segmenter,
                                                          int32_t width, int32_t height,
                                                          int64_t* rows, int64_t* columns);

/**
 * The map of one frame, in host memory. Each array has the size of the grid or of the frame (height
 * x width); in the second case the grid's values are interpolated linearly.
 */
typedef struct egosieve_map {
  uint64_t struct_size;       /**< Set by egosieve_map_init(). */
  egosieve_array probability; /**< Data null: not wanted. */
  egosieve_array mean;        /**< Data null: not wanted. */
  egosieve_array deviation;   /**< Data null: not wanted. */
  /** The number of the object at each place, 0: none. Objects are connected regions of probability
   * 0.25 or more with a value of 0.8 or more, numbered by rows from 1, anew in each frame. */
  egosieve_array objects;
} egosieve_map;

/** Sets all results to not wanted. Null does nothing. */
EGOSIEVE_API void egosieve_map_init(egosieve_map* map);

/** Report about one frame. */
typedef struct egosieve_frame_report {
  uint64_t struct_size;   /**< Set by egosieve_frame_report_init(). */
  int64_t frame;          /**< Index from 0; frames with refused arguments are not counted. -1: no
                               frame and no map, see egosieve_segmenter_options.lag. */
  int32_t learnt;         /**< Nonzero: the model learnt from this frame. */
  char reason[256];       /**< Why it did not learn; empty if it did. Cut to fit. */
  int64_t matches;        /**< Matches between this frame and the other of its pair. */
  int64_t inliers;        /**< Inliers of the camera's motion. */
  int64_t static_labels;  /**< Features labelled static. */
  int64_t dynamic_labels; /**< Features labelled moving. */
  int64_t model_size;     /**< Points in the model. */
  double dynamic_share;   /**< Share of the grid with probability 1/2 or more. */
  double milliseconds;    /**< Spent on this frame. */
} egosieve_frame_report;

/** Sets struct_size, and every other field to 0. Null does nothing. */
EGOSIEVE_API void egosieve_frame_report_init(egosieve_frame_report* report);

/**
 * Learns from the next frame and gives its map.
 *
 * A refused argument changes nothing. If the device or memory fails during the call, nothing is
 * written either, but the frame is counted and may have been learnt from. The segmenter remains
 * valid: continue with the next frame.
 * @param segmenter     The segmenter.
 * @param image         The frame. Frames have one size; a frame of another size starts new pairs.
 * @param time_seconds  Time of the frame's exposure, finite.
 * @param map           Null: the frame is learnt from, but no map is made.
 * @param report        Null: not wanted.
 */
EGOSIEVE_API egosieve_status egosieve_segmenter_process(egosieve_segmenter* segmenter,
                                                        const egosieve_image* image,
                                                        double time_seconds,
                                                        const egosieve_map* map,
                                                        egosieve_frame_report* report);

/** Gives the number of all frames processed, those before egosieve_segmenter_save() included. */
EGOSIEVE_API egosieve_status egosieve_segmenter_frame_count(egosieve_segmenter* segmenter,
                                                            int64_t* frames);

/** Gives the number of frames that wait for later frames, and their size; all 0 without any. */
EGOSIEVE_API egosieve_status egosieve_segmenter_waiting(egosieve_segmenter* segmenter,
                                                        int64_t* frames, int32_t* width,
                                                        int32_t* height);

/**
 * Gives the map of the next frame that waits for later frames. Call it after the last frame, until
 * the report's frame is -1. More frames may be processed afterwards; they continue the sequence.
 * @param segmenter  The segmenter.
 * @param map        Null: the frame is learnt from, but no map is made.
 * @param report     Null: not wanted.
 */
EGOSIEVE_API egosieve_status egosieve_segmenter_finish(egosieve_segmenter* segmenter,
                                                       const egosieve_map* map,
                                                       egosieve_frame_report* report);

/**
 * Writes model, options, the frames that the next pair needs, and those that wait for later frames
 * into a file, completely or not at all. The factor is rebuilt, so that this segmenter and a loaded
 * copy continue identically to the last bit.
 */
EGOSIEVE_API egosieve_status egosieve_segmenter_save(egosieve_segmenter* segmenter,
                                                     const char* path);

/** Reads a file of egosieve_segmenter_save(); `device` as in egosieve_gp_options. */
EGOSIEVE_API egosieve_status egosieve_segmenter_load(const char* path, const char* device,
                                                     egosieve_segmenter** segmenter);

#ifdef __cplusplus
}
#endif

#endif /* EGOSIEVE_SEGMENTER_H_ */
