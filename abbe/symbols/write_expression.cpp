#include "abbe/symbols/write_expression.h"

#include <fmt/core.h>

#include <utility>
#include <vector>

#include "abbe/symbols/grouping.h"

namespace abbe {
namespace {

constexpr int kAllDigits = 15;       // of a double that was read as a decimal number
constexpr int kReadableDigits = 12;  // what conversion of units and rounding leave behind them is not printed
constexpr std::size_t kLatexWidth = 66;    // columns of text that fit a line of a printed page
constexpr std::size_t kShortBracket = 30;  // columns: no line is broken inside

/// A sign with what follows it, up to the next sign: where lines may be broken.
struct Piece {
  std::string text;           // begins with a blank except at the start
  std::size_t width = 0;      // columns when set
  std::size_t depth = 0;      // open brackets before it
  bool starts_group = false;  // of another product of sines and cosines
};

class ExpressionWriter {
 public:
  ExpressionWriter(const SymbolNames& names, Notation notation, int digits)
      : names_(names), notation_(notation), digits_(digits) {}

  [[nodiscard]] std::vector<Piece> pieces(const Expression& expression) {
    const GroupedSum sum = group_terms(expression);
    pieces_.push_back({});
    if (sum.terms.empty()) append("0", 1);
    write(sum, 0);
    return std::move(pieces_);
  }

 private:
  void append(std::string_view text, std::size_t width) {
    pieces_.back().text += text;
    pieces_.back().width += width;
  }

  void write(const GroupedSum& sum, std::size_t depth) {
    for (std::size_t i = 0; i < sum.terms.size(); ++i) {
      const GroupedTerm& term = sum.terms[i];
      if (i > 0) {
        const bool group = depth == 0 && !term.factors.empty() && term.factors.front().bracket == nullptr &&
                           term.factors.front().symbol.is_trigonometric();
        pieces_.push_back({{}, 0, depth, group});
        append(term.negative ? " - " : " + ", 3);
      } else if (term.negative) {
        append("-", 1);
      }
      write(term, depth);
    }
  }

  void write(const GroupedTerm& term, std::size_t depth) {
    bool first = true;
    const auto separate = [&] {
      if (!first) append(notation_ == Notation::text ? "*" : "\\,", 1);
      first = false;
    };
    if (term.number != 1 || term.factors.empty()) {
      separate();
      write_number(term.number);
    }
    for (const GroupedFactor& factor : term.factors) {
      separate();
      if (factor.bracket == nullptr) {
        write_symbol(factor.symbol);
        continue;
      }
      append("(", 1);
      write_bracket(*factor.bracket, depth + 1);
      append(")", 1);
    }
  }

  /// What is in short brackets stays on one line: one piece with what stands before it.
  void write_bracket(const GroupedSum& sum, std::size_t depth) {
    const std::size_t first = pieces_.size();
    const std::size_t before = pieces_.back().width;
    write(sum, depth);
    std::size_t width = pieces_[first - 1].width - before;
    for (std::size_t i = first; i < pieces_.size(); ++i) width += pieces_[i].width;
    if (width > kShortBracket) return;
    for (std::size_t i = first; i < pieces_.size(); ++i) {
      pieces_[first - 1].text += pieces_[i].text;
      pieces_[first - 1].width += pieces_[i].width;
    }
    pieces_.resize(first);
  }

  void write_number(double number) {
    std::string text = fmt::format("{:.{}g}", number, digits_);
    const std::size_t exponent = text.find('e');
    if (notation_ == Notation::latex && exponent != std::string::npos) {
      const int power = std::stoi(text.substr(exponent + 1));
      text = fmt::format("{} \\cdot 10^{{{}}}", text.substr(0, exponent), power);
    }
    append(text, text.size());
  }

  void write_symbol(const Symbol& symbol) {
    const auto index = static_cast<std::size_t>(symbol.index);
    const std::string name =
        symbol.kind == Symbol::Kind::error ? to_string(names_.errors[index]) : names_.axes[index];
    const bool is_cosine = symbol.kind == Symbol::Kind::cosine;
    if (notation_ == Notation::text) {
      const std::string text =
          symbol.is_trigonometric() ? fmt::format("{}({})", is_cosine ? "cos" : "sin", name) : name;
      append(text, text.size());
    } else if (symbol.is_trigonometric()) {
      append(fmt::format("\\{}({})", is_cosine ? "cos" : "sin", latex_name(name)), name.size() + 5);
    } else {
      append(latex_name(name), name.size());
    }
  }

  /// E_{XX}, Z_{1}: everything after the first letter is an index.
  [[nodiscard]] static std::string latex_name(const std::string& name) {
    if (name.size() < 2) return name;
    return fmt::format("{}_{{{}}}", name.substr(0, 1), name.substr(1));
  }

  const SymbolNames& names_;
  Notation notation_;
  int digits_;
  std::vector<Piece> pieces_;
};

/// `text` and the pieces, broken where `width` would be exceeded and, if there is more than one line,
/// where another group starts. `start(depth)` is the beginning of a further line and its columns.
template <class Start>
std::string broken(std::string text, std::size_t column, const std::vector<Piece>& pieces, std::size_t width,
                   const Start& start) {
  std::size_t total = column;
  for (const Piece& piece : pieces) total += piece.width;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Piece& piece = pieces[i];
    if (i > 0 && total > width && (piece.starts_group || column + piece.width > width)) {
      const auto [line, line_column] = start(piece.depth);
      text += line;
      text += piece.text.substr(1);
      column = line_column + piece.width - 1;
    } else {
      text += piece.text;
      column += piece.width;
    }
  }
  return text;
}

}  // namespace

std::string write_expression(const Expression& expression, const SymbolNames& names, Notation notation) {
  std::string text;
  for (const Piece& piece : ExpressionWriter(names, notation, kAllDigits).pieces(expression))
    text += piece.text;
  return text;
}

std::string write_text_equation(std::string_view left, const Expression& expression, const SymbolNames& names,
                                std::size_t width) {
  const std::string start = fmt::format("{} = ", left);
  return broken(start, start.size(),
                ExpressionWriter(names, Notation::text, kReadableDigits).pieces(expression), width,
                [&](std::size_t depth) {
                  const std::size_t indent = start.size() + 2 * depth;
                  return std::pair("\n" + std::string(indent, ' '), indent);
                }) +
         "\n";
}

std::string write_latex_equation(std::string_view left, const Expression& expression,
                                 const SymbolNames& names) {
  const std::string start = fmt::format("{} &= ", left);
  return broken(start, 4, ExpressionWriter(names, Notation::latex, kReadableDigits).pieces(expression),
                kLatexWidth, [](std::size_t depth) {
                  std::string line = " \\notag \\\\\n  &\\quad ";
                  for (std::size_t i = 0; i < depth; ++i) line += "\\quad ";
                  return std::pair(line, 6 + 2 * depth);
                });
}

}  // namespace abbe
