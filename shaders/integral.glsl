// The segment integral that the host chose when it made the pipeline.

#include "shared/integral.glsl.h"
#include "shared/segment_cut.glsl.h"

layout(constant_id = kConstantIntegral) const int kIntegral = kIntegralExact;
layout(constant_id = kConstantSplits) const int kSplits = 1;
