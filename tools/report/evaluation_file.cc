#include "tools/report/evaluation_file.h"

#include <nlohmann/json.hpp>

#include "kernels/base/status_macros.h"
#include "tools/run_folder/json_fields.h"

namespace egosieve::tools {

absl::StatusOr<EvaluationFile> ParseEvaluation(absl::string_view text) {
  using Json = nlohmann::ordered_json;
  const Json json = Json::parse(text.begin(), text.end(), nullptr, /*allow_exceptions=*/false);
  EvaluationFile evaluation;
  Json frames;
  JsonFields fields(json, "the evaluation");
  fields.Read("truth", evaluation.truth);
  fields.Read("pixels", evaluation.pixels);
  fields.Read("pooled_auc", evaluation.pooled_auc);
  fields.Read("mean_auc", evaluation.mean_auc);
  fields.Read("frames_of_prior", evaluation.frames_of_prior);
  fields.Read("frames_without_map", evaluation.frames_without_map);
  fields.Read("frames_without_mask", evaluation.frames_without_mask);
  fields.Read("frames", frames);
  EGOSIEVE_RETURN_IF_ERROR(fields.status());
  for (const Json& entry : frames) {
    EvaluatedFrame frame;
    JsonFields own(entry, "a frame's entry");
    own.Read("index", frame.index);
    own.Read("dynamic_pixels", frame.dynamic_pixels);
    own.Read("static_pixels", frame.static_pixels);
    own.Read("auc", frame.auc);
    EGOSIEVE_RETURN_IF_ERROR(own.status());
    evaluation.frames.push_back(frame);
  }
  return evaluation;
}

}  // namespace egosieve::tools
