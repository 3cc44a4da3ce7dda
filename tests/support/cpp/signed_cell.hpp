// A prepared cell's file with its size and checksum put in again, as a hostile file has them.
#pragma once

#include <cstdint>
#include <cstring>
#include <vector>

using Bytes = std::vector<char>;

inline constexpr std::size_t kSizeAt = 24, kChecksumAt = 36, kHeader = 48;

template <class T>
void put(Bytes& file, std::size_t at, T value) {
  if (at + sizeof value <= file.size()) std::memcpy(file.data() + at, &value, sizeof value);
}

template <class T>
T get(const Bytes& file, std::size_t at) {
  T value{};
  if (at + sizeof value <= file.size()) std::memcpy(&value, file.data() + at, sizeof value);
  return value;
}

// Byte by byte: none of the library's code.
inline std::uint32_t crc32(const char* data, std::size_t size) {
  std::uint32_t rest = ~0U;
  for (std::size_t i = 0; i < size; ++i) {
    rest ^= static_cast<unsigned char>(data[i]);
    for (int bit = 0; bit < 8; ++bit) rest = (rest & 1) != 0 ? rest >> 1 ^ 0xedb88320U : rest >> 1;
  }
  return ~rest;
}

inline void sign(Bytes& file) {
  if (file.size() < kHeader) return;
  put<std::uint64_t>(file, kSizeAt, file.size());
  put(file, kChecksumAt, crc32(file.data() + kHeader, file.size() - kHeader));
}
