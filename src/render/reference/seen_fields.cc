// A field as the views of a batch see it.
#include "render/reference/seen_fields.h"

#include "render/seen_colors.h"

namespace tetrec {

SeenFields FieldsSeenBy(const BatchRays& batch, const RadianceField& field) {
  SeenFields seen;
  if (LayoutOf(field).HarmonicsDegree() == 0) {
    seen[batch.blocks[0].view] =
        std::shared_ptr<const RadianceField>(std::shared_ptr<void>(), &field);  // not owned
    return seen;
  }
  for (const RayBlock& block : batch.blocks) {
    if (seen.contains(block.view)) continue;
    seen[block.view] = std::make_shared<const RadianceField>(
        FieldSeenFrom(field, CenterOf(batch.views[block.view])));
  }
  return seen;
}

const RadianceField& FieldFor(const SeenFields& seen, const BatchRays& batch, size_t ray) {
  return *(seen.size() == 1 ? seen.begin()->second : seen.at(batch.IndexOfView(ray)));
}

}  // namespace tetrec
