#include "tools/evaluate/potential_scores.h"

#include <cmath>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/evaluation/synthetic_truth.h"

namespace egosieve::tools {
namespace {

constexpr char kVoid[] = "void";

std::string KindOf(const SyntheticObject& object) {
  const char* motion = object.moving ? "moving " : "standing ";
  if (object.object_class == "pedestrian") return absl::StrCat(motion, "person");
  if (object.object_class == "cyclist") return absl::StrCat(motion, "cyclist");
  return absl::StrCat(motion, "vehicle");
}

absl::StatusOr<std::vector<std::string>> KindsByScene(const SyntheticTruth& truth, int64_t frame,
                                                      const kernels::ImageGrid& grid) {
  EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat1i ids, truth.ReadIds(frame));
  if (ids.cols != grid.width || ids.rows != grid.height) {
    return absl::FailedPreconditionError(
        absl::StrFormat("frame %d has %d x %d pixels, %s another size", frame, grid.width,
                        grid.height, truth.folder));
  }
  const std::map<int, SyntheticObject>& objects = truth.frames.at(frame);
  std::vector<std::string> kinds;
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      const auto object = objects.find(ids(grid.y_pixels(row), grid.x_pixels(column)));
      kinds.push_back(object == objects.end() ? "" : KindOf(object->second));
    }
  }
  return kinds;
}

}  // namespace

void PotentialScores::Add(const cv::Mat1f& potential, const std::vector<std::string>& kinds) {
  ++frames_;
  auto value = potential.begin();
  for (const std::string& kind : kinds) {
    const uint16_t score = ScoreOf(*value++);
    if (kind.empty()) {
      scenery_.Add(score, false);
    } else if (kind != kVoid) {
      kinds_[kind].Add(score, true);
    }
  }
}

std::optional<double> PotentialScores::Auc(const std::string& kind) const {
  const auto found = kinds_.find(kind);
  if (found == kinds_.end()) return std::nullopt;
  RocHistogram both = found->second;
  both.Merge(scenery_);
  return both.Auc();
}

nlohmann::ordered_json PotentialScores::ToJson() const {
  nlohmann::ordered_json kinds = nlohmann::ordered_json::object();
  for (const auto& [kind, pixels] : kinds_) {
    const std::optional<double> auc = Auc(kind);
    kinds[kind] = {{"pixels", pixels.positive_count()},
                   {"auc", auc ? nlohmann::ordered_json(*auc) : nlohmann::ordered_json()}};
  }
  return {{"frames", frames_}, {"scenery_pixels", scenery_.negative_count()}, {"kinds", kinds}};
}

std::string PotentialScores::ToTable() const {
  std::string table;
  for (const auto& [kind, pixels] : kinds_) {
    const std::optional<double> auc = Auc(kind);
    if (!auc) continue;
    absl::StrAppendFormat(&table,
                          "potential, %s against scenery: AUC %.4f (%d and %d pixels of the grid, "
                          "%d frames)\n",
                          kind, *auc, pixels.positive_count(), scenery_.negative_count(), frames_);
  }
  return table;
}

std::vector<std::string> KindsByBoxes(const std::vector<LabelledBox>& boxes,
                                      const kernels::ImageGrid& grid, double middle) {
  std::vector<std::string> kinds;
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      const double x = grid.x_pixels(column), y = grid.y_pixels(row);
      std::string kind;
      for (const LabelledBox& box : boxes) {
        if (x < box.left || x > box.right || y < box.top || y > box.bottom) continue;
        const bool within =
            std::abs(2.0 * x - box.left - box.right) <= middle * (box.right - box.left) &&
            std::abs(2.0 * y - box.top - box.bottom) <= middle * (box.bottom - box.top);
        const bool told = box.moving.has_value() && box.box_class != BoxClass::kUntold;
        // If boxes overlap, it is not known which of them hides the other.
        kind = kind.empty() && within && told ? absl::StrCat(*box.moving ? "moving " : "standing ",
                                                             BoxClassName(box.box_class))
                                              : kVoid;
      }
      kinds.push_back(std::move(kind));
    }
  }
  return kinds;
}

absl::StatusOr<PotentialScores> ScorePotential(const RunFolder& folder, const std::string& scene,
                                               const std::string& boxes,
                                               const PotentialScoresOptions& options) {
  PotentialScores scores;
  EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder.ReadDescription());
  if (description.flags.count("potential") == 0 || (scene.empty() && boxes.empty())) return scores;
  SyntheticTruth synthetic;
  BoxTruth by_boxes;
  if (!scene.empty()) {
    EGOSIEVE_ASSIGN_OR_RETURN(synthetic, ReadSyntheticTruth(scene));
  } else {
    EGOSIEVE_ASSIGN_OR_RETURN(by_boxes, ReadBoxTruth(boxes));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const std::vector<FrameLine> lines, folder.ReadLines());
  for (const FrameLine& line : lines) {
    const auto own_boxes = by_boxes.find(line.index);
    const bool known = synthetic.frames.count(line.index) > 0 || own_boxes != by_boxes.end();
    if (!line.has_map() || !known || line.time_seconds < options.from_seconds) continue;
    EGOSIEVE_ASSIGN_OR_RETURN(const cv::Mat1f potential, folder.ReadPotential(line, description));
    const kernels::ImageGrid grid = GridOf(line, description);
    std::vector<std::string> kinds;
    if (!scene.empty()) {
      EGOSIEVE_ASSIGN_OR_RETURN(kinds, KindsByScene(synthetic, line.index, grid));
    } else {
      kinds = KindsByBoxes(own_boxes->second, grid, options.middle);
    }
    scores.Add(potential, kinds);
  }
  return scores;
}

}  // namespace egosieve::tools
