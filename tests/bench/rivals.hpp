// Public codecs on the meshes of our nodes.
#pragma once

#include <vector>

#include "codec/coded/coded_node.hpp"

namespace colossus::bench {

struct RivalBytes {
  core::Bytes indices;  // empty where they cannot be told from the rest
  core::Bytes rest;
  std::size_t vertex_count = 0;  // without those that no triangle uses
  std::size_t size() const { return indices.size() + rest.size(); }
};

struct Rival {
  const char* name;
  RivalBytes (*encode)(const codec::coded::CodedNode& node, const codec::coded::CodedPart& part);
  // Throws Error(kBadData) when it fails.
  void (*decode)(const codec::coded::CodedNode& node, const codec::coded::CodedPart& part,
                 const RivalBytes& bytes);
};

// Those that were there when this was compiled.
const std::vector<Rival>& rivals();

}  // namespace colossus::bench
