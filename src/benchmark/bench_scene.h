// Scenes for benchmarks: fields of a given size and cameras around or inside them.
#pragma once

#include "field/radiance_field.h"
#include "render/renderer.h"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// Points per side of a jittered grid whose Delaunay mesh has about this number of tets.
int GridOfTets(double tets);

// The 8 corners of the unit cube, then grid^3 jittered points inside it.
std::vector<glm::vec3> JitteredCube(int grid);

// A ball with a soft rim at the centre of the unit cube, density up to 25, in empty space.
RadianceField BallOn(TetMesh mesh);

// The ball on the Delaunay mesh of JitteredCube, about 6.6 tets per point.
RadianceField BallField(int grid);

// The ball on a mesh of about this number of tets.
RadianceField BallFieldOfTets(uint64_t tets);

// The same field on a Delaunay mesh of about `tets` tets, with attributes per vertex whatever the
// field's storage. A smaller mesh consists of all vertices of the hull and a random choice of the
// others; a larger one of all vertices and midpoints of edges.
RadianceField Resample(const RadianceField& field, uint64_t tets, uint64_t seed);

// A camera at `eye` that looks at `target`.
RenderView LookingAt(const glm::dvec3& eye, const glm::dvec3& target, int width, int height,
                     double focal_px);

// The same with an image of `size` x `size` px.
RenderView SquareView(const glm::dvec3& eye, const glm::dvec3& target, int size);

// Cameras around the unit cube, two side lengths from its centre, spread by the golden angle.
std::vector<RenderView> ViewsAroundCube(int count, int size);

// The square in the middle of the view's image, size x size px.
RenderView SquareMiddle(const RenderView& view, int size);

}  // namespace tetrec
