#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace abbe {

/// A point on the page: x to the right, y downwards, in points of 1/96 inch.
struct PagePoint {
  double x = 0, y = 0;
};

/// Builds one self-contained SVG picture: no scripts, no fonts or files from elsewhere, coordinates
/// with one decimal, so that equal input gives equal bytes.
class SvgPage {
 public:
  SvgPage(double width, double height);

  enum class Anchor { start, middle, end };
  struct TextStyle {
    double size = 12;
    Anchor anchor = Anchor::start;
    bool bold = false;
    double turned = 0;  ///< degrees, counter-clockwise
    std::string_view colour = "#222222";
  };
  struct LineStyle {
    std::string_view colour = "#222222";
    double width = 1;
    std::string_view dashes = {};  ///< as "4 3"; empty = solid
    double opacity = 1;
  };

  void text(PagePoint at, std::string_view text, const TextStyle& style);
  void line(PagePoint from, PagePoint to, const LineStyle& style);
  void polyline(const std::vector<PagePoint>& points, const LineStyle& style);
  /// Many polylines of one style in one element.
  void polylines(const std::vector<std::vector<PagePoint>>& lines, const LineStyle& style);
  void dot(PagePoint centre, double radius, std::string_view colour);
  void ring(PagePoint centre, double radius, const LineStyle& style);
  void box(PagePoint corner, double width, double height, std::string_view fill,
           std::string_view stroke = {});

  /// The whole file.
  [[nodiscard]] std::string finish(std::string_view title, std::string_view description) const;

 private:
  double width_, height_;
  std::string body_;
};

/// Text with the characters that mark-up uses replaced, and bytes that XML does not allow as '?'.
[[nodiscard]] std::string xml_text(std::string_view text);

/// Round numbers from lo to hi (about `count` of them, multiples of 1, 2 or 5 times a power of ten),
/// and the decimals needed to tell them apart. lo < hi, both finite.
struct Ticks {
  std::vector<double> values;
  int decimals = 0;
};
[[nodiscard]] Ticks round_ticks(double lo, double hi, int count);

/// The smallest 1, 1.5, 2, 3, 4, 5, 6 or 8 times a power of ten that is at least `value` (1 for 0).
[[nodiscard]] double round_up(double value);

}  // namespace abbe
