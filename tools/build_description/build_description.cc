#include "tools/build_description/build_description.h"

#include "absl/strings/str_cat.h"

namespace egosieve::tools {

extern const char kBuildLabel[];

namespace {

#if defined(__clang__)
constexpr char kCompiler[] = "Clang " __clang_version__;
#else
constexpr char kCompiler[] = "GCC " __VERSION__;
#endif

#if defined(__AVX512F__)
constexpr char kVectors[] = "AVX-512";
#elif defined(__AVX2__)
constexpr char kVectors[] = "AVX2";
#elif defined(__x86_64__)
constexpr char kVectors[] = "SSE";
#else
constexpr char kVectors[] = "not x86-64";
#endif

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr char kMode[] = "with a sanitizer";
#elif defined(__OPTIMIZE__)
constexpr char kMode[] = "optimised";
#else
constexpr char kMode[] = "not optimised";
#endif

}  // namespace

std::string BuildDescription() {
  std::string commit = kBuildLabel;
  if (commit.empty() || commit == "redacted") commit = "unknown";  // Bazel's value without --stamp
  return absl::StrCat("commit ", commit, ", ", kCompiler, ", ", kVectors, ", ", kMode);
}

}  // namespace egosieve::tools
