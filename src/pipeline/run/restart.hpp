// Opens a build's scratch directory: a new one, or one that an interrupted attempt has left.
#pragma once

#include <filesystem>

#include "cluster/communicator.hpp"
#include "pipeline/run/progress.hpp"
#include "scratch/directory.hpp"

namespace colossus::pipeline::run {

struct OpenedScratch {
  scratch::Location location;
  Progress progress;
};

// Collective. Only rank 0's `manifest` is used. Creates the directory, uses one that is empty, which then
// stays, or with `may_resume` takes over one that is there; the location is the folder of this attempt in it.
// All ranks then have proved that they see the same one. What earlier attempts have finished is checked, by
// all ranks together; what is damaged is as if it had not been done. Throws
// - Error(kCannotCreate) when there is something of this name that cannot be continued;
// - Error(kUsage) when it belongs to another build; the message says what differs;
// - Error(kIo) when a rank does not see the directory, and for failures of the file system.
// Leaves no directory behind that it has created when it throws.
//
// An empty directory of the name that builds give it themselves (`is_own_name`), which a build is to be
// resumed in, has been left by one that was killed, and does not stay.
OpenedScratch open_scratch(const cluster::Communicator& ranks, const std::filesystem::path& directory,
                           bool may_resume, const scratch::Manifest& manifest, bool is_own_name = false);

}  // namespace colossus::pipeline::run
