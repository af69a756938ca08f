#include "tools/suite/suite_run.h"

#include <algorithm>
#include <filesystem>
#include <memory>
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

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

// The last line of a log that says something.
std::string LastLine(const std::string& path) {
  const absl::StatusOr<std::string> text = ReadFile(path);
  if (!text.ok()) return "";
  std::string last;
  for (absl::string_view line : absl::StrSplit(*text, '\n', absl::SkipWhitespace())) {
    last = std::string(line);
  }
  return last;
}

absl::Status Segment(const Sequence& sequence, const SuiteVariant& variant, const std::string& run,
                     const SuiteOptions& options, const std::function<bool()>& stop_requested) {
  const int threads = std::max(1, options.cores / options.jobs);
  ChildCommand command;
  command.arguments = {options.program,
                       "segment",
                       sequence.frames,
                       absl::StrCat("--out=", run),
                       "--resume",
                       "--progress=none",
                       absl::StrCat("--threads=", threads)};
  command.arguments.insert(command.arguments.end(), variant.flags.begin(), variant.flags.end());
  if (options.max_frames > 0) {
    command.arguments.push_back(absl::StrCat("--max_frames=", options.max_frames));
  }
  command.arguments.insert(command.arguments.end(), options.segment_flags.begin(),
                           options.segment_flags.end());
  command.environment["POCL_MAX_PTHREAD_COUNT"] = absl::StrCat(threads);
  command.log_path = run + ".log";
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(fs::path(run).parent_path().string()));
  EGOSIEVE_ASSIGN_OR_RETURN(const int code, RunChild(command, stop_requested));
  if (stop_requested()) return absl::CancelledError("interrupted");
  // Some frames that cannot be read are no reason not to score the others.
  if (code == static_cast<int>(ExitCode::kDone) ||
      code == static_cast<int>(ExitCode::kFramesFailed)) {
    return absl::OkStatus();
  }
  return absl::InternalError(absl::StrFormat("segmenting ended with code %d: %s; see %s", code,
                                             LastLine(command.log_path), command.log_path));
}

absl::Status RunSequence(const SuiteOptions& options, const SuiteVariant& variant,
                         const std::function<bool()>& stop_requested, SequenceResult& result) {
  const std::string path =
      (fs::path(options.out) / "runs" / result.profile / result.sequence.name).string();
  EGOSIEVE_RETURN_IF_ERROR(Segment(result.sequence, variant, path, options, stop_requested));
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
  result.run = std::move(run);
  return absl::OkStatus();
}

}  // namespace

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
                     "\"no_road=--evidence=epipolar,negative_depth,three_view\""));
  }
  return SuiteVariant{std::string(name),
                      absl::StrSplit(text.substr(equals + 1), ' ', absl::SkipEmpty())};
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
