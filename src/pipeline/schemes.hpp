// All schemes.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "pipeline/nodes/scheme.hpp"

namespace colossus::pipeline {

// The default one first. A new one is a folder beside pipeline/diamonds, and a line in schemes.cpp.
std::span<const nodes::Scheme* const> schemes();

// The default one for an empty name. Throws Error(kUsage) that lists the schemes when there is none of this
// name.
const nodes::Scheme& scheme_named(std::string_view name);

// "diamonds: ...; blocks: ...", for --help, of this text of each scheme.
std::string schemes_text(const char* nodes::Scheme::*text);

// Throws Error(kUsage) when an option is given that the scheme has not, or a value of another type. What
// another scheme has by default may be given.
void refuse_options_of_other_schemes(const facts::BuildOptions& options);

}  // namespace colossus::pipeline
