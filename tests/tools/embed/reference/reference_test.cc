// Every public symbol is documented: Doxygen, asked to say what is not, says nothing.
#include <fstream>
#include <string>

#include "gtest/gtest.h"
#include "tests/tools/embed/testing/installed_tree.h"

namespace egosieve::embed {
namespace {

// What Doxygen complains about in a copy of the headers; `more` is appended to one of them.
std::string Complaints(const std::string& name, const std::string& more) {
  const std::string folder = NewFolder(name);
  const std::string root = RunClean(".", "pwd").output;
  const std::string copy = "mkdir -p tools/embed/include && cp -rL '" + InstalledTree() +
                           "/include/egosieve' tools/embed/include/ && mkdir tools/embed/reference "
                           "&& cp '" +
                           InstalledTree() +
                           "'/share/doc/egosieve/*.md "
                           "tools/embed/reference/ && chmod -R u+w .";
  EXPECT_EQ(RunClean(folder, copy).code, 0);
  std::ofstream(folder + "/tools/embed/include/egosieve/types.h", std::ios::app) << more;
  const CommandOutcome outcome =
      RunClean(folder, "mkdir -p out && doxygen '" + root.substr(0, root.find('\n')) +
                           "/tools/embed/reference/Doxyfile'");
  EXPECT_EQ(outcome.code, 0) << outcome.output;
  return outcome.output;
}

TEST(Reference, LeavesNoPublicSymbolOut) {
  if (!HasProgram("doxygen")) GTEST_SKIP() << "there is no doxygen";
  EXPECT_EQ(Complaints("reference", ""), "");
}

TEST(Reference, WouldNoticeASymbolLeftOut) {
  if (!HasProgram("doxygen")) GTEST_SKIP() << "there is no doxygen";
  const std::string complaints = Complaints("unsaid", "\nint egosieve_unsaid(int argument);\n");
  EXPECT_NE(complaints.find("egosieve_unsaid"), std::string::npos) << complaints;
}

}  // namespace
}  // namespace egosieve::embed
