#include "bs_car_odometry/laboratory/consistency.hpp"

#include "bs_car_odometry/laboratory/chi_square.hpp"
#include "bs_car_odometry/laboratory/error.hpp"
#include "bs_car_odometry/laboratory/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace bs_car_odometry::laboratory {

namespace {

void countInside(double square, const std::array<double, 3>& regions, SigmaCounts& counts) {
  for (std::size_t k = 0; k < counts.size(); ++k)
    if (square <= regions[k]) ++counts[k];
}

template <typename Values>
void addTo(Values& to, const Values& from) {
  for (std::size_t k = 0; k < to.size(); ++k) to[k] += from[k];
}

}  // namespace

Judgement judge(const OdometryEstimate& estimate, const simulation::Pose& truth) {
  Judgement judgement;
  judgement.error = poseError(estimate, truth);
  judgement.variance = estimate.pose_covariance.diagonal();
  judgement.nees = exponentialNees(estimate, truth);
  judgement.plain_nees = plainNees(estimate, truth);
  judgement.expected_region = judgement.expected_plain_region = sigmaShares();
  return judgement;
}

void Consistency::add(const Judgement& judgement) {
  static const std::array<double, 3> regions = sigmaRegions(3.0);
  constexpr std::array<double, 3> kIntervals{1.0, 4.0, 9.0};
  ++drives_;
  distance_ += judgement.distance;
  error_ += judgement.error;
  error_square_ += judgement.error * judgement.error.transpose();
  variance_ += judgement.variance;
  nees_ += judgement.nees;
  plain_nees_ += judgement.plain_nees;
  if (judgement.twists > 0) {
    ++twist_drives_;
    twist_nees_ += judgement.twist_nees;
    twist_nees_square_ += judgement.twist_nees * judgement.twist_nees;
  }
  for (Eigen::Index i = 0; i < 3; ++i)
    countInside(judgement.error(i) * judgement.error(i) / judgement.variance(i), kIntervals,
                components_[static_cast<std::size_t>(i)]);
  countInside(judgement.nees, regions, region_);
  countInside(judgement.plain_nees, regions, plain_region_);
  addTo(expected_region_, judgement.expected_region);
  addTo(expected_plain_region_, judgement.expected_plain_region);
}

void Consistency::merge(const Consistency& other) {
  drives_ += other.drives_;
  twist_drives_ += other.twist_drives_;
  distance_ += other.distance_;
  error_ += other.error_;
  error_square_ += other.error_square_;
  variance_ += other.variance_;
  nees_ += other.nees_;
  plain_nees_ += other.plain_nees_;
  twist_nees_ += other.twist_nees_;
  twist_nees_square_ += other.twist_nees_square_;
  for (std::size_t i = 0; i < components_.size(); ++i) addTo(components_[i], other.components_[i]);
  addTo(region_, other.region_);
  addTo(plain_region_, other.plain_region_);
  addTo(expected_region_, other.expected_region_);
  addTo(expected_plain_region_, other.expected_plain_region_);
}

Eigen::Matrix3d Consistency::errorCovariance() const {
  const Eigen::Vector3d mean = meanError();
  return (error_square_ - count() * mean * mean.transpose()) / (count() - 1.0);
}

double Consistency::twistNeesStandardError() const {
  const auto n = static_cast<double>(twist_drives_);
  const double mean = meanTwistNees();
  return std::sqrt(std::max(twist_nees_square_ / n - mean * mean, 0.0) / (n - 1.0));
}

std::array<double, 3> Consistency::componentCoverage(Eigen::Index component) const {
  return share(components_[static_cast<std::size_t>(component)]);
}

std::array<double, 3> Consistency::share(const SigmaCounts& inside) const {
  std::array<double, 3> shares{};
  for (std::size_t k = 0; k < shares.size(); ++k) shares[k] = static_cast<double>(inside[k]) / count();
  return shares;
}

std::array<double, 3> Consistency::mean(std::array<double, 3> sums) const {
  for (double& sum : sums) sum /= count();
  return sums;
}

namespace {

/// Where the method carries particles, they say how many poses lie within each region.
void expectParticles(const OdometryEstimate& estimate, const PoseUncertainty& uncertainty,
                     Judgement& judgement) {
  const std::size_t particles = uncertainty.particles();
  if (particles == 0) return;
  const std::array<double, 3> regions = sigmaRegions(3.0);
  SigmaCounts region{};
  SigmaCounts plain_region{};
  for (std::size_t i = 0; i < particles; ++i) {
    const Pose2 particle = uncertainty.particle(i);
    const simulation::Pose pose{particle.x, particle.y, particle.yaw};
    countInside(exponentialNees(estimate, pose), regions, region);
    countInside(plainNees(estimate, pose), regions, plain_region);
  }
  for (std::size_t k = 0; k < regions.size(); ++k) {
    judgement.expected_region[k] = static_cast<double>(region[k]) / static_cast<double>(particles);
    judgement.expected_plain_region[k] =
        static_cast<double>(plain_region[k]) / static_cast<double>(particles);
  }
}

/// A drive's samples at which it is judged: the first ones at 1/n, 2/n, ... of its way, and the last one.
struct Places {
  std::vector<std::size_t> samples;
  std::vector<double> distances;  ///< [m]
};

std::vector<double> distancesAlong(const std::vector<Sample>& drive) {
  std::vector<double> distances(drive.size(), 0.0);
  for (std::size_t i = 1; i < drive.size(); ++i)
    distances[i] = distances[i - 1] + std::hypot(drive[i].truth.x - drive[i - 1].truth.x,
                                                 drive[i].truth.y - drive[i - 1].truth.y);
  return distances;
}

Places placesOf(const std::vector<Sample>& drive, std::size_t count) {
  const std::vector<double> distances = distancesAlong(drive);
  Places places;
  for (std::size_t k = 1; k <= count; ++k) {
    const double wanted = distances.back() * static_cast<double>(k) / static_cast<double>(count);
    const auto reached = std::lower_bound(distances.begin(), distances.end(), wanted);
    places.samples.push_back(k == count ? drive.size() - 1
                                        : static_cast<std::size_t>(reached - distances.begin()));
    places.distances.push_back(distances[places.samples.back()]);
  }
  return places;
}

/// Judges the updates of one drive one by one.
class Judge {
 public:
  Judge(const Places& places, ConsistencyOverDistance& results) : places_(places), results_(results) {}

  void see(const Sample& sample, const OdometryUpdate& update, const PoseUncertainty& uncertainty) {
    judgeTwist(sample, update);
    for (; place_ < places_.samples.size() && places_.samples[place_] == seen_; ++place_)
      judgePose(sample, update.estimate, uncertainty);
    ++seen_;
    before_ = sample.truth;
  }

 private:
  /// A step without a tick says nothing of a twist: it stands, as the car does.
  void judgeTwist(const Sample& sample, const OdometryUpdate& update) {
    if (!(update.report.interval > 0.0) || update.estimate.twist.isZero(0.0)) return;
    const Eigen::Vector3d truth = meanTwist(before_, sample.truth, update.report.interval);
    twist_nees_ += normalisedSquare(update.estimate.twist - truth, update.estimate.twist_covariance);
    ++twists_;
  }

  void judgePose(const Sample& sample, const OdometryEstimate& estimate, const PoseUncertainty& uncertainty) {
    Judgement judgement = judge(estimate, sample.truth);
    expectParticles(estimate, uncertainty, judgement);
    judgement.distance = places_.distances[place_];
    judgement.twists = twists_;
    if (twists_ > 0) judgement.twist_nees = twist_nees_ / static_cast<double>(twists_);
    results_[place_].add(judgement);
    twist_nees_ = 0.0;
    twists_ = 0;
  }

  const Places& places_;
  ConsistencyOverDistance& results_;
  std::size_t place_{0};
  std::size_t seen_{0};
  simulation::Pose before_;
  double twist_nees_{0.0};
  std::size_t twists_{0};
};

using Results = std::vector<ConsistencyOverDistance>;

Results noResults(const StudySettings& settings) {
  return Results(settings.odometries.size(), ConsistencyOverDistance(settings.places));
}

void judgeDrive(const StudySettings& settings, std::size_t number, Results& results) {
  DriveSettings drive_settings = settings.drive;
  drive_settings.seed += number;
  const std::vector<Sample> drive = record(settings.odometries.front().vehicle, drive_settings);
  const Places places = placesOf(drive, settings.places);
  for (std::size_t k = 0; k < settings.odometries.size(); ++k) {
    Judge judge(places, results[k]);
    OdometryPipeline pipeline(settings.odometries[k]);
    for (const Sample& sample : drive) judge.see(sample, step(pipeline, sample), pipeline.uncertainty());
  }
}

void mergeResults(const Results& from, Results& to) {
  for (std::size_t k = 0; k < to.size(); ++k)
    for (std::size_t place = 0; place < to[k].size(); ++place) to[k][place].merge(from[k][place]);
}

}  // namespace

std::vector<ConsistencyOverDistance> studyConsistency(const StudySettings& settings) {
  if (settings.drives == 0 || settings.odometries.empty() || settings.places == 0)
    throw std::invalid_argument("a study needs drives, odometries and places");
  // Sums are rounded, so which drives are summed together must not depend on the threads.
  constexpr std::size_t kBlocks = 256;
  const std::size_t block = (settings.drives + kBlocks - 1) / kBlocks;
  const std::size_t blocks = (settings.drives + block - 1) / block;
  const auto end = [&](std::size_t i) { return std::min(settings.drives, (i + 1) * block); };
  std::vector<Results> parts(blocks);
  runInParallel(
      blocks, settings.threads,
      [&](std::size_t i) {
        parts[i] = noResults(settings);
        for (std::size_t number = i * block; number < end(i); ++number)
          judgeDrive(settings, number, parts[i]);
      },
      [&](std::size_t done) {
        if (settings.progress) settings.progress(std::min(settings.drives, done * block));
      });
  Results results = noResults(settings);
  for (const Results& part : parts) mergeResults(part, results);
  return results;
}

}  // namespace bs_car_odometry::laboratory
