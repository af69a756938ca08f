// Runs the drives of a batch on this machine, several at the same time. Each step of a drive is a
// line on stderr; the page (index_page.h) is written anew every few seconds, and at the end.
#ifndef EGOSIEVE_TOOLS_BATCH_DRIVES_RUN_H_
#define EGOSIEVE_TOOLS_BATCH_DRIVES_RUN_H_

#include <chrono>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "tools/batch/drive_job.h"
#include "tools/batch/manifest.h"
#include "tools/cli/result_flag.h"

namespace egosieve::tools {

class DrivesRun {
 public:
  // index: the page's path.
  DrivesRun(std::vector<BatchEntry> entries, std::string index)
      : entries_(std::move(entries)), index_(std::move(index)), outcomes_(entries_.size()) {}

  // `jobs` drives at the same time, which share the threads; ends early if interrupted.
  // program: egosieve.
  void Run(const std::string& program, int jobs);
  // Prints the table of all drives, and warns if the page could not be written.
  void Tell(const ResultFlag& result) const;

  // Whether a drive or some of its frames failed.
  bool has_failed() const;

 private:
  void Say(size_t i, const std::string& what);
  // Where there is news. A page that cannot be written does not stop the drives; the last failure
  // is reported.
  void WritePage();

  std::vector<BatchEntry> entries_;
  std::string index_;
  std::vector<DriveOutcome> outcomes_;
  absl::Status index_status_;
  bool has_news_ = false;
  std::chrono::steady_clock::time_point page_due_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_BATCH_DRIVES_RUN_H_
