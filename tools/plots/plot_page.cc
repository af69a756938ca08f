#include "tools/plots/plot_page.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <system_error>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/child_process.h"
#include "tools/plots/embedded_script.h"
#include "tools/report/html.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

constexpr int kLibraryMissing = 3;  // exit code of plot.py

constexpr char kStyle[] =
    "body{font:16px/1.45 sans-serif;margin:2em auto;max-width:84em;padding:0 1em;color:#222}"
    "main{display:grid;column-gap:2em}.full{grid-column:1/-1}h2{font-size:1.1em}"
    "figure{margin:2em 0;border-top:1px solid #ccc;padding-top:1em}"
    "figure svg{max-width:100%;height:auto}figcaption{max-width:60em}"
    "pre{font-size:11px;overflow-x:auto;background:#f6f6f6;padding:1em}";

// The SVG without XML declaration and document type. The library repeats its ids between figures,
// so each figure gets ids of its own.
std::string InlineSvg(const std::string& svg, const std::string& id) {
  const size_t start = svg.find("<svg");
  return absl::StrReplaceAll(start == std::string::npos ? svg : svg.substr(start),
                             {{"id=\"", absl::StrCat("id=\"", id, "-")},
                              {"href=\"#", absl::StrCat("href=\"#", id, "-")},
                              {"url(#", absl::StrCat("url(#", id, "-")}});
}

absl::Status Draw(const std::string& folder, const std::string& python) {
  ChildCommand command;
  command.arguments = {python, "-c", kPlotScript, absl::StrCat(folder, "/figures.json"), folder};
  command.log_path = absl::StrCat(folder, "/plot.log");
  const std::string remedy = absl::StrCat(
      "; on Debian: apt-get install python3-matplotlib; the data are in ", folder, "/figures.json");
  const absl::StatusOr<int> code = RunChild(command, [] { return false; });
  if (!code.ok() || *code == 127) {
    return absl::FailedPreconditionError(
        absl::StrCat("no plots were drawn: ", python, " cannot be run", remedy));
  }
  if (*code == kLibraryMissing) {
    return absl::FailedPreconditionError(
        absl::StrCat("no plots were drawn: ", python, " has no matplotlib", remedy));
  }
  if (*code != 0) {
    return absl::UnavailableError(absl::StrCat("no plots were drawn: plotting ended with code ",
                                               *code, "; see ", command.log_path));
  }
  std::error_code error;
  std::filesystem::remove(command.log_path, error);
  return absl::OkStatus();
}

}  // namespace

absl::Status WritePlotPage(const std::string& folder, const PlotPage& page,
                           const std::string& python) {
  std::vector<Figure> figures;
  std::copy_if(page.figures.begin(), page.figures.end(), std::back_inserter(figures), HasPoints);
  EGOSIEVE_RETURN_IF_ERROR(CreateFolder(folder));
  EGOSIEVE_RETURN_IF_ERROR(
      WriteFileAtomically(absl::StrCat(folder, "/figures.json"), ToJson(figures).dump(1) + "\n"));
  EGOSIEVE_RETURN_IF_ERROR(Draw(folder, python));
  std::string html =
      absl::StrCat(PageHead(page.title, kStyle), "<h1>", EscapeHtml(page.title), "</h1>\n");
  for (const std::string& paragraph : page.paragraphs) {
    absl::StrAppend(&html, "<p>", EscapeHtml(paragraph), "</p>\n");
  }
  for (const TextList& list : page.lists) {
    absl::StrAppend(&html, "<h2>", EscapeHtml(list.title), "</h2>\n<ul>\n");
    for (const std::string& item : list.items) {
      absl::StrAppend(&html, "<li>", EscapeHtml(item), "</li>\n");
    }
    absl::StrAppend(&html, "</ul>\n");
  }
  if (!page.table.empty()) absl::StrAppend(&html, "<pre>", EscapeHtml(page.table), "</pre>\n");
  absl::StrAppend(&html, "<main style=\"grid-template-columns:repeat(", page.columns,
                  ",minmax(0,1fr))\">\n");
  for (const Figure& figure : figures) {
    EGOSIEVE_ASSIGN_OR_RETURN(const std::string svg,
                              ReadFile(absl::StrCat(folder, "/", figure.id, ".svg")));
    absl::StrAppend(&html, figure.full_width ? "<figure class=\"full\">" : "<figure>",
                    InlineSvg(svg, figure.id), "<figcaption>", EscapeHtml(figure.caption),
                    " (<a href=\"", figure.id, ".svg\">SVG</a>, <a href=\"", figure.id,
                    ".png\">PNG</a>)</figcaption></figure>\n");
  }
  absl::StrAppend(&html, "</main></body></html>\n");
  return WriteFileAtomically(absl::StrCat(folder, "/index.html"), html);
}

}  // namespace egosieve::tools
