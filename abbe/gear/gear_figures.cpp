#include "abbe/gear/gear_figures.h"

#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

constexpr std::array kFlanks = {Flank::right, Flank::left};

std::size_t index_of(Flank flank) { return flank == Flank::right ? 0 : 1; }

double range_of(const std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto [lo, hi] = std::minmax_element(values.begin(), values.end());
  return *hi - *lo;
}

PitchFigures pitch_of(const std::vector<std::array<FlankFigures, 2>>& teeth, std::size_t side) {
  PitchFigures pitch;
  const std::size_t count = teeth.size();
  for (std::size_t i = 0; i < count; ++i) {
    pitch.index.push_back(teeth[i][side].position - teeth[0][side].position);
    pitch.single.push_back(teeth[i][side].position - teeth[(i + count - 1) % count][side].position);
    pitch.f_p = std::max(pitch.f_p, std::abs(pitch.single.back()));
  }
  pitch.F_p = range_of(pitch.index);
  return pitch;
}

/// Contacts at these roll angles; false: some is missing.
bool find_contacts(const Gear& gear, const WheelInGap& wheel, const std::vector<double>& rolls,
                   std::array<std::vector<WheelContact>, 2>& contacts) {
  for (const Flank flank : kFlanks)
    for (const double roll : rolls) {
      const std::optional<WheelContact> contact = wheel_contact(gear, wheel, flank, roll);
      if (!contact) return false;
      contacts[index_of(flank)].push_back(*contact);
    }
  return true;
}

}  // namespace

std::size_t gap_of(const Gear& gear, int tooth, Flank flank) {
  const int gap = flank == Flank::right ? tooth : tooth + 1;
  return static_cast<std::size_t>(gap % gear.spec.teeth);
}

TraceFigures trace_figures(std::span<const double> x, std::span<const double> f, double length) {
  const std::size_t n = std::min(x.size(), f.size());
  if (n == 0) return {};
  double mean_x = 0, mean_f = 0;
  for (std::size_t i = 0; i < n; ++i) {
    mean_x += x[i] / static_cast<double>(n);
    mean_f += f[i] / static_cast<double>(n);
  }
  double xx = 0, xf = 0;
  for (std::size_t i = 0; i < n; ++i) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    xf += (x[i] - mean_x) * (f[i] - mean_f);
  }
  const double slope = xx > 0 ? xf / xx : 0.0;
  std::array<double, 2> about_design = {f[0], f[0]}, about_mean = {0, 0};
  for (std::size_t i = 0; i < n; ++i) {
    const double rest = f[i] - mean_f - slope * (x[i] - mean_x);
    about_design = {std::min(about_design[0], f[i]), std::max(about_design[1], f[i])};
    about_mean = {std::min(about_mean[0], rest), std::max(about_mean[1], rest)};
  }
  return {about_design[1] - about_design[0], about_mean[1] - about_mean[0], slope * length};
}

std::optional<GearInspection> GearInspection::make(const Gear& gear, const WheelInGap& wheel,
                                                   const EvaluationSpec& spec) {
  GearInspection out(gear, wheel);
  const double flank_length = gear.base_radius * (gear.tip_roll - gear.form_roll);
  out.profile_length_ = spec.profile_part * flank_length;
  std::vector<double> rolls;
  for (int i = 0; i < spec.profile_samples; ++i) {
    out.profile_x_.push_back(out.profile_length_ * i / (spec.profile_samples - 1));
    rolls.push_back(gear.form_roll + out.profile_x_.back() / gear.base_radius);
  }
  const double b = gear.spec.face_width;
  const double end = std::min(spec.helix_end_part * b, spec.helix_end_modules * gear.spec.module);
  out.helix_length_ = b - 2 * end;
  for (int i = 0; i < spec.helix_samples; ++i)
    out.helix_z_.push_back(out.helix_length_ * (static_cast<double>(i) / (spec.helix_samples - 1) - 0.5));
  std::array<std::vector<WheelContact>, 2> reference;
  const bool found = find_contacts(gear, wheel, rolls, out.profile_) &&
                     find_contacts(gear, wheel, even_rolls(gear, spec.profile_samples), out.whole_) &&
                     find_contacts(gear, wheel, {gear.reference_roll}, reference);
  if (!found) return std::nullopt;
  for (std::size_t side = 0; side < 2; ++side) out.reference_[side] = reference[side].front();
  return out;
}

FlankFigures GearInspection::flank_figures(const WheelDeviations& deviations, std::size_t gap,
                                           Flank flank) const {
  const std::size_t side = index_of(flank);
  std::vector<double> f;
  for (const WheelContact& contact : profile_[side])
    f.push_back(flank_deviation(gear_, wheel_, deviations, gap, contact, 0));
  FlankFigures out;
  out.profile = trace_figures(profile_x_, f, profile_length_);
  f.clear();
  for (const double z : helix_z_)
    f.push_back(flank_deviation(gear_, wheel_, deviations, gap, reference_[side], z));
  out.helix = trace_figures(helix_z_, f, helix_length_);
  // Excess material moves a right flank clockwise, a left one counter-clockwise.
  const double middle = flank_deviation(gear_, wheel_, deviations, gap, reference_[side], 0);
  out.position = -side_of_gap(flank) * middle / std::cos(gear_.transverse_angle);
  return out;
}

GearFigures GearInspection::figures(const WheelDeviations& deviations) const {
  GearFigures out;
  const int teeth = gear_.spec.teeth;
  out.teeth.resize(static_cast<std::size_t>(teeth));
  for (int tooth = 0; tooth < teeth; ++tooth)
    for (const Flank flank : kFlanks)
      out.teeth[static_cast<std::size_t>(tooth)][index_of(flank)] =
          flank_figures(deviations, gap_of(gear_, tooth, flank), flank);
  for (std::size_t side = 0; side < 2; ++side) out.pitch[side] = pitch_of(out.teeth, side);
  // A ball that touches both flanks at the reference cylinder: n+- . (x, y) = f+-
  const double phi = gear_.reference_roll + gear_.half_gap - involute_of_roll(gear_.reference_roll);
  for (std::size_t gap = 0; gap < static_cast<std::size_t>(teeth); ++gap) {
    double sum = 0;
    for (std::size_t side = 0; side < 2; ++side)
      sum += flank_deviation(gear_, wheel_, deviations, gap, reference_[side], 0);
    out.ball.push_back(sum / (2 * std::sin(phi)));
  }
  out.F_r = range_of(out.ball);
  return out;
}

FlankTraces GearInspection::traces(const WheelDeviations& deviations, int tooth, Flank flank) const {
  const std::size_t side = index_of(flank), gap = gap_of(gear_, tooth, flank);
  FlankTraces out;
  for (const WheelContact& contact : whole_[side]) {
    out.roll_length.push_back(gear_.base_radius * contact.roll);
    out.profile.push_back(flank_deviation(gear_, wheel_, deviations, gap, contact, 0));
  }
  out.z = even_heights(gear_, static_cast<int>(helix_z_.size()));
  for (const double z : out.z)
    out.helix.push_back(flank_deviation(gear_, wheel_, deviations, gap, reference_[side], z));
  return out;
}

}  // namespace abbe
