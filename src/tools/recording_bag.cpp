#include "recording_bag.hpp"

#include "bag_writer.hpp"

#include <algorithm>
#include <functional>

namespace bs_car_odometry::tools {
namespace {

/// One message to write; those of the same time go in the order in which they were added.
struct Record {
  ros::Time time;
  std::function<void(BagWriter&)> write;
};

template <typename Message>
void add(const std::vector<Message>& messages, const std::string& topic, std::vector<Record>& records) {
  for (const Message& message : messages)
    records.push_back({message.header.stamp, [&message, topic](BagWriter& bag) {
                         bag.write(topic, message.header.stamp, message);
                       }});
}

std::vector<Record> recordsInTimeOrder(const Recording& recording, const TopicNames& topics) {
  std::vector<Record> records;
  add(recording.front_steering, topics.topic("front_steering"), records);
  add(recording.rear_steering, topics.topic("rear_steering"), records);
  add(recording.wheels, topics.topic("wheel_ticks"), records);
  add(recording.laser_poses, topics.topic("laser_pose"), records);
  add(recording.ground_truth, topics.topic("ground_truth"), records);
  std::stable_sort(records.begin(), records.end(),
                   [](const Record& a, const Record& b) { return a.time < b.time; });
  return records;
}

}  // namespace

void writeBag(const std::string& path, const Recording& recording, const TopicNames& topics) {
  const std::vector<Record> records = recordsInTimeOrder(recording, topics);
  BagWriter bag(path);
  Progress progress("writing " + path, static_cast<double>(records.size()));
  for (std::size_t i = 0; i < records.size(); ++i) {
    records[i].write(bag);
    progress.update(static_cast<double>(i + 1));
  }
  bag.commit();
}

}  // namespace bs_car_odometry::tools
