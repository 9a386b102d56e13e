// How far a build has come: what this attempt and earlier ones have finished.
#pragma once

#include <cstdint>
#include <vector>

#include "scratch/journal.hpp"

namespace colossus::pipeline::run {

struct Progress {
  scratch::JournalWriter journal;  // of this rank
  bool is_resumed = false;         // earlier attempts have left something; the same on all ranks
  std::uint32_t phase_count = 0;   // begun so far; phases are numbered from 1
  std::uint32_t released_up_to = 0;
  // On rank 0 alone:
  std::vector<std::uint64_t> task_counts;      // of these phases
  scratch::History history;                    // of the phases to come
  std::vector<scratch::FileId> earlier_files;  // of earlier attempts
};

}  // namespace colossus::pipeline::run
