// What benchmarks render: fields of a wanted size and cameras around or inside them.
#pragma once

#include "field/radiance_field.h"
#include "render/renderer.h"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// Points a side of a jittered grid whose Delaunay mesh has about so many tets.
int GridOfTets(double tets);

// grid^3 jittered points in the unit cube, behind its 8 corners.
std::vector<glm::vec3> JitteredCube(int grid);

// A soft ball around the middle of the unit cube, density up to 25, in a sea of nothing.
RadianceField BallOn(TetMesh mesh);

// The ball on the Delaunay mesh of JitteredCube, about 6.6 tets a point.
RadianceField BallField(int grid);

// The ball on a mesh of about so many tets.
RadianceField BallFieldOfTets(uint64_t tets);

// The same field on a Delaunay mesh of about so many tets, attributes of vertices whatever the
// field's storage. Fewer: of a seeded choice of its vertices and all those of its hull; more: of
// its vertices and middles of edges.
RadianceField Resample(const RadianceField& field, uint64_t tets, uint64_t seed);

// Looks from `eye` at `target`.
RenderView LookingAt(const glm::dvec3& eye, const glm::dvec3& target, int width, int height,
                     double focal_px);

// `size` x `size` px; looks from `eye` at `target`.
RenderView SquareView(const glm::dvec3& eye, const glm::dvec3& target, int size);

// Around the unit cube, two sides away from its centre, spread by the golden angle.
std::vector<RenderView> ViewsAroundCube(int count, int size);

// The middle of the view's picture, size x size px.
RenderView SquareMiddle(const RenderView& view, int size);

}  // namespace tetrec
