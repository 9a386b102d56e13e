// Checks a container of any scheme.
#pragma once

#include <span>

#include "reader/access/statue.hpp"
#include "verify/measure/report.hpp"

namespace colossus::verify {

// What verification knows of a scheme.
struct Scheme {
  const char* name;
  // Of a statue of this scheme: verify() of verify/diamonds and verify/blocks say what is checked.
  measure::VerifyReport (*verify)(const reader::access::Statue& statue,
                                  const measure::VerifyOptions& options);
};

// All of them. A new one is a folder beside verify/diamonds, and a line in schemes.cpp.
std::span<const Scheme> schemes();

// By the statue's scheme, which must be one of these.
measure::VerifyReport verify(const reader::access::Statue& statue, const measure::VerifyOptions& options);

}  // namespace colossus::verify
