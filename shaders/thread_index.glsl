// Threads of CommandRecorder::DispatchMany, whose workgroups fill as many rows as they need.
uint ThreadIndex() {
  return gl_GlobalInvocationID.y * (gl_NumWorkGroups.x * gl_WorkGroupSize.x) + gl_GlobalInvocationID.x;
}
