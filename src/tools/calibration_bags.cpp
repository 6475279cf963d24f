#include "calibration_bags.hpp"

#include "bag_messages.hpp"
#include "calibrate.hpp"
#include "input_topics.hpp"

#include "bs_car_odometry/ros/calibration_adapter.hpp"

#include <rosbag/view.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <sstream>

namespace bs_car_odometry::tools {

using namespace calibration;

namespace {

/// Of each bag, so many are named.
constexpr std::size_t kMostJumps = 10;

/// Drives the adapter through the bags, one after the other.
class BagFilter {
 public:
  BagFilter(const CalibrateOptions& options, const CalibrationListener& listener)
      : options_(options),
        listener_(listener),
        adapter_(options.parameters),
        inputs_(options.parameters, options.topics),
        topics_(options.parameters, options.topics) {
    topics_.require("laser_pose", "geometry_msgs/PoseWithCovarianceStamped");
    adapter_.setListener([this](const CalibrationUpdate& update) { hear(update); });
  }

  FilteredBags run() {
    open();
    findMount();
    Progress progress("calibrate_bag", static_cast<double>(bags_.size()));
    for (std::size_t i = 0; i < bags_.size(); ++i) {
      if (i > 0) adapter_.newDrive();
      prepareStage(i);
      read(i, progress);
    }
    progress.hide();
    warnOfDrops();
    warnOfJumps();
    return result();
  }

 private:
  void open() {
    for (const std::string& path : options_.bags) {
      bags_.push_back(openBag(path));
      requireTopics(*bags_.back(), path, topicsOf(bags_.size() - 1).required());
      result_.bags.emplace_back();
      result_.bags.back().path = path;
    }
  }

  /// A run that was measured by tape.
  bool isTaped(std::size_t bag) const { return bag == 0 && options_.distance.has_value(); }
  const InputTopics& topicsOf(std::size_t bag) const { return isTaped(bag) ? inputs_ : topics_; }

  /// Of the paper's method.
  void prepareStage(std::size_t bag) {
    if (options_.distance && bag == 1)
      adapter_.takeTapedRun(taped_run_, *options_.distance);
    else if (!options_.distance && bags_.size() > 1)
      adapter_.setStraightRun(bag == 0);
  }

  /// @throws NoResultError when nothing follows it
  void keepTapedRun() {
    for (std::size_t i = 0; i < bag_->drive.steps(); ++i) taped_run_.push_back(bag_->drive.step(i));
    if (bags_.size() > 1) return;
    adapter_.takeTapedRun(taped_run_, *options_.distance);
    const FilterEstimate estimate = adapter_.calibrator().estimate();
    const Axle axle =
        options_.parameters.odometry.axles == AxleSelection::kFront ? Axle::kFront : Axle::kRear;
    std::ostringstream text;
    text << "k_d of the " << name(axle) << " axle is " << estimate.k_d[axle] << ", standard deviation "
         << std::sqrt(estimate.k_d_variance[axle])
         << ": more than the mean of k_r and k_l a straight run by tape does not show; give bags with "
            "laser_pose "
            "after it; nothing was written";
    throw NoResultError(kNotObservedStatus, text.str());
  }

  /// A mount holds for all bags: recorders that split a drive keep /tf_static in the first part alone.
  void findMount() {
    std::vector<std::string> spellings = options_.topics.spellings("tf_static");
    for (const std::string& name : options_.topics.spellings("tf")) spellings.push_back(name);
    for (std::size_t i = 0; i < bags_.size() && !adapter_.mountKnown(); ++i) {
      rosbag::View view(*bags_[i], rosbag::TopicQuery(spellings));
      for (auto message = view.begin(); message != view.end() && !adapter_.mountKnown(); ++message)
        if (const auto transforms = message->instantiate<tf2_msgs::TFMessage>()) adapter_.add(*transforms);
    }
    if (!adapter_.mountKnown())
      throw InputError(listed(options_.bags) + ": " + adapter_.waitingForMount(ros::Time()));
  }

  void read(std::size_t bag, Progress& progress) {
    bag_ = &result_.bags[bag];
    const LaserCounts before = adapter_.calibrator().counts();
    const double distance = adapter_.calibrator().excitation().distance;
    odometry_seen_ = false;
    rosbag::View view(*bags_[bag], rosbag::TopicQuery(topicsOf(bag).spellings()));
    // By time: a view counts its messages one by one.
    const double begin = view.getBeginTime().toSec();
    const double duration = view.getEndTime().toSec() - begin;
    readMessages(options_.bags[bag], [&] {
      BagMessages messages(view, options_.topics);
      while (const BagMessage* message = messages.next()) {
        advance(message->receipt);
        give(*message);
        const double done = message->receipt.toSec() - begin;
        progress.update(static_cast<double>(bag) + (duration > 0.0 ? done / duration : 0.0));
      }
    });
    advance(ros::TIME_MAX);
    bag_->drive = recorder_.take();
    bag_->distance = adapter_.calibrator().excitation().distance - distance;
    if (!odometry_seen_)
      throw InputError(bag_->path + " gave no odometry" + reasons(adapter_.pipeline().counts()));
    if (isTaped(bag)) return keepTapedRun();
    if (adapter_.calibrator().counts().used == before.used) throw InputError(noFirstFix());
  }

  void advance(const ros::Time& now) {
    while (const std::optional<OdometryUpdate> update = adapter_.next(now)) {
      recorder_.add(*update);
      odometry_seen_ = true;
    }
  }

  void give(const BagMessage& message) {
    if (giveInput(message, adapter_))
      advance(message.receipt);
    else if (const auto* pose =
                 std::get_if<geometry_msgs::PoseWithCovarianceStampedConstPtr>(&message.content))
      adapter_.add(**pose, message.receipt);
  }

  void hear(const CalibrationUpdate& update) {
    recorder_.add(update, adapter_.calibrator().counts());
    const bool good = update.innovation.nis <= kRejectLimit;
    bag_->good.push_back(good);
    bag_->distances.push_back(update.distance);
    if (update.jump) bag_->jumps.push_back(*update.jump);
    if (good) {
      sum_of_nis_ += update.innovation.nis;
      ++good_;
    }
    if (listener_) listener_(update);
  }

  std::string noFirstFix() const {
    std::ostringstream text;
    text << bag_->path
         << ": no beginning was found among its laser poses: five are needed while the odometry "
         << "runs, three of which agree with it";
    const LaserInputCounts& counts = adapter_.laserCounts();
    for (std::size_t i = 1; i < counts.verdicts.size(); ++i)
      if (counts.verdicts[i] > 0)
        text << "; " << counts.verdicts[i]
             << " laser poses dropped: " << explain(static_cast<LaserVerdict>(i));
    return text.str();
  }

  void warnOfDrops() const {
    const LaserInputCounts& counts = adapter_.laserCounts();
    for (std::size_t i = 1; i < counts.verdicts.size(); ++i)
      if (counts.verdicts[i] > 0)
        warn(std::to_string(counts.verdicts[i]) +
             " laser poses dropped: " + explain(static_cast<LaserVerdict>(i)));
    if (counts.without_covariance > 0)
      warn(std::to_string(counts.without_covariance) +
           " laser poses carry no covariance: they are taken with laser_sigma");
  }

  void warnOfJumps() const {
    for (const CalibratedBag& bag : result_.bags) {
      const std::size_t named = std::min(bag.jumps.size(), kMostJumps);
      for (std::size_t i = 0; i < named; ++i) warn(bag.name() + ": " + explain(bag.jumps[i]));
      if (bag.jumps.size() > named)
        warn(bag.name() + ": and " + std::to_string(bag.jumps.size() - named) + " more jumps");
    }
  }

  FilteredBags result() {
    const Calibrator& calibrator = adapter_.calibrator();
    result_.parameters = adapter_.parameters();
    result_.estimate = calibrator.estimate();
    result_.estimated = calibrator.estimated();
    result_.prior = calibrator.prior();
    result_.counts = calibrator.counts();
    result_.excitation = calibrator.excitation();
    result_.span = calibrator.span().value();
    result_.mean_nis = good_ > 0 ? sum_of_nis_ / static_cast<double>(good_) : 0.0;
    return std::move(result_);
  }

  const CalibrateOptions& options_;
  const CalibrationListener& listener_;
  CalibrationAdapter adapter_;
  InputTopics inputs_;  ///< of the odometry
  InputTopics topics_;  ///< with the laser's poses
  std::vector<std::unique_ptr<rosbag::Bag>> bags_;
  DriveRecorder recorder_;
  std::vector<MeasuredStep> taped_run_;
  CalibratedBag* bag_{nullptr};  ///< the one that is read
  FilteredBags result_;
  bool odometry_seen_{false};  ///< in this bag
  double sum_of_nis_{0.0};
  std::uint64_t good_{0};
};

}  // namespace

FilteredBags filterBags(const CalibrateOptions& options, const CalibrationListener& listener) {
  return BagFilter(options, listener).run();
}

}  // namespace bs_car_odometry::tools
