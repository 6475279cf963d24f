#pragma once

#include <ros/node_handle.h>
#include <boost/function.hpp>

#include <cstdint>
#include <string>

namespace bs_car_odometry {

/// Hands over nullptr in place of a message that is shorter than its lengths claim, where roscpp would write
/// a line into the log for each.
///
/// The message's own type stays that of the subscription: only then does roscpp pass on a message of the same
/// process as it is. Of any other type it makes bytes, which wait for one more thread (docs/benchmarks.md).
template <typename Message>
class CheckedCallback : public ros::SubscriptionCallbackHelperT<const ros::MessageEvent<const Message>&> {
 public:
  using Base = ros::SubscriptionCallbackHelperT<const ros::MessageEvent<const Message>&>;
  using Event = ros::MessageEvent<const Message>;
  using Take = boost::function<void(const Event* event)>;  ///< nullptr: a message that was cut

  explicit CheckedCallback(const Take& take)
      : Base([take](const Event& event) { take(&event); }), take_(take) {}

  /// roscpp calls this where it calls a callback: in its thread, and never two at a time.
  ros::VoidConstPtr deserialize(const ros::SubscriptionCallbackHelperDeserializeParams& bytes) override {
    try {
      return Base::deserialize(bytes);
    } catch (const ros::serialization::StreamOverrunException&) {
      take_(nullptr);
      return {};
    }
  }

 private:
  Take take_;
};

/// nullptr of a message that was cut.
template <typename Message>
const Message* messageOf(const ros::MessageEvent<const Message>* event) {
  return event ? event->getConstMessage().get() : nullptr;
}

/// A subscription without Nagle's delay.
template <typename Message>
ros::Subscriber subscribeChecked(ros::NodeHandle& node, const std::string& topic, std::uint32_t queue_size,
                                 const typename CheckedCallback<Message>::Take& take) {
  ros::SubscribeOptions options(topic, queue_size, ros::message_traits::md5sum<Message>(),
                                ros::message_traits::datatype<Message>());
  options.helper = boost::make_shared<CheckedCallback<Message>>(take);
  options.transport_hints.tcpNoDelay();
  return node.subscribe(options);
}

}  // namespace bs_car_odometry
