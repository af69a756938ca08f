// Searches for the kernels' shapes that run fastest on a device (kernels/runtime/tuning.h).
//
// The search goes along one coordinate after another: each field is tried at its candidate values
// with the others fixed. The fastest value replaces the present one if it is faster by more than
// `least_gain`. A shape's time is the least of several runs of the dense posterior: means alone for
// the fields of the mean's kernel, with variances for those of the factor's kernel. The results of
// every candidate are compared with those of the initial shape. A candidate is dropped if its
// results differ by more than rounding, or if it does not compile or run.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "kernels/runtime/context.h"
#include "kernels/runtime/tuning.h"

namespace egosieve::tune {

struct TuneOptions {
  std::string device;              // as kernels::ContextOptions::device
  int64_t training_points = 2000;  // of the model that is timed
  int64_t mean_queries = 32768;
  int64_t variance_queries = 1536;
  int repeats = 5;           // runs of a shape, of which the fastest counts
  double least_gain = 0.02;  // as a fraction of the time; smaller changes are noise
  // Start of the search; unset: the device's table, or its defaults.
  std::optional<kernels::KernelTuning> begin;
  // Names of KernelTuning's fields to search; empty: all.
  std::vector<std::string> fields;
  // Called with a line for each shape that was timed; may be empty.
  std::function<void(const std::string&)> progress;
};

struct TuneResult {
  std::string device;  // its name
  kernels::KernelTuning before;
  kernels::KernelTuning after;
  double mean_seconds_before = 0.0;
  double mean_seconds_after = 0.0;
  double variance_seconds_before = 0.0;
  double variance_seconds_after = 0.0;
  int shapes_timed = 0;
  int shapes_dropped = 0;
};

// FailedPrecondition for the reference, which has no shapes. Writes nothing; use
// kernels::SaveTuning.
absl::StatusOr<TuneResult> Tune(const TuneOptions& options);

}  // namespace egosieve::tune
