#include "check.hpp"

#include "bed.hpp"
#include "fluidisation.hpp"
#include "vectorised.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <string>

using namespace Foam;

namespace hotbed
{
namespace
{

constexpr double packed = 0.4; ///< voidage of a settled bed of spheres, for the minimum fluidisation velocity

template <class... Values> void fact(const char* name, const Values&... values)
{
    Info << "fact " << name;
    (void)std::initializer_list<int>{(Info << ' ' << values, 0)...};
    Info << endl; // to the log before the next one may be refused
}

/// Wall time since this process was started [s]: with what the system and MPI needed before the first line of the
/// solver.
double sinceStart()
{
    std::ifstream stat("/proc/self/stat");
    std::string text;
    std::getline(stat, text, ')'); // the name may have spaces
    for (int field = 3; field <= 22; ++field) stat >> text;
    timespec now;
    clock_gettime(CLOCK_BOOTTIME, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec) - std::stod(text) / double(sysconf(_SC_CLK_TCK));
}

double sum(double value)
{
    return returnReduce(value, sumOp<double>());
}

double largest(double value)
{
    return returnReduce(value, maxOp<double>());
}

} // namespace

void Check::addOption()
{
    argList::addOption("check", "seconds", "print what decides stability and cost, run so long, tell the time it took");
}

Check::Check(const argList& args) : on_(args.found("check"))
{
    if (on_) seconds_ = args.get<scalar>("check");
}

void Check::particles(Dem& dem) const
{
    if (!on_) return;
    double mass = 0, volume = 0, surface = 0, high = 0, low = GREAT;
    for (int i = 0; i < dem.size(); ++i)
    {
        const double r = dem.radius()[i];
        mass += dem.mass()[i];
        volume += sphereVolume(r);
        surface += 4 * M_PI * r * r;
        high = std::max(high, 2 * r);
        low = std::min(low, 2 * r);
    }
    fact("particles", sum(dem.size()));
    fact("ratio", dem.ratio());
    fact("demStep", dem.timestep());
    fact("moving", dem.moving());
    fact("solids", sum(volume));
    fact("mass", sum(mass));
    fact("diameter", -largest(-low), largest(high), 6 * sum(volume) / max(sum(surface), VSMALL)); // the last: Sauter's
    fact("otherContacts", dem.otherContacts());
    for (const ContactTime& contact : dem.contacts())
        fact("contact", contact.first, contact.second, contact.steps, contact.least, contact.friction);
}

void Check::gas(const CouplingSettings& settings, const fvMesh& mesh, const Dem& dem, Gas& gas) const
{
    if (!on_) return;
    const Column column(mesh);
    const scalar volume = gSum(mesh.V());

    vector cell(GREAT, GREAT, GREAT); // smallest extents
    for (label c = 0; c < mesh.nCells(); ++c)
        cell = min(cell, boundBox(mesh.points(), mesh.cellPoints()[c], false).span());
    reduce(cell, minOp<vector>());
    const label up3 = mag(column.up.x()) > 0.7 ? 0 : mag(column.up.y()) > 0.7 ? 1 : 2;
    scalar kernel = 0, mass = 0, solids = 0, weight = 0, capacity = 0, heat = 0, bed = 0, surface = 0;
    const bool heated = settings.heatTransfer && dem.heat();
    std::vector<double> capacities(std::size_t(dem.size()));
    if (heated) dem.heatCapacity(0, dem.size(), capacities.data());
    for (int i = 0; i < dem.size(); ++i)
    {
        const double r = dem.radius()[i];
        kernel = max(kernel, settings.windowLength > 0 ? settings.windowLength : settings.kernelWidth * 2 * r);
        mass += dem.mass()[i];
        solids += sphereVolume(r);
        surface += 4 * M_PI * r * r;
        if (!heated) continue;
        capacity += capacities[std::size_t(i)];
        heat += capacities[std::size_t(i)] * dem.temperature()[i];
    }
    mass = sum(mass), solids = sum(solids), surface = sum(surface), capacity = sum(capacity), heat = sum(heat);
    forAll(mesh.V(), c)
    {
        const scalar share = (1 - gas.voidage()[c]) * mesh.V()[c];
        bed += share;
        weight += share * gas.voidage()[c];
    }
    bed = sum(bed), weight = sum(weight);
    const scalar voidage = bed > 0 ? weight / bed : 1; // where the particles are

    const auto mean = [&](const volScalarField& field)
    { return gSum(scalarField(field.primitiveField() * mesh.V())) / volume; };
    const scalar density = mean(gas.thermo().rho()()), viscosity = mean(gas.thermo().mu()()),
                 conductivity = mean(gas.thermo().kappa()()), capacityOfGas = mean(gas.thermo().Cp()());
    const scalar u0 = gas.inflow() / column.section;
    fact("cells", returnReduce(mesh.nCells(), sumOp<label>()));
    fact("cell", cmptMin(cell), cell[up3]); // smallest extent of all, along gravity
    const auto imbalance = [](double mine) { return largest(mine) * Pstream::nProcs() / max(sum(mine), VSMALL); };
    fact("imbalance", imbalance(dem.size()), imbalance(mesh.nCells())); // largest over mean of the ranks
    vector across = mesh.bounds().span();
    fact("domain", cmptMin(across));
    across[up3] = GREAT;
    fact("across", cmptMin(across)); // smallest extent of the column across gravity
    fact("section", column.section);
    fact("kernel", largest(kernel));
    fact("gravity", column.gravity);
    const std::array<double, 3> g = dem.gravity();
    fact("gravityApart", mag(vector(g[0], g[1], g[2]) - gas.gravity())); // particles' and gas's
    fact("voidage", voidage, gMin(gas.voidage().primitiveField()));
    fact("gas", density, viscosity, conductivity, capacityOfGas, mean(gas.T()));
    fact("u0", u0);
    fact("turbulence", mesh.lookupObject<IOdictionary>("turbulenceProperties").get<word>("simulationType"));
    fact("drag", settings.dragName, dem.drag());
    fact("heat", heated);
    if (!(solids > 0)) return;

    const double ratio = dem.ratio(), d = 6 * solids / surface / ratio;
    const NoTraps guard;
    const Suspension suspension = {d, mass / solids, density, viscosity};
    const double gasShare = voidage / (1 - voidage) * solids; // volume of the gas between the particles
    const double number = solids / sphereVolume(0.5 * d);     // of original particles
    const double reynolds = density * mag(u0) * d / viscosity;
    double logReynolds;
    logarithms(1, &reynolds, &logReynolds);
    if (settings.drag)
    {
        double beta;
        settings.drag(1, &voidage, &reynolds, &logReynolds, &beta);
        const double drag = dragCoefficient(beta, viscosity, voidage, d, 1.0);
        fact("dragTime", mass / number / drag, density * gasShare / (number * drag)); // of a particle, of the gas
        fact("minimumFluidisation", carryingVelocity(settings.drag, suspension, packed, column.gravity),
             wenYuMinimumFluidisation(suspension, column.gravity), packed);
        fact("terminal", carryingVelocity(settings.drag, suspension, 1.0, column.gravity));
        fact("fixedBedDrop", bedPressureGradient(settings.drag, suspension, voidage, mag(u0)) * solids / (1 - voidage) /
                                 column.section);
    }
    if (!heated) return;
    const double prandtlRoot = std::cbrt(viscosity * capacityOfGas / conductivity);
    double nusselt;
    settings.heatTransfer(1, &voidage, &logReynolds, &prandtlRoot, &nusselt);
    const double conductance = number * heatConductance(nusselt, conductivity, d, 1.0);
    fact("temperature", heat / capacity);
    fact("heatTime", capacity / conductance, density * capacityOfGas * gasShare / conductance);
}

bool Check::enough(double dem, double courantRate, long demSteps, scalar time)
{
    if (!on_) return false;
    if (steps_.empty()) setUp_ = largest(sinceStart());
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    const auto inSeconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
    const double cpu = largest(inSeconds(usage.ru_utime) + inSeconds(usage.ru_stime));
    const long before = steps_.empty() ? 0 : steps_.back().demSteps;
    steps_.push_back({cpu, largest(MPI_Wtime()), largest(dem), courantRate, before + demSteps, time});
    return steps_.size() > 10 && cpu - steps_.front().cpu > seconds_;
}

void Check::cost() const
{
    if (!on_ || steps_.size() < 2) return;
    const Step& last = steps_.back();
    // later steps cost more: the particles are in contact
    const auto half = std::find_if(steps_.begin() + 1, steps_.end() - 1,
                                   [&](const Step& s) { return s.cpu > 0.5 * (steps_.front().cpu + last.cpu); });
    const Step& first = *(half - 1);
    std::vector<double> rates;
    for (auto step = half; step != steps_.end(); ++step) rates.push_back(step->courantRate);
    fact("steps", steps_.end() - half, last.demSteps - first.demSteps, last.time - first.time, last.time);
    fact("cost", setUp_, last.cpu - first.cpu,
         (last.dem - first.dem) / (last.wall - first.wall));            // share of the DEM
    fact("courantRate", *std::min_element(rates.begin(), rates.end())); // without the kick of the start
}

} // namespace hotbed
