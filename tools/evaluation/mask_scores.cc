#include "tools/evaluation/mask_scores.h"

#include <utility>

#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/evaluation/boundary.h"
#include "tools/run_folder/json_fields.h"

namespace egosieve::tools {
namespace {

constexpr uint8_t kVoid = 128;

}  // namespace

absl::Status MaskScores::Add(const MaskFrame& frame) {
  const cv::Size size = frame.truth.size();
  for (const cv::Size other : {frame.mask.size(), frame.ids.empty() ? size : frame.ids.size(),
                               frame.truth_ids.empty() ? size : frame.truth_ids.size()}) {
    if (other == size) continue;
    return absl::InvalidArgumentError(
        absl::StrFormat("frame %d: a mask of %d x %d pixels and a truth of %d x %d", frame.index,
                        other.width, other.height, size.width, size.height));
  }
  const cv::Mat1b void_pixels = frame.truth == kVoid;
  const cv::Mat1b real = (frame.truth != 0) & ~void_pixels;
  const cv::Mat1b called = (frame.mask != 0) & ~void_pixels;
  EGOSIEVE_ASSIGN_OR_RETURN(const BoundaryScore boundary, BoundaryF(called, real, {}));
  ++frames_;
  if (cv::countNonZero(real) > 0) {
    j_.Add(static_cast<double>(cv::countNonZero(called & real)) /
           static_cast<double>(cv::countNonZero(called | real)));
    f_.Add(boundary.f);
  }
  std::vector<ShapeContext> outline = DescribeOutline(called);
  std::vector<ShapeContext> truth_outline = DescribeOutline(real);
  if (frame.index == last_index_ + 1) {
    if (const auto change = OutlineChange(outline_, outline)) t_.Add(*change);
    if (const auto change = OutlineChange(truth_outline_, truth_outline)) truth_t_.Add(*change);
  }
  last_index_ = frame.index;
  outline_ = std::move(outline);
  truth_outline_ = std::move(truth_outline);
  if (!frame.ids.empty() && !frame.truth_ids.empty()) {
    EGOSIEVE_ASSIGN_OR_RETURN(
        const ObjectScores objects,
        ScoreObjects(frame.ids, frame.truth_ids, void_pixels, object_options_));
    objects_.Add(objects, frame.objects);
    identity_.Add(frame.truth_ids, frame.ids, void_pixels);
  }
  return absl::OkStatus();
}

nlohmann::ordered_json MaskScores::ToJson() const {
  const std::optional<IdentityScores> identity = Identity();
  nlohmann::ordered_json json = {
      {"frames", frames_},
      {"j", OrNull(MeanJ())},
      {"boundary_f", OrNull(MeanF())},
      {"temporal_instability", OrNull(MeanT())},
      {"temporal_instability_of_truth", OrNull(TruthT())},
      {"identity", nullptr},
      {"false_objects_per_frame", OrNull(objects_.FalseObjectsPerFrame())},
      {"object_recall", objects_.RecallToJson()}};
  if (identity) {
    json["identity"] = {{"idf1", identity->idf1},
                        {"hota", identity->hota},
                        {"detection", identity->detection},
                        {"association", identity->association},
                        {"truth_objects", identity->truth_objects},
                        {"predicted_objects", identity->predicted_objects}};
  }
  return json;
}

std::string MaskScores::Summary() const {
  if (!MeanJ()) return "";
  std::string text = absl::StrFormat("masks, %d frames: J %.4f, boundary F %.4f", frames_, *MeanJ(),
                                     MeanF().value_or(0.0));
  if (MeanT()) absl::StrAppendFormat(&text, ", temporal instability T %.4f", *MeanT());
  if (TruthT()) absl::StrAppendFormat(&text, " (truth's own %.4f)", *TruthT());
  text.push_back('\n');
  if (const std::optional<IdentityScores> identity = Identity()) {
    absl::StrAppendFormat(&text, "ids: IDF1 %.4f, HOTA %.4f (detection %.4f, association %.4f)\n",
                          identity->idf1, identity->hota, identity->detection,
                          identity->association);
  }
  for (const auto& [group, r] : objects_.recall()) {
    absl::StrAppendFormat(&text, "movers of ids, %s: %d of %d found (IoU 0.3), %d (IoU 0.5)\n",
                          group, r.found_at_30, r.objects, r.found_at_50);
  }
  if (const std::optional<double> false_objects = objects_.FalseObjectsPerFrame()) {
    absl::StrAppendFormat(&text, "false movers of ids per frame %.4f\n", *false_objects);
  }
  return text;
}

}  // namespace egosieve::tools
