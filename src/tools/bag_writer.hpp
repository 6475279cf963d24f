#pragma once

#include "bs_car_odometry/calibration/atomic_file.hpp"

#include <rosbag/bag.h>

#include <memory>
#include <string>

namespace bs_car_odometry::tools {

/// A bag under way, LZ4 compressed; it appears under its name only with commit(). A disk that takes no more
/// is an exception of write() or commit(), and never one of the destructor.
class BagWriter {
 public:
  explicit BagWriter(const std::string& path)
      : output_(path), bag_(std::make_unique<rosbag::Bag>(output_.temporaryPath(), rosbag::bagmode::Write)) {
    bag_->setCompression(rosbag::compression::LZ4);
  }

  ~BagWriter() {
    try {
      bag_->close();
    } catch (const std::exception&) {
      // Its destructor would close it once more, throw, and end the process.
      static_cast<void>(bag_.release());
    }
  }

  BagWriter(const BagWriter&) = delete;
  BagWriter& operator=(const BagWriter&) = delete;

  template <typename Message>
  void write(const std::string& topic, const ros::Time& time, const Message& message) {
    bag_->write(topic, time, message);
  }

  void commit() {
    bag_->close();
    output_.commit();
  }

 private:
  calibration::AtomicFile output_;
  std::unique_ptr<rosbag::Bag> bag_;
};

}  // namespace bs_car_odometry::tools
