#include "bag_structure.hpp"

#include "bs_car_odometry/ros/raw_message.hpp"

#include <rosbag/constants.h>
#include <rosbag/exceptions.h>

#include <boost/interprocess/exceptions.hpp>
#include <boost/interprocess/file_mapping.hpp>
#include <boost/interprocess/mapped_region.hpp>

#include <cstdint>
#include <cstring>
#include <set>
#include <string_view>
#include <vector>

namespace bs_car_odometry::tools {

namespace {

constexpr std::string_view kFirstLine = "#ROSBAG V2.0\n";

/// [bytes] A chunk has 0.8 MB, or one message when that is larger; roscpp sends none beyond this.
constexpr std::uint32_t kLargestChunk = 1000000000;

void require(bool holds, const char* what) {
  if (!holds) throw rosbag::BagFormatException(what);
}

/// Fields "name=value", each behind its length: the header of a record, or the data of a connection.
class Fields {
 public:
  explicit Fields(ByteReader& reader) : fields_(reader.block()) {
    require(reader.sound(), "a record goes beyond the end");
    ByteReader fields(fields_);
    while (fields.left() > 0) {
      const bool is_field = fields.block().find(rosbag::FIELD_DELIM) != std::string_view::npos;
      require(is_field && fields.sound(), "a field of a record is damaged");
    }
  }

  template <typename Number>
  Number number(const std::string& name) const {
    const std::string_view value = text(name);
    require(value.size() == sizeof(Number), "a field of a record is absent or of another size");
    Number number{};
    std::memcpy(&number, value.data(), sizeof(Number));
    return number;
  }

  /// Empty where the field is absent; of several, rosbag takes the last.
  std::string_view text(const std::string& name) const {
    std::string_view value;
    ByteReader fields(fields_);
    while (fields.left() > 0) {
      const std::string_view field = fields.block();
      const std::size_t delimiter = field.find(rosbag::FIELD_DELIM);
      if (field.substr(0, delimiter) == name) value = field.substr(delimiter + 1);
    }
    return value;
  }

 private:
  std::string_view fields_;
};

Fields headerOf(unsigned char op, ByteReader& reader) {
  const Fields header(reader);
  require(header.number<unsigned char>(rosbag::OP_FIELD_NAME) == op,
          "a record is of another kind than expected");
  return header;
}

/// Follows a bag's index as rosbag does.
class StructureCheck {
 public:
  explicit StructureCheck(std::string_view bytes) : bytes_(bytes) {}

  void run() {
    ByteReader reader = at(checkFileHeader());
    for (std::uint32_t i = 0; i < connection_count_; ++i) checkConnection(reader);
    for (std::uint32_t i = 0; i < chunk_count_; ++i) checkChunkInfo(reader);
    for (const Chunk& chunk : chunks_) checkChunk(chunk);
  }

 private:
  struct Chunk {
    std::uint64_t position;
    std::size_t connections;
  };

  ByteReader at(std::uint64_t position) const {
    require(position <= bytes_.size(), "its index points beyond the end");
    return ByteReader(bytes_.substr(position));
  }

  std::uint64_t positionOf(const ByteReader& reader) const { return bytes_.size() - reader.left(); }

  /// @return where the index begins
  std::uint64_t checkFileHeader() {
    require(bytes_.substr(0, kFirstLine.size()) == kFirstLine,
            "it is no bag of version 2.0; 'rosbag filter OLD NEW True' makes one of an older version");
    ByteReader reader = at(kFirstLine.size());
    const Fields header = headerOf(rosbag::OP_FILE_HEADER, reader);
    const auto index = header.number<std::uint64_t>(rosbag::INDEX_POS_FIELD_NAME);
    if (index == 0) throw rosbag::BagUnindexedException();
    const std::string_view encryptor = header.text(rosbag::ENCRYPTOR_FIELD_NAME);
    require(encryptor.empty() || encryptor == "rosbag/NoEncryptor",
            "it is encrypted; 'rosbag decrypt' makes one that can be read");
    connection_count_ = header.number<std::uint32_t>(rosbag::CONNECTION_COUNT_FIELD_NAME);
    chunk_count_ = header.number<std::uint32_t>(rosbag::CHUNK_COUNT_FIELD_NAME);
    reader.block();
    require(reader.sound(), "its first record goes beyond the end");
    end_of_chunk_ = positionOf(reader);
    return index;
  }

  void checkConnection(ByteReader& reader) {
    const Fields header = headerOf(rosbag::OP_CONNECTION, reader);
    connections_.insert(header.number<std::uint32_t>(rosbag::CONNECTION_FIELD_NAME));
    const Fields of_publisher(reader);
  }

  void checkChunkInfo(ByteReader& reader) {
    const Fields header = headerOf(rosbag::OP_CHUNK_INFO, reader);
    const auto count = header.number<std::uint32_t>(rosbag::COUNT_FIELD_NAME);
    reader.value<std::uint32_t>();  // the size of the entries
    std::set<std::uint32_t> connections;
    for (std::uint32_t i = 0; i < count && reader.sound(); ++i) {
      connections.insert(reader.value<std::uint32_t>());
      reader.value<std::uint32_t>();  // the number of its messages
    }
    require(reader.sound(), "the index is cut off");
    chunks_.push_back({header.number<std::uint64_t>(rosbag::CHUNK_POS_FIELD_NAME), connections.size()});
  }

  void checkChunk(const Chunk& chunk) {
    // Chunks in each other would let a small file hold any number of messages.
    require(chunk.position >= end_of_chunk_, "its chunks are in each other");
    ByteReader reader = at(chunk.position);
    const Fields header = headerOf(rosbag::OP_CHUNK, reader);
    const std::string_view data = reader.block();
    require(reader.sound(), "a chunk goes beyond the end");
    const auto size = header.number<std::uint32_t>(rosbag::SIZE_FIELD_NAME);
    require(size <= kLargestChunk, "a chunk is larger than a message can be");
    const bool is_plain = header.text(rosbag::COMPRESSION_FIELD_NAME) == rosbag::COMPRESSION_NONE;
    require(!is_plain || size == data.size(), "a chunk has two sizes");
    for (std::size_t i = 0; i < chunk.connections; ++i)
      checkIndex(reader, size, is_plain ? data : std::string_view());
    end_of_chunk_ = positionOf(reader);
  }

  /// @param data  of the chunk; empty when it is compressed
  void checkIndex(ByteReader& reader, std::uint32_t size, std::string_view data) const {
    const Fields header = headerOf(rosbag::OP_INDEX_DATA, reader);
    const auto connection = header.number<std::uint32_t>(rosbag::CONNECTION_FIELD_NAME);
    require(connections_.count(connection) > 0, "a connection is missing");
    const auto count = header.number<std::uint32_t>(rosbag::COUNT_FIELD_NAME);
    reader.value<std::uint32_t>();  // the size of the entries
    for (std::uint32_t i = 0; i < count && reader.sound(); ++i) {
      reader.skip(2 * sizeof(std::uint32_t));  // time
      const auto offset = reader.value<std::uint32_t>();
      require(offset < size, "a message lies beyond its chunk");
      if (!data.empty()) checkMessage(ByteReader(data.substr(offset)));
    }
    require(reader.sound(), "the index of a chunk is cut off");
  }

  static void checkMessage(ByteReader reader) {
    headerOf(rosbag::OP_MSG_DATA, reader);
    reader.block();
    require(reader.sound(), "a message goes beyond its chunk");
  }

  std::string_view bytes_;
  std::uint32_t connection_count_{0};
  std::uint32_t chunk_count_{0};
  std::set<std::uint32_t> connections_;
  std::vector<Chunk> chunks_;
  std::uint64_t end_of_chunk_{0};  ///< or of the file header
};

}  // namespace

void checkBagStructure(const std::string& path) {
  namespace ipc = boost::interprocess;
  ipc::mapped_region region;
  try {
    const ipc::file_mapping file(path.c_str(), ipc::read_only);
    ipc::mapped_region(file, ipc::read_only).swap(region);
  } catch (const ipc::interprocess_exception&) {
    return;
  }
  StructureCheck({static_cast<const char*>(region.get_address()), region.get_size()}).run();
}

}  // namespace bs_car_odometry::tools
