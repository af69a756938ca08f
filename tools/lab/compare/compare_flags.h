// The flags of `egosieve lab compare`, and the options that they make.
#ifndef EGOSIEVE_TOOLS_LAB_COMPARE_COMPARE_FLAGS_H_
#define EGOSIEVE_TOOLS_LAB_COMPARE_COMPARE_FLAGS_H_

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tools/lab/compare/compare_run.h"
#include "tools/lab/compare/drive_comparison.h"
#include "tools/segment/segment_flags.h"
#include "tools/suite/suite_run.h"

namespace egosieve::tools {

class CompareFlags {
 public:
  // Adds segment's flags, too.
  void AddFlags(CLI::App& app);

  absl::StatusOr<CompareOptions> MakeOptions() const;

 private:
  void AddDriveFlags(CLI::App& app);
  void AddProfileFlags(CLI::App& app);
  absl::StatusOr<std::vector<SuiteVariant>> Variants() const;
  // The variant's flags override those that were given to all.
  absl::StatusOr<ComparisonOptions> OptionsOf(const SuiteVariant& variant) const;

  std::string methods_;
  std::string scenarios_ = "street,junction,crossing,oncoming";
  std::string profiles_ = "paper,default";
  std::vector<std::string> variants_;
  const CLI::Option* profile_option_ = nullptr;
  const CLI::Option* scenarios_option_ = nullptr;
  CompareOptions options_;        // without the profiles and scenarios
  ComparisonOptions comparison_;  // without the segmenter's, which differ per profile
  SegmentFlags segment_;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_LAB_COMPARE_COMPARE_FLAGS_H_
