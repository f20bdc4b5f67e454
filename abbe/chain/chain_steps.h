#pragma once

#include <vector>

#include "abbe/chain/group_builder.h"

namespace abbe {

/// One matrix of the chain, in the order in which a tool point meets them.
struct Step {
  enum class Kind { tip, translate, motion, error } kind = Kind::translate;
  Vec3 vector = Vec3::Zero();  // translate: by; motion and error: the axis direction
  const Body* body = nullptr;  // motion
  int group = -1;              // error
  Part part = Part::all;
  bool inverse = false;  // motion, error: the inverse matrix acts on the point
};

/// T_wt = T_bw^-1 T_bt read from the right. `groups` says which error factors exist: an empty index
/// gives the nominal chain.
[[nodiscard]] std::vector<Step> chain_steps(const Machine& machine, const GroupIndex& groups);

}  // namespace abbe
