#include "tools/cli/given_flags.h"

#include <gtest/gtest.h>

#include "tools/cli/switch_flag.h"

namespace egosieve::tools {
namespace {

// The names of the given flags of a command, of those that its arguments set.
std::string Given(std::vector<std::string> arguments) {
  CLI::App app;
  int jobs = 2;
  bool masks = false, plots = true;
  std::string out;
  std::vector<std::string> variants;
  app.option_defaults()->always_capture_default();
  app.add_option("--jobs", jobs);
  app.add_flag("--masks,!--no_masks", masks);
  AddSwitch(app, "--plots", "--no_plots", plots, "");
  app.add_option("--out", out);
  app.add_option("--variant", variants);
  app.parse(std::move(arguments));
  return GivenFlags(app.get_options());
}

TEST(GivenFlags, AreThoseWithAnotherValueThanTheirDefault) {
  EXPECT_EQ(Given({}), "");
  EXPECT_EQ(Given({"--jobs=3"}), "--jobs");
  EXPECT_EQ(Given({"--jobs=2"}), "");
  EXPECT_EQ(Given({"--masks"}), "--masks");
  EXPECT_EQ(Given({"--no_masks"}), "");
  EXPECT_EQ(Given({"--masks=false"}), "");
  EXPECT_EQ(Given({"--plots"}), "");
  EXPECT_EQ(Given({"--no_plots"}), "--plots");
  EXPECT_EQ(Given({"--variant=b", "--variant=a", "--out=a"}), "--out, --variant");
}

}  // namespace
}  // namespace egosieve::tools
