#include "scratch/spool.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <random>

#include "support/temporary_directory.hpp"

namespace colossus::scratch {

using namespace support;
namespace {

using core::Bytes;

constexpr unsigned kSeed = 7;
constexpr std::uint64_t kKey = 0x1234'5678'9abc'def0;
constexpr std::uint16_t kAttempt = 3;

Location location_of(const TemporaryDirectory& directory) { return {directory.path(), kKey}; }

Bytes random_bytes(std::mt19937_64& random, std::size_t size) {
  Bytes bytes(size);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
  return bytes;
}

void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  core::File::create(path).write_at(0, bytes);
}

// The error of reading `ref`; empty when there is none.
std::string error_of_reading(const Location& location, const RecordRef& ref) {
  try {
    SpoolReader(location).read(ref);
  } catch (const core::Error& error) {
    EXPECT_EQ(error.status(), core::Status::kIo);
    return error.what();
  }
  return "";
}

TEST(Spool, ReturnsWhatWasAppendedForAllSizes) {
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random(kSeed);
  const TemporaryDirectory directory;
  SpoolWriter writer(location_of(directory), kAttempt, 5);
  std::vector<std::pair<RecordRef, Bytes>> records;
  // Around the alignment, the page and the size above which records are not buffered.
  for (const std::size_t size : {0, 1, 7, 8, 9, 4071, 4072, 4073, 200'000, (1 << 20) - 25, (1 << 20) - 24,
                                 (1 << 20) - 23, 3'000'001, 0, 12}) {
    const Bytes bytes = random_bytes(random, size);
    const auto kind = static_cast<std::uint16_t>(random());
    const RecordRef ref = writer.append(kind, bytes);
    EXPECT_EQ(ref, (RecordRef{{kAttempt, 5, 1}, kind, ref.offset, size}));
    EXPECT_EQ(ref.offset % 8, 0U);
    records.emplace_back(ref, bytes);
  }
  writer.flush();
  EXPECT_EQ(std::filesystem::file_size(path_of(directory.path(), {kAttempt, 5, 1})), writer.ends().stream);
  std::shuffle(records.begin(), records.end(), random);
  SpoolReader reader(location_of(directory));
  for (const auto& [ref, bytes] : records) EXPECT_EQ(reader.read(ref), bytes);
}

TEST(Spool, PartsBecomeOnePayload) {
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random(kSeed);
  const TemporaryDirectory directory;
  SpoolWriter writer(location_of(directory), kAttempt, 0);
  for (const std::size_t middle : {0, 3, 300'000, 2'000'000}) {
    const Bytes a = random_bytes(random, 13);
    const Bytes b = random_bytes(random, middle);
    const Bytes c = random_bytes(random, 1'048'560);
    Bytes all = a;
    all.insert(all.end(), b.begin(), b.end());
    all.insert(all.end(), c.begin(), c.end());
    EXPECT_EQ(SpoolReader(location_of(directory)).read(writer.append(1, {a, b, {}, c})), all);
  }
}

TEST(Spool, IsCreatedExclusively) {
  const TemporaryDirectory directory;
  SpoolWriter first(location_of(directory), kAttempt, 1);
  const RecordRef ref = first.append(1, Bytes(10));
  SpoolWriter second(location_of(directory), kAttempt, 1);
  EXPECT_THROW(second.append(1, Bytes(10)), core::Error);
  EXPECT_EQ(SpoolReader(location_of(directory)).read(ref), Bytes(10))
      << "the failed attempt spoiled the file";
}

TEST(Spool, StreamsAreFilesOfTheirOwn) {
  const TemporaryDirectory directory;
  SpoolWriter writer(location_of(directory), kAttempt, 1);
  EXPECT_TRUE(std::filesystem::is_empty(directory.path())) << "a file is created by the first append to it";
  std::vector<RecordRef> refs;
  for (std::uint16_t stream = 1; stream <= 40; ++stream) {
    writer.begin_stream(stream);
    const SpoolWriter::Ends before = writer.ends();
    EXPECT_TRUE(writer.extents_since(before).empty());
    refs.push_back(writer.append(2, Bytes(stream)));
    refs.push_back(writer.append_kept(3, Bytes(stream + 100)));
    refs.push_back(writer.append(4, Bytes(5)));
    EXPECT_EQ(refs.back().file, (FileId{kAttempt, 1, stream}));
    EXPECT_EQ((refs.end() - 2)->file, (FileId{kAttempt, 1, kKeptStream}));
    const std::vector<Extent> extents = writer.extents_since(before);
    ASSERT_EQ(extents.size(), 2U);
    EXPECT_EQ(extents[0], (Extent{{kAttempt, 1, kKeptStream}, 0, before.kept, writer.ends().kept}));
    EXPECT_EQ(extents[1], (Extent{{kAttempt, 1, stream}, 0, 0, writer.ends().stream}));
    for (const Extent& extent : extents) EXPECT_TRUE(is_intact(location_of(directory), extent, [] {}));
  }
  SpoolReader reader(location_of(directory));
  for (const RecordRef& ref : refs) EXPECT_EQ(reader.read(ref).size(), ref.size);
  EXPECT_EQ(reader.open_file_count(), 41U);
  reader.forget(2, 31);
  EXPECT_EQ(reader.open_file_count(), 11U);
}

TEST(Spool, AReaderSeesRecordsAppendedAfterItOpenedTheFile) {
  const TemporaryDirectory directory;
  SpoolWriter writer(location_of(directory), kAttempt, 1);
  SpoolReader reader(location_of(directory));
  for (std::size_t size = 0; size < 100; ++size) {
    const Bytes bytes(size, std::byte{0x5a});
    EXPECT_EQ(reader.read(writer.append(9, bytes)), bytes);
  }
}

TEST(Spool, RecordsOfAnotherProcessAreReadWhileItGoesOnAppending) {
  const TemporaryDirectory directory;
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  constexpr std::size_t kCount = 300;
  const pid_t child = fork();
  if (child == 0) {
    SpoolWriter writer(location_of(directory), kAttempt, 2);
    for (std::size_t i = 0; i < kCount; ++i) {
      const RecordRef ref = writer.append(4, Bytes(i * 100, static_cast<std::byte>(i)));
      if (write(ends[1], &ref, sizeof ref) != sizeof ref) _exit(1);
    }
    _exit(0);
  }
  close(ends[1]);
  SpoolReader reader(location_of(directory));
  std::size_t count = 0;
  RecordRef ref;
  while (read(ends[0], &ref, sizeof ref) == sizeof ref) {
    EXPECT_EQ(reader.read(ref), Bytes(count * 100, static_cast<std::byte>(count)));
    ++count;
  }
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(count, kCount);
}

TEST(Spool, AReaderKeepsFewFilesOpen) {
  const TemporaryDirectory directory;
  std::vector<RecordRef> refs;
  for (std::uint32_t rank = 0; rank < 20; ++rank)
    refs.push_back(SpoolWriter(location_of(directory), kAttempt, static_cast<std::uint16_t>(rank))
                       .append(rank, core::as_bytes(std::span<const std::uint32_t>(&rank, 1))));
  SpoolReader reader(location_of(directory), 4);
  std::mt19937_64 random(kSeed);
  for (int i = 0; i < 200; ++i) {
    const RecordRef& ref = refs[random() % refs.size()];
    EXPECT_EQ(core::ByteReader(reader.read(ref)).get<std::uint32_t>(), ref.file.rank);
    EXPECT_LE(reader.open_file_count(), 4U);
  }
  EXPECT_EQ(reader.open_file_count(), 4U);
}

// A spool of three records, the middle one with padding.
class SmallSpool : public ::testing::Test {
 protected:
  SmallSpool() {
    SpoolWriter writer(location_, kAttempt, 0);
    refs_.push_back(writer.append(1, Bytes(16, std::byte{0x11})));
    refs_.push_back(writer.append(2, Bytes(13, std::byte{0x22})));
    refs_.push_back(writer.append(3, Bytes()));
    path_ = path_of(directory_.path(), kFile);
    bytes_ = core::read_file(path_);
  }

  std::size_t record_of(std::size_t byte) const {
    std::size_t record = 0;
    while (record_end(refs_[record]) <= byte) ++record;
    return record;
  }

  static constexpr FileId kFile{kAttempt, 0, 1};
  TemporaryDirectory directory_;
  Location location_ = location_of(directory_);
  std::filesystem::path path_;
  std::vector<RecordRef> refs_;
  Bytes bytes_;
};

TEST_F(SmallSpool, IsReadable) {
  for (const RecordRef& ref : refs_) EXPECT_EQ(error_of_reading(location_, ref), "");
}

TEST_F(SmallSpool, AFlippedBitAnywhereIsFoundInItsRecordAndInNoOther) {
  for (std::size_t byte = 0; byte < bytes_.size(); ++byte) {
    for (int bit = 0; bit < 8; ++bit) {
      Bytes damaged = bytes_;
      damaged[byte] ^= static_cast<std::byte>(1 << bit);
      write_file(path_, damaged);
      for (std::size_t i = 0; i < refs_.size(); ++i) {
        const std::string error = error_of_reading(location_, refs_[i]);
        EXPECT_EQ(error.empty(), i != record_of(byte))
            << "byte " << byte << " bit " << bit << " record " << i << error;
      }
    }
  }
}

TEST_F(SmallSpool, AFileCutAnywhereIsFoundInTheRecordsThatLieBehind) {
  for (std::size_t size = 0; size < bytes_.size(); ++size) {
    write_file(path_, std::span(bytes_).first(size));
    for (const RecordRef& ref : refs_)
      EXPECT_EQ(error_of_reading(location_, ref).empty(), record_end(ref) <= size) << size;
  }
}

TEST_F(SmallSpool, AFileCutWhileItIsOpenIsFound) {
  SpoolReader reader(location_);
  reader.read(refs_[1]);
  std::filesystem::resize_file(path_, refs_[1].offset + 5);
  EXPECT_THROW(reader.read(refs_[1]), core::Error);
}

TEST_F(SmallSpool, MessagesNameFileOffsetExpectedAndFound) {
  Bytes damaged = bytes_;
  damaged[refs_[1].offset] ^= std::byte{1};
  write_file(path_, damaged);
  const std::string flipped = error_of_reading(location_, refs_[1]);
  const std::string start = path_.string() + ": damaged scratch record at byte 64: expected checksum ";
  EXPECT_EQ(flipped.substr(0, start.size()), start);
  write_file(path_, std::span(bytes_).first(70));
  EXPECT_EQ(
      error_of_reading(location_, refs_[1]),
      path_.string() +
          ": damaged scratch record at byte 64: expected 13 bytes of kind 2 there, found a file of 70 bytes: "
          "check the disk and run again");
}

TEST_F(SmallSpool, ARecordIsReadOnlyAsWhatItIs) {
  const RecordRef good = refs_[1];
  const FileId other{kAttempt, 7, 1};
  for (const RecordRef& wrong :
       {RecordRef{kFile, 9, good.offset, good.size}, RecordRef{kFile, 2, good.offset, good.size - 1},
        RecordRef{kFile, 2, good.offset + 8, good.size}, RecordRef{kFile, 2, 0, 0},
        RecordRef{kFile, 2, good.offset + 1, 1}, RecordRef{kFile, 2, good.offset, ~std::uint64_t{0}},
        RecordRef{kFile, 2, ~std::uint64_t{7}, 8}, RecordRef{other, 2, good.offset, good.size}})
    EXPECT_NE(error_of_reading(location_, wrong), "")
        << wrong.file.rank << ' ' << wrong.kind << ' ' << wrong.offset;
}

TEST_F(SmallSpool, TheRecordOfAnotherFilePlaceOrBuildDoesNotPass) {
  // The same bytes under other names, the records of another build, and one copied over an equally large one.
  for (const FileId& other : {FileId{kAttempt, 1, 1}, FileId{kAttempt + 1, 0, 1}, FileId{kAttempt, 0, 2}}) {
    std::filesystem::copy_file(path_, path_of(directory_.path(), other));
    EXPECT_NE(error_of_reading(location_, {other, 1, refs_[0].offset, refs_[0].size}), "");
  }
  EXPECT_NE(error_of_reading({directory_.path(), kKey + 1}, refs_[0]), "");
  SpoolWriter writer(location_, kAttempt, 2);
  const RecordRef a = writer.append(1, Bytes(8, std::byte{1}));
  const RecordRef b = writer.append(1, Bytes(8, std::byte{2}));
  const auto path = path_of(directory_.path(), a.file);
  Bytes bytes = core::read_file(path);
  std::copy(bytes.begin(), bytes.begin() + 32, bytes.begin() + 32);
  write_file(path, bytes);
  EXPECT_EQ(error_of_reading(location_, a), "");
  EXPECT_NE(error_of_reading(location_, b), "");
}

// The records that a scan finds, in order.
std::vector<RecordRef> scanned(const Location& location, const FileId& file, std::uint64_t limit,
                               std::uint64_t* end = nullptr) {
  std::vector<RecordRef> refs;
  const std::uint64_t last =
      scan_records(location, file, limit, [&](const RecordRef& ref, std::span<const std::byte> payload) {
        EXPECT_EQ(payload.size(), ref.size);
        refs.push_back(ref);
      });
  if (end) *end = last;
  return refs;
}

TEST_F(SmallSpool, AScanFindsWhatIsWholeInAFileCutAnywhere) {
  for (std::size_t size = 0; size <= bytes_.size(); ++size) {
    write_file(path_, std::span(bytes_).first(size));
    std::vector<RecordRef> whole;
    for (const RecordRef& ref : refs_)
      if (record_end(ref) <= size) whole.push_back(ref);
    std::uint64_t end = 0;
    EXPECT_EQ(scanned(location_, kFile, ~std::uint64_t{0}, &end), whole) << size;
    EXPECT_EQ(end, whole.empty() ? 0 : record_end(whole.back())) << size;
    write_file(path_, bytes_);
    EXPECT_EQ(scanned(location_, kFile, size), whole) << "a limit is like the end of the file: " << size;
  }
}

TEST_F(SmallSpool, AScanStepsOverDamageAndFindsTheRecordsBehind) {
  for (std::size_t byte = 0; byte < bytes_.size(); ++byte)
    for (int bit = 0; bit < 8; ++bit) {
      Bytes damaged = bytes_;
      damaged[byte] ^= static_cast<std::byte>(1 << bit);
      write_file(path_, damaged);
      std::vector<RecordRef> whole = refs_;
      whole.erase(whole.begin() + static_cast<std::ptrdiff_t>(record_of(byte)));
      EXPECT_EQ(scanned(location_, kFile, ~std::uint64_t{0}), whole) << "byte " << byte << " bit " << bit;
      const Extent all{kFile, 0, 0, bytes_.size()};
      EXPECT_FALSE(is_intact(location_, all, [] {})) << "byte " << byte << " bit " << bit;
    }
}

TEST_F(SmallSpool, AScanTakesNoRecordOfAnotherFileOrBuild) {
  EXPECT_EQ(scanned(location_, kFile, ~std::uint64_t{0}), refs_);
  EXPECT_TRUE(scanned({directory_.path(), kKey + 1}, kFile, ~std::uint64_t{0}).empty());
  const FileId other{kAttempt, 1, 1};
  std::filesystem::copy_file(path_, path_of(directory_.path(), other));
  EXPECT_TRUE(scanned(location_, other, ~std::uint64_t{0}).empty());
  EXPECT_TRUE(scanned(location_, {kAttempt, 2, 1}, ~std::uint64_t{0}).empty()) << "there is no such file";
}

TEST_F(SmallSpool, AnExtentIsIntactOnlyAsAWhole) {
  for (std::size_t size = 0; size < bytes_.size(); ++size) {
    write_file(path_, std::span(bytes_).first(size));
    EXPECT_FALSE(is_intact(location_, {kFile, 0, 0, bytes_.size()}, [] {})) << size;
  }
  write_file(path_, bytes_);
  const std::uint64_t second = refs_[1].offset - kRecordHeaderBytes;
  EXPECT_TRUE(is_intact(location_, {kFile, 0, second, record_end(refs_[1])}, [] {}));
  EXPECT_FALSE(is_intact(location_, {kFile, 0, second + 8, record_end(refs_[1])}, [] {}));
  EXPECT_FALSE(is_intact(location_, {kFile, 0, second, record_end(refs_[1]) - 8}, [] {}));
  EXPECT_FALSE(is_intact(location_, {{kAttempt, 9, 1}, 0, 0, 40}, [] {})) << "there is no such file";
  EXPECT_THROW(is_intact(location_, {kFile, 0, second, record_end(refs_[1])}, [] { throw 1; }), int);
}

TEST(Spool, AFailedAppendIsReportedAndLeavesTheSpoolUsable) {
  // A limit on the file's size stands for a full disk; its signal is ignored so that write() fails.
  const TemporaryDirectory directory;
  SpoolWriter writer(location_of(directory), kAttempt, 0);
  const RecordRef first = writer.append(1, Bytes(1000, std::byte{1}));
  rlimit old_limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old_limit), 0);
  const auto old_action = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit = old_limit;
  limit.rlim_cur = 4096;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  EXPECT_THROW(writer.append(1, Bytes(10'000)), core::Error);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &old_limit), 0);
  std::signal(SIGXFSZ, old_action);
  const RecordRef second = writer.append(1, Bytes(500, std::byte{2}));
  SpoolReader reader(location_of(directory));
  EXPECT_EQ(reader.read(first), Bytes(1000, std::byte{1}));
  EXPECT_EQ(reader.read(second), Bytes(500, std::byte{2}));
}

}  // namespace
}  // namespace colossus::scratch
