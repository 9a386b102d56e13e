// The table of all schemes.
#pragma once

#include <span>
#include <string_view>

#include "pipeline/nodes/scheme.hpp"

namespace colossus::pipeline {

// All of them, the default one first.
std::span<const nodes::Scheme> schemes();

// Throws Error(kUsage) that lists the schemes when there is none of this name.
const nodes::Scheme& scheme_named(std::string_view name);

}  // namespace colossus::pipeline
