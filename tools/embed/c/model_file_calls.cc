#include <memory>
#include <string>
#include <utility>

#include "absl/strings/str_format.h"
#include "gp/io/model_file.h"
#include "kernels/base/status_macros.h"
#include "tools/embed/c/device_contexts.h"
#include "tools/embed/c/last_error.h"
#include "tools/embed/c/learning_model.h"
#include "tools/embed/c/model_handles.h"
#include "tools/embed/c/options.h"
#include "tools/embed/include/egosieve/gaussian_process.h"

namespace egosieve::embed {
namespace {

absl::StatusOr<std::shared_ptr<LearningModel>> ModelOfFile(gp::ModelFile file, const char* device) {
  EGOSIEVE_ASSIGN_OR_RETURN(std::shared_ptr<kernels::Context> context, ContextOf(device));
  return LearningModel::FromFile(std::move(context), std::move(file));
}

}  // namespace
extern "C" {

egosieve_status egosieve_gp_set_annotation(egosieve_gp* gp, const void* bytes, int64_t size) {
  return WithModel(__func__, gp, [&](LearningModel& model) -> absl::Status {
    if (size < 0 || size > (int64_t{1} << 30)) {
      return absl::InvalidArgumentError(
          absl::StrFormat("size = %d bytes; it must be 0 to 2^30", size));
    }
    if (size > 0) EGOSIEVE_RETURN_IF_ERROR(CheckPointer("bytes", bytes));
    model.SetAnnotation(size == 0 ? std::string()
                                  : std::string(static_cast<const char*>(bytes), size));
    return absl::OkStatus();
  });
}

egosieve_status egosieve_gp_annotation(egosieve_gp* gp, void* bytes, int64_t capacity,
                                       int64_t* size) {
  return WithModel(__func__, gp, [&](LearningModel& model) {
    return GiveBytes(model.annotation(), bytes, capacity, size);
  });
}

egosieve_status egosieve_gp_save(egosieve_gp* gp, const char* path) {
  return WithModel(__func__, gp, [&](LearningModel& model) -> absl::Status {
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("path", path));
    EGOSIEVE_ASSIGN_OR_RETURN(const gp::ModelFile file, model.ToFile());
    return gp::WriteModelFile(path, file);
  });
}

egosieve_status egosieve_gp_load(const char* path, const char* device, egosieve_gp** gp) {
  return Guard(__func__, [&]() -> absl::Status {
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("path", path));
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("gp", gp));
    EGOSIEVE_ASSIGN_OR_RETURN(gp::ModelFile file, gp::ReadModelFile(path));
    EGOSIEVE_ASSIGN_OR_RETURN(auto model, ModelOfFile(std::move(file), device));
    EGOSIEVE_ASSIGN_OR_RETURN(*gp, AllModels().Insert(std::move(model)));
    return absl::OkStatus();
  });
}

egosieve_status egosieve_gp_serialize(egosieve_gp* gp, void* bytes, int64_t capacity,
                                      int64_t* size) {
  return WithModel(__func__, gp, [&](LearningModel& model) -> absl::Status {
    EGOSIEVE_ASSIGN_OR_RETURN(const gp::ModelFile file, model.ToFile());
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string text, gp::SerializeModel(file));
    return GiveBytes(text, bytes, capacity, size);
  });
}

egosieve_status egosieve_gp_deserialize(const void* bytes, int64_t size, const char* device,
                                        egosieve_gp** gp) {
  return Guard(__func__, [&]() -> absl::Status {
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("bytes", bytes));
    EGOSIEVE_RETURN_IF_ERROR(CheckPointer("gp", gp));
    if (size < 0) {
      return absl::InvalidArgumentError(absl::StrFormat("size = %d is negative", size));
    }
    EGOSIEVE_ASSIGN_OR_RETURN(gp::ModelFile file, gp::ParseModel({static_cast<const char*>(bytes),
                                                                  static_cast<size_t>(size)}));
    EGOSIEVE_ASSIGN_OR_RETURN(auto model, ModelOfFile(std::move(file), device));
    EGOSIEVE_ASSIGN_OR_RETURN(*gp, AllModels().Insert(std::move(model)));
    return absl::OkStatus();
  });
}

}  // extern "C"

}  // namespace egosieve::embed
