#include "tools/embed/include/egosieve/segmenter.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
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

namespace egosieve::embed {
namespace {

static_assert(EGOSIEVE_PROFILE_DEFAULT == static_cast<int>(Profile::kDefault) &&
              EGOSIEVE_PROFILE_PAPER == static_cast<int>(Profile::kPaper) &&
              EGOSIEVE_PROFILE_FAST == static_cast<int>(Profile::kFast));

constexpr int64_t kMaximumFileBytes = int64_t{1} << 30;

using Sessions = HandleTable<HandleKind::kSegmenter, egosieve_segmenter, SegmenterSession>;

// Never destroyed: a program may use handles from its own destructors.
Sessions& AllSessions() {
  static Sessions* sessions = new Sessions;
  return *sessions;
}

template <typename Body>
egosieve_status WithSession(const char* function, egosieve_segmenter* segmenter, Body&& body) {
  return Guard(function, [&]() -> absl::Status {
    EGOSIEVE_ASSIGN_OR_RETURN(const std::shared_ptr<SegmenterSession> session,
                              AllSessions().Find("segmenter", segmenter));
    // The other library's limit: each has threads of its own.
    kernels::SetMaximumThreads(egosieve_threads());
    return body(*session);
  });
}

// One of a map's arrays with the size that it has, the grid's or the frame's. What can fail comes
// before anything is written: Prepare all, then Write all.
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

absl::Status ProcessFrame(SegmenterSession& session, const egosieve_image* image,
                          double time_seconds, const egosieve_map* map,
                          egosieve_frame_report* report) {
  std::vector<uint8_t> storage;
  EGOSIEVE_ASSIGN_OR_RETURN(const kernels::ImageView view, ViewImage("image", image, storage));
  if (!std::isfinite(time_seconds)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("time_seconds = %g; it must be finite", time_seconds));
  }
  const kernels::ImageGrid grid{view.width, view.height, session.stride()};
  egosieve_map wishes;
  egosieve_map_init(&wishes);
  if (map != nullptr) EGOSIEVE_RETURN_IF_ERROR(ReadStruct("map", map, wishes));
  if (report != nullptr) EGOSIEVE_RETURN_IF_ERROR(CheckStruct("report", report));
  EGOSIEVE_ASSIGN_OR_RETURN(MapOutput probability,
                            MapOutput::Create("map.probability", wishes.probability, grid));
  EGOSIEVE_ASSIGN_OR_RETURN(MapOutput mean, MapOutput::Create("map.mean", wishes.mean, grid));
  EGOSIEVE_ASSIGN_OR_RETURN(MapOutput deviation,
                            MapOutput::Create("map.deviation", wishes.deviation, grid));
  EGOSIEVE_ASSIGN_OR_RETURN(SegmenterSession::Result result,
                            session.Process(view, time_seconds, map != nullptr));
  if (map != nullptr) {
    kernels::Context& context = *session.context();
    EGOSIEVE_RETURN_IF_ERROR(probability.Prepare(context, grid, std::move(result.map.probability)));
    EGOSIEVE_RETURN_IF_ERROR(mean.Prepare(context, grid, std::move(result.map.mean)));
    EGOSIEVE_RETURN_IF_ERROR(deviation.Prepare(context, grid, std::move(result.map.deviation)));
    for (const MapOutput* output : {&probability, &mean, &deviation}) output->Write();
  }
  if (report != nullptr) WriteStruct(ReportOf(result.record), report);
  return absl::OkStatus();
}

}  // namespace
}  // namespace egosieve::embed

using egosieve::embed::AllSessions;
using egosieve::embed::CheckPointer;
using egosieve::embed::Guard;
using egosieve::embed::SegmenterSession;
using egosieve::embed::WithSession;

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
      EGOSIEVE_RETURN_IF_ERROR(egosieve::embed::ReadStruct("options", options, wishes));
    }
    if (wishes.profile < EGOSIEVE_PROFILE_DEFAULT || wishes.profile > EGOSIEVE_PROFILE_FAST) {
      return absl::InvalidArgumentError(
          absl::StrFormat("options.profile = %d; it must be EGOSIEVE_PROFILE_DEFAULT, "
                          "EGOSIEVE_PROFILE_PAPER or EGOSIEVE_PROFILE_FAST",
                          wishes.profile));
    }
    egosieve::embed::SessionOptions session_options;
    session_options.profile = static_cast<egosieve::embed::Profile>(wishes.profile);
    session_options.stride = wishes.stride;
    session_options.budget = wishes.budget;
    session_options.seed = wishes.seed;
    EGOSIEVE_RETURN_IF_ERROR(session_options.Validate());
    EGOSIEVE_ASSIGN_OR_RETURN(auto context, egosieve::embed::ContextOf(wishes.device));
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
    const egosieve::kernels::ImageGrid grid{width, height, session.stride()};
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
    return egosieve::embed::ProcessFrame(session, image, time_seconds, map, report);
  });
}

egosieve_status egosieve_segmenter_save(egosieve_segmenter* segmenter, const char* path) {
  return WithSession(__func__, segmenter, [&](SegmenterSession& session) -> absl::Status {
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("path", path));
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string bytes, session.ToBytes());
    return egosieve::kernels::WriteFileAtomically(path, bytes);
  });
}

egosieve_status egosieve_segmenter_load(const char* path, const char* device,
                                        egosieve_segmenter** segmenter) {
  return Guard(__func__, [&]() -> absl::Status {
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("path", path));
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("segmenter", segmenter));
    EGOSIEVE_ASSIGN_OR_RETURN(
        const std::string bytes,
        egosieve::kernels::ReadFile(path, egosieve::embed::kMaximumFileBytes));
    EGOSIEVE_ASSIGN_OR_RETURN(auto context, egosieve::embed::ContextOf(device));
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
