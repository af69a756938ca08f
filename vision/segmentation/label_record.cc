#include "vision/segmentation/label_record.h"

#include <algorithm>

namespace egosieve::vision {

void RecordLabels(const LabelledFrame& labels, FrameRecord& record) {
  record.feature_count = labels.feature_count;
  record.match_count = labels.match_count;
  record.inlier_count = labels.inlier_count;
  record.motion_model = labels.motion_model;
  record.noise_pixels = labels.noise_pixels;
  record.reason = labels.reason;
  record.dynamic_label_count = std::count_if(labels.probability.begin(), labels.probability.end(),
                                             [](double probability) { return probability >= 0.5; });
  for (int64_t i = 0; i < labels.size(); ++i) {
    record.decided_count[static_cast<int>(labels.decided_by[i])] += labels.probability[i] >= 0.5;
  }
  if (labels.first_index >= 0) {
    record.frame_gap = static_cast<int>(labels.second_index - labels.first_index);
  }
  record.doubt = labels.doubt;
  record.step = labels.step;
  record.static_label_count = labels.size() - record.dynamic_label_count;
  record.milliseconds.equalization = labels.times.equalization_milliseconds;
  record.milliseconds.features = labels.times.features_milliseconds;
  record.milliseconds.matching = labels.times.matching_milliseconds;
  record.milliseconds.geometry = labels.times.geometry_milliseconds;
  record.milliseconds.labelling = labels.times.labelling_milliseconds;
}

}  // namespace egosieve::vision
