#include "bus_record.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <utility>

#include "common.h"
#include "csv.h"

namespace abbe::app {

std::optional<BusRecord> load_bus_record(const std::string& file, TestPlane plane, Session& session) {
  FileResult<CsvReader> opened = CsvReader::open(file);
  if (const auto* error = std::get_if<FileError>(&opened)) {
    session.report(*error, file);
    return std::nullopt;
  }
  auto& csv = std::get<CsvReader>(opened);
  BusRecord record;
  const char first = axis_letter(plane.first), second = axis_letter(plane.second);
  const std::array<std::pair<std::string, std::vector<double>*>, 5> wanted = {{
      {"t_s", &record.time},
      {fmt::format("{}.target_position_mm", first), &record.commanded[0]},
      {fmt::format("{}.target_position_mm", second), &record.commanded[1]},
      {fmt::format("{}.position_actual_mm", first), &record.actual[0]},
      {fmt::format("{}.position_actual_mm", second), &record.actual[1]},
  }};
  std::array<std::size_t, 5> places{};
  for (std::size_t i = 0; i < wanted.size() && !csv.failed(); ++i) {
    const auto found = std::find(csv.header().begin(), csv.header().end(), wanted[i].first);
    if (found == csv.header().end()) {
      session.report(option_error(
          "--bus", fmt::format("{} has no column {}", file, wanted[i].first),
          fmt::format("abbe capture FILE --axis {}=STATION:COUNTS/mm,{}=.. -o bus.csv", first, second)));
      return std::nullopt;
    }
    places[i] = static_cast<std::size_t>(found - csv.header().begin());
  }
  while (csv.next() && !interrupted()) {
    for (std::size_t i = 0; i < wanted.size(); ++i)
      if (const auto value = csv.number(places[i])) wanted[i].second->push_back(*value);
  }
  if (!csv.failed()) return record;
  session.report(*csv.failure());
  return std::nullopt;
}

std::optional<BallbarTest> with_bus(BallbarTest test, const std::string& file, Session& session) {
  const std::optional<BusRecord> record = load_bus_record(file, test.plane, session);
  if (!record) return std::nullopt;
  auto joined = join_bus(test, *record);
  if (auto* trouble = std::get_if<JoinTrouble>(&joined)) {
    Diagnostic why;
    why.code = "E-JOIN";
    why.place.file = file;
    why.message = std::move(trouble->message);
    why.why = std::move(trouble->why);
    why.fix = std::move(trouble->fix);
    session.report(why);
    return std::nullopt;
  }
  return std::get<BallbarTest>(std::move(joined));
}

}  // namespace abbe::app
