#include "csv_table.hpp"

#include "tool.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>

namespace bs_car_odometry::tools {
namespace {

std::string trimmed(const std::string& text) {
  const char* const kSpaces = " \t\r";
  const std::size_t begin = text.find_first_not_of(kSpaces);
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(kSpaces) - begin + 1);
}

std::vector<std::string> fieldsOf(const std::string& line) {
  std::vector<std::string> fields;
  std::size_t begin = 0;
  for (std::size_t comma = line.find(','); comma != std::string::npos; comma = line.find(',', begin)) {
    fields.push_back(trimmed(line.substr(begin, comma - begin)));
    begin = comma + 1;
  }
  fields.push_back(trimmed(line.substr(begin)));
  return fields;
}

/// @return false when the text is not wholly a number
bool parseNumber(const std::string& text, double& value) {
  char* end = nullptr;
  value = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == '\0';
}

/// Some programs begin a text file with this mark.
void removeByteOrderMark(std::string& line) {
  if (line.compare(0, 3, "\xEF\xBB\xBF") == 0) line.erase(0, 3);
}

}  // namespace

CsvTable::CsvTable(const std::string& path, const std::vector<std::string>& known) : path_(path) {
  std::ifstream file(path);
  if (!file) throw InputError(path + ": cannot be opened");
  std::size_t number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    if (number == 1) removeByteOrderMark(line);
    line = trimmed(line);
    if (line.empty() || line.front() == '#') continue;
    if (header_.empty()) {
      readHeader(line, number, known);
    } else {
      readRow(line, number);
    }
  }
  if (file.bad()) throw InputError(path + ": cannot be read");
  checkRows();
}

void CsvTable::readHeader(const std::string& line, std::size_t number,
                          const std::vector<std::string>& known) {
  const std::string place = path_ + ":" + std::to_string(number) + ": ";
  header_ = fieldsOf(line);
  double value = 0.0;
  if (std::all_of(header_.begin(), header_.end(), [&](const auto& name) { return parseNumber(name, value); }))
    throw InputError(place + "the header line with the columns' names is missing; known: t, " +
                     listed(known));
  for (const std::string& name : header_) addColumn(name, place, known);
  if (!has("t")) throw InputError(place + "the column 't' is missing");
}

void CsvTable::addColumn(const std::string& name, const std::string& place,
                         const std::vector<std::string>& known) {
  if (name != "t" && std::find(known.begin(), known.end(), name) == known.end())
    throw InputError(place + "unknown column '" + name + "'; known, separated by commas: t, " +
                     listed(known));
  if (!columns_.emplace(name, std::vector<double>()).second)
    throw InputError(place + "the column '" + name + "' is there twice");
}

void CsvTable::readRow(const std::string& line, std::size_t number) {
  const std::string place = path_ + ":" + std::to_string(number) + ": ";
  const std::vector<std::string> fields = fieldsOf(line);
  if (fields.size() != header_.size())
    throw InputError(place + "the row has " + std::to_string(fields.size()) + " columns, the header " +
                     std::to_string(header_.size()));
  for (std::size_t i = 0; i < fields.size(); ++i) {
    double value = 0.0;
    if (!parseNumber(fields[i], value))
      throw InputError(place + "'" + fields[i] + "' in the column '" + header_[i] + "' is not a number");
    if (!std::isfinite(value))
      throw InputError(place + "'" + fields[i] + "' in the column '" + header_[i] + "' is not finite");
    columns_[header_[i]].push_back(value);
  }
  lines_.push_back(number);
  const std::vector<double>& times = columns_["t"];
  if (rows() > 1 && times[rows() - 1] < times[rows() - 2])
    throw InputError(place + "the time goes back, from " + std::to_string(times[rows() - 2]) + " to " +
                     std::to_string(times[rows() - 1]));
}

void CsvTable::checkRows() const {
  if (header_.empty()) throw InputError(path_ + ": the file is empty");
  if (rows() == 0) throw InputError(path_ + ": there is no row below the header");
}

std::string CsvTable::place(std::size_t row) const { return path_ + ":" + std::to_string(lines_[row]); }

}  // namespace bs_car_odometry::tools
