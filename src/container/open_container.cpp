#include "container/open_container.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "container/schema.hpp"
#include "container/table.hpp"

namespace colossus::container {
namespace {

using core::Status;
using hdf5::Blame;
using hdf5::Handle;

bool is_hard_link(hid_t group, const char* name) {
  H5L_info_t link{};
  return H5Lexists(group, name, H5P_DEFAULT) > 0 && H5Lget_info(group, name, &link, H5P_DEFAULT) >= 0 &&
         link.type == H5L_TYPE_HARD;
}

bool is_container(const Blame& blame, hid_t group) {
  if (H5Aexists(group, "format") <= 0) return false;
  try {
    return read_text_attribute(blame, group, "/", "format") == kFormatName;
  } catch (const core::Error&) {
    return false;  // somebody else's attribute of another type
  }
}

herr_t collect_name(hid_t, const char* name, const H5L_info_t* link, void* names) {
  if (link->type == H5L_TYPE_HARD) static_cast<std::vector<std::string>*>(names)->push_back(name);
  return 0;
}

// The groups directly below the root that are containers: h5copy puts a whole one there.
std::vector<std::string> contained(const Blame& blame, hid_t root) {
  std::vector<std::string> names;
  // In no order: to sort, HDF5 1.10 makes a table of all links, and frees what it has not filled where one is
  // damaged.
  blame.check(H5Literate(root, H5_INDEX_NAME, H5_ITER_NATIVE, nullptr, &collect_name, &names),
              "cannot list the root group");
  std::sort(names.begin(), names.end());
  std::vector<std::string> found;
  for (const std::string& name : names) {
    H5O_info_t info{};
    if (H5Oget_info_by_name2(root, name.c_str(), &info, H5O_INFO_BASIC, H5P_DEFAULT) < 0 ||
        info.type != H5O_TYPE_GROUP)
      continue;
    const Handle group(H5Gopen2(root, name.c_str(), H5P_DEFAULT), &H5Gclose);
    if (group.get() >= 0 && is_container(blame, group.get())) found.push_back(name);
  }
  return found;
}

[[noreturn]] void fail_without_container(const Blame& blame, hid_t root,
                                         const std::vector<std::string>& found) {
  if (found.size() > 1)
    core::fail(
        blame.status,
        "{}: expected one container, found {}, such as /{} and /{}: copy the one that is meant into a file "
        "of its own, with h5copy -s /{} -d /{}",
        blame.file, found.size(), found[0], found[1], found[0], found[0]);
  // What h5copy leaves when it copies the objects one by one.
  if (is_hard_link(root, "nodes") && is_hard_link(root, "chunks"))
    core::fail(
        blame.status,
        "{}: has the objects of a Colossus container, but not the attributes of its root group: expected "
        "format, schema_version, scheme and attributes; copy the whole of it instead, with "
        "h5copy -s / -d /statue",
        blame.file);
  core::fail(
      blame.status,
      "{}: is an HDF5 file, but no Colossus container: expected the attribute format = '{}' of the root "
      "group, or of one group directly below it",
      blame.file, kFormatName);
}

Handle open_file(const Blame& blame, hdf5::ReadDevice& device, Handle& driver) {
  const std::string what = "cannot open as an HDF5 file";
  const Handle access = blame.own(H5Pcreate(H5P_FILE_ACCESS), &H5Pclose, what);
  blame.check(H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG), what);
  driver = use_device(blame, access.get(), device);
  return blame.own(H5Fopen(blame.file.c_str(), H5F_ACC_RDONLY, access.get()), &H5Fclose, what);
}

Handle open_group(Blame& blame, hid_t file) {
  const std::string what = "cannot open the group of the container";
  Handle root = blame.own(H5Gopen2(file, "/", H5P_DEFAULT), &H5Gclose, what);
  if (is_container(blame, root.get())) return root;
  const std::vector<std::string> found = contained(blame, root.get());
  if (found.size() != 1) fail_without_container(blame, root.get(), found);
  blame.group = "/" + found[0];
  return blame.own(H5Gopen2(file, blame.group.c_str(), H5P_DEFAULT), &H5Gclose, what);
}

}  // namespace

std::mutex& library_mutex() {
  static std::mutex mutex;
  return mutex;
}

OpenContainer::OpenContainer(std::shared_ptr<const core::File> opened)
    : bytes(std::move(opened)),
      device{bytes.get(), bytes->size(), 0, nullptr, false, 0, 0},
      blame{bytes->path().string(), Status::kBadData} {
  try {
    // Another program may have filtered a table with it, or encoded the chunks anew.
    hdf5::register_zstd_filter(blame);
    file = open_file(blame, device, driver);
    group = open_group(blame, file.get());
  } catch (const core::Error&) {
    rethrow();
  }
}

void OpenContainer::rethrow() const {
  if (device.failure) std::rethrow_exception(device.failure);
  throw;
}

}  // namespace colossus::container
