#include "abbe/machine/error_section.h"

#include <fmt/format.h>

#include <map>
#include <string>
#include <utility>

#include "abbe/machine/machine_sections.h"
#include "abbe/machine/toml_values.h"

namespace abbe {
namespace {

constexpr std::string_view kErrorNames =
    "names: E, direction X Y Z A B C, axis (EXX); with 0 before the axis for its location (EC0Y); "
    "T thermal and D dynamic (TZX, DXX); t and w for tool and workpiece (EXt, ECw)";

/// What names mean on this chain.
class Names {
 public:
  Names(const std::vector<Body>& bodies, Findings& findings) : bodies_(bodies), findings_(findings) {}

  std::optional<ErrorName> read(const TomlEntry& entry) {
    const auto name = read_error_name(entry.key);
    if (!name) {
      findings_.error(
          "E-ERROR-NAME", entry.mark, fmt::format("{} is not the name of an error", in_quotes(entry.key)),
          std::string(kErrorNames), suggestion(entry.key, all(), "use a name of an axis of the chain"));
      return std::nullopt;
    }
    if (is_mount(*name) && name->error_class != ErrorClass::component) {
      findings_.error(
          "E-ERROR-NAME", entry.mark, fmt::format("{} is not the name of an error", in_quotes(entry.key)),
          "tool and workpiece have mounting errors E only",
          fmt::format("write it as {}", to_string({ErrorClass::component, name->direction, name->axis})));
      return std::nullopt;
    }
    if (!is_mount(*name) && body_of(*name) < 0) {
      std::vector<std::string> axes;
      for (const Body& body : bodies_) axes.push_back(body.name);
      findings_.error("E-ERROR-AXIS", entry.mark,
                      fmt::format("{} is an error of axis {}, which is not in the chain",
                                  in_quotes(entry.key), in_quotes(name->axis)),
                      axes.empty() ? "the chain has no axes" : "the chain has " + listed(axes, "and"),
                      suggestion(entry.key, all(), "name an axis of the chain, t or w"));
      return std::nullopt;
    }
    return name;
  }

  [[nodiscard]] int body_of(const ErrorName& name) const {
    if (name.axis == "t") return kToolBody;
    if (name.axis == "w") return kWorkpieceBody;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (bodies_[i].name == name.axis) return static_cast<int>(i);
    }
    return -3;
  }

  static bool is_mount(const ErrorName& name) { return name.axis == "t" || name.axis == "w"; }

 private:
  /// Every name that this chain knows, for suggestions.
  const std::vector<std::string>& all() {
    if (!all_.empty()) return all_;
    const auto add = [&](ErrorClass error_class, const std::string& axis) {
      for (int direction = 0; direction < 6; ++direction) {
        all_.push_back(to_string({error_class, direction, axis}));
      }
    };
    for (const Body& body : bodies_) {
      for (const auto error_class :
           {ErrorClass::component, ErrorClass::location, ErrorClass::thermal, ErrorClass::dynamic}) {
        add(error_class, body.name);
      }
    }
    add(ErrorClass::component, "t");
    add(ErrorClass::component, "w");
    return all_;
  }

  const std::vector<Body>& bodies_;
  Findings& findings_;
  std::vector<std::string> all_;
};

int own_variable(int body, const std::vector<Body>& bodies) {
  return body < 0 ? -1 : bodies[static_cast<std::size_t>(body)].axis;
}

}  // namespace

ErrorSection read_errors(const TomlNode& root, const std::vector<Body>& bodies, const FileUnits& units,
                         FunctionReader& functions, Findings& findings) {
  ErrorSection section;
  Names names(bodies, findings);
  struct Known {
    const TomlEntry* entry;
    std::optional<std::size_t> term;  ///< none if its function was not understood
  };
  std::map<std::string, Known> known;

  if (const TomlNode* table = find_table(root, "errors", findings)) {
    for (const TomlEntry& entry : table->entries) {
      if (findings.full()) break;
      const auto name = names.read(entry);
      if (!name) continue;
      const auto [at, added] = known.emplace(to_string(*name), Known{&entry, std::nullopt});
      if (!added) {
        findings.error(
            "E-ERROR-TWICE", entry.mark,
            fmt::format("{} is the same error as {}", in_quotes(entry.key), in_quotes(at->second.entry->key)),
            fmt::format("it is stated in line {} already", at->second.entry->mark.line),
            "keep one of them; a list [ .. , .. ] adds two parts of an error");
        continue;
      }
      ErrorTerm term;
      term.name = *name;
      term.body = names.body_of(*name);
      term.scale = name->is_rotation() ? units.error_angle : units.error_length;
      auto function = functions.read(entry.value, entry.key, own_variable(term.body, bodies));
      if (!function) continue;
      term.function = std::move(function->function);
      term.of_one_test = function->of_one_test;
      at->second.term = section.terms.size();
      section.terms.push_back(std::move(term));
      section.notes.push_back({entry.mark, function->extent});
    }
  }

  if (const TomlNode* table = find_table(root, "uncertainty", findings)) {
    for (const TomlEntry& entry : table->entries) {
      if (findings.full()) break;
      const auto name = names.read(entry);
      if (!name) continue;
      const auto at = known.find(to_string(*name));
      if (at == known.end()) {
        findings.error("E-UNCERTAINTY", entry.mark,
                       fmt::format("uncertainty of {}, which has no value", entry.key),
                       "an uncertainty belongs to a stated error",
                       fmt::format("add {} = 0 to [errors] if it was measured as zero", entry.key));
        continue;
      }
      auto function =
          functions.read_uncertainty(entry.value, entry.key, own_variable(names.body_of(*name), bodies));
      if (!function || !at->second.term) continue;
      auto& uncertainty = section.terms[*at->second.term].uncertainty;
      if (uncertainty) {
        findings.error("E-ERROR-TWICE", entry.mark,
                       fmt::format("a second uncertainty of {}", to_string(*name)),
                       "the same error has two spellings here", "keep one of them");
        continue;
      }
      uncertainty = std::move(*function);
    }
  }
  return section;
}

}  // namespace abbe
