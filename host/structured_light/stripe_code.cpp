#include "host/structured_light/stripe_code.h"

#include <cmath>

namespace selfproj {

int cell_of_row(double row, int rows, int width) {
  return static_cast<int>(std::floor((row - 0.5 * (rows - 1)) / width));
}

bool is_light(const Stripes& stripes, int cell, int plane) {
  // The middle of the cell, in units of half a cell, so that all numbers are whole. Divisions round down, also below 0.
  const int period = 2 << stripes.bits;  // period of u, in half cells
  const int at = 2 * cell + 1;
  const auto floor_of_quotient = [](int a, int b) { return a >= 0 ? a / b : -((-a + b - 1) / b); };
  const int stripe = plane == 0 && stripes.code == StripeCode::cyclic
                         ? floor_of_quotient(2 * at, period)
                         : floor_of_quotient((at << plane) + period / 2, period);
  return stripe % 2 != 0;
}

int code_of_cell(const Stripes& stripes, int cell) {
  int code = 0;
  bool bit = false;
  for (int plane = 0; plane < stripes.bits; ++plane) {
    bit = bit != is_light(stripes, cell, plane);
    code = 2 * code + (bit ? 1 : 0);
  }
  return code;
}

}  // namespace selfproj
