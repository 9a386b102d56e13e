// Private to this folder: Metadata to and from the attributes and small tables of an HDF5 file.
#pragma once

#include "container/hdf5/support.hpp"
#include "container/schema.hpp"
#include "core/file.hpp"

namespace colossus::container {

void write_metadata(const hdf5::Blame& blame, hid_t file, const Metadata& metadata);

// Throws Error(kBadData) when something is missing, of another type or out of range, when the file is no
// container of ours, or when its schema is too new.
Metadata read_metadata(const hdf5::Blame& blame, hid_t file, const core::File& bytes);

}  // namespace colossus::container
