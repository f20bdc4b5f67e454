#include "abbe/symbols/derive.h"

#include <fmt/core.h>

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "abbe/machine/machine.h"
#include "abbe/report/json_writer.h"
#include "abbe/symbols/write_expression.h"
#include "common.h"
#include "text.h"
#include "verbs.h"

namespace abbe::app {
namespace {

constexpr std::size_t kWidth = 100;  // columns of a terminal

struct DeriveArguments {
  CommonArguments common;
  std::string format = "text";
  bool contributions = false;
  bool all = false;
};

/// One of the results: what it is called in each notation, and its components.
struct Quantity {
  std::string_view member;               // JSON
  std::array<std::string_view, 3> keys;  // JSON
  std::array<std::string_view, 3> text, latex;
  std::string_view heading;
  const Vec3T<Expression>* value;
};

std::array<Quantity, 4> quantities(const Derivation& d) {
  return {{{"deviation",
            {"x", "y", "z"},
            {"dx", "dy", "dz"},
            {"\\Delta x", "\\Delta y", "\\Delta z"},
            "deviation of the tip, actual - nominal, workpiece axes, mm",
            &d.deviation},
           {"tool_axis",
            {"x", "y", "z"},
            {"di", "dj", "dk"},
            {"\\Delta i", "\\Delta j", "\\Delta k"},
            "deviation of the tool axis (unit vector from the tip to the spindle), workpiece axes",
            &d.tool_axis},
           {"tool_twist",
            {"dx", "dy", "dz"},
            {"dx", "dy", "dz"},
            {"\\delta_x", "\\delta_y", "\\delta_z"},
            "the same as displacement of the tip in axes of the ideal tool, mm",
            &d.twist_d},
           {"tool_twist",
            {"ex", "ey", "ez"},
            {"ex", "ey", "ez"},
            {"\\varepsilon_x", "\\varepsilon_y", "\\varepsilon_z"},
            "and rotation of the tool, axes of the ideal tool, rad",
            &d.twist_e}}};
}

Vec3T<Expression> lever_of(const Vec3T<Expression>& value, std::size_t error) {
  return value.unaryExpr([&](const Expression& component) {
    return component.derivative({Symbol::Kind::error, static_cast<int>(error)});
  });
}

/// The part of the machine that the equations depend on besides the file's numbers: how the values of
/// errors of a table are meant.
std::vector<std::string> sign_remarks(const Machine& machine) {
  std::vector<std::string> remarks;
  for (const Body& body : machine.bodies) {
    if (body.branch != Branch::workpiece || body.type == AxisType::fixed) continue;
    remarks.push_back(fmt::format("{} carries the workpiece; its errors are those of the {}", body.name,
                                  body.errors_seen_at_tool ? "tool as seen from the workpiece"
                                                           : "body itself: the tool errs the other way"));
  }
  return remarks;
}

void write_members(JsonWriter& json, const std::array<Quantity, 4>& all, const SymbolNames& names,
                   const std::function<Vec3T<Expression>(const Vec3T<Expression>&)>& shown) {
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Quantity& quantity = all[i];
    const bool continues = i > 0 && all[i - 1].member == quantity.member;
    if (!continues) json.key(quantity.member).begin_object();
    const Vec3T<Expression> value = shown(*quantity.value);
    for (std::size_t k = 0; k < 3; ++k)
      json.member(quantity.keys[k], write_expression(value[static_cast<int>(k)], names));
    if (i + 1 == all.size() || all[i + 1].member != quantity.member) json.end();
  }
}

void write_json(const Setting& setting, const Derivation& d, bool contributions, Session& session) {
  const std::array<Quantity, 4> all = quantities(d);
  JsonWriter json;
  json.begin_object();
  write_preamble(json, "derive", setting.machine);
  std::vector<std::string> names;
  for (const ErrorName& name : d.names.errors) names.push_back(abbe::to_string(name));
  json.member("errors", names).member("axes", d.names.axes);
  write_members(json, all, d.names, [](const Vec3T<Expression>& value) { return value; });
  if (contributions) {
    json.key("contributions").begin_array();
    for (std::size_t i = 0; i < names.size(); ++i) {
      json.begin_object().member("error", names[i]);
      write_members(json, all, d.names, [i](const Vec3T<Expression>& value) { return lever_of(value, i); });
      json.end();
    }
    json.end();
  }
  write_findings(json, "warnings", setting.findings);
  json.end();
  session.out.write(json.take());
}

void write_text(const Machine& machine, const Derivation& d, bool contributions, Session& session) {
  Output& out = session.out;
  out.write(fmt::format("machine  {}\nchain    {}\n", machine.name, machine.chain));
  out.write("first order in the errors; values of errors and positions in mm and rad\n");
  for (const std::string& remark : sign_remarks(machine)) out.write(remark + "\n");
  const std::array<Quantity, 4> all = quantities(d);
  for (const Quantity& quantity : all) {
    out.write(fmt::format("\n{}\n", quantity.heading));
    if (quantity.value == &d.twist_d && d.twist_d == d.deviation) {
      out.write("  no axis turns the tool against the workpiece: the equations above\n");
      continue;
    }
    for (std::size_t k = 0; k < 3; ++k)
      out.write(write_text_equation(fmt::format("  {}", quantity.text[k]),
                                    (*quantity.value)[static_cast<int>(k)], d.names, kWidth));
  }
  if (!contributions) return;
  out.write("\nlevers: what a unit of each error adds\n");
  for (std::size_t i = 0; i < d.names.errors.size(); ++i) {
    const std::string name = abbe::to_string(d.names.errors[i]);
    bool acts = false;
    for (const Quantity* quantity : {&all[0], &all[1]}) {
      const Vec3T<Expression> lever = lever_of(*quantity->value, i);
      for (int k = 0; k < 3; ++k) {
        if (lever[k].is_zero()) continue;
        out.write(write_text_equation(
            fmt::format("  {:<5} {}", acts ? "" : name, quantity->text[static_cast<std::size_t>(k)]),
            lever[k], d.names, kWidth));
        acts = true;
      }
    }
    if (!acts) out.write(fmt::format("  {:<5} no effect on tip and tool axis\n", name));
  }
}

/// Equations of one environment, each with its own number.
void write_align(Output& out, const std::vector<std::string>& equations) {
  out.write("\\begin{align}\n");
  for (std::size_t i = 0; i < equations.size(); ++i)
    out.write(fmt::format("  {}{}\n", equations[i], i + 1 < equations.size() ? " \\\\" : ""));
  out.write("\\end{align}\n");
}

void write_latex(const Machine& machine, const Derivation& d, bool contributions, Session& session) {
  Output& out = session.out;
  out.write(fmt::format("% {}: {}\n% first order, mm and rad; needs \\usepackage{{amsmath}}\n", machine.name,
                        machine.chain));
  const std::array<Quantity, 4> all = quantities(d);
  for (const Quantity& quantity : all) {
    out.write(fmt::format("% {}\n", quantity.heading));
    std::vector<std::string> equations;
    for (std::size_t k = 0; k < 3; ++k)
      equations.push_back(
          write_latex_equation(quantity.latex[k], (*quantity.value)[static_cast<int>(k)], d.names));
    write_align(out, equations);
  }
  if (!contributions) return;
  out.write("% levers: what a unit of each error adds\n");
  for (std::size_t i = 0; i < d.names.errors.size(); ++i) {
    const Expression error(Symbol{Symbol::Kind::error, static_cast<int>(i)});
    std::vector<std::string> equations;
    for (const Quantity* quantity : {&all[0], &all[1]}) {
      const Vec3T<Expression> lever = lever_of(*quantity->value, i);
      for (int k = 0; k < 3; ++k) {
        if (lever[k].is_zero()) continue;
        const std::string left = fmt::format("\\frac{{\\partial {}}}{{\\partial {}}}",
                                             quantity->latex[static_cast<std::size_t>(k)],
                                             write_expression(error, d.names, Notation::latex));
        equations.push_back(write_latex_equation(left, lever[k], d.names));
      }
    }
    if (equations.empty()) {
      out.write(fmt::format("% {}: no effect\n", abbe::to_string(d.names.errors[i])));
    } else {
      write_align(out, equations);
    }
  }
}

void run_derive(const DeriveArguments& arguments, Session& session) {
  const std::optional<Setting> setting = load_setting(arguments.common, session);
  if (!setting) return;
  const Derivation derivation = derive(arguments.all ? with_inventory(setting->machine) : setting->machine);
  if (derivation.names.errors.empty()) {
    session.report(option_warning("derive", "this machine file gives no error, so every deviation is zero",
                                  "--all takes the whole inventory of the chain"));
  }
  if (arguments.common.json || arguments.format == "json") {
    write_json(*setting, derivation, arguments.contributions, session);
  } else if (arguments.format == "latex") {
    write_latex(setting->machine, derivation, arguments.contributions, session);
  } else {
    write_text(setting->machine, derivation, arguments.contributions, session);
  }
}

}  // namespace

Verb derive_verb(Command& program, Session& session) {
  Command* command = program.add_subcommand("derive", "the first-order equations of a machine in symbols");
  auto arguments = std::make_shared<DeriveArguments>();
  add_machine_options(*command, arguments->common, session);
  command
      ->add_option("--format", arguments->format, "text (default), latex, json; --json is the same as json")
      ->check(one_of({"text", "latex", "json"}));
  command->add_flag("--contributions", arguments->contributions,
                    "also the lever of each error: what a unit of it adds to the deviation");
  command->add_flag("--all", arguments->all, "also the errors of the inventory that the file does not give");
  return {command, [arguments, &session] { run_derive(*arguments, session); }};
}

}  // namespace abbe::app
