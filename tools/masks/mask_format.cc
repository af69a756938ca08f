#include "tools/masks/mask_format.h"

#include <filesystem>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace egosieve::tools {

const Words<MaskFormat>& MaskFormatWords() {
  static const auto& words =
      *new Words<MaskFormat>{{"plain", MaskFormat::kPlain},
                             {"colmap", MaskFormat::kColmap},
                             {"nerfstudio", MaskFormat::kNerfstudio},
                             {"instant-ngp", MaskFormat::kInstantNgp},
                             {"gaussian-splatting", MaskFormat::kGaussianSplatting},
                             {"davis", MaskFormat::kDavis},
                             {"coco", MaskFormat::kCoco},
                             {"mots", MaskFormat::kMots}};
  return words;
}

bool HasNumbers(MaskFormat format) {
  return format == MaskFormat::kDavis || format == MaskFormat::kCoco || format == MaskFormat::kMots;
}

bool IsForScenes(MaskFormat format) { return !HasNumbers(format) && format != MaskFormat::kPlain; }

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
  switch (format) {
    case MaskFormat::kColmap:
      return absl::StrCat(image, ".png");
    case MaskFormat::kNerfstudio:
      return absl::StrCat("masks/", image, ".png");
    case MaskFormat::kInstantNgp:
      return (path.parent_path() / absl::StrCat("dynamic_mask_", path.stem().string(), ".png"))
          .string();
    case MaskFormat::kGaussianSplatting:
      return image;
    case MaskFormat::kPlain:
    case MaskFormat::kDavis:
      return std::filesystem::path(path).replace_extension(".png").string();
    case MaskFormat::kMots:
      return absl::StrFormat("%s/%06d.png", sequence, index);
    case MaskFormat::kCoco:
      return "";
  }
  return "";
}

}  // namespace egosieve::tools
