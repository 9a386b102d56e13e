// What the toys' tables know of them.
#pragma once

#include "input/formats.hpp"
#include "pipeline/nodes/scheme.hpp"
#include "reader/access/statue.hpp"
#include "verify/measure/report.hpp"

namespace colossus::toy {

extern const input::Format kTrisFormat;
extern const pipeline::nodes::Scheme kSketchScheme;

// Of a sketch, see sketch.hpp; the finest level is as sharp a measure as it is of blocks.
verify::measure::VerifyReport verify(const reader::access::Statue& statue,
                                     const verify::measure::VerifyOptions& options);

}  // namespace colossus::toy
