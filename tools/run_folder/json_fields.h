// Fields of JSON objects.
#pragma once

#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace egosieve::tools {

// Reads the fields of a JSON object by name; errors name the field. One function reads a whole
// document by visiting every field. The first failure is kept, and later reads are skipped.
class JsonFields {
 public:
  // `document` names the object in errors. `object` must outlive this reader.
  JsonFields(const nlohmann::ordered_json& object, std::string document)
      : object_(object), document_(std::move(document)) {
    if (!object_.is_object()) {
      status_ = absl::DataLossError(absl::StrCat(document_, " is not a JSON object"));
    }
  }

  // null is read as NaN by floating-point targets.
  template <typename T>
  void Read(const char* name, T& target) {
    if (!status_.ok()) return;
    const auto field = object_.find(name);
    if (field == object_.end()) {
      status_ = absl::DataLossError(absl::StrCat(document_, " has no field '", name, "'"));
      return;
    }
    if constexpr (std::is_floating_point_v<T>) {
      if (field->is_null()) {
        target = std::numeric_limits<T>::quiet_NaN();
        return;
      }
    }
    try {
      target = field->template get<T>();
    } catch (const nlohmann::json::exception&) {
      status_ = absl::DataLossError(absl::StrCat(document_, ": field '", name, "' has the value ",
                                                 field->dump().substr(0, 60),
                                                 ", which is of another type"));
    }
  }

  // As Read, but a missing field leaves the target unchanged.
  template <typename T>
  void ReadIfThere(const char* name, T& target) {
    if (status_.ok() && object_.contains(name)) Read(name, target);
  }

  // The nested object `name`, or an empty one after an error.
  const nlohmann::ordered_json& Object(const char* name) {
    static const nlohmann::ordered_json& empty = *new nlohmann::ordered_json();
    if (!status_.ok()) return empty;
    const auto field = object_.find(name);
    if (field == object_.end() || !field->is_object()) {
      status_ = absl::DataLossError(absl::StrCat(document_, " has no object '", name, "'"));
      return empty;
    }
    return *field;
  }

  void Keep(const absl::Status& status) {
    if (status_.ok()) status_ = status;
  }
  const absl::Status& status() const { return status_; }

 private:
  const nlohmann::ordered_json& object_;
  std::string document_;
  absl::Status status_;
};

}  // namespace egosieve::tools
