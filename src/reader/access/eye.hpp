// Where the view of a view-dependent cut is from.
#pragma once

#include <array>
#include <optional>

namespace colossus::reader::access {

inline constexpr double kDefaultKappa = 2.0;

struct Eye {
  std::array<double, 3> position{};  // world, finite
  // A node is coarse enough when its distance from the eye is at least kappa times its side. Without it:
  // kDefaultKappa, or what the scheme's conditions ask for if that is more.
  std::optional<double> kappa;
};

}  // namespace colossus::reader::access
