/// MPI's profiling interface: what the program and its libraries call as MPI_X comes here, the work is done by PMPI_X.

#include "waiting.hpp"

#include <mpi.h>

namespace
{

double seconds = 0.0;

template <class Call> int timed(const Call& call)
{
    const double begin = MPI_Wtime();
    const int code = call();
    seconds += MPI_Wtime() - begin;
    return code;
}

} // namespace

double hotbed::secondsInMpi()
{
    return seconds;
}

#define TIMED(NAME, PARAMETERS, ARGUMENTS)                                                                             \
    __attribute__((visibility("default"))) int MPI_##NAME PARAMETERS                                                   \
    {                                                                                                                  \
        return timed([&] { return PMPI_##NAME ARGUMENTS; });                                                           \
    }

extern "C"
{
    TIMED(Allreduce, (const void* from, void* to, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm),
          (from, to, n, type, op, comm))
    TIMED(Reduce, (const void* from, void* to, int n, MPI_Datatype type, MPI_Op op, int root, MPI_Comm comm),
          (from, to, n, type, op, root, comm))
    TIMED(Bcast, (void* data, int n, MPI_Datatype type, int root, MPI_Comm comm), (data, n, type, root, comm))
    TIMED(Barrier, (MPI_Comm comm), (comm))
    TIMED(Allgather, (const void* from, int n, MPI_Datatype type, void* to, int m, MPI_Datatype other, MPI_Comm comm),
          (from, n, type, to, m, other, comm))
    TIMED(Alltoall, (const void* from, int n, MPI_Datatype type, void* to, int m, MPI_Datatype other, MPI_Comm comm),
          (from, n, type, to, m, other, comm))
    TIMED(Send, (const void* data, int n, MPI_Datatype type, int rank, int tag, MPI_Comm comm),
          (data, n, type, rank, tag, comm))
    TIMED(Bsend, (const void* data, int n, MPI_Datatype type, int rank, int tag, MPI_Comm comm),
          (data, n, type, rank, tag, comm))
    TIMED(Recv, (void* data, int n, MPI_Datatype type, int rank, int tag, MPI_Comm comm, MPI_Status* status),
          (data, n, type, rank, tag, comm, status))
    TIMED(Sendrecv,
          (const void* from, int n, MPI_Datatype type, int toRank, int tag, void* to, int m, MPI_Datatype other,
           int fromRank, int otherTag, MPI_Comm comm, MPI_Status* status),
          (from, n, type, toRank, tag, to, m, other, fromRank, otherTag, comm, status))
    TIMED(Probe, (int rank, int tag, MPI_Comm comm, MPI_Status* status), (rank, tag, comm, status))
    TIMED(Wait, (MPI_Request * request, MPI_Status* status), (request, status))
    TIMED(Waitall, (int n, MPI_Request* requests, MPI_Status* statuses), (n, requests, statuses))
}
