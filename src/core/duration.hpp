// Times as people and batch systems write them.
#pragma once

#include <optional>
#include <string_view>

namespace colossus::core {

// Seconds: a number with or without "s" (90, 90s), numbers with units in falling order (45m, 3h50m, 1d12h),
// or Slurm's forms with a colon or a dash: M:S, H:M:S, D-H, D-H:M, D-H:M:S. Nothing for anything else, for
// zero, and for more than 1000 days.
std::optional<double> parse_duration(std::string_view text);

}  // namespace colossus::core
