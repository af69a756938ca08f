#include "tools/embed/include/egosieve/segmenter.h"

#include <cmath>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kernels/base/matrix_view.h"
#include "kernels/base/parallel_for.h"
#include "kernels/files/atomic_file.h"
#include "tools/embed/c/array_access.h"
#include "tools/embed/c/device_contexts.h"
#include "tools/embed/c/segmenter_session.h"
#include "vision/frame/ignored_area.h"
#include "vision/image/grid_interpolation.h"
#include "vision/image/image_grid.h"
#include "vision/objects/map_objects.h"

namespace egosieve::embed {
namespace {

// The largest that is written: 4 GiB of arrays, and the archive's headers.
constexpr int64_t kMaximumFileBytes = (int64_t{1} << 32) + (int64_t{1} << 20);

template <typename Body>
egosieve_status WithSession(const char* function, egosieve_segmenter* segmenter, const Body& body) {
  return With(function, segmenter, [&](SegmenterSession& session) {
    // Take over the other library's limit: each library has threads of its own.
    kernels::SetMaximumThreads(egosieve_threads());
    body(session);
  });
}

// One of a map's arrays, of the size of the grid or the frame. All steps that can fail come before
// anything is written: first Prepare for all, then Write for all.
class MapOutput {
 public:
  MapOutput(const char* name, const egosieve_array& array, const vision::ImageGrid& grid)
      : grid_(grid),
        full_(array.rows == grid.height && array.columns == grid.width),
        array_(name, &array, full_ ? grid.height : grid.rows(),
               full_ ? grid.width : grid.columns()) {}

  // `values`: on the grid.
  void Prepare(std::vector<float> values) {
    if (!array_.wanted()) return;
    if (!full_ || grid_.stride == 1) {
      values_ = std::move(values);
      return;
    }
    values_.resize(int64_t{grid_.width} * grid_.height);
    Check(vision::GridInterpolation(grid_, {values.data(), grid_.rows(), grid_.columns()},
                                    {values_.data(), grid_.height, grid_.width}));
  }

  // Turns probabilities into numbers of objects; 0 where `ignored` is not 0.
  void NumberObjects(const cv::Mat1b& ignored) {
    if (!array_.wanted()) return;
    const int stride = full_ ? 1 : grid_.stride;
    const int columns = static_cast<int>(full_ ? grid_.width : grid_.columns());
    cv::Mat1f map(static_cast<int>(values_.size()) / columns, columns, values_.data());
    for (int y = 0; y < map.rows; ++y) {
      for (int x = 0; x < columns; ++x) {
        if (vision::IsIgnored(ignored, {grid_.width, grid_.height}, x * stride, y * stride)) {
          map(y, x) = 0.0f;
        }
      }
    }
    const vision::ObjectThresholds thresholds;
    const cv::Mat1i numbers = vision::NumberObjects(map >= thresholds.low, map >= thresholds.high);
    numbers.convertTo(map, CV_32F);
  }

  void Write() const { array_.Write(values_); }

 private:
  const vision::ImageGrid grid_;
  const bool full_;
  const OutputArray array_;
  std::vector<float> values_;
};

egosieve_frame_report ReportOf(const vision::FrameRecord& record) {
  egosieve_frame_report report{};
  report.frame = record.frame_index;
  report.learnt = record.learnt;
  record.reason.copy(report.reason, sizeof report.reason - 1);
  report.matches = record.match_count;
  report.inliers = record.inlier_count;
  report.static_labels = record.static_label_count;
  report.dynamic_labels = record.dynamic_label_count;
  report.model_size = record.model_size;
  report.dynamic_share = record.dynamic_share;
  report.milliseconds = record.milliseconds.total();
  return report;
}

// Gives what is wanted of the map and the report that `learn` gives of a frame of this size.
template <typename Learn>
void GiveFrame(SegmenterSession& session, cv::Size size, const egosieve_map* map,
               egosieve_frame_report* report, const Learn& learn) {
  const vision::ImageGrid grid{size.width, size.height, session.stride()};
  const auto wishes = Read("map", map, egosieve_map_init, /*optional=*/true);
  if (report != nullptr) CheckStruct("report", report);
  MapOutput probability("map.probability", wishes.probability, grid);
  MapOutput mean("map.mean", wishes.mean, grid);
  MapOutput deviation("map.deviation", wishes.deviation, grid);
  MapOutput objects("map.objects", wishes.objects, grid);
  std::optional<SegmenterSession::Result> result = learn();
  egosieve_frame_report given{};
  given.frame = -1;
  if (result.has_value()) given = ReportOf(result->record);
  if (result.has_value() && map != nullptr) {
    objects.Prepare(result->map.probability);
    objects.NumberObjects(session.ignored());
    probability.Prepare(std::move(result->map.probability));
    mean.Prepare(std::move(result->map.mean));
    deviation.Prepare(std::move(result->map.deviation));
    for (const MapOutput* output : {&probability, &mean, &deviation, &objects}) output->Write();
  }
  if (report != nullptr) WriteStruct(given, report);
}

// A mask, in memory of its own, of the pixels that are not 0.
cv::Mat1b IgnoredArea(const egosieve_image* image) {
  if (image == nullptr) return cv::Mat1b();
  std::vector<uint8_t> storage;
  const vision::ImageView view = ViewImage("options.ignore", image, storage);
  Require(view.channels == 1, "options.ignore has colours; it must be EGOSIEVE_GREY");
  return cv::Mat1b(cv::Mat1b(view.height, view.width, const_cast<uint8_t*>(view.data),
                             static_cast<size_t>(view.stride_bytes)) != 0);
}

}  // namespace

extern "C" {

void egosieve_segmenter_options_init(egosieve_segmenter_options* options) {
  if (!Initialise(options)) return;
  options->stride = 5;
  options->seed = 1;
}

void egosieve_map_init(egosieve_map* map) { Initialise(map); }

void egosieve_frame_report_init(egosieve_frame_report* report) { Initialise(report); }

egosieve_status egosieve_segmenter_create(const egosieve_segmenter_options* options,
                                          egosieve_segmenter** segmenter) {
  return New(__func__, segmenter, [&] {
    const auto wishes =
        Read("options", options, egosieve_segmenter_options_init, /*optional=*/true);
    cv::Mat1b ignored = IgnoredArea(wishes.ignore);
    return std::make_shared<SegmenterSession>(Take(ContextOf(wishes.device)), wishes,
                                              std::move(ignored));
  });
}

egosieve_status egosieve_segmenter_free(egosieve_segmenter* segmenter) {
  return Free(__func__, segmenter);
}

egosieve_status egosieve_segmenter_grid_size(egosieve_segmenter* segmenter, int32_t width,
                                             int32_t height, int64_t* rows, int64_t* columns) {
  return WithSession(__func__, segmenter, [&](SegmenterSession& session) {
    RequirePointer("rows", rows);
    RequirePointer("columns", columns);
    const vision::ImageGrid grid{width, height, session.stride()};
    Check(grid.Validate());
    *rows = grid.rows();
    *columns = grid.columns();
  });
}

egosieve_status egosieve_segmenter_process(egosieve_segmenter* segmenter,
                                           const egosieve_image* image, double time_seconds,
                                           const egosieve_map* map, egosieve_frame_report* report) {
  return WithSession(__func__, segmenter, [&](SegmenterSession& session) {
    std::vector<uint8_t> storage;
    const vision::ImageView view = ViewImage("image", image, storage);
    Require(std::isfinite(time_seconds), "time_seconds = %g; it must be finite", time_seconds);
    GiveFrame(session, {view.width, view.height}, map, report,
              [&] { return session.Process(view, time_seconds, map != nullptr); });
  });
}

egosieve_status egosieve_segmenter_finish(egosieve_segmenter* segmenter, const egosieve_map* map,
                                          egosieve_frame_report* report) {
  return WithSession(__func__, segmenter, [&](SegmenterSession& session) {
    const auto [count, size] = session.WaitingFrames();
    const bool waits = count > 0;
    GiveFrame(session, size, waits ? map : nullptr, report,
              [&] { return waits ? session.Finish(map != nullptr) : std::nullopt; });
  });
}

egosieve_status egosieve_segmenter_frame_count(egosieve_segmenter* segmenter, int64_t* frames) {
  return WithSession(__func__, segmenter, [&](SegmenterSession& session) {
    RequirePointer("frames", frames);
    *frames = session.FrameCount();
  });
}

egosieve_status egosieve_segmenter_waiting(egosieve_segmenter* segmenter, int64_t* frames,
                                           int32_t* width, int32_t* height) {
  return WithSession(__func__, segmenter, [&](SegmenterSession& session) {
    RequirePointer("frames", frames);
    RequirePointer("width", width);
    RequirePointer("height", height);
    const auto [count, size] = session.WaitingFrames();
    *frames = count;
    *width = size.width;
    *height = size.height;
  });
}

egosieve_status egosieve_segmenter_save(egosieve_segmenter* segmenter, const char* path) {
  return WithSession(__func__, segmenter, [&](SegmenterSession& session) {
    RequirePointer("path", path);
    Check(kernels::WriteFileAtomically(path, session.ToBytes()));
  });
}

egosieve_status egosieve_segmenter_load(const char* path, const char* device,
                                        egosieve_segmenter** segmenter) {
  return New(__func__, segmenter, [&] {
    RequirePointer("path", path);
    const std::string bytes = Take(kernels::ReadFile(path, kMaximumFileBytes));
    auto context = Take(ContextOf(device));
    try {
      return SegmenterSession::FromBytes(std::move(context), bytes);
    } catch (const CallError& error) {
      throw CallError{Named(path, error.status)};
    }
  });
}

}  // extern "C"

}  // namespace egosieve::embed
