// A field as the views of a batch see it.
#pragma once

#include "field/radiance_field.h"
#include "render/reference/batch_rays.h"

#include <cstdint>
#include <map>
#include <memory>

namespace tetrec {

// By view: the field with the colours that this view sees. If colours do not depend on the view,
// there is one entry, the field itself, for all views.
using SeenFields = std::map<uint32_t, std::shared_ptr<const RadianceField>>;

// The field must outlive the result, whose only entry it may be.
SeenFields FieldsSeenBy(const BatchRays& batch, const RadianceField& field);

const RadianceField& FieldFor(const SeenFields& seen, const BatchRays& batch, size_t ray);

// The centre of a view's camera in the world.
inline glm::dvec3 CenterOf(const RenderView& view) {
  return view.cam_from_world.Inverse().translation;
}

}  // namespace tetrec
