// CSV files, good ones and malformed ones, each with its message.

#include "../../src/tools/csv_table.hpp"

#include "../../src/tools/tool.hpp"
#include "temporary_folder.hpp"

#include <gmock/gmock.h>

namespace bs_car_odometry::tools::testing {
namespace {

using ::testing::ElementsAre;

class CsvTableTest : public ::testing::Test {
 protected:
  CsvTable read(const std::string& text) const { return {folder_.write("a.csv", text), {"fl", "fr"}}; }

  /// The message, from the file's name on.
  std::string errorIn(const std::string& text) const {
    const std::string message = errorOf([&] { read(text); });
    return message.substr(std::min(message.find("a.csv"), message.size()));
  }

  TemporaryFolder folder_;
};

TEST_F(CsvTableTest, columnsMayBeInAnyOrderAndPartlyMissing) {
  const CsvTable table = read("fr,t\n3,0\n-4.5e0,0.5\n");
  EXPECT_EQ(table.rows(), 2u);
  EXPECT_THAT(table["t"], ElementsAre(0.0, 0.5));
  EXPECT_THAT(table["fr"], ElementsAre(3.0, -4.5));
  EXPECT_FALSE(table.has("fl"));
}

TEST_F(CsvTableTest, spacesBlankLinesCommentsAndForeignLineEndsAreTakenInStride) {
  const CsvTable table = read("\xEF\xBB\xBFt, fl\r\n# standing\r\n 0 ,\t1\r\n\r\n1,2");
  EXPECT_THAT(table["t"], ElementsAre(0.0, 1.0));
  EXPECT_THAT(table["fl"], ElementsAre(1.0, 2.0));
  EXPECT_THAT(table.place(1), ::testing::EndsWith("a.csv:5"));
}

TEST_F(CsvTableTest, anEqualTimeIsNoStepBack) { EXPECT_EQ(read("t,fl\n1,0\n1,1\n").rows(), 2u); }

TEST_F(CsvTableTest, malformedOnesAreNamedWithFileAndLine) {
  EXPECT_EQ(errorIn(""), "a.csv: the file is empty");
  EXPECT_EQ(errorIn("\n# only a comment\n"), "a.csv: the file is empty");
  EXPECT_EQ(errorIn("t,fl\n"), "a.csv: there is no row below the header");
  EXPECT_EQ(errorIn("0,1\n1,2\n"),
            "a.csv:1: the header line with the columns' names is missing; known: t, fl, fr");
  EXPECT_EQ(errorIn("t,f\n0,1\n"), "a.csv:1: unknown column 'f'; known, separated by commas: t, fl, fr");
  EXPECT_EQ(errorIn("t;fl\n0;1\n"), "a.csv:1: unknown column 't;fl'; known, separated by commas: t, fl, fr");
  EXPECT_EQ(errorIn("t,fl,fl\n0,1,2\n"), "a.csv:1: the column 'fl' is there twice");
  EXPECT_EQ(errorIn("fl,fr\n0,1\n"), "a.csv:1: the column 't' is missing");
  EXPECT_EQ(errorIn("t,fl\n0,1\n1\n"), "a.csv:3: the row has 1 columns, the header 2");
  EXPECT_EQ(errorIn("t,fl\n0,1,2\n"), "a.csv:2: the row has 3 columns, the header 2");
  EXPECT_EQ(errorIn("t,fl\n0,fast\n"), "a.csv:2: 'fast' in the column 'fl' is not a number");
  EXPECT_EQ(errorIn("t,fl\n0,1 m\n"), "a.csv:2: '1 m' in the column 'fl' is not a number");
  EXPECT_EQ(errorIn("t,fl\n0,\n"), "a.csv:2: '' in the column 'fl' is not a number");
  EXPECT_EQ(errorIn("t,fl\n0,nan\n"), "a.csv:2: 'nan' in the column 'fl' is not finite");
  EXPECT_EQ(errorIn("t,fl\n0,-inf\n"), "a.csv:2: '-inf' in the column 'fl' is not finite");
  EXPECT_EQ(errorIn("t,fl\n0,1\n2,1\n1.5,1\n"), "a.csv:4: the time goes back, from 2.000000 to 1.500000");
}

TEST_F(CsvTableTest, aFileThatIsMissingOrAFolderIsNamed) {
  EXPECT_EQ(errorOf([] { CsvTable("/nowhere/a.csv", {}); }), "/nowhere/a.csv: cannot be opened");
  EXPECT_NE(errorOf([] { CsvTable("/tmp", {}); }), "");
}

}  // namespace
}  // namespace bs_car_odometry::tools::testing
