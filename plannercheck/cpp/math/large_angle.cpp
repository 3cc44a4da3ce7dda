#include "math/large_angle.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace plannercheck {
namespace {

__extension__ using Wide = unsigned __int128;
__extension__ using SignedWide = __int128;

// The first 1,216 bits of 2/pi after the binary point, rounded down: the last bit that a double's product with 2/pi
// needs for 192 bits is the 1,161st.
constexpr std::uint64_t kTwoOverPi[] = {0xa2f9836e4e441529, 0xfc2757d1f534ddc0, 0xdb6295993c439041, 0xfe5163abdebbc561,
                                        0xb7246e3a424dd2e0, 0x06492eea09d1921c, 0xfe1deb1cb129a73e, 0xe88235f52ebb4484,
                                        0xe99c7026b45f7e41, 0x3991d639835339f4, 0x9c845f8bbdf9283b, 0x1ff897ffde05980f,
                                        0xef2f118b5a0a6d1f, 0x6d367ecf27cb09b7, 0x4f463f669e5fea2d, 0x7527bac7ebe5f17b,
                                        0x3d0739f78a5292ea, 0x6bfb5fb11f8d5d08, 0x56033046fc7b6bab};

// pi/2 in units of 2^-127, rounded downwards.
constexpr Wide kHalfPi = Wide{0xc90fdaa22168c234} << 64 | 0xc4c6628b80dc1cd1;

constexpr int kAngleMantissaBits = 53;

// The upper 128 bits of the product of two numbers of 128 bits.
Wide upper_product(Wide a, Wide b) {
  const std::uint64_t a1 = static_cast<std::uint64_t>(a >> 64), a0 = static_cast<std::uint64_t>(a);
  const std::uint64_t b1 = static_cast<std::uint64_t>(b >> 64), b0 = static_cast<std::uint64_t>(b);
  const Wide low = Wide{a0} * b0, left = Wide{a1} * b0, right = Wide{a0} * b1;
  const Wide carried = (low >> 64) + static_cast<std::uint64_t>(left) + static_cast<std::uint64_t>(right);
  return Wide{a1} * b1 + (left >> 64) + (right >> 64) + (carried >> 64);
}

// Bits first ... first + 63 of 2/pi after the binary point, counted from 0.
std::uint64_t bits_of_two_over_pi(int first) {
  const std::size_t word = static_cast<std::size_t>(first) / 64;
  const int offset = first % 64;
  const std::uint64_t head = kTwoOverPi[word] << offset;
  return offset == 0 ? head : head | kTwoOverPi[word + 1] >> (64 - offset);
}

// mantissa * 2^exponent * 2/pi modulo 4: whole quarters, and the rest in units of 2^-128, rounded down.
struct Quarters {
  unsigned whole;
  Wide part;
};

Quarters quarters_of(std::uint64_t mantissa, int exponent) {
  // Bits of 2/pi whose product with 2^exponent is a multiple of 4 change nothing.
  const int skipped = exponent > 2 ? exponent - 2 : 0;
  const Wide low = Wide{mantissa} * bits_of_two_over_pi(skipped + 128);
  const Wide middle = Wide{mantissa} * bits_of_two_over_pi(skipped + 64) + (low >> 64);
  const Wide high = Wide{mantissa} * bits_of_two_over_pi(skipped) + (middle >> 64);
  // The product is `high` followed by 128 bits, in units of 2^-(128 + point): the binary point is `point` bits up in
  // `high`.
  const int point = 64 - (exponent - skipped);
  const Wide behind = Wide{static_cast<std::uint64_t>(middle)} << 64 | static_cast<std::uint64_t>(low);
  const Wide part = high << (128 - point) | behind >> point;
  return {static_cast<unsigned>(high >> point) & 3U, part};
}

}  // namespace

ReducedAngle reduced(double angle) {
  if (!std::isfinite(angle)) {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    return {none, none, 0};
  }
  int exponent = 0;
  const double fraction = std::frexp(std::abs(angle), &exponent);
  const auto mantissa = static_cast<std::uint64_t>(std::ldexp(fraction, kAngleMantissaBits));
  Quarters quarters = quarters_of(mantissa, exponent - kAngleMantissaBits);
  bool negative = std::signbit(angle);
  unsigned whole = negative ? 0U - quarters.whole : quarters.whole;
  if (quarters.part >> 127 != 0) {  // nearer to the next quarter
    whole += negative ? ~0U : 1U;
    quarters.part = -quarters.part;
    negative = !negative;
  }
  const Wide rest = upper_product(quarters.part, kHalfPi);  // in units of 2^-127
  const auto head = static_cast<double>(rest);
  const auto tail = static_cast<double>(static_cast<SignedWide>(rest - static_cast<Wide>(head)));
  const double unit = negative ? -0x1p-127 : 0x1p-127;
  return {head * unit, tail * unit, whole & 3U};
}

}  // namespace plannercheck
