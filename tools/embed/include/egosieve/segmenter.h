/**
 * @file segmenter.h
 * The segmenter: frames of one moving, uncalibrated camera in, maps of what moves by itself out.
 *
 * Every frame's matches with the one before tell how the camera moved; what does not fit labels the
 * frame's features; an online Gaussian process learns the labels and is evaluated over the frame:
 *
 *     probability  of belonging to something that moves, in [0, 1]
 *     mean         of the latent function, whose labels are -1 (static) and 1 (moving)
 *     deviation    its standard deviation: large where nothing like it was seen
 *
 * The first frame gets the prior's map. No frame is an error for what it shows: where nothing can
 * be learnt the map comes from the model as it is, and the report says why.
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

/** A segmenter with all that it has learnt: a handle. Calls on one segmenter wait for each other.
 */
typedef struct egosieve_segmenter egosieve_segmenter;

/** Set of options to start from: one of the constants below. */
typedef int32_t egosieve_profile;

/** The values of #egosieve_profile. */
enum {
  EGOSIEVE_PROFILE_DEFAULT = 0, /**< What works best on handheld and driving video. */
  EGOSIEVE_PROFILE_PAPER = 1,   /**< Faithful to the paper. */
  EGOSIEVE_PROFILE_FAST = 2     /**< Every stage chosen for speed: a sparse model, less training. */
};

/** What a segmenter is made from. */
typedef struct egosieve_segmenter_options {
  uint64_t struct_size;     /**< Set by egosieve_segmenter_options_init(). */
  egosieve_profile profile; /**< Default: #EGOSIEVE_PROFILE_DEFAULT. */
  int32_t stride;           /**< Pixels between the grid's columns and rows, 1 to 64. Default: 5. */
  int64_t budget;           /**< Points that the model holds, 10 to 20000; 0: the profile's. */
  uint64_t seed;            /**< Of everything that is random. Default: 1. */
  const char* device;       /**< As in egosieve_gp_options. */
  /** Later frames that a frame's labels use, 0 to 100: its map comes so many frames later and is
      more accurate. Needs focal_ratio, and frames of one size. Default: 0. */
  int64_t lag;
  /** Grey, of the frames' size; not 0 where they do not show the world: the own vehicle, captions.
      No motion is estimated from there, and nothing moves there. Copied. Default: null. */
  const egosieve_image* ignore;
  /** The camera's focal length over the longer side of the frames, at most 100: motion is then told
      from the camera's rotation and step, in depth. 0, the default: not known. */
  double focal_ratio;
} egosieve_segmenter_options;

/** Sets every field to its default. Null does nothing. */
EGOSIEVE_API void egosieve_segmenter_options_init(egosieve_segmenter_options* options);

/** A segmenter that has seen nothing. `*segmenter` is written on success only. */
EGOSIEVE_API egosieve_status egosieve_segmenter_create(const egosieve_segmenter_options* options,
                                                       egosieve_segmenter** segmenter);

/** Frees a segmenter; null is #EGOSIEVE_OK. */
EGOSIEVE_API egosieve_status egosieve_segmenter_free(egosieve_segmenter* segmenter);

/** Rows and columns of the grid for frames of this size. */
EGOSIEVE_API egosieve_status egosieve_segmenter_grid_size(egosieve_segmenter* segmenter,
                                                          int32_t width, int32_t height,
                                                          int64_t* rows, int64_t* columns);

/**
 * The map of one frame. Each array has the grid's size, or the frame's (height x width): then the
 * grid's values are interpolated linearly.
 */
typedef struct egosieve_map {
  uint64_t struct_size;       /**< Set by egosieve_map_init(). */
  egosieve_array probability; /**< Data null: not wanted. */
  egosieve_array mean;        /**< Data null: not wanted. */
  egosieve_array deviation;   /**< Data null: not wanted. */
  /** The number of the object that a place belongs to, 0: none. Objects are regions of 0.25 and
      more with a place of 0.8 or more, numbered from 1 by rows, in each frame anew. */
  egosieve_array objects;
} egosieve_map;

/** No result wanted. Null does nothing. */
EGOSIEVE_API void egosieve_map_init(egosieve_map* map);

/** The account of one frame. */
typedef struct egosieve_frame_report {
  uint64_t struct_size;   /**< Set by egosieve_frame_report_init(). */
  int64_t frame;          /**< From 0; frames whose arguments were refused are not counted. -1 and
                               no map: no frame, see egosieve_segmenter_options.lag. */
  int32_t learnt;         /**< Nonzero: the model learnt from this frame. */
  char reason[256];       /**< Why it did not; empty where it did. Cut to fit. */
  int64_t matches;        /**< Between this frame and the one that it was paired with. */
  int64_t inliers;        /**< Of the camera's motion. */
  int64_t static_labels;  /**< Features that move with the scene. */
  int64_t dynamic_labels; /**< Features that do not. */
  int64_t model_size;     /**< Points in the model. */
  double dynamic_share;   /**< Of the grid, probability 1/2 or more. */
  double milliseconds;    /**< Spent on this frame. */
} egosieve_frame_report;

/** Sets struct_size, and every other field to 0. Null does nothing. */
EGOSIEVE_API void egosieve_frame_report_init(egosieve_frame_report* report);

/**
 * Learns from the next frame and gives its map.
 *
 * An argument that is refused changes nothing. Where the device or memory fails on the way, nothing
 * is written either, but the frame has its place in the count and may have been learnt from; the
 * segmenter is sound: go on with the next frame.
 * @param segmenter     The segmenter.
 * @param image         The frame. All of one size; another size starts new pairs.
 * @param time_seconds  Finite; of the frame's exposure.
 * @param map           Null: the frame is learnt from and no map is made.
 * @param report        Null: not wanted.
 */
EGOSIEVE_API egosieve_status egosieve_segmenter_process(egosieve_segmenter* segmenter,
                                                        const egosieve_image* image,
                                                        double time_seconds,
                                                        const egosieve_map* map,
                                                        egosieve_frame_report* report);

/** How many frames wait for those after them, and their size; 0 of each without. */
EGOSIEVE_API egosieve_status egosieve_segmenter_waiting(egosieve_segmenter* segmenter,
                                                        int64_t* frames, int32_t* width,
                                                        int32_t* height);

/**
 * The map of the next of the frames that wait for those after them: after the last frame, until
 * the report's frame is -1. Frames may follow; they go on from there.
 * @param segmenter  The segmenter.
 * @param map        Null: the frame is learnt from and no map is made.
 * @param report     Null: not wanted.
 */
EGOSIEVE_API egosieve_status egosieve_segmenter_finish(egosieve_segmenter* segmenter,
                                                       const egosieve_map* map,
                                                       egosieve_frame_report* report);

/**
 * Writes model, options and the frames that the next pair needs into a file, whole or not at all.
 * The factor is rebuilt on the way: this segmenter and the one that is loaded go on alike to the
 * last bit.
 */
EGOSIEVE_API egosieve_status egosieve_segmenter_save(egosieve_segmenter* segmenter,
                                                     const char* path);

/** Reads what egosieve_segmenter_save() wrote; `device` as in egosieve_gp_options. */
EGOSIEVE_API egosieve_status egosieve_segmenter_load(const char* path, const char* device,
                                                     egosieve_segmenter** segmenter);

#ifdef __cplusplus
}
#endif

#endif /* EGOSIEVE_SEGMENTER_H_ */
