// The side of a plane on which a point is, decided exactly.
#include "geometry/orientation.h"

#include <cmath>
#include <limits>

namespace tetrec {
namespace {

// An exact sum of doubles: non-overlapping components of increasing magnitude.
class ExactSum {
 public:
  void Add(double term) {
    int kept = 0;
    for (int i = 0; i < size_; ++i) {
      // Knuth's TwoSum: sum + error == term + component, exactly.
      const double sum = term + components_[i];
      const double virtual_part = sum - term;
      const double error = (term - (sum - virtual_part)) + (components_[i] - virtual_part);
      if (error != 0) components_[kept++] = error;
      term = sum;
    }
    if (term != 0) components_[kept++] = term;
    size_ = kept;
  }
  // The last component outweighs all others together.
  int Sign() const {
    if (size_ == 0) return 0;
    return components_[size_ - 1] > 0 ? 1 : -1;
  }

 private:
  double components_[49];  // one more than the terms that Orientation adds
  int size_ = 0;
};

// Adds sign * x * y * z. A product of two floats is exact in double; the third factor leaves a
// remainder that fma computes exactly. Exponents stay within 3 * [-149, 128], so nothing under- or
// overflows.
void AddProduct(ExactSum& sum, double sign, float x, float y, float z) {
  const double xy = sign * x * y;
  const double product = xy * z;
  sum.Add(std::fma(xy, double(z), -product));
  sum.Add(product);
}

// Adds sign * det(p, q, r).
void AddDeterminant(ExactSum& sum, double sign, const glm::vec3& p, const glm::vec3& q,
                    const glm::vec3& r) {
  AddProduct(sum, sign, p.x, q.y, r.z);
  AddProduct(sum, sign, p.y, q.z, r.x);
  AddProduct(sum, sign, p.z, q.x, r.y);
  AddProduct(sum, -sign, p.z, q.y, r.x);
  AddProduct(sum, -sign, p.y, q.x, r.z);
  AddProduct(sum, -sign, p.x, q.z, r.y);
}

}  // namespace

int Orientation(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d) {
  const glm::dvec3 origin(a);
  const glm::dvec3 u = glm::dvec3(b) - origin, v = glm::dvec3(c) - origin,
                   w = glm::dvec3(d) - origin;
  const glm::dvec3 plus(v.y * w.z, v.z * w.x, v.x * w.y), minus(v.z * w.y, v.x * w.z, v.y * w.x);
  const double determinant = glm::dot(u, plus - minus);
  // Shewchuk's bound for the error of this evaluation, including the rounding of the differences.
  constexpr double kUnit = 0.5 * std::numeric_limits<double>::epsilon();
  const double bound =
      (7.0 + 56.0 * kUnit) * kUnit * glm::dot(glm::abs(u), glm::abs(plus) + glm::abs(minus));
  if (determinant > bound) return 1;
  if (determinant < -bound) return -1;

  // det(b - a, c - a, d - a) = [bcd] - [acd] + [abd] - [abc].
  ExactSum sum;
  AddDeterminant(sum, 1, b, c, d);
  AddDeterminant(sum, -1, a, c, d);
  AddDeterminant(sum, 1, a, b, d);
  AddDeterminant(sum, -1, a, b, c);
  return sum.Sign();
}

}  // namespace tetrec
