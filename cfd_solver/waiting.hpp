#pragma once

namespace hotbed
{

/// Seconds that this rank has spent so far in calls of MPI that may wait for another rank, those of OpenFOAM and
/// LIGGGHTS included. A rank that has less to do than the others spends the difference there.
double secondsInMpi();

} // namespace hotbed
