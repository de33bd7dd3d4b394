/// Adds `pair_style gran model hotbed tangential hotbed`, and the same for fix wall/gran, to LIGGGHTS' public
/// factories.

#include "contact_models.h"
#include "fix_insert_stream.h"
#include "vectorised_pair.hpp"
#include "vectorised_wall.hpp"

#include "register_contact.hpp"

namespace hotbed
{
namespace
{

using namespace LIGGGHTS;

PairStyles::IGranularPairStyle* makePair(LAMMPS_NS::LAMMPS* lmp, LAMMPS_NS::PairGran* parent, int64_t hash)
{
    return new VectorisedPair(lmp, parent, hash);
}

} // namespace

void registerContact()
{
    static bool done = false; // the factories live as long as the process
    if (done) return;
    done = true;
    ContactModels::Factory::instance().addNormalModel("hotbed", ContactModels::HOTBED_NORMAL);
    ContactModels::Factory::instance().addTangentialModel("hotbed", ContactModels::HOTBED_TANGENTIAL);
    PairStyles::Factory::instance().addStyle("gran", ContactStyle::HASHCODE, &makePair);
    Walls::Factory::instance().addStyle("gran", ContactStyle::HASHCODE, &makeWallModel);
}

std::int64_t contactCode()
{
    return ContactStyle::HASHCODE;
}

} // namespace hotbed
