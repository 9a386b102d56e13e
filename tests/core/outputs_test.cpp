#include "core/outputs.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "core/error.hpp"
#include "core/file.hpp"
#include "core/output_file.hpp"
#include "core/place.hpp"

namespace colossus::core {
namespace {

namespace fs = std::filesystem;

class Outputs : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              fmt::format("colossus-outputs-{}-{}", ::getpid(),
                          testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_ / "sub");
    write("scan.ply", "scan");
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path path(const std::string& name) const { return folder_ / name; }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }
  std::string read(const std::string& name) const {
    const Bytes bytes = read_file(path(name));
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }

  // Where the outputs go, or what is wrong.
  struct Outcome {
    Status status = Status::kOk;
    std::string message;
    std::vector<OutputTarget> targets;
  };
  Outcome plan(const std::vector<OutputRequest>& requests) const {
    const SparedFile input{"the input", path("scan.ply")};
    try {
      return {Status::kOk, "", plan_outputs(std::span(&input, 1), requests)};
    } catch (const Error& error) {
      return {error.status(), error.what(), {}};
    }
  }
  Outcome plan(const std::string& name, OutputKind kind = OutputKind::kFile) const {
    return plan({{"-o", path(name), kind}});
  }

  fs::path folder_;
};

TEST_F(Outputs, SpareAnInputUnderEveryName) {
  fs::create_hard_link(path("scan.ply"), path("hard"));
  fs::create_symlink("scan.ply", path("link"));
  fs::create_symlink("../link", path("sub/chain"));
  fs::create_hard_link(path("scan.ply"), path("o.part"));
  for (const char* name : {"scan.ply", "./scan.ply", "sub/../scan.ply", "hard", "link", "sub/chain", "o"})
    for (const OutputKind kind : {OutputKind::kFile, OutputKind::kFileOrStream}) {
      const Outcome outcome = plan(name, kind);
      EXPECT_EQ(outcome.status, Status::kUsage) << name;
      EXPECT_NE(outcome.message.find("the input " + path("scan.ply").string()), std::string::npos)
          << outcome.message;
      EXPECT_NE(outcome.message.find("-o " + path(name).string()), std::string::npos) << outcome.message;
    }
  EXPECT_EQ(plan("other").status, Status::kOk);
}

TEST_F(Outputs, SpareEachOtherBeforeTheyExist) {
  fs::create_symlink("sub/a", path("to_a"));  // dangling
  const auto both = [&](const std::string& a, const std::string& b, OutputKind kind_of_b) {
    return plan({{"-o", path(a), OutputKind::kFile}, {"-s", path(b), kind_of_b}}).status;
  };
  for (const char* name : {"sub/a", "sub/../sub/a", "to_a", "sub/a.part"})
    EXPECT_EQ(both("sub/a", name, OutputKind::kFile), Status::kUsage) << name;
  for (const char* name : {"sub/a", "to_a", "sub/a.part", "sub", ".", "sub/../sub/"})
    EXPECT_EQ(both("sub/a", name, OutputKind::kFolder), Status::kUsage) << name;
  EXPECT_EQ(both("new/a", "new", OutputKind::kFolder), Status::kUsage) << "neither exists";
  EXPECT_EQ(both("sub/a", "sub/b", OutputKind::kFile), Status::kOk);
  EXPECT_EQ(both("sub/a", "a", OutputKind::kFolder), Status::kOk);
  EXPECT_EQ(both("sub/a", "su", OutputKind::kFolder), Status::kOk) << "a prefix of the name alone";
}

TEST_F(Outputs, AreWrittenWhereLinksLead) {
  fs::create_symlink(path("sub/far"), path("absolute"));
  fs::create_symlink("absolute", path("link"));
  ASSERT_EQ(plan("link").targets.size(), 1U);
  EXPECT_EQ(plan("link").targets[0].path, path("sub/far"));
  fs::create_symlink("circle", path("circle"));
  EXPECT_EQ(plan("circle").status, Status::kCannotCreate);
}

TEST_F(Outputs, AreOfTheRightKind) {
  EXPECT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  EXPECT_EQ(plan("pipe").status, Status::kUsage);
  EXPECT_EQ(plan("pipe", OutputKind::kFolder).status, Status::kUsage);
  const Outcome stream = plan("pipe", OutputKind::kFileOrStream);
  ASSERT_EQ(stream.status, Status::kOk);
  EXPECT_TRUE(stream.targets[0].is_stream);
  EXPECT_EQ(plan("sub").status, Status::kCannotCreate);
  EXPECT_EQ(plan("sub", OutputKind::kFileOrStream).status, Status::kCannotCreate);
  EXPECT_EQ(plan("sub", OutputKind::kFolder).status, Status::kOk);
  write("file", "");
  EXPECT_EQ(plan("file", OutputKind::kFolder).status, Status::kCannotCreate);
  EXPECT_EQ(plan({{"-o", "", OutputKind::kFile}}).status, Status::kUsage);
}

TEST_F(Outputs, HaveNamesThatFit) {
  EXPECT_EQ(plan("none/file").status, Status::kCannotCreate);
  EXPECT_EQ(plan("scan.ply/file").status, Status::kCannotCreate);
  EXPECT_EQ(plan(std::string(250, 'n')).status, Status::kOk);
  EXPECT_EQ(plan(std::string(251, 'n')).status, Status::kCannotCreate) << ".part does not fit";
  EXPECT_EQ(plan(std::string(251, 'n'), OutputKind::kFolder).status, Status::kOk);
  EXPECT_EQ(plan({{"-s", path("s"), OutputKind::kFolder, 5000}}).status, Status::kCannotCreate);
}

TEST_F(Outputs, ADescriptorIsWrittenOnFromWhereItStands) {
  const int descriptor = ::open(path("log").c_str(), O_WRONLY | O_CREAT, 0600);
  ASSERT_EQ(::write(descriptor, "before ", 7), 7);
  const Outcome outcome = plan({{"-o", fmt::format("/dev/fd/{}", descriptor), OutputKind::kFileOrStream}});
  ASSERT_EQ(outcome.status, Status::kOk) << outcome.message;
  EXPECT_EQ(outcome.targets[0].descriptor, descriptor);
  EXPECT_TRUE(outcome.targets[0].is_same_as(descriptor));
  OutputFile file(outcome.targets[0]);
  file.append(std::as_bytes(std::span("text", 4)));
  file.commit(OutputFile::Durability::kOnTheDevice);
  ASSERT_EQ(::write(descriptor, " after", 6), 6);
  ::close(descriptor);
  EXPECT_EQ(read("log"), "before text after");
  EXPECT_EQ(plan({{"-o", fmt::format("/dev/fd/{}", descriptor), OutputKind::kFileOrStream}}).status,
            Status::kCannotCreate)
      << "it is closed";
}

TEST_F(Outputs, AFileAppearsWhenItIsComplete) {
  write("o", "old");
  write("other", "precious");
  fs::create_hard_link(path("other"), path("o.part"));
  {
    OutputFile file{path("o")};
    file.append(std::as_bytes(std::span("new", 3)));
    EXPECT_EQ(read("o"), "old");
  }
  EXPECT_EQ(read("o"), "old");
  EXPECT_FALSE(fs::exists(path("o.part")));
  OutputFile file{path("o")};
  file.append(std::as_bytes(std::span("new", 3)));
  file.commit(OutputFile::Durability::kNone);
  EXPECT_EQ(read("o"), "new");
  EXPECT_EQ(read("other"), "precious");
}

TEST_F(Outputs, APartThatIsAnothersIsNeitherRenamedNorRemoved) {
  write("o", "old");
  {
    OutputFile file{path("o")};
    file.append(std::as_bytes(std::span("new", 3)));
    fs::remove(path("o.part"));
    write("o.part", "another's");
    try {
      file.commit(OutputFile::Durability::kNone);
      ADD_FAILURE();
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), Status::kIo) << error.what();
    }
  }
  EXPECT_EQ(read("o"), "old");
  EXPECT_EQ(read("o.part"), "another's");
}

TEST_F(Outputs, WaitingForAReaderCanBeGivenUp) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  OutputTarget target(path("pipe"));
  target.is_stream = true;
  int calls = 0;
  const auto give_up = [&] {
    if (++calls == 2) fail(Status::kStopped, "enough");
  };
  EXPECT_THROW(OutputFile(target, give_up), Error);
  EXPECT_EQ(calls, 2);
  // A reader that does not read: the pipe fills up.
  const int reader = ::open(path("pipe").c_str(), O_RDONLY | O_NONBLOCK);
  OutputFile file(target, give_up);
  calls = 0;
  EXPECT_THROW(file.append(Bytes(std::size_t{1} << 22)), Error);
  EXPECT_EQ(calls, 2);
  ::close(reader);
}

TEST_F(Outputs, OnlyRegularFilesAreRead) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  for (const char* name : {"pipe", "sub", "none"}) {
    try {
      File::open_for_reading(path(name));
      ADD_FAILURE() << name;
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), Status::kBadData) << error.what();
    }
  }
  fs::create_symlink("/dev/stdin", path("stdin"));
  for (const fs::path& name :
       {fs::path("/dev/stdin"), fs::path("/proc/self/fd/0"), path("stdin"), fs::path()})
    EXPECT_THROW(check_input_name(name), Error) << name;
  EXPECT_NO_THROW(check_input_name(path("scan.ply")));
  EXPECT_NO_THROW(check_input_name(path("none"))) << "which is told when it is opened";
}

}  // namespace
}  // namespace colossus::core
