#include "restart.hpp"

#include "IFstream.H"
#include "OFstream.H"
#include "OSspecific.H"

#include <cstdlib>
#include <set>

using namespace Foam;

namespace hotbed
{
namespace
{

const word particleFile("particles.liggghts");

} // namespace

void Restart::setAsideUnfinished(const fileName& casePath)
{
    const fileName restarts = casePath / "restart";
    if (!isDir(restarts)) return;
    if (Pstream::master())
    {
        scalar last = 0;
        for (const fileName& time : readDir(restarts, fileName::DIRECTORY))
            if (isFile(restarts / time / "state")) last = max(last, std::strtod(time.c_str(), nullptr));
        fileNameList places(1, casePath);
        for (const fileName& place : readDir(casePath, fileName::DIRECTORY))
            if (place.find("processor") == 0) places.append(casePath / place);
        for (const fileName& place : places)
            for (const fileName& time : readDir(place, fileName::DIRECTORY))
            {
                char* end = nullptr;
                const scalar value = std::strtod(time.c_str(), &end);
                if (*end != '\0' || !(value > last * (1 + 1e-9))) continue;
                const fileName aside = place / (time + ".unfinished");
                rmDir(aside);
                mv(place / time, aside);
                Info << "Restart: " << place / time << " was left unfinished, set aside as " << aside.name() << nl;
            }
    }
    returnReduce(label(0), sumOp<label>()); // nobody reads times before that is done
}

Restart::Restart(const Time& runTime) : runTime_(runTime)
{
    if (!(runTime_.value() > 0)) return;
    start_ = runTime_.globalPath() / "restart" / runTime_.timeName();
    if (!isFile(start_ / "state"))
        FatalErrorInFunction << "the run would start at " << runTime_.timeName() << " s, but " << start_
                             << " holds no complete restart: set startFrom startTime and startTime 0 in "
                             << "system/controlDict, or a time that has one" << exit(FatalError);
    IFstream file(start_ / "state");
    state_ = dictionary(file);
    resumed_ = true;
}

fileName Restart::particles() const
{
    return resumed_ ? start_ / particleFile : fileName("none");
}

void Restart::begin() const
{
    if (Pstream::master()) mkDir(runTime_.globalPath() / "restart");
}

fileName Restart::folder() const
{
    const fileName place = runTime_.globalPath() / "restart" / runTime_.timeName();
    if (Pstream::master()) mkDir(place);
    return place;
}

void Restart::complete(const dictionary& state) const
{
    returnReduce(label(0), sumOp<label>()); // every rank has written its fields
    if (!Pstream::master()) return;
    const fileName name = folder() / "state";
    {
        OFstream file(name + ".unfinished");
        file.precision(17);
        file << state;
    }
    mv(name + ".unfinished", name);
}

} // namespace hotbed
