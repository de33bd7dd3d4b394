#pragma once

/// What ranks send each other of the particles at their borders. Include after lammps.h.

#include "comm.h"

#include <cstddef>
#include <vector>

namespace hotbed
{

/// Sends places and velocities to both neighbours along an axis at once. LIGGGHTS sends to one side, then to the other:
/// of two ranks each waits while the other one packs.
class BothSides : public LAMMPS_NS::Comm
{
public:
    /// Puts it in the place of LIGGGHTS' own. @return null where that is not the common one
    static BothSides* install(LAMMPS_NS::LAMMPS& lmp);

    void forward_comm(int dummy) override;
    void borders() override;

    /// Packs what the next forward_comm() sends of local particles [first, end), after those before them, while they
    /// are in the cache. They are as they will be then; unless lists of what is sent are made anew before.
    void packEarly(int first, int end);

private:
    struct Packed
    {
        std::size_t at; ///< of the swap in send_
        int count;      ///< of its list
    };

    explicit BothSides(const LAMMPS_NS::Comm& comm) : Comm(comm) {}

    bool takesOver() const;
    void bothSides(int swap);
    bool plain(int swap) const;
    void nothingPacked();
    void packPlain(int swap, int end);

    std::vector<double> send_, receive_;
    std::vector<Packed> packed_; ///< of each swap
    bool early_ = false;         ///< some were by packEarly()
};

} // namespace hotbed
