#include "tools/masks/mask_format.h"

#include <filesystem>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"

namespace egosieve::tools {

namespace {

// By MaskFormat.
constexpr MaskFormatRow kRows[] = {
    {"plain", MaskedPixel::kWhite, false, "{name}.png"},
    {"colmap", MaskedPixel::kBlack, true, "{image}.png"},
    {"nerfstudio", MaskedPixel::kBlack, true, "masks/{image}.png"},
    {"instant-ngp", MaskedPixel::kWhite, true, "{folder}dynamic_mask_{stem}.png"},
    {"opensfm", MaskedPixel::kBlack, true, "{image}.png"},
    {"lichtfeld", MaskedPixel::kBlack, true, "{name}.png"},
    {"postshot", MaskedPixel::kWhite, true, "{name}.png"},
    {"metashape", MaskedPixel::kBlack, true, "{name}_mask.png"},
    {"realityscan", MaskedPixel::kBlack, true, "{image}.mask.png"},
    {"gaussian-splatting", MaskedPixel::kTransparent, true, "{image}"},
    {"davis", MaskedPixel::kNumber, false, "{name}.png"},
    {"coco", MaskedPixel::kNumber, false, ""},
    {"mots", MaskedPixel::kNumber, false, "{sequence}/{index}.png"}};

}  // namespace

const MaskFormatRow& RowOf(MaskFormat format) { return kRows[static_cast<int>(format)]; }

const Words<MaskFormat>& MaskFormatWords() {
  static const auto& words = *new Words<MaskFormat>([] {
    Words<MaskFormat> made;
    for (const MaskFormatRow& row : kRows) {
      made.emplace_back(row.word, static_cast<MaskFormat>(made.size()));
    }
    return made;
  }());
  return words;
}

int LargestNumber(MaskFormat format) {
  if (format == MaskFormat::kDavis) return 254;  // 255 is void
  return format == MaskFormat::kMots ? kMotsClassStep - 1 : UINT16_MAX;
}

std::string NameInside(const std::string& image) {
  std::filesystem::path inside;
  for (const std::filesystem::path& part :
       std::filesystem::path(image).lexically_normal().relative_path()) {
    if (part != "..") inside /= part;
  }
  return inside.string();
}

std::string MaskFile(MaskFormat format, const std::string& image, int64_t index,
                     const std::string& sequence) {
  const std::filesystem::path path(image);
  const std::string folder = path.has_parent_path() ? path.parent_path().string() + "/" : "";
  const std::string stem = path.stem().string();
  return absl::StrReplaceAll(RowOf(format).file, {{"{image}", image},
                                                  {"{name}", folder + stem},
                                                  {"{folder}", folder},
                                                  {"{stem}", stem},
                                                  {"{sequence}", sequence},
                                                  {"{index}", absl::StrFormat("%06d", index)}});
}

std::string ReducedMaskFile(const std::string& image, int by) {
  return absl::StrCat("masks_", by, "/", std::filesystem::path(image).filename().string(), ".png");
}

}  // namespace egosieve::tools
