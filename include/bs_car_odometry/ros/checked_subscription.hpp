#pragma once

#include <ros/node_handle.h>
#include <boost/function.hpp>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

namespace bs_car_odometry {

/// Counts messages that are shorter than their lengths claim. roscpp reads a message once for all
/// subscriptions in a process that take its type, in the thread of any of them, and may do so after one of
/// them has gone.
class CutMessages {
 public:
  void note() { ++count_; }
  /// How many since the last time.
  std::uint64_t take() { return count_.exchange(0); }

 private:
  std::atomic<std::uint64_t> count_{0};
};

/// Counts messages that are cut, where roscpp would write a line into the log for each.
///
/// The message's own type stays that of the subscription: only then does roscpp pass on a message of the same
/// process as it is. Of any other type it makes bytes, which wait for one more thread (docs/benchmarks.md).
template <typename Message>
class CheckedCallback : public ros::SubscriptionCallbackHelperT<const ros::MessageEvent<const Message>&> {
 public:
  using Base = ros::SubscriptionCallbackHelperT<const ros::MessageEvent<const Message>&>;

  CheckedCallback(const typename Base::Callback& callback, std::shared_ptr<CutMessages> cut)
      : Base(callback), cut_(std::move(cut)) {}

  /// @return none of a message that is cut; nobody is called with it
  ros::VoidConstPtr deserialize(const ros::SubscriptionCallbackHelperDeserializeParams& bytes) override {
    try {
      return Base::deserialize(bytes);
    } catch (const ros::serialization::StreamOverrunException&) {
      cut_->note();
      return {};
    }
  }

 private:
  std::shared_ptr<CutMessages> cut_;
};

/// A subscription, without Nagle's delay, of messages that may be cut.
class CheckedSubscriber {
 public:
  /// @param on_cut  called by tellCut() for each message that was cut
  template <typename Message>
  static CheckedSubscriber make(ros::NodeHandle& node, const std::string& topic, std::uint32_t queue_size,
                                const typename CheckedCallback<Message>::Base::Callback& callback,
                                const std::function<void()>& on_cut) {
    CheckedSubscriber subscriber;
    subscriber.on_cut_ = on_cut;
    ros::SubscribeOptions options(topic, queue_size, ros::message_traits::md5sum<Message>(),
                                  ros::message_traits::datatype<Message>());
    options.helper = boost::make_shared<CheckedCallback<Message>>(callback, subscriber.cut_);
    options.transport_hints.tcpNoDelay();
    subscriber.subscriber_ = node.subscribe(options);
    return subscriber;
  }

  /// To be called now and then, in the thread of the callbacks.
  void tellCut() const {
    for (std::uint64_t left = cut_->take(); left > 0; --left) on_cut_();
  }

 private:
  std::shared_ptr<CutMessages> cut_{std::make_shared<CutMessages>()};
  std::function<void()> on_cut_;
  ros::Subscriber subscriber_;
};

}  // namespace bs_car_odometry
