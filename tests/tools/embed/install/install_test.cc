// The installed tree in a folder of its own: headers, libraries, packages and examples, as a user
// with another build system meets them.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>

#include "gtest/gtest.h"
#include "tests/tools/embed/testing/installed_tree.h"

namespace egosieve::embed {
namespace {

namespace fs = std::filesystem;

#define SKIP_WITHOUT(program) \
  if (!HasProgram(program)) GTEST_SKIP() << "there is no " program " to build with"
#define SKIP_INSTRUMENTED() \
  if (IsInstrumented()) GTEST_SKIP() << "plain programs cannot load libraries with a sanitizer"

// Small enough for seconds on the reference device.
constexpr char kSize[] = " --wells=150 --side=41";

std::string Bytes(const std::string& path) {
  std::ostringstream bytes;
  bytes << std::ifstream(path, std::ios::binary).rdbuf();
  return bytes.str();
}

// Every library that the loader takes lies in the tree or among the system's.
void ExpectOwnLibraries(const std::string& program) {
  const CommandOutcome ldd = RunClean("/", "ldd '" + program + "'");
  std::istringstream lines(ldd.output);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_EQ(line.find("not found"), std::string::npos) << line;
    const size_t arrow = line.find("=> ");
    if (arrow == std::string::npos) continue;
    const std::string path = line.substr(arrow + 3, line.rfind(" (") - arrow - 3);
    const bool system = path.rfind("/lib", 0) == 0 || path.rfind("/usr/lib", 0) == 0;
    const bool ours = fs::weakly_canonical(path).string().rfind(
                          fs::weakly_canonical(InstalledTree()).string() + "/lib/", 0) == 0;
    EXPECT_TRUE(system || ours) << program << ": " << line;
  }
}

// Builds with CMake what `project` says in a folder `name`.
CommandOutcome BuildWithCMake(const std::string& source, const std::string& name) {
  return RunClean(NewFolder(name), "cmake -S '" + source + "' -B . -DCMAKE_PREFIX_PATH='" +
                                       InstalledTree() + "' && cmake --build .");
}

// The folder of the C++ examples' programs, built once a process.
const std::string& CppExamples() {
  static const std::string folder = [] {
    const CommandOutcome built =
        BuildWithCMake(InstalledTree() + "/share/egosieve/examples/cpp", "cpp");
    EXPECT_EQ(built.code, 0) << built.output;
    return testing::TempDir() + "/cpp";
  }();
  return folder;
}

std::string CMakeProject(const std::string& name, const std::string& find) {
  const std::string folder = NewFolder(name);
  std::ofstream(folder + "/CMakeLists.txt")
      << "cmake_minimum_required(VERSION 3.13)\nproject(p CXX)\n" + find +
             "\nadd_executable(p p.cc)\ntarget_link_libraries(p egosieve::egosieve)\n";
  std::ofstream(folder + "/p.cc") << "#include \"egosieve/gaussian_process.hpp\"\n"
                                     "int main() { return egosieve_abi_version() - 1; }\n";
  return folder;
}

TEST(Headers, CompileAloneWithoutAnythingElse) {
  const std::string folder = NewFolder("headers");
  const std::string warnings = " -Wall -Wextra -Wpedantic -Werror -fsyntax-only -I '" +
                               InstalledTree() + "/include' -isystem /usr/include/eigen3 ";
  int headers = 0;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(InstalledTree() + "/include/egosieve")) {
    const std::string name = entry.path().filename().string();
    const bool c = entry.path().extension() == ".h";
    const std::string source = folder + "/" + name + (c ? ".c" : ".cc");
    std::ofstream(source) << "#include \"egosieve/" + name + "\"\nint unused;\n";
    std::string command =
        c ? "gcc -std=c99" + warnings + source + " && g++ -x c++ -std=c++17" + warnings + source
          : "g++ -std=c++17" + warnings + source;
    if (HasProgram("clang++")) command += " && clang++ -x c++ -std=c++17" + warnings + source;
    if (name == "eigen.hpp" && !fs::exists("/usr/include/eigen3/Eigen/Core")) continue;
    const CommandOutcome outcome = RunClean(folder, command);
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    ++headers;
  }
  EXPECT_GE(headers, 9);
}

TEST(Libraries, ShowTheInterfaceAndNothingElse) {
  for (const char* library : {"libegosieve.so.1", "libegosieve_vision.so.1"}) {
    const std::string path = InstalledTree() + "/lib/" + library;
    const CommandOutcome symbols =
        RunClean("/", "nm -D --defined-only '" + path + "' | awk '$2 != \"A\" {print $3}'");
    std::istringstream lines(symbols.output);
    int count = 0;
    for (std::string symbol; std::getline(lines, symbol); ++count) {
      EXPECT_EQ(symbol.rfind("egosieve_", 0), 0u) << library << " shows " << symbol;
    }
    EXPECT_GE(count, 9) << symbols.output;
    const CommandOutcome name = RunClean("/", "readelf -d '" + path + "' | grep SONAME");
    EXPECT_NE(name.output.find(library), std::string::npos) << name.output;
    ExpectOwnLibraries(path);
  }
  EXPECT_EQ(fs::read_symlink(InstalledTree() + "/lib/libegosieve.so"), "libegosieve.so.1");
}

TEST(Program, Runs) {
  SKIP_INSTRUMENTED();
  const CommandOutcome help = RunClean("/", "'" + InstalledTree() + "/bin/egosieve' --help");
  EXPECT_EQ(help.code, 0) << help.output;
  ExpectOwnLibraries(InstalledTree() + "/bin/egosieve");
  for (const char* const script : {"egosieve-eval", "egosieve-view"}) {
    const CommandOutcome told =
        RunClean("/", "'" + InstalledTree() + "/bin/" + script + "' --help");
    EXPECT_EQ(told.code, 0) << told.output;
  }
}

TEST(Program, HasItsManualPageCompletionAndSchemas) {
  const std::string share = InstalledTree() + "/share";
  EXPECT_EQ(Bytes(share + "/man/man1/egosieve.1").rfind(".TH EGOSIEVE 1", 0), 0u);
  const CommandOutcome completed = RunClean(
      "/", "bash -c '. \"" + share +
               "/bash-completion/completions/egosieve\"; COMP_WORDS=(egosieve seg); COMP_CWORD=1; "
               "_egosieve; echo $COMPREPLY'");
  EXPECT_EQ(completed.output, "segment\n");
  EXPECT_NE(Bytes(share + "/egosieve/schema/run.schema.json").find("\"$schema\""),
            std::string::npos);
}

TEST(Examples, OfThreeLanguagesGiveTheSameBits) {
  SKIP_WITHOUT("cmake");
  SKIP_WITHOUT("pkg-config");
  SKIP_INSTRUMENTED();
  const std::string& tree = InstalledTree();
  const std::string examples = tree + "/share/egosieve/examples";
  const std::string out = NewFolder("results");

  CommandOutcome ran = RunClean(CppExamples(), "./kriging --out='" + out + "/cpp'" + kSize);
  ASSERT_EQ(ran.code, 0) << ran.output;
  ExpectOwnLibraries(CppExamples() + "/kriging");
  const std::string expected = Bytes(out + "/cpp");
  ASSERT_EQ(expected.size(), 2 * 41 * 41 * sizeof(float));

  const std::string c = NewFolder("c");
  const std::string compile = "gcc -std=c99 -pedantic -Wall -Werror -O2 '" + examples +
                              "/c/kriging.c' $(pkg-config --cflags ";
  const std::string package_path = "PKG_CONFIG_PATH='" + tree + "/lib/pkgconfig'";
  ran = RunClean(c,
                 compile + "--libs egosieve) -Wl,-rpath,'" + tree + "/lib' -lm -o shared && " +
                     compile +
                     "--static --libs egosieve | sed s/-legosieve/-l:libegosieve.a/) -lm -o whole",
                 package_path);
  ASSERT_EQ(ran.code, 0) << ran.output;
  for (const std::string program : {"shared", "whole"}) {
    ran = RunClean(c, "./" + program + " --out='" + out + "/" + program + "'" + kSize);
    ASSERT_EQ(ran.code, 0) << ran.output;
    ExpectOwnLibraries(c + "/" + program);
    EXPECT_TRUE(Bytes(out + "/" + program) == expected) << program;
  }

  if (RunClean("/", "python3 -c 'import numpy'").code != 0) {
    GTEST_SKIP() << "there is no python3 with numpy to run the third with";
  }
  ran = RunClean(out, "python3 '" + examples + "/python/kriging.py' --out=python" + kSize,
                 "PYTHONPATH='" + InstalledPythonFolder() + "'");
  ASSERT_EQ(ran.code, 0) << ran.output;
  EXPECT_TRUE(Bytes(out + "/python") == expected);
}

TEST(Examples, PythonPlots) {
  SKIP_INSTRUMENTED();
  if (RunClean("/", "python3 -c 'import matplotlib'").code != 0) {
    GTEST_SKIP() << "there is no python3 with matplotlib";
  }
  for (const std::string example :
       {"kriging.py' --plot=plot.png --wells=60 --side=30", "tutorial.py' plot.png 200"}) {
    SCOPED_TRACE(example);
    const std::string folder = NewFolder("plot");
    const CommandOutcome ran = RunClean(
        folder, "python3 '" + InstalledTree() + "/share/egosieve/examples/python/" + example,
        "PYTHONPATH='" + InstalledPythonFolder() + "'");
    EXPECT_EQ(ran.code, 0) << ran.output;
    EXPECT_EQ(Bytes(folder + "/plot.png").substr(0, 4), "\x89PNG");
  }
}

TEST(Examples, SegmentersFindTheSquare) {
  SKIP_WITHOUT("cmake");
  SKIP_INSTRUMENTED();
  const std::string examples = InstalledTree() + "/share/egosieve/examples";
  CommandOutcome ran = RunClean(CppExamples(), "./segment --frames=3");
  EXPECT_EQ(ran.code, 0) << ran.output;
  ExpectOwnLibraries(CppExamples() + "/segment");
  if (RunClean("/", "python3 -c 'import numpy'").code != 0) {
    GTEST_SKIP() << "there is no python3 with numpy";
  }
  ran = RunClean("/", "python3 '" + examples + "/python/segment.py' --frames=3",
                 "PYTHONPATH='" + InstalledPythonFolder() + "'");
  EXPECT_EQ(ran.code, 0) << ran.output;
}

// The program of a document under a heading, "": of what stands before the first.
std::string ProgramOf(const std::string& document, const std::string& heading) {
  std::ifstream lines(InstalledTree() + "/share/doc/egosieve/" + document);
  std::string program;
  bool found = heading.empty();
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("## ", 0) == 0) found = line == heading;
    if (found && line.rfind("    ", 0) == 0) program += line.substr(4) + "\n";
  }
  return program;
}

TEST(Examples, OfTheReferenceRunOnAQueue) {
  SKIP_WITHOUT("pkg-config");
  SKIP_INSTRUMENTED();
  const char* device = std::getenv("EGOSIEVE_DEVICE");
  if (device != nullptr && std::string(device) == "reference") {
    GTEST_SKIP() << "the reference has no queues";
  }
  if (!fs::exists("/usr/include/CL/cl.h")) GTEST_SKIP() << "there are no headers of OpenCL";
  constexpr char kHeading[] = "## On a queue of your own";
  const std::string folder = NewFolder("queue");
  std::ofstream(folder + "/queue.c") << ProgramOf("c.md", kHeading);
  std::ofstream(folder + "/queue.cc") << ProgramOf("cpp.md", kHeading);
  const std::string flags =
      " -Wall -Werror queue.$1 -o queue_$1 $(pkg-config --cflags --libs "
      "egosieve) -lOpenCL -lm -Wl,-rpath,'" +
      InstalledTree() + "/lib'";
  std::string results[2];
  for (const bool cpp : {false, true}) {
    const std::string command = std::string("set -- ") + (cpp ? "cc" : "c") + " && " +
                                (cpp ? "g++ -std=c++17" : "gcc -std=c99 -pedantic") + flags +
                                " && ./queue_$1";
    const CommandOutcome ran =
        RunClean(folder, command, "PKG_CONFIG_PATH='" + InstalledTree() + "/lib/pkgconfig'");
    ASSERT_EQ(ran.code, 0) << ran.output;
    results[cpp] = ran.output;
  }
  EXPECT_EQ(results[0], results[1]);
  // 50 points of sin(3 x) with a noise of 0.1.
  std::istringstream numbers(results[0]);
  for (const double place : {-0.5, 0.0, 0.5}) {
    double x = 9.0, mean = 9.0, variance = 9.0;
    ASSERT_TRUE(numbers >> x >> mean >> variance) << results[0];
    EXPECT_EQ(x, place);
    EXPECT_NEAR(mean, std::sin(3.0 * place), 0.1);
    EXPECT_GT(variance, 0.0);
    EXPECT_LT(variance, 0.01);
  }
}

TEST(Examples, OfTheReferenceFitSaveAndLoad) {
  SKIP_WITHOUT("pkg-config");
  SKIP_INSTRUMENTED();
  const std::string folder = NewFolder("gp");
  std::ofstream(folder + "/gp.cc") << ProgramOf("cpp.md", "## A Gaussian process");
  CommandOutcome ran =
      RunClean(folder,
               "g++ -std=c++17 -Wall -Wextra -Werror gp.cc -o gp $(pkg-config --cflags --libs "
               "egosieve) -Wl,-rpath,'" +
                   InstalledTree() + "/lib' && ./gp",
               "PKG_CONFIG_PATH='" + InstalledTree() + "/lib/pkgconfig'");
  ASSERT_EQ(ran.code, 0) << ran.output;
  std::istringstream numbers(ran.output);
  for (const double x : {0.0, 0.5}) {
    double mean = 9.0, variance = 9.0, k = 9.0;
    ASSERT_TRUE(numbers >> mean >> variance >> k) << ran.output;
    EXPECT_NEAR(mean, std::sin(3.0 * x) * -x, 0.05);
    EXPECT_LT(variance, 0.01);
    EXPECT_GT(k, 0.0);
  }
  if (RunClean("/", "python3 -c 'import numpy'").code != 0) {
    GTEST_SKIP() << "there is no python3 with numpy";
  }
  // What the page of Python takes as given, then its block up to the sparse models, and a file that
  // C++ refuses.
  const std::string block = ProgramOf("python.md", "");
  std::ofstream(folder + "/gp.py") << R"(import numpy as np
X, queries = (np.random.default_rng(seed).normal(size=(40, 2)) for seed in (0, 1))
y = np.sign(X[:, 0])
more_X, more_y, many_queries, names = X[:9] + 0.1, y[:9], queries, y > 0
)" << block.substr(0, block.find("egosieve.GaussianProcess(approximation"))
                                   << R"(
assert len(egosieve.GaussianProcess.load("model.npz").X_train_) == 46
egosieve.GaussianProcess(normalize_y=True).fit(X, 3 + y).save("model.npz")
)";
  std::ofstream(folder + "/load.cc") << R"(#include <cstdio>
#include "egosieve/gaussian_process.hpp"
int main() {
  std::puts(egosieve::GaussianProcess::Load("model.npz").status().message().c_str());
})";
  ran = RunClean(folder,
                 "python3 gp.py && g++ -std=c++17 load.cc -o load $(pkg-config --cflags --libs "
                 "egosieve) -Wl,-rpath,'" +
                     InstalledTree() + "/lib' && ./load",
                 "PKG_CONFIG_PATH='" + InstalledTree() + "/lib/pkgconfig' PYTHONPATH='" +
                     InstalledPythonFolder() + "'");
  EXPECT_EQ(ran.code, 0) << ran.output;
  EXPECT_NE(ran.output.find("normalize_y in Python"), std::string::npos) << ran.output;
}

TEST(Documents, LinkToWhatIsInstalled) {
  const std::regex link(R"(\]\(([^)#:]+)[^)]*\))");
  int links = 0;
  for (const auto& entry : fs::recursive_directory_iterator(InstalledTree() + "/share")) {
    if (entry.path().extension() != ".md") continue;
    const std::string text = Bytes(entry.path().string());
    for (std::sregex_iterator found(text.begin(), text.end(), link), end; found != end; ++found) {
      EXPECT_TRUE(fs::exists(entry.path().parent_path() / (*found)[1].str()))
          << entry.path() << ": " << (*found)[1];
      ++links;
    }
  }
  EXPECT_GT(links, 5);
}

TEST(Examples, OfTheReferenceRunOnSeveralDevices) {
  SKIP_INSTRUMENTED();
  if (RunClean("/", "python3 -c 'import numpy'").code != 0) {
    GTEST_SKIP() << "there is no python3 with numpy";
  }
  const std::string folder = NewFolder("devices");
  std::ofstream(folder + "/devices.py") << ProgramOf("python.md", "## On several devices");
  const CommandOutcome ran =
      RunClean(folder, "python3 devices.py", "PYTHONPATH='" + InstalledPythonFolder() + "'");
  ASSERT_EQ(ran.code, 0) << ran.output;
  // 200 points of sin(3 x) cos(y) with a noise of 0.1, at (0.5, 0).
  double mean = 9.0;
  ASSERT_TRUE(std::istringstream(ran.output) >> mean) << ran.output;
  EXPECT_NEAR(mean, std::sin(1.5), 0.1);
}

// Unpacked as pip does it; `./run wheel` also copies the system's libraries in.
TEST(Wheel, IsWholeAndServesAnyPython) {
  SKIP_INSTRUMENTED();
  if (RunClean("/", "python3 -c 'import numpy'").code != 0) {
    GTEST_SKIP() << "there is no python3 with numpy";
  }
  const std::string script = fs::absolute("tools/embed/install/wheel.py").string();
  const std::string archive = fs::absolute("tools/embed/install/egosieve.tar").string();
  const std::string folder = NewFolder("wheel");
  const CommandOutcome made = RunClean(folder, "python3 '" + script + "' '" + archive + "' .");
  ASSERT_EQ(made.code, 0) << made.output;
  EXPECT_NE(made.output.find("-py3-none-linux_x86_64.whl"), std::string::npos) << made.output;
  // Every file but the record itself stands in the record with its size and digest.
  std::ofstream(folder + "/check.py") << R"(
import base64, csv, glob, hashlib, io, os, zipfile
wheel = zipfile.ZipFile(glob.glob("*.whl")[0])
name = [n for n in wheel.namelist() if n.endswith(".dist-info/RECORD")][0]
rows = list(csv.reader(io.StringIO(wheel.read(name).decode())))
assert sorted(row[0] for row in rows) == sorted(wheel.namelist()), rows
for path, digest, size in rows:
    if path == name: continue
    found = base64.urlsafe_b64encode(hashlib.sha256(wheel.read(path)).digest()).decode()
    assert digest == "sha256=" + found.rstrip("="), path
    assert int(size) == len(wheel.read(path)), path
assert "egosieve/py.typed" in wheel.namelist()
wheel.extractall("site")
for item in wheel.infolist(): os.chmod("site/" + item.filename, item.external_attr >> 16)
)";
  CommandOutcome ran = RunClean(folder, "python3 check.py");
  ASSERT_EQ(ran.code, 0) << ran.output;
  ran = RunClean(folder,
                 "python3 -c 'import egosieve; g = egosieve.GaussianProcess(optimize=False); "
                 "print(g.fit([[0.0]], [1.0]).predict([[0.0]])[0]); egosieve.Segmenter()'",
                 "PYTHONPATH='" + folder + "/site'");
  EXPECT_EQ(ran.code, 0) << ran.output;
  ran = RunClean(folder, "python3 -m egosieve_program devices", "PYTHONPATH='" + folder + "/site'");
  EXPECT_EQ(ran.code, 0) << ran.output;
  EXPECT_NE(ran.output.find("reference"), std::string::npos) << ran.output;
  if (RunClean("/", "python3 -c 'import cv2'").code != 0) return;
  ran = RunClean(folder, "python3 -c 'import egosieve_program as p; p.view()' none",
                 "PYTHONPATH='" + folder + "/site'");
  EXPECT_EQ(ran.code, 3) << ran.output;
  EXPECT_NE(ran.output.find("egosieve-view: there is no none/run.json"), std::string::npos)
      << ran.output;
}

TEST(CMakePackage, KnowsItsComponentsAndVersion) {
  SKIP_WITHOUT("cmake");
  SKIP_INSTRUMENTED();
  const std::string gp_only =
      CMakeProject("gp_only", "find_package(egosieve REQUIRED COMPONENTS kernels_gp)");
  CommandOutcome outcome = BuildWithCMake(gp_only, "gp_only_build");
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  outcome = RunClean(testing::TempDir() + "/gp_only_build", "./p && ldd p");
  EXPECT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_EQ(outcome.output.find("opencv"), std::string::npos) << outcome.output;

  outcome = BuildWithCMake(
      CMakeProject("sound", "find_package(egosieve REQUIRED COMPONENTS sound)"), "sound_build");
  EXPECT_NE(outcome.code, 0);
  EXPECT_NE(outcome.output.find("egosieve has no component sound"), std::string::npos)
      << outcome.output;
  outcome =
      BuildWithCMake(CMakeProject("later", "find_package(egosieve 99 REQUIRED)"), "later_build");
  EXPECT_NE(outcome.code, 0);
}

}  // namespace
}  // namespace egosieve::embed
