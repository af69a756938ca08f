#include "kernels/covariance/covariance_expression.h"

#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "kernels/base/status_macros.h"

namespace egosieve::kernels {
namespace {

using Part = CovariancePart;

constexpr int kDeepest = 32;  // nested parentheses

// Without spaces; runs of three and more as first:end.
std::string TextOf(const std::vector<int64_t>& columns) {
  std::vector<std::string> ranges;
  for (size_t i = 0; i < columns.size();) {
    size_t end = i + 1;
    while (end < columns.size() && columns[end] == columns[end - 1] + 1) ++end;
    if (end - i < 3) end = i + 1;
    ranges.push_back(end == i + 1 ? absl::StrCat(columns[i])
                                  : absl::StrCat(columns[i], ":", columns[end - 1] + 1));
    i = end;
  }
  return absl::StrJoin(ranges, ",");
}

// A recursive-descent parser of the grammar.
class Parser {
 public:
  Parser(std::string_view text, const CovarianceNames& names) : text_(text), names_(names) {}

  absl::StatusOr<NamedDescription> Parse() {
    EGOSIEVE_ASSIGN_OR_RETURN(NamedDescription sum, Sum(0));
    SkipSpace();
    if (place_ != text_.size()) return Error("'+' or '*'");
    return sum;
  }

 private:
  absl::StatusOr<NamedDescription> Sum(int depth) {
    return Chain('+', depth, [this](int d) {
      return Chain('*', d, [this](int inner) { return WithColumns(inner); });
    });
  }

  template <typename Next>
  absl::StatusOr<NamedDescription> Chain(char sign, int depth, const Next& next) {
    std::vector<std::string> texts;
    std::vector<Part> parts;
    do {
      EGOSIEVE_ASSIGN_OR_RETURN(NamedDescription part, next(depth));
      texts.push_back(std::move(part.text));
      parts.push_back(std::move(part.description));
    } while (Take(sign));
    if (parts.size() == 1) return NamedDescription{std::move(texts[0]), std::move(parts[0])};
    return NamedDescription{absl::StrJoin(texts, sign == '+' ? " + " : " * "),
                            MakeComposition(std::move(parts), sign == '+')};
  }

  absl::StatusOr<NamedDescription> WithColumns(int depth) {
    EGOSIEVE_ASSIGN_OR_RETURN(NamedDescription part, Factor(depth));
    if (!Take('[')) return part;
    if (HasColumns(part)) return Error("a function without columns before '['");
    std::vector<int64_t> columns;
    do {
      const int64_t least = columns.empty() ? 0 : columns.back() + 1;
      const std::optional<int64_t> first = TakeNumber();
      const std::optional<int64_t> end = !first.has_value() ? first
                                         : Take(':')        ? TakeNumber()
                                                            : *first + 1;
      if (!end.has_value() || *first < least || *end <= *first || *end > kMaxInputDimension) {
        return Error("increasing columns, such as 0, 2:5, below 256,");
      }
      for (int64_t c = *first; c < *end; ++c) columns.push_back(c);
    } while (Take(','));
    if (!Take(']')) return Error("']'");
    return NamedDescription{absl::StrCat(part.text, "[", TextOf(columns), "]"),
                            MakeOfColumns(part.description, columns)};
  }

  static bool HasColumns(const NamedDescription& part) {
    return part.text.find('[') != std::string::npos;
  }

  // Nothing unless there is one, of three digits at most.
  std::optional<int64_t> TakeNumber() {
    SkipSpace();
    const size_t begin = place_;
    int64_t number = 0;
    while (place_ < text_.size() && place_ < begin + 3 && absl::ascii_isdigit(text_[place_])) {
      number = 10 * number + (text_[place_++] - '0');
    }
    return place_ > begin ? std::optional<int64_t>(number) : std::nullopt;
  }

  absl::StatusOr<NamedDescription> Factor(int depth) {
    if (depth > kDeepest) return Error("fewer parentheses within each other");
    if (Take('(')) return Enclosed("", depth);
    SkipSpace();
    size_t end = place_;
    while (end < text_.size() && (absl::ascii_isalnum(text_[end]) || text_[end] == '_')) ++end;
    const std::string_view name = text_.substr(place_, end - place_);
    if (name == "isotropic") {
      place_ = end;
      if (!Take('(')) return Error("'(' after isotropic");
      EGOSIEVE_ASSIGN_OR_RETURN(NamedDescription part, Enclosed(name, depth));
      if (HasColumns(part)) return Error("columns behind isotropic(...), not in it,");
      part.description = MakeIsotropic(std::move(part.description));
      return part;
    }
    const auto found = names_.find(name);
    if (found == names_.end()) return Error("a covariance function");
    place_ = end;
    return NamedDescription{found->first, found->second};
  }

  // Continues after the opening parenthesis. Unnecessary parentheses are dropped.
  absl::StatusOr<NamedDescription> Enclosed(std::string_view before, int depth) {
    EGOSIEVE_ASSIGN_OR_RETURN(NamedDescription sum, Sum(depth + 1));
    if (!Take(')')) return Error("')'");
    if (!before.empty() || sum.text.find(' ') != std::string::npos) {
      sum.text = absl::StrCat(absl::string_view(before.data(), before.size()), "(", sum.text, ")");
    }
    return sum;
  }

  void SkipSpace() {
    while (place_ < text_.size() && absl::ascii_isspace(text_[place_])) ++place_;
  }

  bool Take(char wanted) {
    SkipSpace();
    if (place_ == text_.size() || text_[place_] != wanted) return false;
    ++place_;
    return true;
  }

  absl::Status Error(const char* expected) const {
    return absl::InvalidArgumentError(
        absl::StrCat("covariance \"", absl::string_view(text_.data(), text_.size()),
                     "\": expected ", expected, " at character ", place_ + 1, "; functions are ",
                     absl::StrJoin(names_, ", ", [](std::string* out, const auto& entry) {
                       absl::StrAppend(out, entry.first);
                     })));
  }

  std::string_view text_;
  const CovarianceNames& names_;
  size_t place_ = 0;
};

}  // namespace

absl::StatusOr<NamedDescription> ParseCovariance(std::string_view text,
                                                 const CovarianceNames& names) {
  return Parser(text, names).Parse();
}

}  // namespace egosieve::kernels
