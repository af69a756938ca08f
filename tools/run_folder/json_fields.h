// The fields of JSON objects, read and written by the same walk over a struct:
//
//   template <typename Point, typename Fields>  // Point: may be const
//   void Walk(Point& point, Fields& fields) { fields.Field("x", point.x); ... }
#pragma once

#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "tools/run_folder/json_name.h"

namespace egosieve::tools {

// Numbers by name, in an order of their own.
using NamedNumbers = std::vector<std::pair<std::string, double>>;

// Writes the fields of an object in the order of the walk.
class JsonWriter {
 public:
  template <typename T>
  void Field(const char* name, const T& value) {
    if constexpr (std::is_same_v<T, std::string>) {
      json_[name] = JsonName(value);
    } else {
      json_[name] = value;
    }
  }
  // What `make` gives, for readers of the file alone.
  template <typename Make>
  void Told(const char* name, const Make& make) {
    json_[name] = make();
  }
  // Left out, and where it is missing left as it is, if it is empty.
  template <typename T>
  void Optional(const char* name, const T& value) {
    if (!value.empty()) Field(name, value);
  }
  // null if it is empty.
  void OrNull(const char* name, const std::string& value) {
    json_[name] =
        value.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(JsonName(value));
  }
  void Numbers(const char* name, const NamedNumbers& numbers) {
    nlohmann::ordered_json& object = json_[name] = nlohmann::ordered_json::object();
    for (const auto& [key, value] : numbers) object[key] = value;
  }
  // walk: gets the writer of the nested object.
  template <typename Walk>
  void Object(const char* name, const Walk& walk) {
    JsonWriter nested;
    walk(nested);
    json_[name] = std::move(nested.json_);
  }

  const nlohmann::ordered_json& json() const { return json_; }

 private:
  nlohmann::ordered_json json_ = nlohmann::ordered_json::object();
};

// Reads the fields of an object; errors, DataLoss, name the field. The first one is kept, and later
// reads are skipped.
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
  void Field(const char* name, T& target) {
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
    } catch (const std::exception&) {
      status_ = absl::DataLossError(absl::StrCat(document_, ": field '", name, "' has the value ",
                                                 field->dump().substr(0, 60),
                                                 ", which is of another type"));
    }
  }
  template <typename Make>
  void Told(const char* /*name*/, const Make& /*make*/) {}
  template <typename T>
  void Optional(const char* name, T& target) {
    if (status_.ok() && object_.contains(name)) Field(name, target);
  }
  void OrNull(const char* name, std::string& target) {
    if (!object_.contains(name) || !object_[name].is_null()) Field(name, target);
  }
  void Numbers(const char* name, NamedNumbers& numbers) {
    Object(name, [&](JsonFields& nested) {
      for (const auto& [key, value] : nested.object_.items()) {
        nested.Field(key.c_str(), numbers.emplace_back(key, 0.0).second);
      }
    });
  }
  template <typename Walk>
  void Object(const char* name, const Walk& walk) {
    nlohmann::ordered_json object;
    Field(name, object);
    if (!status_.ok()) return;
    JsonFields nested(object, absl::StrCat(document_, ": '", name, "'"));
    if (nested.status_.ok()) walk(nested);
    status_ = nested.status_;
  }

  const absl::Status& status() const { return status_; }

 private:
  const nlohmann::ordered_json& object_;
  std::string document_;
  absl::Status status_;
};

}  // namespace egosieve::tools
