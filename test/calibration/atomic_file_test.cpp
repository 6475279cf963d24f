// C11: a calibration file is the old one or the new one, whatever ends the saving.
#include "calibration_file.hpp"

#include "support/environment.hpp"
#include "support/figure.hpp"
#include "tools/temporary_folder.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <ctime>
#include <fstream>
#include <functional>
#include <iostream>
#include <iterator>
#include <random>

namespace bs_car_odometry::calibration::testing {
namespace {

using ::testing::HasSubstr;
using tools::testing::errorOf;
using tools::testing::TemporaryFolder;

// scripts/kills asks for more.
const int kKills = static_cast<int>(fromEnvironment("BS_CAR_ODOMETRY_KILLS", 100.0));

std::string textOf(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

CalibrationResult numbered(int number) {
  CalibrationResult numbered = result();
  numbered.data.laser_poses = static_cast<std::uint64_t>(number);
  return numbered;
}

void save(const std::string& path, const CalibrationResult& result) {
  writeCalibrationFile(path, result, cycab());
}

using Write = std::function<void(const std::string& path, const std::string& text)>;

/// What the atomic writing is there to avoid.
void rewrite(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

/// A process that writes one calibration after the other until it is killed; it has written one already.
pid_t startWriting(const Write& write, const std::string& path, int first) {
  std::vector<std::string> texts;
  for (int number = first; number < first + 10; ++number) texts.push_back(toText(numbered(number), cycab()));
  int ready[2];
  if (::pipe(ready) != 0) std::abort();
  const pid_t process = ::fork();
  if (process == 0) {
    write(path, texts.front());
    if (::write(ready[1], "x", 1) != 1) ::_exit(1);
    for (std::size_t i = 0;; ++i) write(path, texts[i % texts.size()]);
  }
  char byte = 0;
  if (process < 0 || ::read(ready[0], &byte, 1) != 1) std::abort();
  ::close(ready[0]);
  ::close(ready[1]);
  return process;
}

/// How many of the files that killed processes leave cannot be read.
int corruptAfterKills(const Write& write) {
  constexpr unsigned kSeed = 11;
  std::cout << "seed " << kSeed << "\n";
  std::mt19937 random(kSeed);
  // Thousands of writings without a disk, some on a slow one.
  std::uniform_int_distribution<long> nanoseconds(0, 10000000);
  const TemporaryFolder folder;
  const std::string path = folder.file("car.yaml");
  int corrupt = 0;
  for (int kill = 0; kill < kKills; ++kill) {
    const int first = 1000000 * (kill + 1);
    const pid_t process = startWriting(write, path, first);
    const timespec moment{0, nanoseconds(random)};
    ::nanosleep(&moment, nullptr);
    ::kill(process, SIGKILL);
    int status = 0;
    ::waitpid(process, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status)) << "the writing ended by itself";
    try {
      const CalibrationResult read = readCalibrationFile(path, cycab());
      EXPECT_GE(read.data.laser_poses, static_cast<std::uint64_t>(first))
          << "older than what had been written";
    } catch (const CalibrationFileError&) {
      ++corrupt;
    }
  }
  EXPECT_LE(folder.files(), 2u) << "hidden files pile up";
  return corrupt;
}

TEST(AtomicFile, C11_a_killed_writing_leaves_a_whole_file) {
  const int corrupt = corruptAfterKills(writeAtomically);
  EXPECT_EQ(corrupt, 0);
  recordFigure("%d of %d files broken by kill -9", corrupt, kKills);
}

/// The test above finds what it looks for.
TEST(AtomicFile, C11_plain_rewriting_does_not) {
  const int corrupt = corruptAfterKills(rewrite);
  std::cout << "corrupt after plain rewriting: " << corrupt << " of " << kKills << "\n";
  EXPECT_GT(corrupt, 0);
}

/// A calibration that is there, and that no failure may change.
class OldFile : public ::testing::Test {
 protected:
  void SetUp() override { save(path_, numbered(1)); }
  void TearDown() override {
    EXPECT_EQ(readCalibrationFile(path_, cycab()).data.laser_poses, 1u);
    EXPECT_EQ(folder_.files(), files_) << "something is left";
  }
  std::string saveError(const std::string& path) {
    return errorOf([&] { save(path, numbered(2)); });
  }

  TemporaryFolder folder_;
  std::string path_{folder_.file("car.yaml")};
  std::size_t files_{1};
};

/// The disk is full after so many bytes.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int){nullptr};
};

TEST_F(OldFile, C11_survives_a_full_disk) {
  for (const rlim_t bytes : {0, 1, 100, 1000}) {
    const FullDisk disk(bytes);
    EXPECT_THAT(saveError(path_), HasSubstr(path_ + " cannot be written: File too large")) << bytes;
  }
}

TEST_F(OldFile, C11_survives_a_folder_that_is_none) {
  for (const auto& [path, why] :
       {std::pair<std::string, std::string>{folder_.file("none/car.yaml"), "No such file"},
        {path_ + "/car.yaml", "Not a directory"},
        {folder_.file(""), "not the name of a file"},
        {folder_.file("."), "not the name of a file"},
        {folder_.file(".."), "not the name of a file"},
        {"/tmp", "not a regular file"},
        {"", "not the name of a file"},
        {"/dev/full", "not a regular file"}}) {
    EXPECT_THAT(saveError(path), HasSubstr(why)) << path;
    const std::string checked = path;
    EXPECT_THAT(errorOf([&] { checkWritable(checked); }), HasSubstr(why)) << path;
  }
}

/// On a file system that nobody can write to, the superuser included.
TEST_F(OldFile, C11_survives_a_folder_that_is_read_only) {
  const std::string path = "/proc/self/car.yaml";
  EXPECT_THAT(saveError(path), HasSubstr("cannot be written: "));
  EXPECT_THAT(errorOf([&] { checkWritable(path); }), HasSubstr("cannot be written: "));
}

TEST_F(OldFile, X2_survives_symbolic_links) {
  const std::string link = folder_.file("link.yaml");
  ASSERT_EQ(::symlink(path_.c_str(), link.c_str()), 0);
  const std::string hidden = folder_.file(".other.yaml.tmp");
  ASSERT_EQ(::symlink(path_.c_str(), hidden.c_str()), 0);
  files_ = 3;
  EXPECT_THAT(saveError(link), HasSubstr("it is a symbolic link; name the file itself"));
  EXPECT_THAT(errorOf([&] { checkWritable(link); }), HasSubstr("it is a symbolic link"));
  EXPECT_THAT(saveError(folder_.file("other.yaml")), HasSubstr("cannot be written"));
}

TEST_F(OldFile, X2_is_not_written_through_a_second_name) {
  ASSERT_EQ(::link(path_.c_str(), folder_.file(".other.yaml.tmp").c_str()), 0);
  files_ = 2;
  EXPECT_THAT(saveError(folder_.file("other.yaml")), HasSubstr("is in the way"));
}

TEST_F(OldFile, C11_two_writers_do_not_mix) {
  const int other = ::open(folder_.file(".car.yaml.tmp").c_str(), O_RDWR | O_CREAT, 0600);
  ASSERT_EQ(::flock(other, LOCK_EX), 0);
  EXPECT_THAT(saveError(path_), HasSubstr("another program is writing it"));
  ::close(other);
  files_ = 2;
}

TEST(AtomicFile, C11_takes_over_what_a_crash_left) {
  const TemporaryFolder folder;
  folder.write(".car.yaml.tmp", std::string(100000, 'x'));
  save(folder.file("car.yaml"), numbered(3));
  EXPECT_EQ(readCalibrationFile(folder.file("car.yaml"), cycab()).data.laser_poses, 3u);
  EXPECT_EQ(folder.files(), 1u);
}

TEST(AtomicFile, C11_can_be_checked_beforehand) {
  const TemporaryFolder folder;
  EXPECT_NO_THROW(checkWritable(folder.file("car.yaml")));
  EXPECT_EQ(folder.files(), 0u);
  save(folder.file("car.yaml"), numbered(4));
  EXPECT_NO_THROW(checkWritable(folder.file("car.yaml")));
  EXPECT_EQ(readCalibrationFile(folder.file("car.yaml"), cycab()).data.laser_poses, 4u);
}

TEST(AtomicFile, theFileAppearsOnlyWhenCommitted) {
  const TemporaryFolder folder;
  const std::string path = folder.write("out.bag", "old");
  AtomicFile output(path);
  std::ofstream(output.temporaryPath()) << "new";
  EXPECT_EQ(textOf(path), "old");
  output.commit();
  EXPECT_EQ(textOf(path), "new");
  EXPECT_EQ(folder.files(), 1u);
}

TEST(AtomicFile, whatIsNotCommittedLeavesNoTrace) {
  const TemporaryFolder folder;
  { const AtomicFile output(folder.file("out.bag")); }
  EXPECT_EQ(folder.files(), 0u);
}

TEST(AtomicFile, has_the_permissions_of_any_new_file) {
  const TemporaryFolder folder;
  const mode_t mask = ::umask(027);
  save(folder.file("car.yaml"), numbered(5));
  ::umask(mask);
  struct stat status {};
  ASSERT_EQ(::stat(folder.file("car.yaml").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777u, 0640u);
}

}  // namespace
}  // namespace bs_car_odometry::calibration::testing
