#include "tools/suite/suite_run.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <set>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "kernels/base/parallel_for.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/exit_code.h"
#include "tools/run_folder/atomic_file.h"
#include "tools/suite/child_process.h"
#include "vision/frame/frame_source.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

// The last line of a log that is not empty.
std::string LastLine(const std::string& path) {
  const absl::StatusOr<std::string> text = ReadFile(path);
  if (!text.ok()) return "";
  std::string last;
  for (absl::string_view line : absl::StrSplit(*text, '\n', absl::SkipWhitespace())) {
    last = std::string(line);
  }
  return last;
}

// Largest number of frames; 0: no limit.
int64_t MostFrames(const SuiteOptions& options, double rate) {
  if (!(options.max_seconds > 0.0)) return options.max_frames;
  const int64_t frames = std::max<int64_t>(1, std::llround(options.max_seconds * rate));
  return options.max_frames > 0 ? std::min(frames, options.max_frames) : frames;
}

// Runs the program with its share of the cores; its log lies beside the run, as NAME with `suffix`.
// `what` describes the work in errors.
absl::Status RunProgram(std::vector<std::string> arguments, const std::string& run,
                        const char* suffix, const char* what, const SuiteOptions& options,
                        const std::function<bool()>& stop_requested) {
  const int threads = std::max(1, options.cores / options.jobs);
  ChildCommand command;
  command.arguments = std::move(arguments);
  command.arguments.insert(command.arguments.begin(), options.program);
  command.arguments.insert(command.arguments.end(),
                           {"--progress=none", absl::StrCat("--threads=", threads)});
  const fs::path logs = fs::path(run).parent_path() / "egosieve_logs";
  const std::string log = (logs / fs::path(run).filename()).string() + suffix;
  command.log_path = log;
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(logs.string()));
  EGOSIEVE_ASSIGN_OR_RETURN(const int code, RunChild(command, stop_requested));
  if (stop_requested()) return absl::CancelledError("interrupted");
  // A few unreadable frames do not prevent scoring of the others.
  if (code == static_cast<int>(ExitCode::kDone) ||
      code == static_cast<int>(ExitCode::kFramesFailed)) {
    return absl::OkStatus();
  }
  return absl::InternalError(
      absl::StrFormat("%s ended with code %d: %s; see %s", what, code, LastLine(log), log));
}

absl::Status Segment(const Sequence& sequence, const SuiteVariant& variant, const std::string& run,
                     const SuiteOptions& options, const std::function<bool()>& stop_requested) {
  std::vector<std::string> arguments = {"segment", sequence.frames, absl::StrCat("--out=", run),
                                        "--resume"};
  arguments.insert(arguments.end(), variant.flags.begin(), variant.flags.end());
  EGOSIEVE_ASSIGN_OR_RETURN(const double rate, RateOf(sequence));
  arguments.push_back(absl::StrCat("--fps=", rate));
  if (const int64_t frames = MostFrames(options, rate); frames > 0) {
    arguments.push_back(absl::StrCat("--max_frames=", frames));
  }
  arguments.insert(arguments.end(), options.segment_flags.begin(), options.segment_flags.end());
  return RunProgram(std::move(arguments), run, ".log", "segmenting", options, stop_requested);
}

FurtherTruth FurtherTruthOf(const Sequence& sequence, const SuiteOptions& options) {
  FurtherTruth truth = FindFurtherTruth(sequence.frames);
  if (!truth.poses.empty() && truth.camera.empty()) truth.camera = options.true_camera;
  return truth;
}

absl::Status RunSequence(const SuiteOptions& options, const SuiteVariant& variant,
                         const std::function<bool()>& stop_requested, SequenceResult& result) {
  const std::string path =
      (fs::path(options.out) / "runs" / result.profile / result.sequence.name).string();
  EGOSIEVE_RETURN_IF_ERROR(Segment(result.sequence, variant, path, options, stop_requested));
  if (options.masks) {
    EGOSIEVE_RETURN_IF_ERROR(RunProgram({"reconstruct", path}, path, ".masks.log", "making masks",
                                        options, stop_requested));
  }
  EGOSIEVE_ASSIGN_OR_RETURN(const RunFolder folder, RunFolder::Open(path));
  EGOSIEVE_ASSIGN_OR_RETURN(const RunDescription description, folder.ReadDescription());
  result.frames = description.frames_answered;
  if (result.frames > 0) {
    result.seconds_per_frame = description.seconds / static_cast<double>(result.frames);
  }
  EGOSIEVE_ASSIGN_OR_RETURN(RunEvaluation run,
                            EvaluateRun(folder, result.sequence.truth, options.evaluate,
                                        [&] { return !stop_requested(); }));
  EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(folder.File("eval.json"), ToText(run.evaluation)));
  EGOSIEVE_RETURN_IF_ERROR(WriteFileAtomically(folder.File("eval.csv"), ToCsv(run.evaluation)));
  EGOSIEVE_ASSIGN_OR_RETURN(
      result.further,
      ScoreFurther(folder, FurtherTruthOf(result.sequence, options), options.further));
  result.run = std::move(run);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<double> RateOf(const Sequence& sequence) {
  const std::string path = FindFurtherTruth(sequence.frames).camera;
  if (path.empty()) return vision::FrameSourceOptions().nominal_rate_hz;
  EGOSIEVE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  const absl::StatusOr<CameraTruth> camera = ParseCamera(text);
  if (!camera.ok()) {
    return absl::DataLossError(absl::StrCat(path, ": ", camera.status().message()));
  }
  return camera->frames_per_second.value_or(vision::FrameSourceOptions().nominal_rate_hz);
}

SuiteVariant VariantOfProfile(const std::string& profile) {
  return {profile, {absl::StrCat("--profile=", profile)}};
}

absl::StatusOr<SuiteVariant> ParseVariant(absl::string_view text) {
  const size_t equals = text.find('=');
  const absl::string_view name = text.substr(0, equals);
  const bool is_name = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return absl::ascii_isalnum(c) || c == '_' || c == '-' || c == '+';
  });
  if (equals == absl::string_view::npos || !is_name) {
    return absl::InvalidArgumentError(
        absl::StrCat("variant \"", text,
                     "\" is not NAME=FLAGS, NAME of letters, digits, _, - and +; write, say, "
                     "\"no_road=--evidence=epipolar,negative_depth,three_view,accumulation,"
                     "own_vehicle\""));
  }
  return SuiteVariant{std::string(name),
                      absl::StrSplit(text.substr(equals + 1), ' ', absl::SkipEmpty())};
}

absl::StatusOr<std::vector<SuiteVariant>> ParseVariants(absl::string_view profiles,
                                                        const std::vector<std::string>& variants) {
  std::vector<SuiteVariant> parsed;
  for (const absl::string_view profile : absl::StrSplit(profiles, ',', absl::SkipEmpty())) {
    parsed.push_back(VariantOfProfile(std::string(profile)));
  }
  for (const std::string& text : variants) {
    EGOSIEVE_ASSIGN_OR_RETURN(SuiteVariant variant, ParseVariant(text));
    parsed.push_back(std::move(variant));
  }
  return parsed;
}

absl::Status SuiteOptions::Validate() const {
  if (program.empty() || out.empty()) {
    return absl::InvalidArgumentError("a suite needs a program and a folder to write");
  }
  if (variants.empty()) {
    return absl::InvalidArgumentError("no profile; give one at least, as in --profiles=default");
  }
  std::set<std::string> names;
  for (const SuiteVariant& variant : variants) {
    if (!names.insert(variant.name).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("two variants have the name ", variant.name, "; give each its own"));
    }
  }
  if (jobs < 1 || jobs > 256 || cores < 1) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "jobs = %d, cores = %d; they must be from 1 to 256, and at least 1", jobs, cores));
  }
  return evaluate.scores.Validate();
}

absl::StatusOr<std::vector<SequenceResult>> RunSuite(const SequenceList& list,
                                                     const SuiteOptions& options,
                                                     const std::function<bool()>& stop_requested,
                                                     const std::function<void()>& after_sequence) {
  EGOSIEVE_RETURN_IF_ERROR(options.Validate());
  std::vector<SequenceResult> results;
  for (const Sequence& sequence : list.sequences) {
    for (const SuiteVariant& variant : options.variants) {
      SequenceResult result;
      result.sequence = sequence;
      result.profile = variant.name;
      results.push_back(std::move(result));
    }
  }
  std::mutex mutex;
  const auto count = static_cast<int64_t>(results.size());
  kernels::ParallelFor(count, {.threads = options.jobs}, [&](int64_t i) {
    if (stop_requested()) return;
    results[i].status = RunSequence(options, options.variants[i % options.variants.size()],
                                    stop_requested, results[i]);
    const std::lock_guard lock(mutex);
    after_sequence();
  });
  if (stop_requested()) {
    return absl::CancelledError(
        absl::StrCat("interrupted; the runs in ", options.out, " go on where they are"));
  }
  return results;
}

}  // namespace egosieve::tools
