// Figures as data: drawn by a plotting library, and reusable with another.
#ifndef EGOSIEVE_TOOLS_PLOTS_FIGURE_H_
#define EGOSIEVE_TOOLS_PLOTS_FIGURE_H_

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace egosieve::tools {

struct Series {
  enum class Style { kLine, kDashed, kSteps, kBars, kIntervals };

  std::string name;
  std::vector<double> x;         // of bars and intervals: 0, 1, ..., the index in `categories`
  std::vector<double> y;         // NaN: none
  std::vector<double> low = {};  // of intervals
  std::vector<double> high = {};
  Style style = Style::kLine;
};

struct Figure {
  std::string id;  // letters, digits, underscores: the files' name
  std::string title;
  std::string caption;  // what it shows and how to read it
  std::string x_label;
  std::string y_label;
  std::vector<Series> series = {};
  std::vector<std::string> categories = {};  // names of places on the x axis, for bars
  std::optional<std::pair<double, double>> x_range = {};
  std::optional<std::pair<double, double>> y_range = {};
  bool diagonal = false;  // a faint line from (0, 0) to (1, 1)
  bool logarithmic_y = false;
  bool full_width = false;  // of the page, if that has columns
};

// Whether any series has a finite point: figures without such a point are not drawn.
bool HasPoints(const Figure& figure);

nlohmann::ordered_json ToJson(const std::vector<Figure>& figures);

}  // namespace egosieve::tools

#endif  // EGOSIEVE_TOOLS_PLOTS_FIGURE_H_
