// Threads of CommandRecorder::DispatchMany, whose workgroups fill as many rows as they need. A macro:
// before the kernel has declared its local size gl_WorkGroupSize is 1.
#define ThreadIndex() \
  (gl_GlobalInvocationID.y * (gl_NumWorkGroups.x * gl_WorkGroupSize.x) + gl_GlobalInvocationID.x)
