// The sums of gradients of a field on the device, and the quanta in which they count.
#include "render/vulkan/device_sums.h"

#include "core/error.h"

#include <utility>
#include <vector>

namespace tetrec {

void DeviceSums::Expect(const FixedPoint& quanta) {
  TETREC_CHECK(!has_values_ || quanta == quanta_,
               "batches summed for one update agree in rays_of_mean, loss and dssim_weight");
  quanta_ = quanta;
  has_quanta_ = true;
}

void DeviceSums::ExpectPositions(DeviceField& field, const FixedPoint& quanta,
                                 const std::function<void()>& wait) {
  AllocatePositionGradients(device_, field);
  if (has_positions_ && quanta.position_quanta != position_quanta_.position_quanta) {
    wait();
    CountPositions(field);
  }
  position_quanta_ = quanta;
  has_positions_ = true;
}

void DeviceSums::ForgetPositions() {
  counted_positions_ = {};
  has_positions_ = false;
}

void DeviceSums::Add(DeviceField& field, const GradientSums& given) {
  AllocateOtherGradients(device_, field);
  AddToGradients(field, given.values, quanta_);
  has_values_ = true;
  if (given.position.empty()) return;
  ExpectPositions(field, quanta_, [] {});
  std::vector<double> rows;
  for (size_t v = 0; v < given.position.size(); ++v) {
    for (int i = 0; i < 3; ++i) rows.push_back(given.position[v][i]);
    rows.push_back(given.absolute_position[v]);
  }
  AddToPositionGradients(field, rows, quanta_);
}

GradientSums DeviceSums::Take(DeviceField& field, const FixedPoint& quanta) {
  GradientSums sums = TakePositions(field);
  sums.values = DownloadGradients(field, quanta);
  ClearGradients(field);
  has_values_ = false;
  return sums;
}

GradientSums DeviceSums::TakePositions(DeviceField& field) {
  GradientSums sums;
  if (!has_positions_) return sums;
  CountPositions(field);
  sums.position = std::move(counted_positions_.position);
  sums.absolute_position = std::move(counted_positions_.absolute_position);
  ForgetPositions();
  return sums;
}

// Moves the sums on the device to counted_positions_.
void DeviceSums::CountPositions(DeviceField& field) {
  GradientSums& sums = counted_positions_;
  sums.position.resize(field.vertex_count, glm::dvec3(0.0));
  sums.absolute_position.resize(field.vertex_count, 0.0);
  const std::vector<double> rows = DownloadPositionGradients(field, position_quanta_);
  for (size_t v = 0; v < sums.position.size(); ++v) {
    sums.position[v] += glm::dvec3(rows[4 * v], rows[4 * v + 1], rows[4 * v + 2]);
    sums.absolute_position[v] += rows[4 * v + 3];
  }
  field.position_gradients.FillZero();
}

}  // namespace tetrec
