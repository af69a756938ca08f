#include "tools/embed/include/egosieve/segmenter.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "kernels/base/image_grid.h"
#include "kernels/base/matrix_view.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "kernels/files/atomic_file.h"
#include "kernels/ops/grid_interpolation.h"
#include "tools/embed/c/array_access.h"
#include "tools/embed/c/device_contexts.h"
#include "tools/embed/c/handle_table.h"
#include "tools/embed/c/last_error.h"
#include "tools/embed/c/options.h"
#include "tools/embed/c/segmenter_session.h"
#include "vision/frame/ignored_area.h"
#include "vision/objects/map_objects.h"

namespace egosieve::embed {
namespace {

static_assert(EGOSIEVE_PROFILE_DEFAULT == static_cast<int>(Profile::kDefault) &&
              EGOSIEVE_PROFILE_PAPER == static_cast<int>(Profile::kPaper) &&
              EGOSIEVE_PROFILE_FAST == static_cast<int>(Profile::kFast));

// The largest that is written: 4 GiB of arrays, and the archive's headers.
constexpr int64_t kMaximumFileBytes = (int64_t{1} << 32) + (int64_t{1} << 20);

using Sessions = HandleTable<HandleKind::kSegmenter, egosieve_segmenter, SegmenterSession>;

// Never destroyed, because a program may use handles in its own destructors.
Sessions& AllSessions() {
  static Sessions* sessions = new Sessions;
  return *sessions;
}

template <typename Body>
egosieve_status WithSession(const char* function, egosieve_segmenter* segmenter, Body&& body) {
  return Guard(function, [&]() -> absl::Status {
    EGOSIEVE_ASSIGN_OR_RETURN(const std::shared_ptr<SegmenterSession> session,
                              AllSessions().Find("segmenter", segmenter));
    // Take over the other library's limit: each library has threads of its own.
    kernels::SetMaximumThreads(egosieve_threads());
    return body(*session);
  });
}

// One of a map's arrays, of the size of the grid or the frame. All steps that can fail come before
// anything is written: first Prepare for all, then Write for all.
class MapOutput {
 public:
  static absl::StatusOr<MapOutput> Create(const char* name, const egosieve_array& array,
                                          const kernels::ImageGrid& grid) {
    MapOutput output;
    output.full_ = array.rows == grid.height && array.columns == grid.width;
    absl::StatusOr<OutputArray> checked =
        output.full_ ? OutputArray::Create(name, array, grid.height, grid.width)
                     : OutputArray::Create(name, array, grid.rows(), grid.columns());
    EGOSIEVE_RETURN_IF_ERROR(checked.status());
    output.array_ = *checked;
    return output;
  }

  // `values`: on the grid.
  absl::Status Prepare(kernels::Context& context, const kernels::ImageGrid& grid,
                       std::vector<float> values) {
    if (!array_.wanted()) return absl::OkStatus();
    if (!full_ || grid.stride == 1) {
      values_ = std::move(values);
      return absl::OkStatus();
    }
    values_.resize(int64_t{grid.width} * grid.height);
    return kernels::GridInterpolation(
        context, grid, {values.data(), grid.rows(), grid.columns()},
        kernels::MatrixView<float>(values_.data(), grid.height, grid.width));
  }

  // Turns probabilities into numbers of objects; 0 where `ignored` is not 0.
  void NumberObjects(const kernels::ImageGrid& grid, const cv::Mat1b& ignored) {
    if (!array_.wanted()) return;
    const int stride = full_ ? 1 : grid.stride;
    const int columns = static_cast<int>(full_ ? grid.width : grid.columns());
    cv::Mat1f map(static_cast<int>(values_.size()) / columns, columns, values_.data());
    for (int y = 0; y < map.rows; ++y) {
      for (int x = 0; x < columns; ++x) {
        if (vision::IsIgnored(ignored, {grid.width, grid.height}, x * stride, y * stride)) {
          map(y, x) = 0.0f;
        }
      }
    }
    const vision::ObjectThresholds thresholds;
    const cv::Mat1i numbers = vision::NumberObjects(map >= thresholds.low, map >= thresholds.high);
    numbers.convertTo(map, CV_32F);
  }

  void Write() const {
    if (array_.wanted()) array_.Write(0, static_cast<int64_t>(values_.size()), values_.data());
  }

 private:
  OutputArray array_;
  bool full_ = false;
  std::vector<float> values_;
};

egosieve_frame_report ReportOf(const vision::FrameRecord& record) {
  egosieve_frame_report report{};
  report.frame = record.frame_index;
  report.learnt = record.learnt;
  const size_t length = std::min(record.reason.size(), sizeof report.reason - 1);
  std::memcpy(report.reason, record.reason.data(), length);
  report.matches = record.match_count;
  report.inliers = record.inlier_count;
  report.static_labels = record.static_label_count;
  report.dynamic_labels = record.dynamic_label_count;
  report.model_size = record.model_size;
  report.dynamic_share = record.dynamic_share;
  report.milliseconds = record.milliseconds.total();
  return report;
}

absl::Status WriteNoFrame(egosieve_frame_report* report) {
  if (report == nullptr) return absl::OkStatus();
  egosieve_frame_report none{};
  none.frame = -1;
  WriteStruct(none, report);
  return absl::OkStatus();
}

// Destinations of a frame's map and report. `map` and `report` as in egosieve_segmenter_process.
class FrameOutputs {
 public:
  static absl::StatusOr<FrameOutputs> Create(const egosieve_map* map, egosieve_frame_report* report,
                                             const kernels::ImageGrid& grid) {
    FrameOutputs outputs;
    outputs.grid_ = grid;
    outputs.map_wanted_ = map != nullptr;
    outputs.report_ = report;
    egosieve_map wishes;
    egosieve_map_init(&wishes);
    if (map != nullptr) EGOSIEVE_RETURN_IF_ERROR(ReadStruct("map", map, wishes));
    if (report != nullptr) EGOSIEVE_RETURN_IF_ERROR(CheckStruct("report", report));
    EGOSIEVE_ASSIGN_OR_RETURN(outputs.probability_,
                              MapOutput::Create("map.probability", wishes.probability, grid));
    EGOSIEVE_ASSIGN_OR_RETURN(outputs.mean_, MapOutput::Create("map.mean", wishes.mean, grid));
    EGOSIEVE_ASSIGN_OR_RETURN(outputs.deviation_,
                              MapOutput::Create("map.deviation", wishes.deviation, grid));
    EGOSIEVE_ASSIGN_OR_RETURN(outputs.objects_,
                              MapOutput::Create("map.objects", wishes.objects, grid));
    return outputs;
  }

  absl::Status Write(SegmenterSession& session, std::optional<SegmenterSession::Result> result) {
    if (!result.has_value()) return WriteNoFrame(report_);
    if (map_wanted_) {
      kernels::Context& context = *session.context();
      vision::SegmentationMap& map = result->map;
      EGOSIEVE_RETURN_IF_ERROR(objects_.Prepare(context, grid_, map.probability));
      objects_.NumberObjects(grid_, session.ignored());
      EGOSIEVE_RETURN_IF_ERROR(probability_.Prepare(context, grid_, std::move(map.probability)));
      EGOSIEVE_RETURN_IF_ERROR(mean_.Prepare(context, grid_, std::move(map.mean)));
      EGOSIEVE_RETURN_IF_ERROR(deviation_.Prepare(context, grid_, std::move(map.deviation)));
      for (const MapOutput* output : {&probability_, &mean_, &deviation_, &objects_}) {
        output->Write();
      }
    }
    if (report_ != nullptr) WriteStruct(ReportOf(result->record), report_);
    return absl::OkStatus();
  }

 private:
  kernels::ImageGrid grid_;
  bool map_wanted_ = false;
  egosieve_frame_report* report_ = nullptr;
  MapOutput probability_, mean_, deviation_, objects_;
};

absl::Status ProcessFrame(SegmenterSession& session, const egosieve_image* image,
                          double time_seconds, const egosieve_map* map,
                          egosieve_frame_report* report) {
  std::vector<uint8_t> storage;
  EGOSIEVE_ASSIGN_OR_RETURN(const kernels::ImageView view, ViewImage("image", image, storage));
  if (!std::isfinite(time_seconds)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("time_seconds = %g; it must be finite", time_seconds));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(
      FrameOutputs outputs,
      FrameOutputs::Create(map, report, {view.width, view.height, session.stride()}));
  EGOSIEVE_ASSIGN_OR_RETURN(auto result, session.Process(view, time_seconds, map != nullptr));
  return outputs.Write(session, std::move(result));
}

absl::Status FinishFrame(SegmenterSession& session, const egosieve_map* map,
                         egosieve_frame_report* report) {
  const auto [count, size] = session.WaitingFrames();
  if (count == 0) {
    if (report != nullptr) EGOSIEVE_RETURN_IF_ERROR(CheckStruct("report", report));
    return WriteNoFrame(report);
  }
  EGOSIEVE_ASSIGN_OR_RETURN(
      FrameOutputs outputs,
      FrameOutputs::Create(map, report, {size.width, size.height, session.stride()}));
  EGOSIEVE_ASSIGN_OR_RETURN(auto result, session.Finish(map != nullptr));
  return outputs.Write(session, std::move(result));
}

// A mask, in memory of its own, of the pixels that are not 0.
absl::StatusOr<cv::Mat1b> IgnoredArea(const egosieve_image* image) {
  if (image == nullptr) return cv::Mat1b();
  std::vector<uint8_t> storage;
  EGOSIEVE_ASSIGN_OR_RETURN(const kernels::ImageView view,
                            ViewImage("options.ignore", image, storage));
  if (view.channels != 1) {
    return absl::InvalidArgumentError("options.ignore has colours; it must be EGOSIEVE_GREY");
  }
  return cv::Mat1b(cv::Mat1b(view.height, view.width, const_cast<uint8_t*>(view.data),
                             static_cast<size_t>(view.stride_bytes)) != 0);
}

}  // namespace
extern "C" {

void egosieve_segmenter_options_init(egosieve_segmenter_options* options) {
  if (options == nullptr) return;
  *options = egosieve_segmenter_options{};
  options->struct_size = sizeof *options;
  options->profile = EGOSIEVE_PROFILE_DEFAULT;
  options->stride = 5;
  options->seed = 1;
}

void egosieve_map_init(egosieve_map* map) {
  if (map == nullptr) return;
  *map = egosieve_map{};
  map->struct_size = sizeof *map;
}

void egosieve_frame_report_init(egosieve_frame_report* report) {
  if (report == nullptr) return;
  *report = egosieve_frame_report{};
  report->struct_size = sizeof *report;
}

egosieve_status egosieve_segmenter_create(const egosieve_segmenter_options* options,
                                          egosieve_segmenter** segmenter) {
  return Guard(__func__, [&]() -> absl::Status {
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("segmenter", segmenter));
    egosieve_segmenter_options wishes;
    egosieve_segmenter_options_init(&wishes);
    if (options != nullptr) {
      EGOSIEVE_RETURN_IF_ERROR(ReadStruct("options", options, wishes));
    }
    if (wishes.profile < EGOSIEVE_PROFILE_DEFAULT || wishes.profile > EGOSIEVE_PROFILE_FAST) {
      return absl::InvalidArgumentError(
          absl::StrFormat("options.profile = %d; it must be EGOSIEVE_PROFILE_DEFAULT, "
                          "EGOSIEVE_PROFILE_PAPER or EGOSIEVE_PROFILE_FAST",
                          wishes.profile));
    }
    SessionOptions session_options;
    session_options.profile = static_cast<Profile>(wishes.profile);
    session_options.stride = wishes.stride;
    session_options.budget = wishes.budget;
    session_options.seed = wishes.seed;
    session_options.lag = wishes.lag;
    session_options.focal_ratio = wishes.focal_ratio;
    EGOSIEVE_RETURN_IF_ERROR(session_options.Validate());
    EGOSIEVE_ASSIGN_OR_RETURN(session_options.ignored, IgnoredArea(wishes.ignore));
    EGOSIEVE_ASSIGN_OR_RETURN(auto context, ContextOf(wishes.device));
    EGOSIEVE_ASSIGN_OR_RETURN(auto session,
                              SegmenterSession::Create(std::move(context), session_options));
    EGOSIEVE_ASSIGN_OR_RETURN(*segmenter, AllSessions().Insert(std::move(session)));
    return absl::OkStatus();
  });
}

egosieve_status egosieve_segmenter_free(egosieve_segmenter* segmenter) {
  if (segmenter == nullptr) return EGOSIEVE_OK;
  return Guard(__func__, [&] { return AllSessions().Erase("segmenter", segmenter); });
}

egosieve_status egosieve_segmenter_grid_size(egosieve_segmenter* segmenter, int32_t width,
                                             int32_t height, int64_t* rows, int64_t* columns) {
  return WithSession(__func__, segmenter, [&](SegmenterSession& session) -> absl::Status {
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("rows", rows));
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("columns", columns));
    const kernels::ImageGrid grid{width, height, session.stride()};
    EGOSIEVE_RETURN_IF_ERROR(grid.Validate());
    *rows = grid.rows();
    *columns = grid.columns();
    return absl::OkStatus();
  });
}

egosieve_status egosieve_segmenter_process(egosieve_segmenter* segmenter,
                                           const egosieve_image* image, double time_seconds,
                                           const egosieve_map* map, egosieve_frame_report* report) {
  return WithSession(__func__, segmenter, [&](SegmenterSession& session) {
    return ProcessFrame(session, image, time_seconds, map, report);
  });
}

egosieve_status egosieve_segmenter_frame_count(egosieve_segmenter* segmenter, int64_t* frames) {
  return WithSession(__func__, segmenter, [&](SegmenterSession& session) -> absl::Status {
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("frames", frames));
    *frames = session.FrameCount();
    return absl::OkStatus();
  });
}

egosieve_status egosieve_segmenter_waiting(egosieve_segmenter* segmenter, int64_t* frames,
                                           int32_t* width, int32_t* height) {
  return WithSession(__func__, segmenter, [&](SegmenterSession& session) -> absl::Status {
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("frames", frames));
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("width", width));
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("height", height));
    const auto [count, size] = session.WaitingFrames();
    *frames = count;
    *width = size.width;
    *height = size.height;
    return absl::OkStatus();
  });
}

egosieve_status egosieve_segmenter_finish(egosieve_segmenter* segmenter, const egosieve_map* map,
                                          egosieve_frame_report* report) {
  return WithSession(__func__, segmenter,
                     [&](SegmenterSession& session) { return FinishFrame(session, map, report); });
}

egosieve_status egosieve_segmenter_save(egosieve_segmenter* segmenter, const char* path) {
  return WithSession(__func__, segmenter, [&](SegmenterSession& session) -> absl::Status {
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("path", path));
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string bytes, session.ToBytes());
    return kernels::WriteFileAtomically(path, bytes);
  });
}

egosieve_status egosieve_segmenter_load(const char* path, const char* device,
                                        egosieve_segmenter** segmenter) {
  return Guard(__func__, [&]() -> absl::Status {
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("path", path));
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("segmenter", segmenter));
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string bytes, kernels::ReadFile(path, kMaximumFileBytes));
    EGOSIEVE_ASSIGN_OR_RETURN(auto context, ContextOf(device));
    auto session = SegmenterSession::FromBytes(std::move(context), bytes);
    if (!session.ok()) {
      return absl::Status(session.status().code(),
                          absl::StrFormat("%s: %s", path, session.status().message()));
    }
    EGOSIEVE_ASSIGN_OR_RETURN(*segmenter, AllSessions().Insert(*std::move(session)));
    return absl::OkStatus();
  });
}

}  // extern "C"

}  // namespace egosieve::embed
