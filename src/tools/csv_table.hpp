#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace bs_car_odometry::tools {

/// A recording kept as CSV: a header line with the columns' names, then rows of finite numbers. `t` [s] is
/// one of the columns and never goes back.
class CsvTable {
 public:
  /// Reads a file whose columns are `t` and any of `known`, in any order. Blank lines and those that begin
  /// with
  /// '#' are passed over.
  /// @throws InputError, a sentence with file and line
  CsvTable(const std::string& path, const std::vector<std::string>& known);

  const std::string& path() const { return path_; }
  std::size_t rows() const { return lines_.size(); }
  bool has(const std::string& column) const { return columns_.count(column) > 0; }

  /// The values of a column that the table has.
  const std::vector<double>& operator[](const std::string& column) const { return columns_.at(column); }

  /// "file:line" of a row, for messages.
  std::string place(std::size_t row) const;

 private:
  void readHeader(const std::string& line, std::size_t number, const std::vector<std::string>& known);
  void addColumn(const std::string& name, const std::string& place, const std::vector<std::string>& known);
  void readRow(const std::string& line, std::size_t number);
  void checkRows() const;

  std::string path_;
  std::vector<std::string> header_;
  std::map<std::string, std::vector<double>> columns_;
  std::vector<std::size_t> lines_;  ///< of each row, counted from 1
};

}  // namespace bs_car_odometry::tools
