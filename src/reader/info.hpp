// What is inside a container, for people and for scripts. Needs the node table only.
#pragma once

#include <string>

#include "reader/access/statue.hpp"

namespace colossus::reader {

// Lines and a table per level: from the node table level, nodes, leaves, triangles, vertices, bytes, bits per
// vertex (8 * stored bytes / vertices) and largest error; then what of the bits is spent on what and shares,
// made of the stored statistics (target, reached, locked, small angles), and their other columns; then a line
// for each level that misses its target by more than a tenth.
std::string info_text(const access::Statue& statue);

// The same as one JSON object: file, schema, scheme, lattice, position_bits, quantisation_error, attributes,
// options, parameters, measures, inputs, counts, nodes, above_limit, levels, levels_above_target.
std::string info_json(const access::Statue& statue);

}  // namespace colossus::reader
