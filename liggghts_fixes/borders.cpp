#include "liggghts.hpp"

#include "borders.hpp"

#include "atom_vec_sphere.h"

#include <typeinfo>
#include <utility>

using namespace LAMMPS_NS;

namespace hotbed
{

BothSides* BothSides::install(LAMMPS& lmp)
{
    Comm* comm = lmp.comm;
    if (typeid(*comm) == typeid(BothSides)) return static_cast<BothSides*>(comm);
    if (typeid(*comm) != typeid(Comm)) return nullptr;
    auto* both = new BothSides(*comm);
    lmp.comm = both;
    ::operator delete(comm); // all that it owned is the other's now
    return both;
}

void BothSides::forward_comm(int dummy)
{
    if (!takesOver())
    {
        Comm::forward_comm(dummy);
        return;
    }
    if (!std::exchange(early_, false)) nothingPacked();
    // both sides of an axis, as often as ranks that lie further away are needed
    for (int swap = 0; swap < nswap; swap += 2) bothSides(swap);
}

void BothSides::borders()
{
    early_ = false;
    Comm::borders();
}

void BothSides::bothSides(int swap)
{
    std::size_t received = 0;
    for (int s = swap; s < swap + 2; ++s) received += std::size_t(recvnum[s] * size_forward);
    if (receive_.size() < received) receive_.resize(received);
    MPI_Request requests[4];
    int open = 0;
    double* to = receive_.data();
    for (int s = swap; s < swap + 2; ++s)
        if (sendproc[s] != me && recvnum[s])
        {
            MPI_Irecv(to, recvnum[s] * size_forward, MPI_DOUBLE, recvproc[s], s, world, &requests[open++]);
            to += recvnum[s] * size_forward;
        }
    for (int s = swap; s < swap + 2; ++s)
    {
        double* from = send_.data() + packed_[s].at;
        if (plain(s))
            packPlain(s, atom->nlocal + atom->nghost);
        else if (sendnum[s])
            atom->avec->pack_comm_vel(sendnum[s], sendlist[s], from, pbc_flag[s], pbc[s]);
        if (sendproc[s] == me)
            atom->avec->unpack_comm_vel(recvnum[s], firstrecv[s], from);
        else if (sendnum[s])
            MPI_Isend(from, sendnum[s] * size_forward, MPI_DOUBLE, sendproc[s], s, world, &requests[open++]);
    }
    MPI_Waitall(open, requests, MPI_STATUSES_IGNORE);
    to = receive_.data();
    for (int s = swap; s < swap + 2; ++s)
        if (sendproc[s] != me && recvnum[s])
        {
            atom->avec->unpack_comm_vel(recvnum[s], firstrecv[s], to);
            to += recvnum[s] * size_forward;
        }
}

void BothSides::packEarly(int first, int end)
{
    if (!takesOver()) return;
    if (first == 0)
    {
        nothingPacked();
        early_ = true;
    }
    for (int s = 0; s < nswap; ++s)
        if (plain(s)) packPlain(s, end);
}

bool BothSides::takesOver() const
{
    return !comm_x_only && ghost_velocity && !domain->is_wedge;
}

/// Whether places are sent as they are, and nothing but places, velocities and spins.
bool BothSides::plain(int swap) const
{
    return !pbc_flag[swap] && !atom->radvary_flag && typeid(*atom->avec) == typeid(AtomVecSphere);
}

void BothSides::nothingPacked()
{
    packed_.clear();
    std::size_t at = 0;
    for (int s = 0; s < nswap; ++s)
    {
        packed_.push_back({at, 0});
        at += std::size_t(sendnum[s] * size_forward);
    }
    if (send_.size() < at) send_.resize(at);
}

/// Those of the list, which is in order, before particle `end`, after those that are packed
void BothSides::packPlain(int swap, int end)
{
    // LIGGGHTS keeps n x 3 arrays in one block behind row pointers
    const double *x = atom->x[0], *v = atom->v[0], *omega = atom->omega[0];
    const int* list = sendlist[swap];
    int i = packed_[swap].count;
    double* to = send_.data() + packed_[swap].at + 9 * std::size_t(i);
    for (; i < sendnum[swap] && list[i] < end; ++i, to += 9)
    {
        const int k = 3 * list[i];
        // in place of std::copy_n(), which would be a call each
        for (int c = 0; c < 3; ++c)
        {
            to[c] = x[k + c];
            to[3 + c] = v[k + c];
            to[6 + c] = omega[k + c];
        }
    }
    packed_[swap].count = i;
}

} // namespace hotbed
