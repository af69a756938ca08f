// The objects of a drive that were found, by group, and the false ones: objects.h over its frames.
#ifndef EGOSIEVE_TOOLS_EVALUATION_OBJECT_TALLY_H_
#define EGOSIEVE_TOOLS_EVALUATION_OBJECT_TALLY_H_

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tools/evaluation/objects.h"
#include "tools/evaluation/synthetic_truth.h"

namespace egosieve::tools {

// How many objects of a group were visible and found.
struct ObjectRecall {
  int64_t objects = 0;      // counted per frame: an object seen in ten frames counts ten times
  int64_t found = 0;        // at the options' IoU
  int64_t found_at_30 = 0;  // IoU of 0.3 or more
  int64_t found_at_50 = 0;
  double iou_sum = 0.0;

  void Add(const ObjectRecall& other);
};

class ObjectTally {
 public:
  // The scores of a frame. known: properties of its objects, by id; null: none.
  void Add(const ObjectScores& scores, const std::map<int, SyntheticObject>* known);
  // `other`: with the same options.
  void Merge(const ObjectTally& other);

  int64_t frames() const { return frames_; }
  int64_t false_objects() const { return false_objects_; }
  // Absent without frames.
  std::optional<double> FalseObjectsPerFrame() const;
  // By group: "all", "relation ahead", "class car", "size 100-399", "distance under 20 m",
  // "ahead within 40 m", "ahead vehicle within 40 m" (neither pedestrian nor cyclist), ...
  const std::map<std::string, ObjectRecall>& recall() const { return recall_; }
  nlohmann::ordered_json RecallToJson() const;

 private:
  std::map<std::string, ObjectRecall> recall_;
  int64_t frames_ = 0;
  int64_t false_objects_ = 0;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_EVALUATION_OBJECT_TALLY_H_
