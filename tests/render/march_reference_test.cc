// The march renderer against the reference renderer.
#include <gtest/gtest.h>
#include <fmt/format.h>

#include "render/reference_renderer.h"
#include "scenes.h"

namespace tetrec::test {
namespace {

struct ImageError { double color = 0, depth = 0; };

TEST_F(RendererTest, Quick) {
  for (float stop : {0.0f, 1e-3f})
  for (int points : {0, 20, 300, 3000}) for (uint32_t seed : {1u, 2u, 3u}) {
    RendererOptions options; options.stop_transmittance = stop; options.count_steps=true;
    auto& renderer = MakeRenderer(options);
    RadianceField field = RandomField(points, seed, 10.f);
    renderer.SetField(field);
    std::vector<RenderView> views = {LookAt({1.7, -1.1, -1.0}, {0, 0.3, 0.6}, 61, 47), LookAt({0.1, 0.4, 0.5}, {0.3, 0.6, 0.9}, 61, 47), LookAt({0.1, 0.4, 2.5}, {0.0, 0.4, 0.9}, 61, 47)};
    for (auto& view : views) {
      RenderedImage image = renderer.Render(view, 1);
      ReferenceImage ref = RenderReference(field, view, stop);
      double ce=0, de=0, maxd=0; size_t bad=0, worst=0;
      for (size_t i = 0; i < ref.color_srgb.size(); ++i) {
        double e = glm::length(glm::dvec3(image.color_srgb[i]) - ref.color_srgb[i]);
        if (e > ce) worst=i;
        ce = std::max(ce, e);
        if (e > 1e-4) ++bad;
        de = std::max(de, std::abs(image.transmittance[i] - std::exp(-ref.optical_depth[i])));
        maxd = std::max(maxd, ref.optical_depth[i]);
      }
      fmt::print("stop {} tets {} color err {:.2e} (pix {} {}) T err {:.2e} bad {} maxdepth {:.2f}", stop, field.mesh.tets.size(), ce, worst%61, worst/61, de, bad, maxd);
      std::mt19937 random(7); std::normal_distribution<float> n;
      std::vector<glm::vec4> g(ref.color_srgb.size()); std::vector<glm::dvec4> gd;
      for (auto& v : g) { v = glm::vec4(n(random), n(random), n(random), n(random)); gd.emplace_back(v); }
      FieldGradient grad = renderer.Backpropagate(view, g);
      ReferenceGradient rg = BackpropagateReference(field, view, gd, stop);
      double ec=0, ed=0, mc=0, md=0;
      for (size_t v=0; v<rg.density.size(); ++v) {
        ec = std::max(ec, glm::length(glm::dvec3(grad.color_srgb[v]) - rg.color_srgb[v]));
        mc = std::max(mc, glm::length(rg.color_srgb[v]));
        ed = std::max(ed, std::abs(grad.density[v]-rg.density[v]));
        md = std::max(md, std::abs(rg.density[v]));
      }
      fmt::print(" gradc {:.1e} of {:.1e} gradd {:.1e} of {:.1e}", ec, mc, ed, md);
      auto c = renderer.counts();
      fmt::print(" lost {} steps/hit {:.1f}\n", c.lost_rays, double(c.steps)/double(c.hit_rays));
    }
  }
}

}  // namespace
}  // namespace tetrec::test
