#include "kernels/cl/sources.h"

#include <string>

#include "absl/strings/str_split.h"
#include "gtest/gtest.h"

namespace egosieve::kernels {
namespace {

bool StartsWithAny(absl::string_view line, std::initializer_list<absl::string_view> prefixes) {
  for (const absl::string_view prefix : prefixes) {
    if (line.substr(0, prefix.size()) == prefix) return true;
  }
  return false;
}

// In C99 an inline function that is not static leaves a call that is not inlined to a definition
// elsewhere, which there is none of: compilers that do not inline refuse the program.
TEST(Sources, NoFunctionIsInlineAlone) {
  int functions = 0;
  for (const char* file :
       {"common.cl", "covariance.cl", "covariance_gradient.cl", "dense_posterior.cl",
        "dense_posterior_local.cl", "image.cl", "posterior_outputs.cl", "roofline.cl"}) {
    const std::string text(cl_sources::Text(file));
    ASSERT_FALSE(text.empty()) << file;
    for (const absl::string_view line : absl::StrSplit(text, '\n')) {
      // Declarations of functions start at the margin; so does what follows, which is none.
      if (line.find('(') == std::string::npos ||
          StartsWithAny(line, {" ", "#", "/", "}", "__kernel", "typedef"})) {
        continue;
      }
      ++functions;
      EXPECT_FALSE(StartsWithAny(line, {"inline"})) << file << ": " << line;
    }
  }
  EXPECT_GT(functions, 20);
}

}  // namespace
}  // namespace egosieve::kernels
