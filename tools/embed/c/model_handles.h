// The tables of objects behind the handles of egosieve_gp and egosieve_posterior, and calls on
// these objects.
#ifndef EGOSIEVE_TOOLS_EMBED_C_MODEL_HANDLES_H_
#define EGOSIEVE_TOOLS_EMBED_C_MODEL_HANDLES_H_

#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "kernels/base/status_macros.h"
#include "tools/embed/c/handle_table.h"
#include "tools/embed/c/last_error.h"
#include "tools/embed/c/learning_model.h"
#include "tools/embed/c/prediction.h"
#include "tools/embed/include/egosieve/gaussian_process.h"

namespace egosieve::embed {

using Models = HandleTable<HandleKind::kGaussianProcess, egosieve_gp, LearningModel>;
using Posteriors = HandleTable<HandleKind::kPosterior, egosieve_posterior, const DevicePosterior>;

// Never destroyed, because a program may use handles in its own destructors.
inline Models& AllModels() {
  static Models* models = new Models;
  return *models;
}
inline Posteriors& AllPosteriors() {
  static Posteriors* posteriors = new Posteriors;
  return *posteriors;
}

// Calls `body` with the object behind `gp`, within Guard.
template <typename Body>
egosieve_status WithModel(const char* function, egosieve_gp* gp, Body&& body) {
  return Guard(function, [&]() -> absl::Status {
    EGOSIEVE_ASSIGN_OR_RETURN(const std::shared_ptr<LearningModel> model,
                              AllModels().Find("gp", gp));
    return std::forward<Body>(body)(*model);
  });
}

// The same for the posterior behind `posterior`.
template <typename Body>
egosieve_status WithPosterior(const char* function, egosieve_posterior* posterior, Body&& body) {
  return Guard(function, [&]() -> absl::Status {
    EGOSIEVE_ASSIGN_OR_RETURN(const std::shared_ptr<const DevicePosterior> found,
                              AllPosteriors().Find("posterior", posterior));
    return body(*found);
  });
}

}  // namespace egosieve::embed

#endif  // EGOSIEVE_TOOLS_EMBED_C_MODEL_HANDLES_H_
