// The flags --object_low and --object_high: the thresholds of an object (map_objects.h).
#pragma once

#include <CLI/CLI.hpp>

#include "tools/cli/checks.h"
#include "vision/objects/map_objects.h"

namespace egosieve::tools {

inline void AddObjectFlags(CLI::App& app, vision::ObjectThresholds& thresholds) {
  app.add_option("--object_low", thresholds.low,
                 "Probability of moving from which connected pixels are one object")
      ->check(Between(0.0, 1.0))
      ->capture_default_str()
      ->type_name("P");
  app.add_option("--object_high", thresholds.high,
                 "Probability of moving that an object has somewhere, to be one")
      ->check(Between(0.0, 1.0))
      ->capture_default_str()
      ->type_name("P");
}

}  // namespace egosieve::tools
