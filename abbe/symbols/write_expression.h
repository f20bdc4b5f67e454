#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "abbe/symbols/derive.h"

namespace abbe {

enum class Notation {
  text,   ///< EXX + Z*EBX - 200*sin(A)*(EBY - EBZ): also what sympy and most languages read
  latex,  ///< E_{XX} + Z\,E_{BX} - 200\,\sin(A)\,(E_{BY} - E_{BZ})
};

/// The expression in one line, grouped as group_terms() says; "0" if it is zero. Numbers have up to 15
/// significant digits.
[[nodiscard]] std::string write_expression(const Expression& expression, const SymbolNames& names,
                                           Notation notation = Notation::text);

/// `left = expression`, broken before + and - where a line would be longer than `width` columns; later
/// lines are indented by two more columns per open bracket. Numbers have up to 12 digits: for reading.
/// Ends with a line feed.
[[nodiscard]] std::string write_text_equation(std::string_view left, const Expression& expression,
                                              const SymbolNames& names, std::size_t width);

/// `left &= expression` as lines of an align environment, broken in the same way with \\, numbered
/// once; without the \\ that ends an equation.
[[nodiscard]] std::string write_latex_equation(std::string_view left, const Expression& expression,
                                               const SymbolNames& names);

}  // namespace abbe
