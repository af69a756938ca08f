// egosieve render DIR: render/NNNNNN.png and overlay.mp4.
#include <CLI/CLI.hpp>
#include <string>

#include "tools/cli/checks.h"
#include "tools/cli/command.h"
#include "tools/cli/object_flags.h"
#include "tools/cli/switch_flag.h"
#include "tools/render/render_run.h"

namespace egosieve::tools {
namespace {

class RenderCommand : public Command {
 public:
  std::string name() const override { return "render"; }
  std::string summary() const override {
    return "Draws a run's movers, or its maps, over its frames, as a video and as images.";
  }
  std::string example() const override { return "egosieve render out/drive --object_high=0.9"; }

  void AddFlags(CLI::App& app) override {
    app.add_option("DIR", options_.directory,
                   "The run folder; its overlay.mp4, and with --images its render/, are written")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("--input", options_.input, "Where the run's input is now, if it was moved")
        ->type_name("PATH");
    AddObjectFlags(app, options_.overlay.objects);
    AddSwitch(app, "--movers", "--map", options_.movers,
              "Show the movers that refine has numbered, where it has; --map: the map");
    app.add_flag("--outlines", options_.overlay.outlines_only,
                 "Of movers, draw nothing but outlines");
    AddSwitch(app, "--legend", "--no_legend", options_.overlay.legend, "Draw the legend");
    app.add_flag("--images", options_.images, "Write each frame's overlay, too: render/NNNNNN.png");
    AddSwitch(app, "--video", "--no_video", options_.video, "Write overlay.mp4");
    app.add_option("--rate", options_.rate_hz, "The video's frames per second; 0: the input's")
        ->check(Between(0.0, 240.0))
        ->type_name("HZ");
    options_.range.AddFlags(app);
    options_.device.AddFlag(app);
    options_.progress.AddFlag(app);
    options_.result.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override { return RunRender(options_); }

 private:
  RenderOptions options_;
};

}  // namespace

std::unique_ptr<Command> MakeRenderCommand() { return std::make_unique<RenderCommand>(); }

}  // namespace egosieve::tools
