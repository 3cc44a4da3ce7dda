// The container of a prepared cell: named arrays, one after the other, behind a checksum.
//
// In: the bytes of a file (plannercheck/common/section_files.py writes them). Out: its sections, which are asked for in
// their order, by name and shape; whatever else the file holds is an error. A file has a header of kHeaderBytes, an
// entry of kEntryBytes for each section, and the sections, each at the next multiple of kAlignment. All numbers are
// little-endian. Nothing is trusted: sizes are compared with the file's before anything is allocated or read.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace plannercheck {

// Says what is wrong with a file, in words that can follow its name.
class CellError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Raise it with any change to the sections, their order or meaning: other files are then refused.
inline constexpr std::uint32_t kCellFormat = 6;

// What a file starts with: zeros fill the array.
inline constexpr std::array<char, 16> kMagic{"plannercheck\n"};

class CellFile {
 public:
  // Throws CellError if the bytes are no such file, or not the whole of one. They have to outlive this, at an address
  // that is a multiple of 8.
  explicit CellFile(std::span<const std::byte> bytes);

  // The next section, which has to have this name and so many columns; its rows one after the other.
  std::span<const double> doubles(const char* name, std::size_t columns = 1);
  std::span<const std::int32_t> integers(const char* name, std::size_t columns = 1);
  std::span<const std::uint8_t> bytes(const char* name, std::size_t columns = 1);
  // A section with any count of columns: numbers or bytes.
  struct Table {
    std::span<const double> numbers;
    std::span<const std::uint8_t> bytes;
    std::size_t rows, columns;
  };
  Table table(const char* name);
  Table byte_table(const char* name);
  // One number.
  double number(const char* name);
  std::int32_t integer(const char* name);
  std::string text(const char* name);
  // Texts that a zero ends each.
  std::vector<std::string> texts(const char* name);
  // The names of all sections, in their order.
  std::vector<std::string> names() const;
  // There is no more.
  void end() const;

 private:
  enum class Type : std::uint32_t { kBytes = 1, kIntegers = 2, kDoubles = 3 };
  struct Entry {
    std::string name;
    std::uint32_t type;
    std::size_t columns, rows, offset;
  };

  std::span<const std::byte> file_;
  std::vector<Entry> entries_;
  std::size_t next_ = 0;

  Entry take(const char* name, Type type);
  Entry take(const char* name, Type type, std::size_t columns);
  void read_entries(std::size_t count);
  template <class T>
  std::span<const T> numbers(const Entry& entry) const;
};

// Throws CellError with these words unless `sound`.
void require_sound(bool sound, const char* what);

}  // namespace plannercheck
