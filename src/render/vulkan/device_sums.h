// The sums of gradients of a field on the device, and the quanta in which they count.
#pragma once

#include "render/training_renderer.h"
#include "render/vulkan/device_field.h"

#include <functional>

namespace tetrec {

// Gradients by values are summed for one update, in one kind of quanta. Those by positions may be
// of several updates, and in quanta that change. Functions that take the field read or write its
// sums, so the device must be idle for them.
class DeviceSums {
 public:
  explicit DeviceSums(const Device& device) : device_(device) {}

  // Gradients are about to be added that count in these quanta. TETREC_CHECKs that those which are
  // there count in the same.
  void Expect(const FixedPoint& quanta);
  bool has_quanta() const { return has_quanta_; }  // that the next gradients must count in
  const FixedPoint& quanta() const { return quanta_; }
  // There are gradients by values that no update has used.
  bool has_values() const { return has_values_; }
  void HaveValues() { has_values_ = true; }
  // They are zero, or will be when the device is done.
  void ForgetValues() { has_values_ = has_quanta_ = false; }

  // Gradients by positions are about to be added that count in these quanta. Makes room for them.
  // `wait`: called if the device must be idle for it.
  void ExpectPositions(DeviceField& field, const FixedPoint& quanta,
                       const std::function<void()>& wait);
  void ForgetPositions();

  // Adds given gradients; quanta are expected.
  void Add(DeviceField& field, const GradientSums& given);
  // Read the sums and set them to zero. `quanta`: of the values.
  GradientSums Take(DeviceField& field, const FixedPoint& quanta);
  GradientSums TakePositions(DeviceField& field);

 private:
  void CountPositions(DeviceField& field);

  const Device& device_;
  bool has_values_ = false, has_quanta_ = false;
  FixedPoint quanta_;
  bool has_positions_ = false;      // that were not taken
  FixedPoint position_quanta_;      // of those on the device
  GradientSums counted_positions_;  // those in other quanta
};

}  // namespace tetrec
