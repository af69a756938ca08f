#include "tools/segment/segment_words.h"

namespace egosieve::tools {

using vision::OnlineSegmenterOptions;

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
