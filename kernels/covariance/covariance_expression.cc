#include "kernels/covariance/covariance_expression.h"

#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "kernels/base/status_macros.h"
#include "kernels/covariance/covariance_composition.h"

namespace egosieve::kernels {
namespace {

using Part = CovariancePart;
using Names = std::map<std::string, Part, std::less<>>;

constexpr int kDeepest = 32;  // nested parentheses

// A recursive-descent parser of the grammar.
class Parser {
 public:
  Parser(std::string_view text, const Names& names) : text_(text), names_(names) {}

  absl::StatusOr<NamedDescription> Parse() {
    EGOSIEVE_ASSIGN_OR_RETURN(NamedDescription sum, Sum(0));
    SkipSpace();
    if (place_ != text_.size()) return Error("'+' or '*'");
    return sum;
  }

 private:
  absl::StatusOr<NamedDescription> Sum(int depth) {
    return Chain('+', depth, [this](int d) {
      return Chain('*', d, [this](int inner) { return Factor(inner); });
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
  const Names& names_;
  size_t place_ = 0;
};

}  // namespace

absl::StatusOr<NamedDescription> ParseCovariance(std::string_view text, const Names& names) {
  return Parser(text, names).Parse();
}

}  // namespace egosieve::kernels
