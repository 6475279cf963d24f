#include "bs_car_odometry/ros/parameter_server.hpp"

#include <ros/param.h>
#include <yaml-cpp/binary.h>

#include <cmath>
#include <ctime>
#include <limits>
#include <locale>
#include <sstream>
#include <string>
#include <vector>

namespace bs_car_odometry {
namespace {

using XmlRpc::XmlRpcValue;

/// The number with all its digits, as YAML writes it.
std::string doubleText(double value) {
  if (std::isnan(value)) return ".nan";
  if (std::isinf(value)) return value > 0.0 ? ".inf" : "-.inf";
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(std::numeric_limits<double>::max_digits10);
  text << value;
  return text.str();
}

YAML::Node binaryNode(const XmlRpcValue& value) {
  const auto& bytes = static_cast<const XmlRpcValue::BinaryData&>(value);
  return YAML::Node(YAML::Binary(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

YAML::Node dateNode(const XmlRpcValue& value) {
  const auto& date = static_cast<const struct tm&>(value);
  char text[32] = "";
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%S", &date);
  return YAML::Node(std::string(text));
}

YAML::Node sequenceNode(const XmlRpcValue& array) {
  YAML::Node sequence(YAML::NodeType::Sequence);
  for (int i = 0; i < array.size(); ++i) sequence.push_back(toYaml(array[i]));
  return sequence;
}

YAML::Node mapNode(const XmlRpcValue& structure) {
  YAML::Node map(YAML::NodeType::Map);
  for (const auto& [name, member] : structure) map[name] = toYaml(member);
  return map;
}

}  // namespace

YAML::Node toYaml(const XmlRpcValue& value) {
  switch (value.getType()) {
    case XmlRpcValue::TypeBoolean:
      return YAML::Node(static_cast<const bool&>(value) ? "true" : "false");
    case XmlRpcValue::TypeInt:
      return YAML::Node(std::to_string(static_cast<const int&>(value)));
    case XmlRpcValue::TypeDouble:
      return YAML::Node(doubleText(static_cast<const double&>(value)));
    case XmlRpcValue::TypeString:
      return YAML::Node(static_cast<const std::string&>(value));
    case XmlRpcValue::TypeDateTime:
      return dateNode(value);
    case XmlRpcValue::TypeBase64:
      return binaryNode(value);
    case XmlRpcValue::TypeArray:
      return sequenceNode(value);
    case XmlRpcValue::TypeStruct:
      return mapNode(value);
    case XmlRpcValue::TypeInvalid:
      break;
  }
  return YAML::Node();
}

YAML::Node parameterServerTree(const ros::NodeHandle& private_node) {
  XmlRpcValue value;
  if (!ros::param::get(private_node.getNamespace(), value)) return YAML::Node(YAML::NodeType::Map);
  return toYaml(value);
}

}  // namespace bs_car_odometry
