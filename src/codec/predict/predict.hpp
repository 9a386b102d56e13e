// The default codec: connectivity by traversal, everything else predicted from what came before, what is left
// by entropy coders. schemas/container.md describes the bytes.
#pragma once

#include <optional>

#include "codec/coded_node.hpp"
#include "core/error.hpp"

namespace colossus::codec {

// Triangles must be as order_by_traversal() of predict/connectivity.hpp leaves them.
Sections encode_predicted(const CodedNode& node);
std::optional<core::Defect> decode_predicted(const SectionViews& sections, CodedNode& node);
// Of version 1.
std::optional<core::Defect> decode_predicted_1(const SectionViews& sections, CodedNode& node);

}  // namespace colossus::codec
