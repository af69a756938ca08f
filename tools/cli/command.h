// A command of the program `egosieve`: the interface between its folder and the command line.
//
// A command's folder defines one of the functions below, tools/egosieve.cc calls them. The command
// line (command_line.h) builds a parser, lets the command add its flags, and runs it:
//
//   class SegmentCommand : public Command {
//     std::string name() const override { return "segment"; }
//     std::string summary() const override { return "Segments a drive."; }
//     std::string example() const override { return "egosieve segment drive.mp4 --out=out"; }
//     void AddFlags(CLI::App& app) override { app.add_option("--out", out_, "...")->required(); }
//     absl::StatusOr<ExitCode> Run() override { ... }
//   };
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "tools/cli/exit_code.h"

namespace CLI {
class App;
}

namespace egosieve::tools {

// The present name of a command: `reconstruct` is what refine was called before.
inline std::string PresentName(const std::string& name) {
  return name == "reconstruct" ? "refine" : name;
}

class Command {
 public:
  virtual ~Command() = default;

  virtual std::string name() const = 0;
  // One sentence.
  virtual std::string summary() const = 0;
  // Command lines that can be run as they are, one per line; they end the text of --help.
  virtual std::string example() const = 0;

  // Binds flags to members. Lower case with underscores, units in the name or the description.
  virtual void AddFlags(CLI::App& app) = 0;

  // Called once the flags have been read. A Status is printed as one line ("what; what to do") and
  // gives the exit code (exit_code.h); progress goes to stderr, results to stdout.
  virtual absl::StatusOr<ExitCode> Run() = 0;
};

// Each in tools/NAME.
std::unique_ptr<Command> MakeBatchCommand();
std::unique_ptr<Command> MakeDevicesCommand();
std::unique_ptr<Command> MakeMasksCommand();
std::unique_ptr<Command> MakeMergeCommand();
std::unique_ptr<Command> MakePointsCommand();
std::unique_ptr<Command> MakeRefineCommand();
std::unique_ptr<Command> MakeRenderCommand();
std::unique_ptr<Command> MakeReportCommand();
std::unique_ptr<Command> MakeRunCommand();
std::unique_ptr<Command> MakeSegmentCommand();
std::unique_ptr<Command> MakeSynthesizeCommand();
std::unique_ptr<Command> MakeTuneCommand();

}  // namespace egosieve::tools
