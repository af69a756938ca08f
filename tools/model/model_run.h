// The run of `model`: describes a checkpoint of the model and writes its points as CSV.
#ifndef EGOSIEVE_TOOLS_MODEL_MODEL_RUN_H_
#define EGOSIEVE_TOOLS_MODEL_MODEL_RUN_H_

#include <string>

#include "absl/status/statusor.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/result_flag.h"

namespace egosieve::tools {

struct ModelOptions {
  std::string path;        // a model file, or a run folder: its newest checkpoint
  std::string csv;         // file for the points; empty: none
  bool overwrite = false;  // replace that file
  ResultFlag result;
};

// NotFound or DataLoss without a model that can be read; AlreadyExists or InvalidArgument if the
// points cannot be written to `csv`; errors of the environment.
absl::StatusOr<ExitCode> RunModel(const ModelOptions& options);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_MODEL_MODEL_RUN_H_
