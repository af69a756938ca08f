#include "tests/tools/embed/testing/installed_tree.h"

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "gtest/gtest.h"

namespace egosieve::embed {
namespace {

constexpr char kArchive[] = "tools/embed/install/egosieve.tar";

std::string Quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string Variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : std::string(name) + "=" + Quoted(value) + " ";
}

CommandOutcome RunShell(const std::string& command) {
  CommandOutcome outcome;
  std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return outcome;
  std::array<char, 4096> piece;
  while (const size_t count = std::fread(piece.data(), 1, piece.size(), pipe)) {
    outcome.output.append(piece.data(), count);
  }
  const int status = pclose(pipe);
  outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return outcome;
}

std::string Unpack() {
  const std::string tree = NewFolder("installed");
  const CommandOutcome outcome =
      RunShell("tar --extract --file=" + std::string(kArchive) + " --directory=" + Quoted(tree));
  EXPECT_EQ(outcome.code, 0) << outcome.output;
  return outcome.code == 0 ? tree : "";
}

}  // namespace

CommandOutcome RunClean(const std::string& folder, const std::string& command,
                        const std::string& variables) {
  return RunShell("cd " + Quoted(folder) + " && env -i PATH=/usr/bin:/bin " + Variable("HOME") +
                  Variable("POCL_CACHE_DIR") + Variable("EGOSIEVE_CACHE_DIR") +
                  Variable("EGOSIEVE_DEVICE") + variables + " sh -c " + Quoted(command));
}

bool HasProgram(const std::string& name) {
  return RunClean("/", "command -v " + name + " >/dev/null").code == 0;
}

const std::string& InstalledTree() {
  static const std::string tree = Unpack();
  return tree;
}

std::string InstalledPythonFolder() {
  for (const auto& entry : std::filesystem::directory_iterator(InstalledTree() + "/lib")) {
    if (entry.path().filename().string().rfind("python3.", 0) == 0) {
      return entry.path().string() + "/site-packages";
    }
  }
  ADD_FAILURE() << "no lib/python3.* in " << InstalledTree();
  return "";
}

bool IsInstrumented() {
  return RunClean(InstalledTree(),
                  "nm -D --undefined-only lib/libegosieve.so.1 | grep -qE '__(a|t|ub)san_'")
             .code == 0;
}

std::string NewFolder(const std::string& name) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / name;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return std::filesystem::absolute(folder).string();
}

}  // namespace egosieve::embed
