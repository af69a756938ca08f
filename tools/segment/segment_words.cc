#include "tools/segment/segment_words.h"

namespace egosieve::tools {

using vision::OnlineSegmenterOptions;

const Words<vision::FeatureSource>& FeatureWords() {
  static const auto& words =
      *new Words<vision::FeatureSource>{{"sift+corners", vision::FeatureSource::kSiftCorners},
                                        {"flow", vision::FeatureSource::kFlow},
                                        {"both", vision::FeatureSource::kBoth},
                                        {"auto", vision::FeatureSource::kAuto}};
  return words;
}

const Words<vision::MotionModelChoice>& MotionModelWords() {
  static const auto& words = *new Words<vision::MotionModelChoice>{
      {"auto", vision::MotionModelChoice::kAuto},
      {"fundamental", vision::MotionModelChoice::kFundamental},
      {"homography", vision::MotionModelChoice::kHomography},
      {"calibrated", vision::MotionModelChoice::kCalibrated}};
  return words;
}

const Words<vision::LabelRule>& LabelWords() {
  static const auto& words =
      *new Words<vision::LabelRule>{{"scaled_distance", vision::LabelRule::kScaledDistance},
                                    {"scaled_median", vision::LabelRule::kScaledMedian},
                                    {"mixture", vision::LabelRule::kMixture}};
  return words;
}

const Words<vision::Equalization>& EqualizationWords() {
  static const auto& words =
      *new Words<vision::Equalization>{{"none", vision::Equalization::kNone},
                                       {"global", vision::Equalization::kGlobal},
                                       {"clahe", vision::Equalization::kClahe}};
  return words;
}

const Words<vision::ModelKind>& ModelWords() {
  static const auto& words = *new Words<vision::ModelKind>{{"exact", vision::ModelKind::kExact},
                                                           {"sparse", vision::ModelKind::kSparse}};
  return words;
}

const Words<vision::FlowQuality>& FlowQualityWords() {
  static const auto& words =
      *new Words<vision::FlowQuality>{{"ultrafast", vision::FlowQuality::kUltrafast},
                                      {"fast", vision::FlowQuality::kFast},
                                      {"medium", vision::FlowQuality::kMedium}};
  return words;
}

const Words<bool>& SwitchWords() {
  static const auto& words = *new Words<bool>{{"on", true}, {"off", false}};
  return words;
}

const Words<OnlineSegmenterOptions (*)()>& Profiles() {
  static const auto& words =
      *new Words<OnlineSegmenterOptions (*)()>{{"default", &OnlineSegmenterOptions::Default},
                                               {"paper", &OnlineSegmenterOptions::Paper},
                                               {"fast", &OnlineSegmenterOptions::Fast}};
  return words;
}

}  // namespace egosieve::tools
