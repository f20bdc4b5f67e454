#include "abbe/surface/write_tool_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace abbe {
namespace {

/// The highest tip, and the clearance over it.
double safe_height(const ToolPath& path, const ToolPathText& text) {
  double highest = -std::numeric_limits<double>::infinity();
  for (const ToolPass& pass : path.passes)
    for (const ToolContact& point : pass.points) highest = std::max(highest, point.tip.z());
  return highest + text.clearance;
}

/// Names as comments take them: no brackets, no control bytes.
std::string plain(const std::string& name) {
  std::string out;
  for (const char c : name.substr(0, 40))
    out += c < 0x20 || c > 0x7e || c == '(' || c == ')' || c == '$' ? ' ' : c;
  return out;
}

/// The first code of the control with that meaning.
std::optional<std::string> code_of(const Profile& profile, Meaning meaning, std::uint16_t number = 0) {
  const bool is_g = about(meaning).kind == 'G';
  const std::size_t count = is_g ? Profile::kGCodes : Profile::kMCodes;
  for (std::size_t k = 0; k < count; ++k) {
    const CodeUse& use = is_g ? profile.g[k] : profile.m[k];
    if (use.meaning == meaning && use.number == number)
      return is_g ? g_name(profile, k) : fmt::format("M{}", k);
  }
  return std::nullopt;
}

/// Words of a tip; those that stay are left out.
class Words {
 public:
  explicit Words(const Profile& profile) : decimals_(profile.numbers.decimals_mm) {}

  std::string of(const Vec3& tip) {
    std::string out;
    for (std::size_t k = 0; k < 3; ++k) {
      std::string number = fmt::format("{:.{}f}", tip[static_cast<Eigen::Index>(k)], decimals_);
      if (number.find_first_not_of("-0.") == std::string::npos && number[0] == '-') number.erase(0, 1);
      if (number == last_[k]) continue;
      out += fmt::format(" {}{}", "XYZ"[k], number);
      last_[k] = std::move(number);
    }
    return out;
  }

 private:
  int decimals_;
  std::array<std::string, 3> last_;
};

Vec3 lifted(const Vec3& tip, double height) { return {tip.x(), tip.y(), height}; }

}  // namespace

std::string write_cl(const ToolPath& path, const ToolPathText& text) {
  const double safe = safe_height(path, text);
  std::string out = fmt::format("PARTNO {}\nUNITS/MM\nCUTTER/{:.4f},{:.4f}\nFEDRAT/{:.1f},MMPM\n",
                                plain(text.name), 2 * text.radius, text.radius, text.feed);
  const auto go = [&](const Vec3& tip, bool rapid) {
    out += fmt::format("{}GOTO/{:.6f},{:.6f},{:.6f}\n", rapid ? "RAPID\n" : "", tip.x(), tip.y(), tip.z());
  };
  const ToolContact* last = nullptr;
  for (const ToolPass& pass : path.passes) {
    if (!pass.linked) {
      if (last != nullptr) go(lifted(last->tip, safe), true);
      go(lifted(pass.points.front().tip, safe), true);
    }
    for (const ToolContact& point : pass.points) go(point.tip, false);
    last = &pass.points.back();
  }
  if (last != nullptr) go(lifted(last->tip, safe), true);
  return out + "FINI\n";
}

std::optional<std::string> write_program(const ToolPath& path, const ToolPathText& text,
                                         const Profile& profile) {
  const auto rapid = code_of(profile, Meaning::rapid), line = code_of(profile, Meaning::line),
             metric = code_of(profile, Meaning::units_mm), absolute = code_of(profile, Meaning::absolute),
             minute = code_of(profile, Meaning::per_minute), end = code_of(profile, Meaning::end);
  if (!rapid || !line || !metric || !absolute || !minute || !end) return std::nullopt;
  const double safe = safe_height(path, text);
  std::string out = profile.text.percent ? "%\n" : "";
  if (profile.text.parentheses)
    out += fmt::format("({}, ball of {} mm)\n(switch on spindle and coolant before)\n", plain(text.name),
                       text.radius);
  const auto offset = code_of(profile, Meaning::work_offset, 1);
  out += fmt::format("{} {} {}{}\n", *metric, *absolute, *minute, offset ? " " + *offset : "");
  const auto length = code_of(profile, Meaning::tool_length), change = code_of(profile, Meaning::tool_change);
  if (text.tool) {
    if (!length || !change) return std::nullopt;
    out += fmt::format("T{} {}\n", *text.tool, *change);
  }
  Words words(profile);
  const auto lift = [&](const Vec3& tip) {
    return fmt::format("{}{}\n", *rapid, words.of(lifted(tip, safe)));
  };
  const ToolContact* last = nullptr;
  for (const ToolPass& pass : path.passes) {
    if (!pass.linked) {
      if (last != nullptr) out += lift(last->tip);
      const Vec3 above = lifted(pass.points.front().tip, safe);
      const std::string tool =
          last == nullptr && text.tool ? fmt::format("{} H{} ", *length, *text.tool) : "";
      out += fmt::format("{}{}{}\n", tool, *rapid, words.of(above));
    }
    for (std::size_t k = 0; k < pass.points.size(); ++k) {
      const std::string moved = words.of(pass.points[k].tip);
      const bool first = k == 0 && !pass.linked;
      if (moved.empty() && !first) continue;
      out += fmt::format("{}{}{}\n", *line, moved, first ? fmt::format(" F{:.1f}", text.feed) : "");
    }
    last = &pass.points.back();
  }
  if (last != nullptr) out += lift(last->tip);
  return out + *end + "\n" + (profile.text.percent ? "%\n" : "");
}

}  // namespace abbe
