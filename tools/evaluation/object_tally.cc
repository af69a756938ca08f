#include "tools/evaluation/object_tally.h"

#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"

namespace egosieve::tools {
namespace {

// The groups that an object belongs to, beside "all".
std::vector<std::string> GroupsOf(const SyntheticObject& object) {
  const char* size = object.area_pixels < 100    ? "size under 100"
                     : object.area_pixels < 400  ? "size 100-399"
                     : object.area_pixels < 1600 ? "size 400-1599"
                                                 : "size from 1600";
  const char* distance = object.distance_metres < 20.0   ? "distance under 20 m"
                         : object.distance_metres < 40.0 ? "distance 20-40 m"
                                                         : "distance from 40 m";
  std::vector<std::string> groups = {absl::StrCat("relation ", object.relation),
                                     absl::StrCat("class ", object.object_class), size, distance};
  const bool is_vehicle = object.object_class != "pedestrian" && object.object_class != "cyclist";
  if (object.distance_metres < 40.0) {
    groups.push_back(absl::StrCat(object.relation, " within 40 m"));
    groups.push_back(is_vehicle ? "vehicle within 40 m" : "person or cyclist within 40 m");
    if (is_vehicle) groups.push_back(absl::StrCat(object.relation, " vehicle within 40 m"));
  }
  if (object.object_class == "pedestrian" && object.distance_metres < 25.0) {
    groups.emplace_back("person within 25 m");
  }
  return groups;
}

}  // namespace

void ObjectRecall::Add(const ObjectRecall& other) {
  objects += other.objects;
  found += other.found;
  found_at_30 += other.found_at_30;
  found_at_50 += other.found_at_50;
  iou_sum += other.iou_sum;
}

void ObjectTally::Add(const ObjectScores& scores, const std::map<int, SyntheticObject>* known) {
  false_objects_ += scores.false_objects;
  ++frames_;
  for (const FoundObject& found : scores.objects) {
    std::vector<std::string> groups = {"all"};
    if (known != nullptr) {
      const auto object = known->find(found.id);
      if (object != known->end()) {
        for (std::string& group : GroupsOf(object->second)) groups.push_back(std::move(group));
      }
    }
    const ObjectRecall one = {1, found.found, found.iou >= 0.3, found.iou >= 0.5, found.iou};
    for (const std::string& group : groups) recall_[group].Add(one);
  }
}

void ObjectTally::Merge(const ObjectTally& other) {
  for (const auto& [group, recall] : other.recall_) recall_[group].Add(recall);
  frames_ += other.frames_;
  false_objects_ += other.false_objects_;
}

std::optional<double> ObjectTally::FalseObjectsPerFrame() const {
  if (frames_ == 0) return std::nullopt;
  return static_cast<double>(false_objects_) / static_cast<double>(frames_);
}

nlohmann::ordered_json ObjectTally::RecallToJson() const {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const auto& [group, r] : recall_) {
    const double n = static_cast<double>(r.objects);
    json[group] = {{"objects", r.objects},
                   {"recall", r.found / n},
                   {"recall_at_0.3", r.found_at_30 / n},
                   {"recall_at_0.5", r.found_at_50 / n},
                   {"mean_iou", r.iou_sum / n}};
  }
  return json;
}

}  // namespace egosieve::tools
