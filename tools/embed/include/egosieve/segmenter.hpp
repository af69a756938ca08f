/**
 * @file segmenter.hpp
 * The segmenter in C++17: takes frames of one moving camera and gives maps of moving objects.
 * segmenter.h describes the maps.
 *
 *     auto segmenter = egosieve::Segmenter::Create({}).value();
 *     segmenter.Process({pixels, width, height}, time, {{probability, height, width}});
 */
#ifndef EGOSIEVE_SEGMENTER_HPP_
#define EGOSIEVE_SEGMENTER_HPP_

#include <cstdint>
#include <string>

#include "arrays.hpp"
#include "result.hpp"
#include "segmenter.h"

namespace egosieve {

/** Set of options to start from. */
enum class Profile : int32_t {
  kDefault = EGOSIEVE_PROFILE_DEFAULT, /**< Most accurate on handheld and driving video. */
  kPaper = EGOSIEVE_PROFILE_PAPER,     /**< Faithful to the paper. */
  kFast = EGOSIEVE_PROFILE_FAST,       /**< Smaller, neighbouring frames, fewer inducing points. */
};

/** Options for a new segmenter. */
struct SegmenterOptions {
  Profile profile = Profile::kDefault; /**< Profile to start from. */
  int32_t stride = 5;                  /**< Pixels between grid columns and rows, 1 to 64. */
  int64_t budget = 0;                  /**< Largest number of model points; 0: the profile's. */
  uint64_t seed = 1;                   /**< Seed of all random numbers. */
  std::string device;                  /**< As in #egosieve_gp_options. */
  int64_t lag = 0;                     /**< Later frames that a frame's labels use, 0 to 100. */
  Image ignore{};           /**< Grey, not 0 where the scene is not visible; data null: unused. */
  double focal_ratio = 0.0; /**< Focal length over the longer side; 0: learnt from the frames. */
};

/** The grid that a frame's map is evaluated on. */
struct GridSize {
  int64_t rows = 0;    /**< Rows of the map. */
  int64_t columns = 0; /**< Columns of the map. */
};

/** Destinations of a map, each of the grid's size or the frame's; a default Array is not wanted. */
struct Map {
  Array probability{}; /**< Probability of moving. */
  Array mean{};        /**< Of the latent function, -1 static, 1 moving. */
  Array deviation{};   /**< Its standard deviation. */
  Array objects{};     /**< Numbers of objects, 0: none; see #egosieve_map. */
};

/** Report about one frame. */
struct FrameReport {
  int64_t frame = 0;          /**< From 0; -1: none yet, or none left. */
  bool learnt = false;        /**< The model learnt from this frame. */
  std::string reason;         /**< Why it did not learn; empty if it did. */
  int64_t matches = 0;        /**< Matches between this frame and the other of its pair. */
  int64_t inliers = 0;        /**< Inliers of the camera's motion. */
  int64_t static_labels = 0;  /**< Features labelled static. */
  int64_t dynamic_labels = 0; /**< Features labelled moving. */
  int64_t model_size = 0;     /**< Points in the model. */
  double dynamic_share = 0.0; /**< Share of the grid with probability 1/2 or more. */
  double milliseconds = 0.0;  /**< Spent on this frame. */
};

/** A segmenter with its learnt state. Calls on one segmenter wait for each other. */
class Segmenter : public Owner<egosieve_segmenter, egosieve_segmenter_free> {
 public:
  using Owner::Owner;

  /** Creates a segmenter without learnt state. */
  static Result<Segmenter> Create(const SegmenterOptions& options) {
    egosieve_segmenter_options c;
    egosieve_segmenter_options_init(&c);
    c.profile = static_cast<egosieve_profile>(options.profile);
    c.stride = options.stride;
    c.budget = options.budget;
    c.seed = options.seed;
    c.device = options.device.c_str();
    c.lag = options.lag;
    c.focal_ratio = options.focal_ratio;
    const egosieve_image ignore = options.ignore.c();
    c.ignore = ignore.data == nullptr ? nullptr : &ignore;
    egosieve_segmenter* handle = nullptr;
    return internal::Own<Segmenter>(egosieve_segmenter_create(&c, &handle), handle);
  }
  /** Reads a file of Save(). */
  static Result<Segmenter> Load(const std::string& path, const std::string& device = "") {
    egosieve_segmenter* handle = nullptr;
    return internal::Own<Segmenter>(egosieve_segmenter_load(path.c_str(), device.c_str(), &handle),
                                    handle);
  }

  /** Rows and columns of the grid for frames of this size. */
  Result<GridSize> GridSizeFor(int32_t width, int32_t height) const {
    GridSize size;
    return internal::Given(
        egosieve_segmenter_grid_size(handle_, width, height, &size.rows, &size.columns), size);
  }
  /**
   * Learns from the next frame and gives its map. With a lag, learns from the frame that came `lag`
   * frames before, and gives the map of that frame.
   */
  Result<FrameReport> Process(const Image& image, double time_seconds, const Map& map) {
    const egosieve_map c = ToC(map);
    return ProcessWith(image, time_seconds, &c);
  }
  /** Learns from the next frame without a map. */
  Result<FrameReport> Learn(const Image& image, double time_seconds) {
    return ProcessWith(image, time_seconds, nullptr);
  }
  /** How many frames were processed, those before Save() included. */
  Result<int64_t> FrameCount() const {
    int64_t frames = 0;
    return internal::Given(egosieve_segmenter_frame_count(handle_, &frames), frames);
  }
  /** How many frames wait for later frames. */
  Result<int64_t> Waiting() const {
    int64_t frames = 0;
    int32_t width = 0, height = 0;
    return internal::Given(egosieve_segmenter_waiting(handle_, &frames, &width, &height), frames);
  }
  /** With a lag, after the last frame: the map of the next waiting frame, until frame is -1. */
  Result<FrameReport> Finish(const Map& map) {
    const egosieve_map c_map = ToC(map);
    egosieve_frame_report c;
    egosieve_frame_report_init(&c);
    return Report(egosieve_segmenter_finish(handle_, &c_map, &c), c);
  }
  /** Writes all that later calls need into a file, completely or not at all. */
  Status Save(const std::string& path) {
    return Status::FromC(egosieve_segmenter_save(handle_, path.c_str()));
  }

 private:
  Result<FrameReport> ProcessWith(const Image& image, double time_seconds,
                                  const egosieve_map* map) {
    const egosieve_image c_image = image.c();
    egosieve_frame_report c;
    egosieve_frame_report_init(&c);
    return Report(egosieve_segmenter_process(handle_, &c_image, time_seconds, map, &c), c);
  }

  static egosieve_map ToC(const Map& map) {
    egosieve_map c;
    egosieve_map_init(&c);
    c.probability = map.probability.c();
    c.mean = map.mean.c();
    c.deviation = map.deviation.c();
    c.objects = map.objects.c();
    return c;
  }

  // The report is passed by reference because the call that gives `code` writes it.
  static Result<FrameReport> Report(egosieve_status code, const egosieve_frame_report& c) {
    if (code != EGOSIEVE_OK) return Status::FromC(code);
    FrameReport report;
    report.frame = c.frame;
    report.learnt = c.learnt != 0;
    report.reason = c.reason;
    report.matches = c.matches;
    report.inliers = c.inliers;
    report.static_labels = c.static_labels;
    report.dynamic_labels = c.dynamic_labels;
    report.model_size = c.model_size;
    report.dynamic_share = c.dynamic_share;
    report.milliseconds = c.milliseconds;
    return report;
  }
};

}  // namespace egosieve

#endif  // EGOSIEVE_SEGMENTER_HPP_
