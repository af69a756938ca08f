// What the program writes and prints agrees with tools/schema, by Debian's python3-jsonschema;
// skipped where that is absent.
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"
#include "tests/testing/fresh_folder.h"
#include "tests/tools/testing/patch_drive.h"
#include "tests/tools/testing/program.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

// check.py SCHEMA FILE: FILE holds one JSON text, or one a line where it ends with "l". Every
// schema must also refuse each value with a field more and with any required field less, or it
// would say nothing of new fields.
constexpr char kScript[] = R"(
import copy, json, sys, jsonschema
schema = json.load(open(sys.argv[1]))
jsonschema.Draft7Validator.check_schema(schema)
validator = jsonschema.Draft7Validator(schema)
text = open(sys.argv[2]).read()
values = [json.loads(line) for line in text.splitlines()] if sys.argv[2].endswith("l") else [json.loads(text)]
assert values, "nothing to check"
for value in values:
    errors = [f"{list(error.path)}: {error.message[:200]} {[e.message[:200] for e in error.context or []]}"
              for error in validator.iter_errors(value)]
    assert not errors, (errors, value)
    for part in value if isinstance(value, list) else [value]:
        part["no_such_field"] = 1
        assert not validator.is_valid(value), "a field that the schema does not know passes"
        del part["no_such_field"]
    if isinstance(value, dict):
        for name in schema.get("required", ["command", "schema_version"]):
            less = copy.deepcopy(value)
            del less[name]
            assert not validator.is_valid(less), f"{name} is not needed"
print("ok", len(values))
)";

class Schema : public testing::Test {
 protected:
  Schema() : root_(FreshFolder()) {
    WritePatchDrive(root_, SmallPatchDrive(6));
    EXPECT_TRUE(WriteFileAtomically(root_ + "/check.py", kScript).ok());
  }

  // "ok N", or what is wrong.
  std::string Check(const std::string& schema, const std::string& file) const {
    return ShellOutput(absl::StrCat("/usr/bin/python3 ", root_, "/check.py ", "tools/schema/",
                                    schema, ".schema.json ", file, " 2>&1 | tail -n 1"));
  }

  static bool IsThere() {
    return std::system("/usr/bin/python3 -c 'import jsonschema' >/dev/null 2>&1") == 0;
  }

  // Runs the program and keeps what it prints with --json.
  void Run(std::vector<std::string> arguments) {
    arguments.push_back("--json");
    const ProgramOutcome outcome = RunProgram(arguments);
    ASSERT_EQ(outcome.code, 0) << arguments[0] << ": " << outcome.err;
    ASSERT_FALSE(outcome.out.empty()) << arguments[0];
    results_ += outcome.out;
  }

  void MakeRun() {
    Run({"segment", root_ + "/frames", "--out=" + root_ + "/run", "--budget=100", "--stride=8",
         "--checkpoint_every=3", "--progress=none"});
    Run({"refine", root_ + "/run", "--progress=none"});
  }

  std::string root_;
  std::string results_;
};

TEST_F(Schema, OfTheFilesOfARun) {
  if (!IsThere()) GTEST_SKIP() << "/usr/bin/python3 has no jsonschema";
  MakeRun();
  EXPECT_EQ(Check("run", root_ + "/run/run.json"), "ok 1\n");
  EXPECT_EQ(Check("frame_line", root_ + "/run/frames.jsonl"), "ok 6\n");
  EXPECT_EQ(Check("camera", root_ + "/run/camera.json"), "ok 1\n");
  EXPECT_EQ(Check("shots", root_ + "/run/shots.json"), "ok 1\n");
  EXPECT_EQ(Check("objects", root_ + "/run/full/000004.objects.json"), "ok 1\n");
  ASSERT_TRUE(WriteFileAtomically(root_ + "/frames/000006.png", "no picture").ok());
  const ProgramOutcome damaged = RunProgram({"segment", root_ + "/frames", "--out=" + root_ + "/b",
                                             "--stride=8", "--profile=paper", "--progress=none"});
  ASSERT_EQ(damaged.code, 4) << damaged.err;
  EXPECT_EQ(Check("run", root_ + "/b/run.json"), "ok 1\n");
  EXPECT_EQ(Check("frame_line", root_ + "/b/frames.jsonl"), "ok 7\n");
}

TEST_F(Schema, OfWhatCommandsPrint) {
  if (!IsThere()) GTEST_SKIP() << "/usr/bin/python3 has no jsonschema";
  MakeRun();
  const std::string run = root_ + "/run";
  for (const std::string range : {"to", "from"}) {
    Run({"segment", root_ + "/frames", "--out=" + root_ + "/" + range, "--" + range + "=3",
         "--budget=100", "--stride=8", "--progress=none"});
  }
  Run({"merge", root_ + "/to", root_ + "/from"});
  Run({"render", run, "--progress=none"});
  Run({"report", run, "--progress=none"});
  Run({"masks", run, "--for=colmap", "--out=" + root_ + "/colmap", "--progress=none"});
  Run({"masks", run, "--out=" + root_ + "/plain", "--progress=none"});
  for (const auto& [name, text] :
       {std::pair("cameras", "1 SIMPLE_PINHOLE 160 96 150 80 48\n"),
        std::pair("images", "1 1 0 0 0 0 0 0 1 000003.png\n\n"), std::pair("points3D", "")}) {
    ASSERT_TRUE(WriteFileAtomically(absl::StrCat(root_, "/", name, ".txt"), text).ok());
  }
  Run({"points", root_, "--masks=" + root_ + "/colmap", "--out=" + root_ + "_points",
       "--progress=none"});
  results_ += RunEvaluation({run, "--truth=" + root_ + "/masks", "--json", "--no-plots"}).out;
  Run({"synthesize", "--frames=2", "--width=64", "--height=48", "--out=" + root_ + "/drive",
       "--progress=none"});
  Run({"devices"});
  ASSERT_TRUE(
      WriteFileAtomically(root_ + "/drives.toml", "[a]\npath = 'frames'\nout = 'of_batch'\n").ok());
  Run({"batch", root_ + "/drives.toml", "--plan"});
  Run({"batch", root_ + "/drives.toml", "--status"});
  Run({"batch", root_ + "/drives.toml"});
  ASSERT_TRUE(WriteFileAtomically(root_ + "/results.jsonl", results_).ok());
  EXPECT_EQ(Check("result", root_ + "/results.jsonl"),
            absl::StrCat("ok ", CountLines(results_), "\n"));
  EXPECT_EQ(Check("camera", root_ + "/drive/camera.json"), "ok 1\n");
}

}  // namespace
}  // namespace egosieve::tools
