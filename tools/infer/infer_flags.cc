#include "tools/infer/infer_flags.h"

#include "tools/cli/checks.h"

namespace egosieve::tools {

void InferFlags::AddFlags(CLI::App& app) {
  app.add_option("DIR", target.run, "The run folder, which keeps the model of every frame")
      ->required()
      ->type_name("")
      ->configurable(false);
  app.add_option("--out", target.out, "The run folder to write; none: DIR itself")
      ->type_name("DIR");
  app.add_flag("--overwrite", target.overwrite,
               "Replace the run that --out holds; without --out, make existing maps again");
  app.add_option("--input", input, "Where the run's input is now, if it was moved")
      ->type_name("PATH");
  range.AddFlags(app);
  app.add_option("--every", every, "Makes each N-th map only, from the run's first frame on")
      ->check(AtLeast<int64_t>(1))
      ->type_name("N");
  app.add_option("--stride", stride,
                 "Pixels between neighbouring grid pixels; 0: the run's; others need --out")
      ->check(Between(0, 1000))
      ->type_name("PIXELS");
  threads.AddFlag(app);
  device.AddFlag(app);
  progress.AddFlag(app);
  result.AddFlag(app);
}

}  // namespace egosieve::tools
