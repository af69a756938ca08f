// The formats in which other programs read masks.
//
//   plain               NAME.png             255 moving, 0 static
//   colmap              IMAGE.png            0 ignored, 255 used: ImageReader.mask_path
//   nerfstudio          masks/IMAGE.png      as colmap; transforms.json: a copy with mask_path
//                       masks_N/FILE.png     of the pictures images_N/FILE, reduced by N
//   instant-ngp         dynamic_mask_NAME.png    255 ignored; must lie next to the pictures
//   opensfm             IMAGE.png            0 ignored, 255 used
//   lichtfeld           NAME.png             0 ignored, 255 used: its mask mode "ignore"
//   postshot            NAME.png             255 ignored, 0 used: its mask mode "Remove Occluders"
//   metashape           NAME_mask.png        0 ignored, 255 used: template "{filename}_mask.png"
//   realityscan         IMAGE.mask.png       0 ignored, 255 used: its image layer "mask"
//   gaussian-splatting  IMAGE                the picture, alpha 0 where ignored; always PNG data,
//                                            whatever its name, because JPEG has no alpha
//   davis               NAME.png             palette; the mover's number, 0 background
//   coco                annotations.json     run lengths (run_length.h), track_id: the number
//   mots                SEQ/NNNNNN.png, SEQ.txt    1000 class + number
//
// IMAGE is the picture's name relative to the input, with folders (NameInside); NAME is the same
// without its extension, FILE without its folders; SEQ is the input's name. Pictures of a video are NNNNNN.png, starting at
// 000000.png.
#pragma once

#include <cstdint>
#include <string>

#include "tools/cli/checks.h"

namespace egosieve::tools {

// MOTS: of an object's class, 1 a car, 2 a pedestrian.
inline constexpr int kMotsClassStep = 1000;

enum class MaskFormat {
  kPlain,
  kColmap,
  kNerfstudio,
  kInstantNgp,
  kOpenSfm,
  kLichtfeld,
  kPostshot,
  kMetashape,
  kRealityScan,
  kGaussianSplatting,
  kDavis,
  kCoco,
  kMots,
};

// What a masked pixel is in the format's pictures.
enum class MaskedPixel { kBlack, kWhite, kTransparent, kNumber };

struct MaskFormatRow {
  const char* word;  // of --for
  MaskedPixel masked;
  // Whether the reader reconstructs a scene from unmasked pixels. The own vehicle is then masked,
  // too.
  bool is_for_scenes;
  // With {image}, {name}, {folder} and {stem}, the parts of NAME, {sequence} and {index}.
  const char* file;
};

const MaskFormatRow& RowOf(MaskFormat format);

const Words<MaskFormat>& MaskFormatWords();

// Whether the format keeps the movers' numbers, and so has one mask per mover.
inline bool HasNumbers(MaskFormat format) { return RowOf(format).masked == MaskedPixel::kNumber; }
inline bool IsForScenes(MaskFormat format) { return RowOf(format).is_for_scenes; }

// The largest number of a mover.
int LargestNumber(MaskFormat format);

// `image` without what leads out of a folder: "../images/./1.png" and "/images/1.png" become
// "images/1.png".
std::string NameInside(const std::string& image);

// The mask file of an image, relative to the folder of the masks; empty for kCoco.
std::string MaskFile(MaskFormat format, const std::string& image, int64_t index,
                     const std::string& sequence);

// nerfstudio's mask file of an image that is reduced by `by`.
std::string ReducedMaskFile(const std::string& image, int by);

}  // namespace egosieve::tools
