// egosieve segment INPUT --out=DIR: a drive's run folder.
#include <string>

#include "tools/cli/command.h"
#include "tools/segment/segment_call.h"
#include "tools/segment/segment_run.h"

namespace egosieve::tools {
namespace {

class SegmentCommand : public Command {
 public:
  std::string name() const override { return "segment"; }
  std::string summary() const override {
    return "Segments a drive: maps of what moves by itself, and a line of the log per frame.";
  }
  std::string example() const override {
    return "egosieve segment drive.mp4 --out=out/drive\n"
           "egosieve segment drive.mp4 -o out/no_prior --set location_prior=0\n"
           "egosieve segment drive.mp4 --max-frames=100\n"
           "egosieve segment 'frames/*.png' --out=out/frames --stride=3 --profile=paper";
  }
  void AddFlags(CLI::App& app) override { call_.AddFlags(app); }
  absl::StatusOr<ExitCode> Run() override { return RunSegment(call_); }

 private:
  SegmentCall call_;
};

}  // namespace

std::unique_ptr<Command> MakeSegmentCommand() { return std::make_unique<SegmentCommand>(); }

}  // namespace egosieve::tools
