#include "core/error.hpp"

#include <cstdio>
#include <cstdlib>

namespace colossus::core {

void check_failed(const char* condition, const char* file, int line, const std::string& context) {
  std::fprintf(stderr, "colossus: internal error (please report it): %s does not hold at %s:%d%s%s\n",
               condition, file, line, context.empty() ? "" : ": ", context.c_str());
  std::fflush(nullptr);
  // Not abort(): the status says "a bug in Colossus", and mpirun ends the other ranks of a rank that exits
  // so.
  std::_Exit(static_cast<int>(Status::kInternal));
}

}  // namespace colossus::core
