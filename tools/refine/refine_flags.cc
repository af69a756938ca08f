#include "tools/refine/refine_flags.h"

#include <CLI/CLI.hpp>

#include "kernels/base/status_macros.h"
#include "tools/cli/object_flags.h"

namespace egosieve::tools {

void RefineFlags::AddFlags(CLI::App& app) {
  app.add_option("DIR", directory,
                 "The run folder; its masks/, ids/, full/ and tracks.csv are written")
      ->required()
      ->type_name("")
      ->configurable(false);
  app.add_option("--what", what,
                 "What is written, by commas: masks, ids, tracks, objects, probability, "
                 "deviation, class")
      ->capture_default_str()
      ->type_name("WORDS");
  app.add_option("--mask_low", options.mask.low,
                 "Probability of moving from which a pixel of a mask is moving, where its region "
                 "holds one of --mask_high; others are static")
      ->capture_default_str()
      ->type_name("P");
  app.add_option("--mask_high", options.mask.high,
                 "Probability that a moving region of a mask holds somewhere")
      ->capture_default_str()
      ->type_name("P");
  app.add_flag("--causal", options.window.link.causal,
               "Each frame from itself and the frames before it, as for a live camera");
  app.add_flag("--resume", options.resume,
               "Continue where the same command stopped; start it where there is none");
  app.add_option("--input", options.input, "Where the run's input is now, if it was moved")
      ->type_name("PATH");
  app.add_option("--static_below", options.classes.static_below,
                 "Probability of moving below which a pixel's class is static (0)")
      ->type_name("P");
  app.add_option("--dynamic_above", options.classes.dynamic_above,
                 "Probability of moving above which a pixel's class is dynamic (255)")
      ->type_name("P");
  AddObjectFlags(app, options.objects);
  range.AddFlags(app);
  threads.AddFlag(app);
  device.AddFlag(app);
  progress.AddFlag(app);
  result.AddFlag(app);
}

absl::StatusOr<RefineOptions> RefineFlags::MakeOptions() const {
  RefineOptions made = options;
  EGOSIEVE_ASSIGN_OR_RETURN(made.what, ProductChoice::FromText(what));
  EGOSIEVE_RETURN_IF_ERROR(made.Validate());
  return made;
}

}  // namespace egosieve::tools
