#include "library/cell_file.hpp"

#include <array>
#include <bit>
#include <cstring>

#include "bodies/polytope.hpp"

namespace plannercheck {
namespace {

static_assert(std::endian::native == std::endian::little, "prepared cells are little-endian");

constexpr std::size_t kHeaderBytes = 48, kEntryBytes = 64, kNameBytes = 32, kAlignment = 64;

// Header: magic, u32 format, u32 body format, u64 size of the file, u32 sections, u32 CRC-32 of all after the header,
// u64 zero.
constexpr std::size_t kFormatAt = 16, kBodyFormatAt = 20, kSizeAt = 24, kCountAt = 32, kChecksumAt = 36, kZeroAt = 40;

template <class T>
T read_at(std::span<const std::byte> bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

std::size_t aligned(std::size_t offset) { return (offset + kAlignment - 1) / kAlignment * kAlignment; }

// CRC-32 as in zlib and PNG, eight bytes at once (Kounavis and Berry 2005, "slicing by 8").
constexpr std::size_t kSlices = 8;
using CrcTables = std::array<std::array<std::uint32_t, 256>, kSlices>;

constexpr CrcTables crc_tables() {
  constexpr std::uint32_t kPolynomial = 0xedb88320;
  CrcTables tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t rest = byte;
    for (int bit = 0; bit < 8; ++bit) rest = (rest & 1) != 0 ? rest >> 1 ^ kPolynomial : rest >> 1;
    tables[0][byte] = rest;
  }
  for (std::size_t slice = 1; slice < kSlices; ++slice) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t before = tables[slice - 1][byte];
      tables[slice][byte] = before >> 8 ^ tables[0][before & 0xff];
    }
  }
  return tables;
}

std::uint32_t crc32(std::span<const std::byte> bytes) {
  static constexpr CrcTables kTables = crc_tables();
  std::uint32_t rest = ~0U;
  std::size_t i = 0;
  for (; i + kSlices <= bytes.size(); i += kSlices) {
    const auto eight = read_at<std::uint64_t>(bytes, i) ^ rest;
    rest = 0;
    for (std::size_t k = 0; k < kSlices; ++k) rest ^= kTables[kSlices - 1 - k][eight >> 8 * k & 0xff];
  }
  for (; i < bytes.size(); ++i) rest = rest >> 8 ^ kTables[0][(rest ^ static_cast<std::uint32_t>(bytes[i])) & 0xff];
  return ~rest;
}

std::string formats(std::uint32_t cell, std::uint32_t bodies) {
  return std::to_string(cell) + " with bodies of format " + std::to_string(bodies);
}

}  // namespace

void require_sound(bool sound, const char* what) {
  if (!sound) throw CellError(std::string("is damaged: ") + what);
}

CellFile::CellFile(std::span<const std::byte> bytes) : file_(bytes) {
  if (file_.size() < kMagic.size() || std::memcmp(file_.data(), kMagic.data(), kMagic.size()) != 0)
    throw CellError("is no prepared cell: it does not start with 'plannercheck'");
  if (file_.size() < kHeaderBytes) throw CellError("is cut short");
  const auto format = read_at<std::uint32_t>(file_, kFormatAt), bodies = read_at<std::uint32_t>(file_, kBodyFormatAt);
  if (format != kCellFormat || bodies != static_cast<std::uint32_t>(kPolytopeFormat))
    throw CellError("is of format " + formats(format, bodies) + ", this version reads " +
                    formats(kCellFormat, static_cast<std::uint32_t>(kPolytopeFormat)) + ": save the cell again");
  if (read_at<std::uint64_t>(file_, kSizeAt) != file_.size() ||
      read_at<std::uint32_t>(file_, kChecksumAt) != crc32(file_.subspan(kHeaderBytes)))
    throw CellError("is cut short or changed: its content does not match its checksum");
  require_sound(read_at<std::uint64_t>(file_, kZeroAt) == 0, "its header");
  read_entries(read_at<std::uint32_t>(file_, kCountAt));
}

void CellFile::read_entries(std::size_t count) {
  require_sound(count <= (file_.size() - kHeaderBytes) / kEntryBytes, "its number of sections");
  std::size_t end = kHeaderBytes + count * kEntryBytes;
  for (std::size_t i = 0; i < count; ++i) {
    const std::span<const std::byte> raw = file_.subspan(kHeaderBytes + i * kEntryBytes, kEntryBytes);
    const char* name = reinterpret_cast<const char*>(raw.data());
    const std::size_t length = strnlen(name, kNameBytes);
    Entry entry{{name, length},
                read_at<std::uint32_t>(raw, kNameBytes),
                read_at<std::uint32_t>(raw, kNameBytes + 4),
                read_at<std::uint64_t>(raw, kNameBytes + 8),
                read_at<std::uint64_t>(raw, kNameBytes + 16)};
    const std::size_t width = entry.type == static_cast<std::uint32_t>(Type::kBytes)      ? 1
                              : entry.type == static_cast<std::uint32_t>(Type::kIntegers) ? 4
                              : entry.type == static_cast<std::uint32_t>(Type::kDoubles)  ? 8
                                                                                          : 0;
    require_sound(width > 0 && entry.columns > 0, "a section's type");
    require_sound(entry.offset == aligned(end) && entry.offset <= file_.size(), "a section's place");
    require_sound(entry.rows <= (file_.size() - entry.offset) / (width * entry.columns), "a section's size");
    end = entry.offset + entry.rows * entry.columns * width;
    entries_.push_back(std::move(entry));
  }
  require_sound(end == file_.size(), "it goes on after its end");
}

CellFile::Entry CellFile::take(const char* name, Type type) {
  if (next_ == entries_.size()) throw CellError(std::string("is damaged: it has no section '") + name + "'");
  Entry& entry = entries_[next_++];
  if (entry.name != name || entry.type != static_cast<std::uint32_t>(type))
    throw CellError(std::string("is damaged: there is no section '") + name + "' where it should be");
  return entry;
}

CellFile::Entry CellFile::take(const char* name, Type type, std::size_t columns) {
  Entry entry = take(name, type);
  if (entry.columns != columns) throw CellError(std::string("is damaged: the columns of '") + name + "'");
  return entry;
}

template <class T>
std::span<const T> CellFile::numbers(const Entry& entry) const {
  return {reinterpret_cast<const T*>(file_.data() + entry.offset), entry.rows * entry.columns};
}

std::span<const double> CellFile::doubles(const char* name, std::size_t columns) {
  return numbers<double>(take(name, Type::kDoubles, columns));
}

std::span<const std::int32_t> CellFile::integers(const char* name, std::size_t columns) {
  return numbers<std::int32_t>(take(name, Type::kIntegers, columns));
}

std::span<const std::uint8_t> CellFile::bytes(const char* name, std::size_t columns) {
  return numbers<std::uint8_t>(take(name, Type::kBytes, columns));
}

CellFile::Table CellFile::table(const char* name) {
  const Entry entry = take(name, Type::kDoubles);
  return {numbers<double>(entry), {}, entry.rows, entry.columns};
}

CellFile::Table CellFile::byte_table(const char* name) {
  const Entry entry = take(name, Type::kBytes);
  return {{}, numbers<std::uint8_t>(entry), entry.rows, entry.columns};
}

double CellFile::number(const char* name) {
  const auto found = doubles(name);
  require_sound(found.size() == 1, name);
  return found[0];
}

std::int32_t CellFile::integer(const char* name) {
  const auto found = integers(name);
  require_sound(found.size() == 1, name);
  return found[0];
}

std::string CellFile::text(const char* name) {
  const auto found = bytes(name);
  return {found.begin(), found.end()};
}

std::vector<std::string> CellFile::texts(const char* name) {
  const std::string all = text(name);
  require_sound(all.empty() || all.back() == '\0', name);
  std::vector<std::string> out;
  for (std::size_t first = 0; first < all.size(); first += out.back().size() + 1) out.emplace_back(all.c_str() + first);
  return out;
}

std::vector<std::string> CellFile::names() const {
  std::vector<std::string> out;
  for (const Entry& entry : entries_) out.push_back(entry.name);
  return out;
}

void CellFile::end() const { require_sound(next_ == entries_.size(), "it has more sections than it should"); }

}  // namespace plannercheck
