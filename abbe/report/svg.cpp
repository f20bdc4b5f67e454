#include "abbe/report/svg.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "abbe/report/utf8.h"

namespace abbe {
namespace {

/// One decimal is finer than any printer; "-0.0" and trailing zeros are left out.
std::string number(double value) {
  std::string text = fmt::format("{:.1f}", value);
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

std::string line_attributes(const SvgPage::LineStyle& style) {
  std::string text = fmt::format("stroke=\"{}\" stroke-width=\"{}\"", style.colour, number(style.width));
  if (!style.dashes.empty()) text += fmt::format(" stroke-dasharray=\"{}\"", style.dashes);
  if (style.opacity < 1) text += fmt::format(" stroke-opacity=\"{}\"", number(style.opacity));
  return text;
}

}  // namespace

std::string xml_text(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const char c = text.front();
    if (length > 1) {
      // U+FFFE and U+FFFF are no characters of XML.
      const bool allowed = !text.starts_with("\xEF\xBF\xBE") && !text.starts_with("\xEF\xBF\xBF");
      result += allowed ? text.substr(0, length) : std::string_view("?");
    } else if (length == 0 || static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
      result += '?';
    } else if (c == '<') {
      result += "&lt;";
    } else if (c == '>') {
      result += "&gt;";
    } else if (c == '&') {
      result += "&amp;";
    } else if (c == '"') {
      result += "&quot;";
    } else {
      result += c;
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return result;
}

SvgPage::SvgPage(double width, double height) : width_(width), height_(height) {}

void SvgPage::text(PagePoint at, std::string_view text, const TextStyle& style) {
  const char* anchor = style.anchor == Anchor::start    ? "start"
                       : style.anchor == Anchor::middle ? "middle"
                                                        : "end";
  body_ += fmt::format("<text x=\"{}\" y=\"{}\" font-size=\"{}\" text-anchor=\"{}\" fill=\"{}\"",
                       number(at.x), number(at.y), number(style.size), anchor, style.colour);
  if (style.bold) body_ += " font-weight=\"bold\"";
  if (style.turned != 0) {
    body_ +=
        fmt::format(" transform=\"rotate({} {} {})\"", number(-style.turned), number(at.x), number(at.y));
  }
  body_ += fmt::format(">{}</text>\n", xml_text(text));
}

void SvgPage::line(PagePoint from, PagePoint to, const LineStyle& style) {
  body_ += fmt::format("<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\" {}/>\n", number(from.x), number(from.y),
                       number(to.x), number(to.y), line_attributes(style));
}

void SvgPage::polyline(const std::vector<PagePoint>& points, const LineStyle& style) {
  polylines({points}, style);
}

void SvgPage::polylines(const std::vector<std::vector<PagePoint>>& lines, const LineStyle& style) {
  std::string path;
  for (const std::vector<PagePoint>& points : lines) {
    for (std::size_t i = 0; points.size() > 1 && i < points.size(); ++i) {
      path += i == 0 ? (path.empty() ? "M" : " M") : i == 1 ? "L" : " ";
      path += number(points[i].x) + ',' + number(points[i].y);
    }
  }
  if (path.empty()) return;
  body_ +=
      fmt::format("<path fill=\"none\" stroke-linejoin=\"round\" stroke-linecap=\"round\" {} d=\"{}\"/>\n",
                  line_attributes(style), path);
}

void SvgPage::dot(PagePoint centre, double radius, std::string_view colour) {
  body_ += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{}\"/>\n", number(centre.x),
                       number(centre.y), number(radius), colour);
}

void SvgPage::ring(PagePoint centre, double radius, const LineStyle& style) {
  body_ += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"none\" {}/>\n", number(centre.x),
                       number(centre.y), number(radius), line_attributes(style));
}

void SvgPage::box(PagePoint corner, double width, double height, std::string_view fill,
                  std::string_view stroke) {
  body_ += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\"", number(corner.x),
                       number(corner.y), number(width), number(height), fill.empty() ? "none" : fill);
  if (!stroke.empty()) body_ += fmt::format(" stroke=\"{}\" stroke-width=\"1\"", stroke);
  body_ += "/>\n";
}

std::string SvgPage::finish(std::string_view title, std::string_view description) const {
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
      "font-family=\"Helvetica, Arial, Liberation Sans, DejaVu Sans, sans-serif\">\n"
      "<title>{2}</title>\n<desc>{3}</desc>\n<rect width=\"{0}\" height=\"{1}\" "
      "fill=\"#ffffff\"/>\n{4}</svg>\n",
      number(width_), number(height_), xml_text(title), xml_text(description), body_);
}

Ticks round_ticks(double lo, double hi, int count) {
  Ticks ticks;
  if (!(hi > lo) || !std::isfinite(hi - lo) || count < 1) return ticks;
  const double least = (hi - lo) / count;
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * power >= least * (1 - 1e-9)) step = factor * power;
  }
  ticks.decimals = std::clamp(static_cast<int>(-std::floor(std::log10(step) + 1e-9)), 0, 9);
  const double first = std::ceil(lo / step - 1e-9), last = std::floor(hi / step + 1e-9);
  // Far from zero the steps may be finer than doubles: then there is nothing to tell apart.
  if (!(last - first <= 10.0 * count)) return ticks;
  for (double k = first; k <= last; ++k) ticks.values.push_back(k * step + 0.0);
  return ticks;
}

double round_up(double value) {
  if (!(value > 0) || !std::isfinite(value)) return 1;
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double factor : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0}) {
    if (factor * power >= value * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

}  // namespace abbe
