// The diamonds scheme: triangles cut into the tetrahedra of a hierarchy of diamonds (Balsa Rodriguez et al.
// 2013).
#pragma once

#include "pipeline/nodes/scheme.hpp"

namespace colossus::pipeline::diamonds {

extern const nodes::Scheme kScheme;

}  // namespace colossus::pipeline::diamonds
