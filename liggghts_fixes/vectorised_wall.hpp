#pragma once

/// fix wall/gran with the contact law `hotbed`. Include after what fix_wall_gran.h wants to be included before it.

#include "contact_kernel.hpp"

#include "fix_wall_gran.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace hotbed
{

LIGGGHTS::Walls::IGranularWall* makeWallModel(LAMMPS_NS::LAMMPS* lmp, LAMMPS_NS::FixWallGran* parent, int64_t hash);

/// LIGGGHTS' own fix wall/gran, whose loop over the particles near a primitive plane is ours where the wall has the
/// contact law `hotbed` and no more than forces is asked for. List of near particles and springs are LIGGGHTS'.
class VectorisedWall : public LAMMPS_NS::FixWallGran
{
public:
    using FixWallGran::FixWallGran;

    void init() override;

    /// Whether compute() and give() may take the place of the next post_force().
    bool mayBeFirst() const { return vectorised_ && forcesOnly(); }
    /// Forces of this time step, before those of pairs
    void compute();
    /// Adds those of local particles [first, end), after those before them. @param force, torque  of `first` and those
    /// after it
    void give(int first, int end, double (*force)[3], double (*torque)[3]);

protected:
    void post_force_primitive(int vflag) override;

private:
    bool forcesOnly() const;
    void nearForces();

    bool vectorised_ = false;
    int offset_ = 0;                          ///< of the spring in a particle's history
    std::vector<ContactConstants> constants_; ///< of each particle type with the wall's
    std::vector<WallContact> contacts_;       ///< by their particles
    std::size_t given_ = 0;                   ///< the first of contacts_ that is not
    bool computed_ = false;                   ///< before the next post_force()
};

} // namespace hotbed
