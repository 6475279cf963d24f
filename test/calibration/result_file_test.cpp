// C12: what a calibration file says, and that it is refused when it is not whole or not this car's.
#include "calibration_file.hpp"

#include "bs_car_odometry/core/systematic_prior.hpp"
#include "bs_car_odometry/parameters/load.hpp"
#include "support/figure.hpp"
#include "tools/temporary_folder.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <iostream>
#include <random>

namespace bs_car_odometry::calibration::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;
using tools::testing::errorOf;
using tools::testing::TemporaryFolder;

/// The file of docs/interface.md with a checksum of Python's zlib.crc32; its covariance, given there as an
/// example of the shape, is one.
const char* const kDocumented =
    "format: 1\n"
    "software: 0.1.0\n"
    "vehicle: {name: cycab, wheelbase: 1.2, track: {front: 1.2, rear: 1.2}, hub_offset: {front: 0.0, rear: "
    "0.0}, "
    "base_link_x: 0.0, axle_geometry: ackermann,\n"
    "  rear_steering: {source: polynomial, coefficients: [0.0, -1.0]},\n"
    "  metres_per_tick: {front_left: 1.0e-4, front_right: 1.0e-4, rear_left: 1.0e-4, rear_right: 1.0e-4}}\n"
    "data: {bags: [morning.bag], from: 1767225600.0, to: 1767226255.2, distance: 412.6, laser_poses: 6540, "
    "rejected: 12, method: joint, axles: rear}\n"
    "gains:\n"
    "  rear: {k_r: 1.0021, k_l: 0.9987, k_b: 1.0153}\n"
    "  parameters: [rear/k_r, rear/k_l, rear/k_b, front/steering_offset]\n"
    "  covariance: [1.6e-6, 1.1e-6, 2.0e-7, 0.0,  1.1e-6, 1.7e-6, -1.0e-7, 0.0,  2.0e-7, -1.0e-7, 6.1e-5, "
    "0.0,  "
    "0.0, 0.0, 0.0, 3.7e-7]\n"
    "steering: {front: {offset: -0.0041}}\n"
    "not_observed: []\n"
    "checksum: 0426c3d0\n";

std::string documented() { return kDocumented; }

void expectIdentical(const CalibrationResult& a, const CalibrationResult& b) {
  EXPECT_EQ(a.listed, b.listed);
  EXPECT_EQ(a.not_observed, b.not_observed);
  EXPECT_EQ(std::memcmp(a.values.data(), b.values.data(), sizeof a.values), 0) << a.values - b.values;
  EXPECT_EQ(std::memcmp(a.covariance.data(), b.covariance.data(), sizeof a.covariance), 0);
  EXPECT_EQ(a.data.from, b.data.from);
  EXPECT_EQ(a.data.to, b.data.to);
  EXPECT_EQ(a.data.distance, b.data.distance);
  EXPECT_EQ(a.data.laser_poses, b.data.laser_poses);
  EXPECT_EQ(a.data.rejected, b.data.rejected);
}

/// One change to the lines of a whole file, and the word by which the refusal shows what is wrong.
struct Change {
  const char* name;
  const char* from;
  const char* to;
  const char* says;

  friend std::ostream& operator<<(std::ostream& stream, const Change& change) {
    return stream << change.name;
  }
};

/// With a checksum that is right, so that it is the content that is judged.
std::string changed(const Change& change) {
  std::string lines = withoutChecksum(documented());
  const std::size_t at = lines.find(change.from);
  if (at == std::string::npos) return "not there: " + std::string(change.from);
  return withChecksum(lines.replace(at, std::strlen(change.from), change.to));
}

class ChangedFile : public ::testing::TestWithParam<Change> {};

TEST(CalibrationFile, is_read_as_documented) {
  const CalibrationResult result = fromText(documented(), cycab());
  EXPECT_EQ(result.values[systematic::kRearRight], 1.0021);
  EXPECT_EQ(result.values[systematic::kRearLeft], 0.9987);
  EXPECT_EQ(result.values[systematic::kRearTrack], 1.0153);
  EXPECT_EQ(result.values[systematic::kFrontOffset], -0.0041);
  EXPECT_EQ(result.covariance(systematic::kRearRight, systematic::kRearLeft), 1.1e-6);
  EXPECT_EQ(result.covariance(systematic::kFrontOffset, systematic::kFrontOffset), 3.7e-7);
  EXPECT_EQ(result.data.bags, std::vector<std::string>{"morning.bag"});
  EXPECT_EQ(result.data.laser_poses, 6540u);
}

TEST(CalibrationFile, reads_back_bit_by_bit) {
  const CalibrationResult written = result();
  const CalibrationResult read = fromText(toText(written, cycab()), cycab());
  expectIdentical(read, written);
  EXPECT_EQ(read.data.bags, written.data.bags);
}

TEST(CalibrationFile, lists_only_what_was_observed) {
  const std::string text = toText(result(), cycab());
  EXPECT_THAT(text, HasSubstr("\ngains:\n  rear: {k_r: 1.0033333333333334, k_l: "));
  EXPECT_THAT(text, HasSubstr("parameters: [front/steering_offset, rear/k_r, rear/k_l, rear/k_b, "
                              "front/steering_scale, laser/x]\n"));
  EXPECT_THAT(text, HasSubstr("not_observed: [laser/y]\n"));
  EXPECT_THAT(text, HasSubstr("method: joint, axles: rear}\n"));
  EXPECT_THAT(text, Not(HasSubstr("front: {k_")));
}

TEST(CalibrationFile, holds_no_value_that_could_not_be_read) {
  CalibrationResult broken = result();
  broken.values[systematic::kRearRight] = std::nan("");
  EXPECT_THAT(errorOf([&] { toText(broken, cycab()); }), HasSubstr("finite"));
  EXPECT_THAT(errorOf([&] { toText(CalibrationResult(), cycab()); }), HasSubstr("no parameter"));
}

TEST(CalibrationFile, names_as_many_bags_as_have_room) {
  CalibrationResult many = result();
  many.data.bags.assign(10000, std::string(200, 'b') + ".bag");
  const CalibrationResult read = fromText(toText(many, cycab()), cycab());
  EXPECT_THAT(read.data.bags.back(), HasSubstr(" more"));
}

/// A car of every kind of name recognises itself.
TEST(CalibrationFile, knows_its_car_by_any_name) {
  for (const char* name :
       {"", "null", "yes", "12", "a b", "it's \"mine\"", "!x", "\xc3\xa9", "a: {b", "\n\t\x7f"}) {
    Parameters car = cycab();
    car.vehicle.name = name;
    EXPECT_THAT(refusal(toText(result(), car), car), IsEmpty()) << name;
    EXPECT_THAT(refusal(toText(result(), car)), HasSubstr("another car")) << name;
    EXPECT_NE(vehicleChecksum(car), vehicleChecksum(cycab())) << name;
  }
}

TEST(CalibrationFile, C12_another_car_is_refused) {
  const std::string text = toText(result(), cycab());
  const std::vector<std::pair<std::string, std::function<void(Parameters&)>>> changes{
      {"name", [](Parameters& p) { p.vehicle.name = "cycab2"; }},
      {"wheelbase", [](Parameters& p) { p.vehicle.wheelbase = std::nextafter(1.2, 2.0); }},
      {"track/front", [](Parameters& p) { p.vehicle.track.front = 1.3; }},
      {"track/rear", [](Parameters& p) { p.vehicle.track.rear = 1.3; }},
      {"hub_offset/front", [](Parameters& p) { p.vehicle.hub_offset.front = 0.1; }},
      {"hub_offset/rear", [](Parameters& p) { p.vehicle.hub_offset.rear = 0.1; }},
      {"base_link_x", [](Parameters& p) { p.vehicle.base_link_x = 0.1; }},
      {"axle_geometry", [](Parameters& p) { p.vehicle.axle_geometry = AxleGeometry::kPivot; }},
      {"rear_steering/source",
       [](Parameters& p) { p.vehicle.rear_steering.source = RearSteering::Source::kMeasured; }},
      {"rear_steering/coefficients",
       [](Parameters& p) {
         p.vehicle.rear_steering.coefficients = {0.0, -0.9};
       }},
      {"metres_per_tick/rear_left",
       [](Parameters& p) { p.vehicle.metres_per_tick[Wheel::kRearLeft] *= -1.0; }}};
  for (const auto& [says, change] : changes) {
    Parameters car = cycab();
    change(car);
    EXPECT_THAT(refusal(text, car), HasSubstr("another car: its " + says + " ")) << says;
    EXPECT_NE(vehicleChecksum(car), vehicleChecksum(cycab())) << says;
  }
}

TEST(CalibrationFile, belongs_to_the_car_and_not_to_its_settings) {
  Parameters car = cycab();
  car.noise.wheel = 0.02;
  car.odometry.axles = AxleSelection::kBoth;
  car.vehicle.gains.rear.k_r = 1.01;
  EXPECT_THAT(refusal(toText(result(), cycab()), car), IsEmpty());
  EXPECT_EQ(vehicleChecksum(car), vehicleChecksum(cycab()));
}

TEST(CalibrationFile, C12_cut_at_every_byte_it_is_refused) {
  const std::string text = toText(result(), cycab());
  ASSERT_THAT(refusal(text), IsEmpty());
  for (std::size_t size = 0; size < text.size(); ++size)
    ASSERT_THAT(refusal(text.substr(0, size)), HasSubstr("; calibrate again")) << "cut at " << size;
  recordFigure("refused at each of %zu cuts", text.size());
}

TEST(CalibrationFile, C12_with_any_byte_flipped_it_is_refused) {
  const std::string text = toText(result(), cycab());
  ASSERT_THAT(refusal(text), IsEmpty());
  for (std::size_t at = 0; at < text.size(); ++at)
    for (const int flip : {0x01, 0x20, 0x80, 0xff}) {
      std::string other = text;
      other[at] = static_cast<char>(other[at] ^ flip);
      ASSERT_THAT(refusal(other), HasSubstr("; calibrate again")) << "byte " << at << " xor " << flip;
    }
  recordFigure("refused after each of %zu changed bytes", 4 * text.size());
}

TEST_P(ChangedFile, C12_is_refused_for_what_it_says) {
  const std::string why = refusal(changed(GetParam()));
  EXPECT_THAT(why, HasSubstr(GetParam().says));
  EXPECT_THAT(why, ::testing::AnyOf(HasSubstr("; calibrate"), HasSubstr("; drive"))) << "no remedy";
  EXPECT_THAT(why, Not(HasSubstr("\n"))) << "more than one line";
}

const Change kChanges[] = {
    {"format", "format: 1", "format: 2", "its format is '2'"},
    {"no_format", "format: 1\n", "", "format is missing"},
    {"no_vehicle", "vehicle: ", "vehicles: ", "vehicle is missing"},
    {"no_name", "name: cycab, ", "", "vehicle/name is missing"},
    {"more_of_the_car", "name: cycab, ", "name: cycab, colour: red, ", "vehicle/colour is unknown"},
    {"no_data", "data: {", "dates: {", "data is missing"},
    {"count", "6540", "-1", "data/laser_poses is no count"},
    {"unknown_parameter", "[rear/k_r,", "[rear/k_x,", "'rear/k_x', which no calibration finds"},
    {"twice", "rear/k_l, rear/k_b", "rear/k_r, rear/k_b", "'rear/k_r' twice"},
    {"key_twice", "k_l: 0.9987", "k_r: 0.9987", "gains/rear/k_r is given twice"},
    {"no_value", "k_l: 0.9987, ", "", "rear/k_l is listed without a value"},
    {"no_listing", "not_observed", "laser: {x: 0.5}\nnot_observed", "laser/x has a value, but is not listed"},
    {"gain_too_large", "1.0021", "2.01", "rear/k_r is not within 0.5 to 2"},
    {"gain_too_small", "0.9987", "0.49", "rear/k_l is not within 0.5 to 2"},
    {"gain_nan", "1.0021", "nan", "gains/rear/k_r is not a finite number"},
    {"gain_infinite", "1.0021", "1e999", "gains/rear/k_r is not a finite number"},
    {"gain_text", "1.0021", "1.0x", "gains/rear/k_r is not a finite number"},
    {"offset", "-0.0041", "4.1", "front/steering_offset is not within"},
    {"one_number_less", "3.7e-7]", "]", "gains/covariance"},
    {"one_number_more", "3.7e-7]", "3.7e-7, 0.0]", "17 numbers for 4 parameters"},
    {"negative_variance", "3.7e-7]", "-3.7e-7]", "not symmetric and positive semidefinite"},
    {"not_symmetric", "1.7e-6, -1.0e-7", "1.7e-6, -1.1e-7", "not symmetric and positive semidefinite"},
    {"correlation_above_one", "[1.6e-6", "[0.7e-6", "not symmetric and positive semidefinite"},
    {"nothing_observed", "[rear/k_r, rear/k_l, rear/k_b, front/steering_offset]", "[]", "no parameter"},
    {"observed_and_not", "not_observed: []", "not_observed: [rear/k_b]", "both observed and not"},
    {"a_list", "gains:\n", "gains: []\nmore:\n", "gains is not a map"},
    {"tag", "name: cycab", "name: !!str cycab", "no YAML as calibrations have it"},
    {"anchor", "name: cycab", "name: &a cycab", "no YAML as calibrations have it"},
    {"brackets", "not_observed: []", "not_observed: [", "it is no YAML"},
};

INSTANTIATE_TEST_SUITE_P(Table, ChangedFile, ::testing::ValuesIn(kChanges),
                         [](const auto& row) { return std::string(row.param.name); });

/// Both ends of every parameter's range are within it, and what lies beyond them is not.
TEST(CalibrationFile, C12_every_parameter_has_its_range) {
  constexpr double kPi = 3.14159265358979;
  const auto expectRange = [](std::size_t parameter, double low, double high) {
    SCOPED_TRACE(parameterName(parameter));
    for (const double value : {low, high, 0.25 * low + 0.75 * high})
      EXPECT_THAT(faultOf(parameter, value), IsEmpty()) << value;
    const double width = high - low;
    for (const double value : {low - 0.01 * width, high + 0.01 * width})
      EXPECT_THAT(faultOf(parameter, value), HasSubstr("is not within")) << value;
    EXPECT_EQ(faultOf(parameter, std::nan("")), "is not finite");
    EXPECT_EQ(faultOf(parameter, -HUGE_VAL), "is not finite");
  };
  for (std::size_t i = 0; i < systematic::kCount; ++i) {
    if (isGain(i)) {
      expectRange(i, 0.5, 2.0);
    } else {
      expectRange(i, -kPi, kPi);  // an offset of the steering
    }
  }
  for (const std::size_t scale : {kFrontScale, kRearScale}) {
    expectRange(scale, -1000.0, 1000.0);
    EXPECT_THAT(faultOf(scale, 0.0), HasSubstr("and not 0"));
  }
  expectRange(kLaserX, -100.0, 100.0);
  expectRange(kLaserY, -100.0, 100.0);
  expectRange(kLaserYaw, -2.0 * kPi, 2.0 * kPi);
  expectRange(kTimeOffset, -10.0, 10.0);
}

TEST(CalibrationFile, C12_a_covariance_is_told_from_other_matrices) {
  const ParameterMatrix sound = 1e-6 * ParameterMatrix::Identity();
  EXPECT_TRUE(isCovariance(sound));
  EXPECT_TRUE(isCovariance(ParameterMatrix::Zero()));
  const auto with = [&](Eigen::Index i, Eigen::Index j, double value) {
    ParameterMatrix matrix = sound;
    matrix(i, j) = value;
    return matrix;
  };
  for (const double value : {-1e-9, 1.1e4, std::nan(""), HUGE_VAL})
    EXPECT_FALSE(isCovariance(with(2, 2, value))) << value;
  EXPECT_FALSE(isCovariance(with(0, 1, 1e-8))) << "not symmetric";
  EXPECT_FALSE(isCovariance(with(0, 1, 1.1e-6) + with(1, 0, 1.1e-6) - sound)) << "a correlation of 1.1";
  EXPECT_TRUE(isCovariance(with(0, 1, 9e-7) + with(1, 0, 9e-7) - sound)) << "one of 0.9";
}

/// Where every correlation by itself is possible, but not all of them together.
TEST(CalibrationFile, C12_correlations_must_go_together) {
  CalibrationResult impossible = result();
  impossible.covariance.setZero();
  for (std::size_t i = 0; i < kCount; ++i)
    for (std::size_t j = 0; j < kCount; ++j)
      if (impossible.listed[i] && impossible.listed[j])
        impossible.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
            i == j ? 1e-6 : -9e-7;
  EXPECT_THAT(errorOf([&] { toText(impossible, cycab()); }), HasSubstr("positive semidefinite"));
}

/// Whatever else is thrown than a CalibrationFileError ends the test, as does a stack that overflows.
TEST(CalibrationFile, C12_survives_any_bytes) {
  constexpr unsigned kSeed = 12;
  std::cout << "seed " << kSeed << "\n";
  std::mt19937 random(kSeed);
  const std::string lines = withoutChecksum(toText(result(), cycab()));
  const std::string pieces = "[]{},:- \n\"'#?&*!|>%@`0123e.\\xk\t";
  const auto below = [&random](std::size_t limit) {
    return std::uniform_int_distribution<std::size_t>(0, limit - 1)(random);
  };
  for (int i = 0; i < 20000; ++i) {
    std::string text = i % 2 == 0 ? lines : lines.substr(0, below(lines.size()));
    for (std::size_t changes = 1 + below(20); changes > 0; --changes) {
      const std::size_t at = below(text.size() + 1);
      if (below(3) == 0) text.erase(at, below(20));
      text.insert(std::min(at, text.size()), below(9) == 0 ? below(2000) : 1, pieces[below(pieces.size())]);
    }
    refusal(withChecksum(text.substr(0, 60000)));
  }
  for (const char* piece : {"[", "{", "- ", "? ", "[?", "{a: ", "-\n", "\"", "!2", "&a [*a, "}) {
    std::string text;
    while (text.size() < 65000) text += piece;
    EXPECT_THAT(refusal(withChecksum(text)), Not(IsEmpty())) << piece;
    EXPECT_THAT(refusal(withChecksum(lines.substr(0, 200) + text.substr(0, 60000))), Not(IsEmpty())) << piece;
  }
  for (int i = 0; i < 2000; ++i) {
    std::string text(below(300), '\0');
    for (char& c : text) c = static_cast<char>(below(256));
    EXPECT_THAT(refusal(text), Not(IsEmpty()));
    EXPECT_THAT(refusal(withChecksum(text)), Not(IsEmpty()));
  }
}

TEST(CalibrationFile, X2_only_a_small_regular_file_is_read) {
  const TemporaryFolder folder;
  const std::string text = toText(result(), cycab());
  const std::string good = folder.write("good.yaml", text);
  EXPECT_NO_THROW(readCalibrationFile(good, cycab()));
  const auto error = [](const std::string& path) {
    return errorOf([&] { readCalibrationFile(path, cycab()); });
  };
  ASSERT_EQ(::symlink(good.c_str(), folder.file("link.yaml").c_str()), 0);
  EXPECT_THAT(error(folder.file("link.yaml")), HasSubstr("it is a symbolic link; name the file itself"));
  ASSERT_EQ(::mkfifo(folder.file("pipe.yaml").c_str(), 0600), 0);
  EXPECT_THAT(error(folder.file("pipe.yaml")), HasSubstr("not a regular file"));
  EXPECT_THAT(error(folder.file("")), HasSubstr("not a regular file"));
  EXPECT_THAT(error(folder.file("none.yaml")), HasSubstr("No such file"));
  EXPECT_THAT(error("/dev/zero"), HasSubstr("not a regular file"));
  EXPECT_THAT(error(folder.write("large.yaml", std::string(65537, ' '))), HasSubstr("larger than 64 kB"));
  EXPECT_THAT(error(folder.write("empty.yaml", "")), HasSubstr("no checksum"));
  EXPECT_THAT(error(folder.write("cut.yaml", text.substr(0, 500))),
              StartsWith(folder.file("cut.yaml") + " is not used: "));
}

TEST(ApplyCalibration, puts_values_and_covariance_in_their_place) {
  Parameters parameters = cycab();
  parameters.vehicle.gains.rear.k_r = 1.5;  // replaced, not multiplied
  parameters.vehicle.gains.front.k_l = 1.1;
  parameters.vehicle.steering.front.scale = 2.0;
  const CalibrationResult calibration = result();
  applyCalibration(calibration, parameters);
  EXPECT_EQ(parameters.vehicle.gains.rear.k_r, calibration.values[systematic::kRearRight]);
  EXPECT_EQ(parameters.vehicle.gains.rear.k_b, calibration.values[systematic::kRearTrack]);
  EXPECT_EQ(parameters.vehicle.gains.front.k_l, 1.1);
  EXPECT_EQ(parameters.vehicle.steering.front.offset, calibration.values[systematic::kFrontOffset]);
  EXPECT_EQ(parameters.vehicle.steering.front.scale, calibration.values[kFrontScale]);
  EXPECT_EQ(parameters.laser.x, calibration.values[kLaserX]);
  EXPECT_EQ(parameters.laser.y, 0.0);

  const SystematicCovariance nominal = systematicCovariance(parameters.noise.systematic);
  ASSERT_TRUE(parameters.systematic_covariance);
  for (std::size_t i = 0; i < systematic::kCount; ++i)
    for (std::size_t j = 0; j < systematic::kCount; ++j) {
      const auto row = static_cast<Eigen::Index>(i);
      const auto column = static_cast<Eigen::Index>(j);
      const bool neither = !calibration.listed[i] && !calibration.listed[j];
      const bool both = calibration.listed[i] && calibration.listed[j];
      const double expected =
          both ? calibration.covariance(row, column) : (neither ? nominal(row, column) : 0.0);
      EXPECT_EQ((*parameters.systematic_covariance)(row, column), expected) << i << ", " << j;
    }
}

}  // namespace
}  // namespace bs_car_odometry::calibration::testing
