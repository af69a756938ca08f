// The flag --plots of commands that draw figures.
#ifndef EGOSIEVE_TOOLS_PLOTS_PLOTS_FLAG_H_
#define EGOSIEVE_TOOLS_PLOTS_PLOTS_FLAG_H_

#include <CLI/CLI.hpp>
#include <string>

#include "absl/status/status.h"
#include "tools/plots/plot_page.h"

namespace egosieve::tools {

class PlotsFlag {
 public:
  void AddFlag(CLI::App& app);

  // Draws if wanted and prints the page's path on stderr. A missing plotting library is a warning
  // on stderr: the figures' data are written and the command continues.
  absl::Status Write(const std::string& folder, const PlotPage& page) const;

 private:
  bool wanted_ = true;
};

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_PLOTS_PLOTS_FLAG_H_
