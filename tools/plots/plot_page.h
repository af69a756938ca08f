// Figures drawn as SVG and PNG by Debian's matplotlib, and one page with all of them.
//
//   FOLDER/figures.json    the figures as data (figure.h)
//   FOLDER/ID.svg, ID.png  each figure
//   FOLDER/index.html      title, text, the figures with their captions; needs no other file
#ifndef EGOSIEVE_TOOLS_PLOTS_PLOT_PAGE_H_
#define EGOSIEVE_TOOLS_PLOTS_PLOT_PAGE_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "tools/plots/figure.h"

namespace egosieve::tools {

struct TextList {
  std::string title;
  std::vector<std::string> items;
};

// Texts are plain.
struct PlotPage {
  std::string title;
  std::vector<std::string> paragraphs;  // above the figures
  std::vector<TextList> lists;          // below the paragraphs
  std::string table;                    // set in a fixed width; may be empty
  std::vector<Figure> figures;          // those without points are left out
  int columns = 1;                      // of figures
};

// FailedPrecondition, naming the package to install, if Python or matplotlib is missing; the data
// are written in any case. Otherwise errors of the folder's files.
absl::Status WritePlotPage(const std::string& folder, const PlotPage& page,
                           const std::string& python = "/usr/bin/python3");

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_PLOTS_PLOT_PAGE_H_
