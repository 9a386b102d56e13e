// A toy scheme, to show that the program knows a scheme in the folders and table lines that src/README.md
// names, and nowhere else: "sketch" has two levels. The finest one holds the input's triangles in the cubes of
// their barycentres, uncut; level 0 is one sketch of the whole, with half as many triangles. A cut is one
// level or the other. Good for nothing else: the sketch is made in the memory of one rank.
#pragma once

namespace colossus::toy {

inline constexpr const char* kSketch = "sketch";
inline constexpr int kFinestLevel = 1;

// Of the octree, whose cubes are the nodes of the finest level; --levels chooses another.
inline constexpr int kCubeLevel = 2;

}  // namespace colossus::toy
