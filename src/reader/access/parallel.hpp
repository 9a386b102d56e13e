// Loops over all usable processors whose results do not depend on their number.
#pragma once

#include <cstddef>
#include <functional>

namespace colossus::reader::access {

// Processors that this process may run on (sched_getaffinity), at least 1.
std::size_t usable_cpu_count();

// Calls body(i) once for each i < count, on up to usable_cpu_count() threads, and returns when all are done.
// body must write only to places of its own i. When bodies throw, the exception of the least i among those
// that ran is thrown here and no further i is started.
void parallel_for(std::size_t count, const std::function<void(std::size_t)>& body);

}  // namespace colossus::reader::access
