// The number of a thread of CommandRecorder::DispatchMany, whose workgroups fill as many rows as
// needed. A macro, because gl_WorkGroupSize is 1 until the kernel has declared its local size.
#define ThreadIndex() \
  (gl_GlobalInvocationID.y * (gl_NumWorkGroups.x * gl_WorkGroupSize.x) + gl_GlobalInvocationID.x)
