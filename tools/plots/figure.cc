#include "tools/plots/figure.h"

#include <algorithm>
#include <cmath>

namespace egosieve::tools {
namespace {

using Json = nlohmann::ordered_json;

const char* NameOf(Series::Style style) {
  switch (style) {
    case Series::Style::kLine:
      return "line";
    case Series::Style::kDashed:
      return "dashed";
    case Series::Style::kSteps:
      return "steps";
    case Series::Style::kBars:
      return "bars";
    case Series::Style::kIntervals:
      return "intervals";
  }
  return "line";
}

// NaN becomes null, since JSON has no NaN.
Json Numbers(const std::vector<double>& values) {
  Json json = Json::array();
  for (const double value : values) json.push_back(std::isfinite(value) ? Json(value) : Json());
  return json;
}

Json Range(const std::optional<std::pair<double, double>>& range) {
  return range ? Json{range->first, range->second} : Json();
}

}  // namespace

bool HasPoints(const Figure& figure) {
  return std::any_of(figure.series.begin(), figure.series.end(), [](const Series& series) {
    return std::any_of(series.y.begin(), series.y.end(),
                       [](double value) { return std::isfinite(value); });
  });
}

Json ToJson(const std::vector<Figure>& figures) {
  Json all = Json::array();
  for (const Figure& figure : figures) {
    Json series = Json::array();
    for (const Series& s : figure.series) {
      series.push_back({{"name", s.name},
                        {"style", NameOf(s.style)},
                        {"x", Numbers(s.x)},
                        {"y", Numbers(s.y)},
                        {"low", Numbers(s.low)},
                        {"high", Numbers(s.high)}});
    }
    all.push_back({{"id", figure.id},
                   {"title", figure.title},
                   {"caption", figure.caption},
                   {"x_label", figure.x_label},
                   {"y_label", figure.y_label},
                   {"categories", figure.categories},
                   {"x_range", Range(figure.x_range)},
                   {"y_range", Range(figure.y_range)},
                   {"diagonal", figure.diagonal},
                   {"logarithmic_y", figure.logarithmic_y},
                   {"series", series}});
  }
  return all;
}

}  // namespace egosieve::tools
