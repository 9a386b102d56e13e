// Checks a container of any scheme.
#pragma once

#include "reader/open.hpp"
#include "verify/measure/report.hpp"

namespace colossus::verify {

// As verify() of the statue's scheme, see verify/diamonds and verify/blocks.
measure::VerifyReport verify(const reader::AnyStatue& statue, const measure::VerifyOptions& options);

}  // namespace colossus::verify
