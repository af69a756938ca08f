#include "tools/plots/plots_flag.h"

#include <iostream>

#include "absl/strings/str_cat.h"
#include "tools/cli/exit_code.h"
#include "tools/cli/switch_flag.h"

namespace egosieve::tools {

void PlotsFlag::AddFlag(CLI::App& app) {
  AddSwitch(app, "--plots", "--no_plots", wanted_,
            "Draw figures (SVG, PNG) and a page with them, plots/index.html (needs "
            "python3-matplotlib)");
}

absl::Status PlotsFlag::Write(const std::string& folder, const PlotPage& page) const {
  if (!wanted_) return absl::OkStatus();
  const absl::Status status = WritePlotPage(folder, page);
  if (absl::IsFailedPrecondition(status)) {
    std::cerr << ErrorLine(absl::StrCat("warning: ", status.message())) << "\n";
    return absl::OkStatus();
  }
  if (status.ok()) std::cerr << "plots: " << folder << "/index.html\n";
  return status;
}

}  // namespace egosieve::tools
