#include "tools/refine/frame_products.h"

#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "kernels/base/status_macros.h"
#include "tools/run_folder/map_image.h"

namespace egosieve::tools {
namespace {

struct Word {
  const char* name;
  bool ProductChoice::*chosen;
};

constexpr std::array<Word, 7> kWords = {{{"masks", &ProductChoice::masks},
                                         {"ids", &ProductChoice::ids},
                                         {"tracks", &ProductChoice::tracks},
                                         {"objects", &ProductChoice::objects},
                                         {"probability", &ProductChoice::probability},
                                         {"deviation", &ProductChoice::deviation},
                                         {"class", &ProductChoice::classes}}};

absl::Status WriteMap(const std::string& path, const cv::Mat1f& values, double full_scale) {
  EGOSIEVE_ASSIGN_OR_RETURN(const EncodedMap encoded, EncodeMap(values, full_scale));
  return WriteFileAtomically(path, encoded.png);
}

// Boxes are [left, top, width, height] in pixels.
std::string ObjectsToText(const std::vector<vision::MapObject>& objects) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const vision::MapObject& object : objects) {
    nlohmann::ordered_json entry = {
        {"box", {object.box.x, object.box.y, object.box.width, object.box.height}},
        {"pixels", object.pixels},
        {"peak_probability", object.peak},
        {"mean_probability", object.mean},
        {"sure", object.sure}};
    list.push_back(std::move(entry));
  }
  return list.dump(1) + "\n";
}

}  // namespace

absl::StatusOr<ProductChoice> ProductChoice::FromText(absl::string_view text) {
  ProductChoice choice;
  for (const Word& word : kWords) choice.*word.chosen = false;
  bool any = false;
  for (const absl::string_view name : absl::StrSplit(text, ',', absl::SkipEmpty())) {
    bool is_known = false;
    for (const Word& word : kWords) {
      if (name != word.name) continue;
      choice.*word.chosen = true;
      is_known = any = true;
    }
    if (!is_known) {
      return absl::InvalidArgumentError(absl::StrCat(
          "--what: \"", name, "\" is none of ",
          absl::StrJoin(kWords, ", ",
                        [](std::string* out, const Word& word) { out->append(word.name); })));
    }
  }
  if (!any) return absl::InvalidArgumentError("--what is empty; name what is to be written");
  return choice;
}

std::string ProductChoice::ToText() const {
  std::vector<std::string> names;
  for (const Word& word : kWords) {
    if (this->*word.chosen) names.push_back(word.name);
  }
  return absl::StrJoin(names, ",");
}

absl::Status CreateProductFolders(const RunFolder& folder, const ProductChoice& what) {
  if (what.masks) EGOSIEVE_RETURN_IF_ERROR(CreateFolder(folder.File("masks")));
  if (what.ids) EGOSIEVE_RETURN_IF_ERROR(CreateFolder(folder.File("ids")));
  if (what.objects || what.probability || what.deviation || what.classes) {
    EGOSIEVE_RETURN_IF_ERROR(CreateFolder(folder.File("full")));
  }
  return absl::OkStatus();
}

absl::Status WriteProducts(const RunFolder& folder, const ProductChoice& what,
                           const FrameResult& result, double deviation_full_scale,
                           const ClassThresholds& classes,
                           const vision::ObjectThresholds& objects) {
  const auto path = [&](const char* name, const char* suffix) {
    return folder.FrameFile(name, result.index, suffix);
  };
  if (what.probability) {
    EGOSIEVE_RETURN_IF_ERROR(WriteMap(path("full", ".prob.png"), result.probability, 1.0));
  }
  if (what.deviation) {
    EGOSIEVE_RETURN_IF_ERROR(
        WriteMap(path("full", ".std.png"), result.deviation, deviation_full_scale));
  }
  if (what.classes) {
    EGOSIEVE_RETURN_IF_ERROR(
        WritePng(path("full", ".class.png"), ClassifyMap(result.probability, classes)));
  }
  if (what.objects) {
    EGOSIEVE_RETURN_IF_ERROR(
        WriteFileAtomically(path("full", ".objects.json"),
                            ObjectsToText(vision::FindObjects(result.probability, objects))));
  }
  if (what.masks) EGOSIEVE_RETURN_IF_ERROR(WritePng(path("masks", ".png"), result.mask));
  if (what.ids) EGOSIEVE_RETURN_IF_ERROR(WritePng(path("ids", ".png"), result.ids));
  return absl::OkStatus();
}

std::string TrackRows(const FrameResult& result) {
  struct Sums {
    cv::Rect box;
    int64_t area = 0;
    double probability = 0.0, doubt = 0.0;
  };
  std::map<uint16_t, Sums> movers;
  for (int y = 0; y < result.ids.rows; ++y) {
    for (int x = 0; x < result.ids.cols; ++x) {
      if (result.ids(y, x) == 0) continue;
      Sums& sums = movers[result.ids(y, x)];
      const double p = result.probability(y, x);
      sums.box |= cv::Rect(x, y, 1, 1);
      ++sums.area;
      sums.probability += p;
      sums.doubt += std::sqrt(p * (1.0 - p));
    }
  }
  std::string rows;
  for (const auto& [id, sums] : movers) {
    const auto area = static_cast<double>(sums.area);
    absl::StrAppendFormat(&rows, "%d,%.6f,%d,%d,%d,%d,%d,%d,%.4f,%.4f\n", result.index,
                          result.time_seconds, id, sums.box.x, sums.box.y, sums.box.width,
                          sums.box.height, sums.area, sums.probability / area,
                          1.0 - 2.0 * sums.doubt / area);
  }
  return rows;
}

}  // namespace egosieve::tools
