#include "liggghts.hpp"

#include "borders.hpp"

#include "atom_vec_sphere.h"

#include <algorithm>
#include <typeinfo>
#include <vector>

using namespace LAMMPS_NS;

namespace hotbed
{
namespace
{

class BothSides : public Comm
{
public:
    explicit BothSides(const Comm& comm) : Comm(comm) {}

    void forward_comm(int dummy) override
    {
        if (comm_x_only || !ghost_velocity || domain->is_wedge)
            Comm::forward_comm(dummy);
        else
            // both sides of an axis, as often as ranks that lie further away are needed
            for (int swap = 0; swap < nswap; swap += 2) bothSides(swap);
    }

private:
    void bothSides(int swap)
    {
        std::size_t sent = 0, received = 0;
        for (int s = swap; s < swap + 2; ++s)
        {
            sent += std::size_t(sendnum[s] * size_forward);
            received += std::size_t(recvnum[s] * size_forward);
        }
        if (send_.size() < sent) send_.resize(sent);
        if (receive_.size() < received) receive_.resize(received);
        MPI_Request requests[4];
        int open = 0;
        double *to = receive_.data(), *from = send_.data();
        for (int s = swap; s < swap + 2; ++s)
            if (sendproc[s] != me && recvnum[s])
            {
                MPI_Irecv(to, recvnum[s] * size_forward, MPI_DOUBLE, recvproc[s], s, world, &requests[open++]);
                to += recvnum[s] * size_forward;
            }
        for (int s = swap; s < swap + 2; ++s)
        {
            if (sendnum[s]) pack(s, from);
            if (sendproc[s] == me)
                atom->avec->unpack_comm_vel(recvnum[s], firstrecv[s], from);
            else if (sendnum[s])
                MPI_Isend(from, sendnum[s] * size_forward, MPI_DOUBLE, sendproc[s], s, world, &requests[open++]);
            from += sendnum[s] * size_forward;
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

    void pack(int swap, double* to) const
    {
        if (pbc_flag[swap] || atom->radvary_flag || typeid(*atom->avec) != typeid(AtomVecSphere))
        {
            atom->avec->pack_comm_vel(sendnum[swap], sendlist[swap], to, pbc_flag[swap], pbc[swap]);
            return;
        }
        // LIGGGHTS keeps n x 3 arrays in one block behind row pointers
        const double *x = atom->x[0], *v = atom->v[0], *omega = atom->omega[0];
        const int* list = sendlist[swap];
        for (int i = 0; i < sendnum[swap]; ++i, to += 9)
        {
            const int k = 3 * list[i];
            for (int c = 0; c < 3; ++c)
            {
                to[c] = x[k + c];
                to[3 + c] = v[k + c];
                to[6 + c] = omega[k + c];
            }
        }
    }

    std::vector<double> send_, receive_;
};

} // namespace

void sendToBothSides(LAMMPS& lmp)
{
    Comm* comm = lmp.comm;
    if (typeid(*comm) != typeid(Comm)) return;
    lmp.comm = new BothSides(*comm);
    ::operator delete(comm); // all that it owned is the other's now
}

} // namespace hotbed
