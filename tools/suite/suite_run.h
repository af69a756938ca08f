// Sets of flags of segment, for `egosieve lab compare`.
#ifndef EGOSIEVE_TOOLS_SUITE_SUITE_RUN_H_
#define EGOSIEVE_TOOLS_SUITE_SUITE_RUN_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace egosieve::tools {

// One set of flags of segment; its name is that of a folder.
struct SuiteVariant {
  std::string name;
  std::vector<std::string> flags;
};

// The profiles, named by commas, then the variants: "NAME=FLAGS", flags separated by spaces.
// InvalidArgument if a name is missing or has other characters than letters, digits, '_', '-' and
// '+'.
absl::StatusOr<std::vector<SuiteVariant>> ParseVariants(absl::string_view profiles,
                                                        const std::vector<std::string>& variants);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_SUITE_SUITE_RUN_H_
