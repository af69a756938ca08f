#include "vision/frame/input_files.h"

#include <glob.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <iterator>
#include <map>
#include <set>
#include <string_view>
#include <system_error>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "kernels/base/status_macros.h"
#include "vision/frame/frame_source.h"
#include "vision/frame/image_decoding.h"

namespace egosieve::vision {
namespace {

namespace fs = std::filesystem;

bool IsHidden(const fs::path& path) { return path.filename().string().starts_with('.'); }

// "DynamicMask_0001" has the words "dynamic" and "mask".
std::vector<std::string> WordsOf(const std::string& text) {
  std::vector<std::string> words(1);
  bool was_lower = false;
  for (const char c : text) {
    const bool begins = !absl::ascii_isalpha(c) || (was_lower && absl::ascii_isupper(c));
    if (begins && !words.back().empty()) words.emplace_back();
    if (absl::ascii_isalpha(c)) words.back().push_back(absl::ascii_tolower(c));
    was_lower = absl::ascii_islower(c);
  }
  return words;
}

std::string FolderOf(const std::string& path) { return fs::path(path).parent_path().string(); }
std::string StemOf(const std::string& path) { return fs::path(path).stem().string(); }

using Kinds = std::map<std::string, std::vector<std::string>>;

// The paths by kind; those without one are left out.
template <typename KindOf>
Kinds ByKind(const std::vector<std::string>& paths, KindOf kind_of) {
  Kinds kinds;
  for (const std::string& path : paths) {
    const std::string kind = kind_of(path);
    if (!kind.empty()) kinds[kind].push_back(path);
  }
  return kinds;
}

// By kind: "30 masks beside the pictures are left out, ...".
void TakeOutSidePictures(const fs::path& root, InputFiles& files) {
  const auto kind_of = [&](const std::string& path) {
    return SideKind(fs::path(path).lexically_relative(root).string());
  };
  std::vector<std::string> kept = files.paths;
  std::erase_if(kept, [&](const std::string& path) { return !kind_of(path).empty(); });
  if (kept.empty()) return;
  for (const auto& [name, paths] : ByKind(files.paths, kind_of)) {
    files.remarks.push_back(absl::StrCat(paths.size(), " ", name,
                                         " beside the pictures are left out, by their names, such "
                                         "as ",
                                         paths.front()));
  }
  files.paths = std::move(kept);
}

// Of files that differ only in their extension one is the picture: seldom the PNG, which masks are.
int Rank(const std::string& path) {
  constexpr std::string_view kLast[] = {".png", ".pgm", ".pbm"};
  const auto* place = std::find(std::begin(kLast), std::end(kLast), ExtensionOf(path));
  return place == std::end(kLast) ? 0 : 1 + static_cast<int>(place - std::begin(kLast));
}

void TakeOutVersions(InputFiles& files) {
  std::map<std::string, int> best;  // rank by path without the extension
  const std::set<std::string> all(files.paths.begin(), files.paths.end());
  const auto key = [](const std::string& path) {
    return fs::path(path).replace_extension().string();
  };
  for (const std::string& path : files.paths) {
    const auto [at, is_new] = best.emplace(key(path), Rank(path));
    if (!is_new) at->second = std::min(at->second, Rank(path));
  }
  const auto versions =
      std::stable_partition(files.paths.begin(), files.paths.end(), [&](const std::string& path) {
        return Rank(path) == best[key(path)] && all.count(key(path)) == 0;
      });
  if (versions == files.paths.end()) return;
  files.remarks.push_back(absl::StrCat(files.paths.end() - versions,
                                       " files that have the name of another picture are left out "
                                       "as its masks, such as ",
                                       *versions));
  files.paths.erase(versions, files.paths.end());
}

InputFiles Chosen(const std::vector<std::string>& paths, const fs::path& root) {
  InputFiles files;
  std::copy_if(paths.begin(), paths.end(), std::back_inserter(files.paths), HasImageExtension);
  std::vector<std::string> videos;
  std::copy_if(paths.begin(), paths.end(), std::back_inserter(videos), HasVideoExtension);
  for (const auto& [kind, unread] : ByKind(paths, UnreadPictureKind)) {
    files.remarks.push_back(absl::StrCat(unread.size(), " ", kind,
                                         " files are left out; convert them to JPEG, with "
                                         "ImageMagick: mogrify -format jpg ",
                                         unread.front(), " and so on"));
  }
  if (files.paths.empty()) {
    files.are_videos = true;
    files.paths = std::move(videos);
  } else if (!videos.empty()) {
    files.remarks.push_back(absl::StrCat(videos.size(),
                                         " videos beside the pictures are left out, such as ",
                                         videos.front(), "; a glob names them"));
  }
  std::sort(files.paths.begin(), files.paths.end(), NaturalLess);
  if (files.are_videos) return files;
  TakeOutSidePictures(root, files);
  TakeOutVersions(files);
  return files;
}

// The folders of the pictures with their stems.
std::map<std::string, std::set<std::string>> StemsByFolder(const std::vector<std::string>& paths) {
  std::map<std::string, std::set<std::string>> stems;
  for (const std::string& path : paths) stems[FolderOf(path)].insert(StemOf(path));
  return stems;
}

// X of X_2, X_4; empty for other names.
std::string Original(const std::string& folder) {
  const size_t end = folder.find_last_not_of("0123456789");
  const bool is_numbered = end != std::string::npos && end + 1 < folder.size() && end > 0;
  return is_numbered && folder[end] == '_' ? folder.substr(0, end) : "";
}

void TakeOutCopies(InputFiles& files) {
  const auto stems = StemsByFolder(files.paths);
  std::set<std::string> copies;
  for (const auto& [folder, own] : stems) {
    const auto original = stems.find(Original(folder));
    if (original == stems.end()) continue;
    const auto& names = original->second;
    if (std::includes(names.begin(), names.end(), own.begin(), own.end())) copies.insert(folder);
  }
  std::erase_if(files.paths,
                [&](const std::string& path) { return copies.count(FolderOf(path)) > 0; });
  for (const std::string& folder : copies) {
    files.remarks.push_back(absl::StrCat("the pictures of ", folder,
                                         " are left out as copies of those of ", Original(folder)));
  }
}

// The numbers in a name, "2 17" for "cam2_17"; the name if it has none.
std::string NumbersOf(const std::string& stem) {
  std::string numbers;
  for (const char c : stem) {
    if (absl::ascii_isdigit(c)) {
      numbers.push_back(c);
    } else if (!numbers.empty() && numbers.back() != ' ') {
      numbers.push_back(' ');
    }
  }
  absl::StripTrailingAsciiWhitespace(&numbers);
  return numbers.empty() ? stem : numbers;
}

// Folders that follow one another have numbers that do, or a single picture each.
absl::Status CheckFoldersFollow(const std::string& root, const std::vector<std::string>& paths) {
  struct Span {
    std::string first, last, folder;
  };
  std::vector<Span> spans;
  bool are_single = true;
  for (const auto& [folder, stems] : StemsByFolder(paths)) {
    std::vector<std::string> numbers;
    for (const std::string& stem : stems) numbers.push_back(NumbersOf(stem));
    const auto [first, last] = std::minmax_element(numbers.begin(), numbers.end(), NaturalLess);
    spans.push_back({*first, *last, folder});
    are_single &= stems.size() == 1;
  }
  if (are_single) return absl::OkStatus();
  std::sort(spans.begin(), spans.end(),
            [](const Span& a, const Span& b) { return NaturalLess(a.first, b.first); });
  for (size_t i = 1; i < spans.size(); ++i) {
    if (NaturalLess(spans[i - 1].last, spans[i].first)) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        root, ": files of several cameras, or the same ones again: ", spans[i - 1].folder, " and ",
        spans[i].folder,
        " have the same numbers; name one of the folders, or a glob: of one camera's "
        "pictures, or of all where the folders follow one another"));
  }
  return absl::OkStatus();
}

size_t CommonCount(const std::set<std::string>& a, const std::set<std::string>& b) {
  return std::count_if(a.begin(), a.end(), [&](const std::string& x) { return b.count(x) > 0; });
}

// "left_0001" and "right_0001" are two series: their letters differ, most of their numbers do not.
absl::Status CheckOneSeries(const std::string& root, const std::vector<std::string>& paths) {
  constexpr size_t kMostSeries = 16;  // more are names of no order
  struct Series {
    std::string first;
    std::set<std::string> numbers;
  };
  std::map<std::string, std::map<std::string, Series>> folders;  // by the letters of the names
  for (const std::string& path : paths) {
    Series& series = folders[FolderOf(path)][absl::StrJoin(WordsOf(StemOf(path)), " ")];
    if (series.first.empty()) series.first = path;
    series.numbers.insert(NumbersOf(StemOf(path)));
  }
  for (const auto& [folder, by_letters] : folders) {
    std::vector<const Series*> all;
    for (const auto& [letters, series] : by_letters) {
      if (series.numbers.size() > 1) all.push_back(&series);
    }
    for (size_t i = 0; all.size() <= kMostSeries && i < all.size(); ++i) {
      for (size_t j = 0; j < i; ++j) {
        const auto &a = all[j]->numbers, &b = all[i]->numbers;
        if (2 * CommonCount(a, b) < std::min(a.size(), b.size())) continue;
        return absl::InvalidArgumentError(absl::StrCat(
            root, ": two series of files in one folder, such as of two cameras: ", all[j]->first,
            " and ", all[i]->first, "; name one of them by a glob"));
      }
    }
  }
  return absl::OkStatus();
}

absl::Status NoPictures(const std::string& input, const InputFiles& files,
                        const std::string& otherwise) {
  return absl::InvalidArgumentError(absl::StrCat(
      input, files.remarks.empty() ? otherwise
                                   : absl::StrCat(": no pictures that are read; ",
                                                  absl::StrJoin(files.remarks, "; "))));
}

// The pattern with the characters of folders that exist by that very name taken literally.
std::string WithLiteralFolders(const std::string& pattern) {
  std::error_code error;
  for (size_t end = pattern.rfind('/'); end != std::string::npos && end > 0;
       end = pattern.rfind('/', end - 1)) {
    const std::string folder = pattern.substr(0, end);
    if (!fs::is_directory(folder, error)) continue;
    std::string literal;
    for (const char c : folder) {
      if (std::string_view("*?[\\").find(c) != std::string_view::npos) literal.push_back('\\');
      literal.push_back(c);
    }
    return literal + pattern.substr(end);
  }
  return pattern;
}

// The visible files in a folder, and its visible folders.
absl::Status List(const fs::path& folder, std::vector<std::string>& files,
                  std::vector<fs::path>& folders) {
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code unknown;
    if (IsHidden(it->path())) continue;
    if (it->is_directory(unknown)) folders.push_back(it->path());
    if (it->is_regular_file(unknown)) files.push_back(it->path().string());
  }
  if (!error) return absl::OkStatus();
  return absl::NotFoundError(
      absl::StrCat(folder.string(), ": the folder cannot be read (", error.message(), ")"));
}

}  // namespace

bool HasVideoExtension(const std::string& path) {
  constexpr std::string_view kExtensions[] = {".mp4",  ".mov", ".avi",  ".mkv", ".m4v",
                                              ".webm", ".mpg", ".mpeg", ".mts", ".ts",
                                              ".m2ts", ".3gp", ".wmv",  ".insv"};
  return std::count(std::begin(kExtensions), std::end(kExtensions), ExtensionOf(path)) > 0;
}

std::string SideKind(const std::string& path) {
  const auto is_one_of = [](const std::string& word, std::initializer_list<const char*> words) {
    return std::find(words.begin(), words.end(), word) != words.end();
  };
  for (const std::string& word : WordsOf(fs::path(path).replace_extension().string())) {
    if (is_one_of(word, {"mask", "masks", "masked"})) return "masks";
    if (word.starts_with("depth") || is_one_of(word, {"disparity", "disparities"})) {
      return "depth maps";
    }
    if (is_one_of(word, {"label", "labels", "semantic", "semantics", "segmentation",
                         "segmentations", "annotation", "annotations", "normals"})) {
      return "labels";
    }
  }
  return "";
}

absl::StatusOr<InputFiles> FilesOfFolder(const std::string& folder) {
  std::vector<std::string> paths;
  std::vector<fs::path> folders;
  EGOSIEVE_RETURN_IF_ERROR(List(folder, paths, folders));
  InputFiles files = Chosen(paths, folder);
  if (files.paths.empty()) {
    std::error_code error;
    std::set<fs::path> seen = {fs::canonical(folder, error)};
    for (const bool follows_links : {false, true}) {  // so that a file has its own folder's name
      std::sort(folders.begin(), folders.end());
      for (size_t i = 0; i < folders.size(); ++i) {  // `folders` grows; links may form circles
        const fs::path below = folders[i];
        if (fs::is_symlink(below) && !follows_links) continue;
        if (!seen.insert(fs::canonical(below, error)).second) continue;
        EGOSIEVE_RETURN_IF_ERROR(List(below, paths, folders));
      }
    }
    files = Chosen(paths, folder);
    if (!files.are_videos) TakeOutCopies(files);
  }
  if (files.paths.empty()) {
    return NoPictures(folder, files,
                      ": no pictures in this folder, and no videos; give one that holds PNG or "
                      "JPEG files, or videos");
  }
  const std::string kind =
      SideKind((fs::absolute(folder).lexically_normal() / "").parent_path().filename().string());
  if (!kind.empty()) {
    files.remarks.push_back(absl::StrCat("by the name of ", folder, " these are ", kind,
                                         "; give the folder of the camera's pictures"));
  }
  EGOSIEVE_RETURN_IF_ERROR(CheckFoldersFollow(folder, files.paths));
  EGOSIEVE_RETURN_IF_ERROR(CheckOneSeries(folder, files.paths));
  return files;
}

absl::StatusOr<InputFiles> FilesOfGlob(const std::string& pattern) {
  std::vector<std::string> paths;
  size_t match_count = 0;
  glob_t matches = {};
  if (glob(WithLiteralFolders(pattern).c_str(), GLOB_NOSORT, nullptr, &matches) == 0) {
    match_count = matches.gl_pathc;
    for (size_t i = 0; i < matches.gl_pathc; ++i) {
      std::error_code error;
      const fs::path path = matches.gl_pathv[i];
      if (!IsHidden(path) && fs::is_regular_file(path, error)) paths.push_back(path.string());
    }
  }
  globfree(&matches);
  if (match_count == 0) {
    return absl::NotFoundError(
        absl::StrCat(pattern, ": no file matches; quote the pattern and check the folder"));
  }
  const size_t wild = pattern.find_first_of("*?[");
  InputFiles files = Chosen(paths, FolderOf(pattern.substr(0, wild)));
  if (!files.paths.empty()) return files;
  return NoPictures(pattern, files,
                    absl::StrCat(": matches ", match_count,
                                 " files, none of them a picture or a video; name a video by "
                                 "itself"));
}

}  // namespace egosieve::vision
