// Moves a field's attributes from vertices to tets, and back.
#include "field/change_storage.h"

#include "core/error.h"

#include <cmath>
#include <utility>

namespace tetrec {
namespace {

// Weighted means of what lies around each row, for every component of the layout.
class RowMeans {
 public:
  RowMeans(const FieldLayout& layout, size_t rows)
      : attributes_(layout.ByComponent()),
        weight_(rows, 0.0),
        sum_(rows * attributes_.size(), 0.0),
        dense_weight_(rows, 0.0),
        dense_sum_(rows * attributes_.size(), 0.0) {}

  void Add(size_t row, double weight, const float* values) {
    weight_[row] += weight;
    const double by_density = weight * std::max(0.0, double(values[kDensityOffset]));
    dense_weight_[row] += by_density;
    for (size_t c = 0; c < attributes_.size(); ++c) {
      sum_[row * attributes_.size() + c] += weight * double(values[c]);
      dense_sum_[row * attributes_.size() + c] += by_density * double(values[c]);
    }
  }

  // Densities and the like by weight, all else by weight and density.
  std::vector<float> Values() const {
    std::vector<float> values;
    for (size_t row = 0; row < weight_.size(); ++row) {
      const size_t first = row * attributes_.size();
      for (size_t c = 0; c < attributes_.size(); ++c) {
        const bool by_density =
            attributes_[c]->activation != Activation::kExp && dense_weight_[row] > 0;
        const double value = by_density         ? dense_sum_[first + c] / dense_weight_[row]
                             : weight_[row] > 0 ? sum_[first + c] / weight_[row]
                                                : 0.0;
        // A cell has no negative values: the mean of vertices of either sign may be below 0.
        values.push_back(float(c == size_t(kDensityOffset) ? std::max(0.0, value) : value));
      }
    }
    return values;
  }

 private:
  std::vector<const Attribute*> attributes_;
  std::vector<double> weight_, sum_;
  std::vector<double> dense_weight_, dense_sum_;  // weighted by density, too
};

}  // namespace

RadianceField WithStorage(RadianceField field, FieldStorage storage) {
  if (field.storage == storage) return field;
  FieldLayout layout = LayoutOf(field);
  layout.storage = storage;
  const size_t components = size_t(layout.Components());
  const std::vector<float> values = ValuesOf(field);
  RowMeans means(layout, RowCount(field.mesh, storage));
  for (size_t t = 0; t < field.mesh.tets.size(); ++t) {
    const glm::uvec4& tet = field.mesh.tets[t];
    const double volume = std::abs(TetVolume(field.mesh, tet));
    for (int i = 0; i < 4; ++i) {
      if (storage == FieldStorage::kCell) {
        means.Add(t, 1.0, &values[tet[i] * components]);
      } else {
        means.Add(tet[i], volume, &values[t * components]);
      }
    }
  }
  return MakeField(std::move(field.mesh), layout, means.Values());
}

}  // namespace tetrec
