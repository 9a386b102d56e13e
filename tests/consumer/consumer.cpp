// consumer CONTAINER: prints the number of its nodes and the level of the first one's diamond.
#include <cstdio>

#include "hierarchy/diamond.hpp"
#include "reader/diamonds/statue.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const colossus::reader::diamonds::Statue statue(argv[1]);
  std::printf("%zu nodes, the first at level %d\n", statue.rows().size(),
              colossus::hierarchy::level_of(statue.center(0)));
  return 0;
}
