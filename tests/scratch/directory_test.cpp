#include "scratch/directory.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "core/error.hpp"
#include "scratch/spool.hpp"
#include "support/temporary_directory.hpp"

namespace colossus::scratch {

using namespace support;
namespace {

template <typename Action>
core::Status status_of(const Action& action) {
  try {
    action();
  } catch (const core::Error& error) {
    return error.status();
  }
  return core::Status::kOk;
}

Manifest sample_manifest() {
  Manifest manifest;
  manifest.add("program", "0.1.0");
  manifest.add("leaf_triangles", "8000");
  manifest.add("input 1", "/scans/a: b\\n\n.ply, 17 bytes");
  return manifest;
}

void append_one(const std::filesystem::path& folder, const FileId& file) {
  RecordFile(Location{folder, 0}, file).append(1, {core::Bytes(3)});
}

TEST(ScratchDirectory, IsCreatedByOneOfTwo) {
  const TemporaryDirectory parent;
  const auto path = parent.path() / "statue.h5.scratch";
  EXPECT_FALSE(look_into_directory(path).exists);
  EXPECT_TRUE(create_scratch_directory(path));
  EXPECT_FALSE(create_scratch_directory(path));
  EXPECT_TRUE(look_into_directory(path).exists);
  EXPECT_EQ(look_into_directory(path).attempt, 1);
  std::ofstream(parent.path() / "file") << "no directory";
  EXPECT_FALSE(create_scratch_directory(parent.path() / "file"));
  EXPECT_EQ(status_of([&] { create_scratch_directory(parent.path() / "none" / "scratch"); }),
            core::Status::kCannotCreate);
}

TEST(ScratchDirectory, FileNamesAndFilesCorrespond) {
  for (const FileId& file : {FileId{1, 0, 0}, FileId{1, 0, kJournalStream}, FileId{12, 345, 67},
                             FileId{65535, 65535, 65534}, FileId{65535, 65535, kJournalStream}})
    EXPECT_EQ(file_of_name(path_of("folder", file).filename().string()), file);
  for (const char* name :
       {"", "notes.txt", "manifest", "attempt-0001-rank-00003", "attempt-0001-rank-00003.journal.bak",
        "attempt-1-rank-3.journal", "attempt-0001-rank-00003-stream-00007",
        "attempt-0001-rank-00003-stream-.spool", "attempt-0001-rank-70000.journal",
        "attempt-0001-rank-00003-stream-65535.spool", "attempt-99999999999999999999-rank-00003.journal",
        "attempt-0001-rank-00003.spool"})
    EXPECT_EQ(file_of_name(name), std::nullopt) << name;
}

TEST(ScratchDirectory, ContentIsOursOrForeign) {
  const TemporaryDirectory folder;
  EXPECT_TRUE(look_into(folder.path()).files.empty());
  append_one(folder.path(), {2, 0, 1});
  append_one(folder.path(), {1, 3, kJournalStream});
  write_manifest(folder.path(), sample_manifest());
  FolderContent content = look_into(folder.path());
  EXPECT_EQ(content.files, (std::vector<FileId>{{1, 3, kJournalStream}, {2, 0, 1}}));
  EXPECT_TRUE(content.has_manifest);
  EXPECT_FALSE(content.has_foreign);
  std::ofstream(folder.path() / "notes.txt") << "precious";
  EXPECT_TRUE(look_into(folder.path()).has_foreign);
}

TEST(ScratchDirectory, IsRemovedWithItsFilesButNeverWithOthers) {
  const TemporaryDirectory parent;
  const auto path = parent.path() / "scratch";
  const auto folder = folder_of_attempt(path, 1);
  create_scratch_directory(path);
  write_manifest(folder, sample_manifest());
  append_one(folder, {1, 0, kJournalStream});
  append_one(folder, {9, 1234, 5});
  remove_scratch_directory(path, 1);
  EXPECT_FALSE(std::filesystem::exists(path));
  for (const char* name : {"notes.txt", "manifest.bak", "attempt-0001-rank-00003.journal.bak"})
    for (const auto& place : {path, folder}) {
      create_scratch_directory(path);
      append_one(folder, {1, 0, 4});
      std::ofstream(place / name) << "precious";
      EXPECT_EQ(status_of([&] { remove_scratch_directory(path, 1); }), core::Status::kIo);
      EXPECT_TRUE(std::filesystem::exists(place / name)) << name;
      EXPECT_FALSE(std::filesystem::exists(path_of(folder, {1, 0, 4})));
      EXPECT_EQ(look_into_directory(path).has_foreign, place == path) << name;
      std::filesystem::remove_all(path);
    }
}

TEST(ScratchDirectory, ThatWasThereIsUsedByOneOfTwoAndStays) {
  const TemporaryDirectory parent;
  const auto path = parent.path() / "scratch";
  std::filesystem::create_directory(path);
  EXPECT_TRUE(look_into_directory(path).is_empty);
  EXPECT_TRUE(use_empty_directory(path));
  EXPECT_FALSE(use_empty_directory(path));
  const DirectoryContent content = look_into_directory(path);
  EXPECT_TRUE(content.is_lent);
  EXPECT_FALSE(content.is_empty || content.has_foreign);
  EXPECT_EQ(content.attempt, 1);
  append_one(folder_of_attempt(path, 1), {1, 0, 4});
  EXPECT_EQ(take_attempt(path, 1), 2);
  remove_scratch_directory(path, 1);
  EXPECT_TRUE(look_into_directory(path).is_lent);
  remove_scratch_directory(path, 2);
  EXPECT_TRUE(look_into_directory(path).is_empty);
}

TEST(ScratchDirectory, ThatSomebodyHasJustCreatedIsNotTaken) {
  const TemporaryDirectory parent;
  const auto path = parent.path() / "scratch";
  create_scratch_directory(path);  // after it was seen to be empty
  EXPECT_EQ(status_of([&] { use_empty_directory(path); }), core::Status::kCannotCreate);
  remove_scratch_directory(path, 1);
  EXPECT_FALSE(look_into_directory(path).exists);
}

TEST(ScratchDirectory, IsTakenOverByOneAttemptAndLostToTheEarlierOnes) {
  const TemporaryDirectory parent;
  const auto path = parent.path() / "scratch";
  create_scratch_directory(path);
  EXPECT_EQ(status_of([&] { take_attempt(path, 0); }), core::Status::kCannotCreate);
  const auto folder = folder_of_attempt(path, 1);
  append_one(folder, {1, 0, 4});
  RecordFile open(Location{folder, 0}, {1, 1, 4});
  EXPECT_EQ(take_attempt(path, 1), 2);
  EXPECT_EQ(status_of([&] { take_attempt(path, 1); }), core::Status::kCannotCreate)
      << "both had seen attempt 1";
  EXPECT_EQ(look_into_directory(path).attempt, 2);
  EXPECT_EQ(look_into(folder_of_attempt(path, 2)).files, (std::vector<FileId>{{1, 0, 4}, {1, 1, 4}}));
  // What a rank of the first attempt might do.
  open.append(1, {core::Bytes(3)});
  EXPECT_EQ(status_of([&] { append_one(folder, {1, 2, 4}); }), core::Status::kCannotCreate);
  remove_files(folder, {{1, 0, 4}});
  remove_scratch_directory(path, 1);
  EXPECT_EQ(look_into(folder_of_attempt(path, 2)).files, (std::vector<FileId>{{1, 0, 4}, {1, 1, 4}}));
}

TEST(Manifest, IsReadAsItWasWritten) {
  const TemporaryDirectory folder;
  EXPECT_EQ(read_manifest(folder.path()), std::nullopt);
  write_manifest(folder.path(), sample_manifest());
  EXPECT_EQ(status_of([&] { write_manifest(folder.path(), sample_manifest()); }),
            core::Status::kCannotCreate);
  const auto read = read_manifest(folder.path());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->entries, sample_manifest().entries);
  EXPECT_EQ(read->key(), sample_manifest().key());
  EXPECT_EQ(sample_manifest().difference_from(*read), "");
}

TEST(Manifest, IsNothingWhenTornOrDamagedAnywhere) {
  const std::string text = sample_manifest().text();
  ASSERT_TRUE(Manifest::parse(text));
  for (std::size_t size = 0; size < text.size(); ++size)
    EXPECT_EQ(Manifest::parse(text.substr(0, size)), std::nullopt) << size;
  for (std::size_t byte = 0; byte < text.size(); ++byte)
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = text;
      damaged[byte] = static_cast<char>(damaged[byte] ^ 1 << bit);
      EXPECT_EQ(Manifest::parse(damaged), std::nullopt) << "byte " << byte << " bit " << bit;
    }
  EXPECT_EQ(Manifest::parse(text + "\n"), std::nullopt);
}

TEST(Manifest, SaysWhatDiffers) {
  Manifest other = sample_manifest();
  other.entries[1].second = "1500";
  EXPECT_EQ(other.difference_from(sample_manifest()), "leaf_triangles is 8000 there, and 1500 here");
  EXPECT_NE(other.key(), sample_manifest().key());
  other.entries.pop_back();
  other.add("levels", "3");
  EXPECT_EQ(other.difference_from(sample_manifest()),
            "leaf_triangles is 8000 there, and 1500 here; levels is absent there, and 3 here; input 1 is "
            "/scans/a: b\\\\n\\n.ply, 17 bytes there, and absent here");
}

}  // namespace
}  // namespace colossus::scratch
