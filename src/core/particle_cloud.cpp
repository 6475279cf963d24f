#include "bs_car_odometry/core/particle_cloud.hpp"

#include "bs_car_odometry/core/first_order_covariance.hpp"
#include "bs_car_odometry/core/particle_draws.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace bs_car_odometry {

namespace {

/// What random numbers are drawn for.
enum Purpose : std::uint32_t {
  kGaussianNoise,
  kOtherNoise,      ///< and those after it, one for each source
  kHeldErrors = 8,  ///< and one after it
  kInitialPose = 10,
  kParameters  ///< and those after it
};

/// Quantiles are taken over so many particles at most: sorting more would take longer than moving them.
constexpr std::size_t kMostForQuantiles = 10000;

/// The symmetric root of the nearest covariance.
Eigen::Matrix3d symmetricRoot(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(0.5 * (covariance + covariance.transpose()));
  const Eigen::Matrix3d& V = solver.eigenvectors();
  return V * solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * V.transpose();
}

/// Departures of one more block in the sums of those before it (T. F. Chan, G. H. Golub, R. J. LeVeque,
/// "Updating formulae and a pairwise algorithm for computing sample variances", 1979).
struct Moments {
  double count{0.0};
  Eigen::Vector3d mean{Eigen::Vector3d::Zero()};
  Eigen::Matrix3d products{Eigen::Matrix3d::Zero()};

  void add(const BlockMoments& block, double block_count) {
    const Eigen::Vector3d apart = Eigen::Vector3d(block.mean[0], block.mean[1], block.mean[2]) - mean;
    const double total = count + block_count;
    const std::array<double, 6>& p = block.products;
    Eigen::Matrix3d own;
    own << p[0], p[1], p[2], p[1], p[3], p[4], p[2], p[4], p[5];
    products += own + (count * block_count / total) * apart * apart.transpose();
    mean += (block_count / total) * apart;
    count = total;
  }
};

}  // namespace

/// What passes between the kernels of one block.
struct ParticleCloud::Workspace {
  BitBlock particles;
  std::array<BitBlock, 4> bits;
  std::array<FloatBlock, 3> draws;
  PerAxle<FloatBlock> angles;
  MotionBlock motion;
  DoubleBlock halfway;
  FloatBlock sines, cosines, chord;
};

ParticleCloud::ParticleCloud(const OdometryConfiguration& c)
    : planner_(c),
      prior_(c),
      seed_(static_cast<std::uint64_t>(c.options.particles.seed)),
      x_(static_cast<std::size_t>(c.options.particles.count)),
      y_(x_.size()),
      yaw_(x_.size()),
      held_{{planner_.angleError(Axle::kFront), c.noise.steering.correlation_length, x_.size()},
            {planner_.angleError(Axle::kRear), c.noise.steering.correlation_length, x_.size()}},
      pool_(static_cast<std::size_t>(c.options.particles.threads)),
      workspaces_(pool_.threads()),
      moments_((x_.size() + kParticleBlock - 1) / kParticleBlock),
      sorted_(std::min(x_.size(), kMostForQuantiles)) {
  for (std::vector<float>& errors : parameters_) errors.resize(x_.size());
  reset({}, Eigen::Matrix3d::Zero());
}

ParticleCloud::~ParticleCloud() = default;

/// Blocks are dealt out to the threads in turn.
template <typename Work>
void ParticleCloud::forEachBlock(const Work& work) {
  pool_.run([&](std::size_t thread) {
    Workspace& w = workspaces_[thread];
    for (std::size_t b = thread; b < moments_.size(); b += pool_.threads()) {
      const std::size_t first = b * kParticleBlock;
      const Block block{first, std::min(kParticleBlock, x_.size() - first)};
      std::iota(w.particles.begin(), w.particles.end(), static_cast<std::uint32_t>(first));
      work(block, w);
      moments_[b] = kernels::moments(&x_[first], &y_[first], &yaw_[first], block.count);
    }
  });
}

void ParticleCloud::reset(const Pose2& pose, const Eigen::Matrix3d& covariance) {
  step_ = 0;
  reference_ = pose;
  unseen_.setZero();
  for (std::vector<double>* values : {&x_, &y_, &yaw_}) std::fill(values->begin(), values->end(), 0.0);
  drawParameters(prior_, SystematicCovariance::Zero());
  for (const Axle axle : kAllAxles) held_[axle].restart();
  forEachBlock([this](const Block& block, const Workspace&) {
    for (const Axle axle : kAllAxles)
      if (held_[axle].active())
        held_[axle].begin(number(kHeldErrors + static_cast<std::uint32_t>(index(axle))), block.first,
                          block.count);
  });
  addDraws(covariance, kInitialPose);
}

void ParticleCloud::setSystematic(const SystematicPrior& prior, const SystematicCovariance& carried) {
  ++step_;
  drawParameters(prior, carried);
  prior_ = prior;
}

void ParticleCloud::addDraws(const Eigen::Matrix3d& covariance, std::uint32_t purpose) {
  const Eigen::Matrix3d root = symmetricRoot(covariance);
  forEachBlock([&, this](const Block& block, Workspace& w) {
    kernels::randomBits(number(purpose), w.particles.data(), block.count, w.bits);
    kernels::normals(w.bits[0], w.bits[1], block.count, w.draws[0], w.draws[1]);
    kernels::normals(w.bits[2], w.bits[3], block.count, w.draws[2]);
    for (std::size_t i = 0; i < block.count; ++i) {
      const Eigen::Vector3d error = root * Eigen::Vector3d(w.draws[0][i], w.draws[1][i], w.draws[2][i]);
      x_[block.first + i] += error.x();
      y_[block.first + i] += error.y();
      yaw_[block.first + i] += error.z();
    }
  });
  setMoments();
}

/// A' = L' (M^T a + R z) with independent draws of the components of z, R R^T = I - M^T M.
void ParticleCloud::drawParameters(const SystematicPrior& prior, const SystematicCovariance& carried) {
  const SystematicCovariance L = prior.root.matrix();
  const SystematicCovariance I = SystematicCovariance::Identity();
  const SystematicCovariance drawn = L * SystematicRoot(I - carried.transpose() * carried).matrix();
  const SystematicCovariance kept =
      carried.isZero(0.0) ? SystematicCovariance::Zero()
                          : SystematicCovariance(L * carried.transpose() * prior_.root.inverse());
  forEachBlock([&, this](const Block& block, Workspace& w) {
    keepParameters(kept, block);
    for (std::size_t j = 0; j < prior.active.size(); ++j) {
      if (!prior.active[j]) continue;
      drawStandardised(prior.shape[j], number(kParameters + static_cast<std::uint32_t>(j)),
                       w.particles.data(), block.count, w.draws[0]);
      for (std::size_t i = j; i < parameters_.size(); ++i) {
        const auto factor =
            static_cast<float>(drawn(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
        for (std::size_t k = 0; k < block.count; ++k)
          parameters_[i][block.first + k] += factor * w.draws[0][k];
      }
    }
  });
  setUncertain(L, prior);
}

void ParticleCloud::keepParameters(const SystematicCovariance& kept, const Block& block) {
  const Eigen::Matrix<float, systematic::kCount, systematic::kCount> K = kept.cast<float>();
  Eigen::Matrix<float, systematic::kCount, 1> errors;
  for (std::size_t k = block.first; k < block.first + block.count; ++k) {
    for (std::size_t i = 0; i < parameters_.size(); ++i)
      errors[static_cast<Eigen::Index>(i)] = parameters_[i][k];
    errors = (K * errors).eval();
    for (std::size_t i = 0; i < parameters_.size(); ++i)
      parameters_[i][k] = errors[static_cast<Eigen::Index>(i)];
  }
}

/// Which parameters have errors at all, and how large those of the angles are.
void ParticleCloud::setUncertain(const SystematicCovariance& L, const SystematicPrior& prior) {
  std::array<double, systematic::kCount> variance{};
  for (std::size_t i = 0; i < uncertain_.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j)
      if (prior.active[j])
        variance[i] += std::pow(L(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)), 2);
    uncertain_[i] = variance[i] > 0.0;
  }
  planner_.setOffsets(
      {std::sqrt(variance[systematic::kFrontOffset]), std::sqrt(variance[systematic::kRearOffset])});
  uncertain_[systematic::kFrontOffset] &= planner_.hasOffset(Axle::kFront);
  uncertain_[systematic::kRearOffset] &= planner_.hasOffset(Axle::kRear);
}

void ParticleCloud::advance(const UncertainStep& step) {
  const auto& travels = step.readings.travel.values;
  const bool stands =
      std::all_of(travels.begin(), travels.end(), [](double travel) { return travel == 0.0; });
  if (stands && step.increment.motion.isZero(0.0)) return;
  ++step_;
  reference_ = step.moved.pose;
  advanceNoise(step.moved, Eigen::Matrix3d::Zero(), unseen_);
  const ParticlePlan plan = planner_.plan(step);
  for (const Axle axle : kAllAxles) held_step_[axle] = held_[axle].take(plan.angle_path[axle]);
  forEachBlock([&, this](const Block& block, Workspace& w) { move(plan, block, w); });
  setMoments();
}

void ParticleCloud::move(const ParticlePlan& plan, const Block& block, Workspace& w) {
  MotionBlock& t = w.motion;
  std::fill_n(t.x.begin(), block.count, plan.motion[0]);
  std::fill_n(t.y.begin(), block.count, plan.motion[1]);
  std::fill_n(t.turn.begin(), block.count, plan.motion[2]);
  addGains(plan, block, w);
  addNoise(plan, block, w);
  addAngleErrors(plan, block, w);
  if (kernels::largestSize(t.turn, block.count) <= kernels::kLargeTurn) {
    kernels::chords(t.turn, block.count, w.chord);
  } else {
    kernels::chordsOfLargeTurns(t.turn, block.count, w.chord);
  }
  kernels::halfwayHeadings(&yaw_[block.first], t.turn, block.count, w.halfway);
  kernels::sinesAndCosines(w.halfway, block.count, w.sines, w.cosines);
  kernels::move(t, w.chord, w.sines, w.cosines, plan.reference, block.count, &x_[block.first],
                &y_[block.first], &yaw_[block.first]);
}

void ParticleCloud::addGains(const ParticlePlan& plan, const Block& block, Workspace& w) const {
  for (const Axle axle : kAllAxles) {
    const std::size_t k = axle == Axle::kFront ? systematic::kFrontRight : systematic::kRearRight;
    if (!uncertain_[k] && !uncertain_[k + 1] && !uncertain_[k + 2]) continue;
    kernels::addProducts(plan.gains[axle], &parameters_[k][block.first], &parameters_[k + 1][block.first],
                         &parameters_[k + 2][block.first], block.count, w.motion);
  }
}

void ParticleCloud::addNoise(const ParticlePlan& plan, const Block& block, Workspace& w) const {
  if (plan.has_gaussian) {
    kernels::randomBits(number(kGaussianNoise), w.particles.data(), block.count, w.bits);
    kernels::normals(w.bits[0], w.bits[1], block.count, w.draws[0], w.draws[1]);
    kernels::normals(w.bits[2], w.bits[3], block.count, w.draws[2]);
    kernels::addProducts(plan.gaussian, w.draws[0].data(), w.draws[1].data(), w.draws[2].data(), block.count,
                         w.motion);
  }
  for (std::size_t j = 0; j < plan.source_count; ++j) {
    const ParticlePlan::Source& source = plan.sources[j];
    draw(*source.distribution, number(kOtherNoise + static_cast<std::uint32_t>(j)), w.particles.data(),
         block.count, w.draws[0]);
    const Eigen::Vector3f& c = source.column;
    const float* values = w.draws[0].data();
    kernels::addProducts({c.x(), 0, 0, c.y(), 0, 0, c.z(), 0, 0}, values, values, values, block.count,
                         w.motion);
  }
}

/// What is held for a length of travel, and what for the whole drive.
void ParticleCloud::addAngleErrors(const ParticlePlan& plan, const Block& block, Workspace& w) {
  bool any = false;
  for (const Axle axle : kAllAxles) {
    FloatBlock& angle = w.angles[axle];
    HeldErrors& held = held_[axle];
    const bool drives = held.active() && held_step_[axle].travel > 0.0;
    std::fill_n(angle.begin(), block.count, 0.0F);
    if (drives)
      held.advance(held_step_[axle], number(kHeldErrors + static_cast<std::uint32_t>(index(axle))),
                   block.first, block.count, angle);
    const std::size_t k = axle == Axle::kFront ? systematic::kFrontOffset : systematic::kRearOffset;
    if (uncertain_[k])
      for (std::size_t i = 0; i < block.count; ++i) angle[i] += parameters_[k][block.first + i];
    any = any || drives || uncertain_[k];
  }
  if (any) kernels::addPolynomials(plan.angles, w.angles.front, w.angles.rear, block.count, w.motion);
}

void ParticleCloud::setMoments() {
  Moments sums;
  for (std::size_t b = 0; b < moments_.size(); ++b)
    sums.add(moments_[b], static_cast<double>(std::min(kParticleBlock, x_.size() - b * kParticleBlock)));
  mean_ = sums.mean;
  const double degrees_of_freedom = sums.count - 1.0;
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = i; j < 3; ++j)
      covariance_(i, j) = covariance_(j, i) = sums.products(i, j) / degrees_of_freedom;
}

std::optional<Pose2> ParticleCloud::mean() const {
  return Pose2{reference_.x + mean_.x(), reference_.y + mean_.y(), reference_.yaw + mean_.z()};
}

Pose2 ParticleCloud::particle(std::size_t i) const {
  return {reference_.x + x_[i], reference_.y + y_[i], reference_.yaw + yaw_[i]};
}

std::optional<PoseQuantiles> ParticleCloud::quantiles() {
  return PoseQuantiles{quantilesOf(x_, reference_.x), quantilesOf(y_, reference_.y),
                       quantilesOf(yaw_, reference_.yaw)};
}

/// The smallest value that is not exceeded with the probability.
PoseQuantiles::Values ParticleCloud::quantilesOf(const std::vector<double>& departures, double reference) {
  std::copy_n(departures.begin(), sorted_.size(), sorted_.begin());
  PoseQuantiles::Values values;
  auto from = sorted_.begin();
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double rank = PoseQuantiles::kLevels[k] * static_cast<double>(sorted_.size());
    const auto place = sorted_.begin() + static_cast<std::ptrdiff_t>(rank);
    std::nth_element(from, place, sorted_.end());
    values[k] = reference + *place;
    from = place;
  }
  return values;
}

}  // namespace bs_car_odometry
