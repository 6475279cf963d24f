#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace bs_car_odometry::tools::doctor {

/// Values of a long stream, evenly spread over it and bounded in number: each time it is full, every other
/// one goes and the stride doubles.
class EvenSample {
 public:
  void add(double value) {
    if (count_++ % stride_ != 0) return;
    values_.push_back(value);
    if (values_.size() < kMost) return;
    for (std::size_t i = 0; 2 * i < values_.size(); ++i) values_[i] = values_[2 * i];
    values_.resize((values_.size() + 1) / 2);
    stride_ *= 2;
  }

  bool empty() const { return values_.empty(); }

  /// @param fraction  0.5: the median  @return 0 when empty
  double quantile(double fraction) const {
    if (values_.empty()) return 0.0;
    std::vector<double> sorted = values_;
    const auto at = static_cast<std::size_t>(fraction * static_cast<double>(sorted.size() - 1) + 0.5);
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(at), sorted.end());
    return sorted[at];
  }

 private:
  static constexpr std::size_t kMost = 8192;
  std::vector<double> values_;
  std::size_t count_{0};
  std::size_t stride_{1};
};

/// Samples in order of their time `t` [s], at most 20 a second, and fewer when the bag is long: for ten
/// hours the memory stays below 100 MB, and what a car does lasts longer.
template <typename Sample>
class Series {
 public:
  void add(const Sample& sample) {
    if (!samples_.empty() && sample.t - samples_.back().t < 0.999 * interval_) return;
    samples_.push_back(sample);
    if (samples_.size() < kMost) return;
    for (std::size_t i = 0; 2 * i < samples_.size(); ++i) samples_[i] = samples_[2 * i];
    samples_.resize((samples_.size() + 1) / 2);
    interval_ *= 2.0;
  }

  const std::vector<Sample>& samples() const { return samples_; }
  std::vector<Sample>& samples() { return samples_; }

  /// Index of the last sample that is not after `t`, so that [i, i + 1] holds it; size() when outside.
  std::size_t before(double t) const {
    const auto after = std::upper_bound(samples_.begin(), samples_.end(), t,
                                        [](double time, const Sample& sample) { return time < sample.t; });
    if (after == samples_.begin() || after == samples_.end()) return samples_.size();
    return static_cast<std::size_t>(after - samples_.begin()) - 1;
  }

 private:
  static constexpr std::size_t kMost = 400000;
  std::vector<Sample> samples_;
  double interval_{0.05};
};

}  // namespace bs_car_odometry::tools::doctor
