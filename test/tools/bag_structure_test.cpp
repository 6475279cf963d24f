// Damaged bags: refused with a sentence before rosbag follows a length or an offset that leads beyond the
// file.

#include "../../src/tools/bag_structure.hpp"
#include "../../src/tools/bag_input.hpp"
#include "../../src/tools/tool.hpp"
#include "temporary_folder.hpp"

#include "bs_car_odometry/WheelTicks.h"

#include <gmock/gmock.h>

#include <iterator>

namespace bs_car_odometry::tools::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string bytesOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

class BagStructure : public ::testing::Test {
 protected:
  /// Four messages in chunks of two, without the 4 kB of blanks behind the first record.
  std::string bag(rosbag::CompressionType compression) {
    {
      rosbag::Bag bag(file_, rosbag::bagmode::Write);
      bag.setCompression(compression);
      for (std::uint32_t i = 0; i < 4; ++i) {
        if (i == 2) bag.setChunkThreshold(1000000);  // ends a chunk
        bag.write("/wheel_ticks", ros::Time(1000 + i, 0), WheelTicks());
      }
    }
    return bytesOf(file_);
  }

  /// What is said of a bag when all its messages are read; empty when they can be.
  std::string refusal(const std::string& bytes) {
    folder_.write("any.bag", bytes);
    try {
      const std::unique_ptr<rosbag::Bag> bag = openBag(file_);
      readMessages(file_, [&] {
        for (const rosbag::MessageInstance& message : rosbag::View(*bag)) message.instantiate<WheelTicks>();
      });
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  /// What is said when the number behind `field=`, or the first one after `text`, is another.
  std::string refusalWith(const std::string& text, std::uint32_t number) {
    std::string bytes = bag(rosbag::compression::Uncompressed);
    const std::size_t at = bytes.find(text);
    if (at == std::string::npos) return "the bag has no " + text;
    bytes.replace(at + text.size(), sizeof number, reinterpret_cast<const char*>(&number), sizeof number);
    return refusal(bytes);
  }

  TemporaryFolder folder_;
  const std::string file_ = folder_.file("any.bag");
};

TEST_F(BagStructure, C10_soundBagsAreRead) {
  EXPECT_THAT(refusal(bag(rosbag::compression::Uncompressed)), IsEmpty());
  EXPECT_THAT(refusal(bag(rosbag::compression::LZ4)), IsEmpty());
  EXPECT_THAT(refusal(bag(rosbag::compression::BZ2)), IsEmpty());
}

TEST_F(BagStructure, C10_numbersThatLeadBeyondTheFileAreNamed) {
  const std::string repair = "'rosbag reindex " + file_ + "'";
  EXPECT_THAT(refusalWith("index_pos=", 100000000),
              AllOf(HasSubstr("its index points beyond"), HasSubstr(repair)));
  EXPECT_THAT(refusalWith("chunk_count=", 4000000000), AllOf(HasSubstr("beyond the end"), HasSubstr(repair)));
  EXPECT_THAT(refusalWith("chunk_pos=", 1), AllOf(HasSubstr("in each other"), HasSubstr(repair)));
  EXPECT_THAT(refusalWith("size=", 2000000000), AllOf(HasSubstr("larger than a message"), HasSubstr(repair)));
}

// A segmentation fault of rosbag would end the test.
TEST_F(BagStructure, C10_anyByteMayBeDamaged) {
  for (const auto compression : {rosbag::compression::Uncompressed, rosbag::compression::LZ4}) {
    const std::string good = bag(compression);
    const std::size_t blanks = good.find("     ");
    const std::size_t records = good.find_first_not_of(' ', blanks);
    std::size_t refused = 0;
    for (std::size_t i = 0; i < good.size(); i = i + 1 == blanks ? records : i + 1) {
      std::string bytes = good;
      bytes[i] = static_cast<char>(~bytes[i]);
      const std::string said = refusal(bytes);
      if (said.empty()) continue;
      ++refused;
      EXPECT_THAT(said, HasSubstr(file_)) << "byte " << i;
    }
    EXPECT_GT(refused, 100u);
  }
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
