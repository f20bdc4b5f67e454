#include "abbe/machine/error_body.h"

namespace abbe {

std::optional<int> body_of(const Machine& machine, const ErrorName& name) {
  if (name.axis == "t") return kToolBody;
  if (name.axis == "w") return kWorkpieceBody;
  for (std::size_t i = 0; i < machine.bodies.size(); ++i)
    if (machine.bodies[i].name == name.axis) return static_cast<int>(i);
  return std::nullopt;
}

std::optional<Machine> with_unit_error(const Machine& machine, const ErrorName& name) {
  const std::optional<int> body = body_of(machine, name);
  if (!body) return std::nullopt;
  Machine single = machine;
  single.errors = {ErrorTerm{name, *body, ErrorFunction::constant(1), 1, std::nullopt}};
  return single;
}

}  // namespace abbe
