// The default codec: connectivity by traversal, everything else predicted from what came before, what is left
// by entropy coders. schemas/container.md describes the bytes.
#pragma once

#include <optional>

#include "codec/coded/coded_node.hpp"
#include "core/error.hpp"

namespace colossus::codec::predict {

// Triangles must be as order_by_traversal() of predict/connectivity.hpp leaves them.
coded::Sections encode_predicted(const coded::CodedNode& node);
std::optional<core::Defect> decode_predicted(const coded::SectionViews& sections, coded::CodedNode& node);
// Of version 1.
std::optional<core::Defect> decode_predicted_1(const coded::SectionViews& sections, coded::CodedNode& node);

}  // namespace colossus::codec::predict
