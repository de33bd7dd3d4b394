/// hotbedFoam: coarse-grained CFD-DEM with gas-particle heat transfer. An OpenFOAM solver that holds a LIGGGHTS
/// instance on its own MPI ranks. Case: see docs/case.md. Options are those of any OpenFOAM solver.

#include "bed.hpp"
#include "check.hpp"
#include "coupling.hpp"
#include "gas.hpp"
#include "restart.hpp"
#include "settings.hpp"
#include "version.hpp"
#include "waiting.hpp"
#include "watch.hpp"

#include "foamVersion.H"

#include <csignal>
#include <mpi.h>
#include <sys/resource.h>
#include <unistd.h>

#include <climits>
#include <cmath>
#include <cstring>
#include <iomanip>
#include <iostream>
#include <sstream>

using namespace Foam;
using namespace hotbed;

namespace
{

/// Makes the case the working directory and takes `-case DIR` out of the arguments, so that paths in the DEM script
/// are relative to the case wherever the solver was started.
void enterCase(int& argc, char** argv)
{
    for (int i = 1; i + 1 < argc; ++i)
    {
        if (std::strcmp(argv[i], "-case") != 0) continue;
        if (chdir(argv[i + 1]) != 0)
        {
            std::cerr << "hotbedFoam: no case directory '" << argv[i + 1] << "'\n";
            std::exit(1);
        }
        if (char* here = getcwd(nullptr, 0)) // OpenFOAM trusts PWD
        {
            setenv("PWD", here, 1);
            std::free(here);
        }
        std::copy(argv + i + 2, argv + argc + 1, argv + i);
        argc -= 2;
        return;
    }
}

/// DEM steps in a gas step; the gas step must be a whole number of them.
int demSteps(const Time& runTime, const Dem& dem, const fileName& script)
{
    const scalar deltaT = runTime.deltaTValue();
    const scalar steps = deltaT / max(dem.timestep(), deltaT / INT_MAX); // the quotient may be too large for a number
    const int whole = int(std::lround(steps));
    if (whole < 1 || whole == INT_MAX || std::abs(steps - whole) > 1e-6 * steps)
        FatalErrorInFunction << "deltaT in system/controlDict is " << runTime.deltaTValue() << " s, which is " << steps
                             << " DEM steps of " << dem.timestep() << " s (timestep in " << script
                             << "): it must be a whole number of them, for example "
                             << std::max(1, whole) * dem.timestep() << exit(FatalError);
    return whole;
}

/// With adjustTimeStep: the largest whole number of DEM steps that keeps maxCo and maxDeltaT, made a little smaller, or
/// up to a twentieth larger, where that meets the next write time or the end. No jumps: the gas takes up in one step
/// what the particles have displaced in the one before.
void adjustTimeStep(Time& runTime, const Dem& dem, scalar Courant)
{
    const dictionary& control = runTime.controlDict();
    const StepSettings settings(runTime); // anew, the file may have been changed
    if (!settings.adjust) return;
    const scalar now = runTime.deltaTValue();
    const scalar growth = max(1.2 * now, now + dem.timestep()); // few DEM steps: one more at least
    const scalar wanted = min(min(now * settings.maxCo / max(Courant, SMALL), growth), settings.maxDeltaT);
    long steps = std::max(std::lround(std::floor(wanted / dem.timestep() * (1 + 1e-9))), 1L);

    scalar next = runTime.endTime().value();
    if (control.lookupOrDefault<word>("writeControl", "timeStep") == "adjustableRunTime")
    {
        const scalar interval = control.get<scalar>("writeInterval");
        const scalar since = runTime.value() - runTime.startTime().value();
        next = min(next, runTime.startTime().value() + interval * (std::floor(since / interval * (1 + 1e-9)) + 1));
    }
    const long left = std::lround(min((next - runTime.value()) / dem.timestep(), scalar(1e9)));
    if (left > 0)
    {
        const auto piecesOf = [&](scalar longest) { return std::lround(std::ceil(scalar(left) / longest)); };
        long pieces = piecesOf(scalar(steps));
        if (scalar(left) < 0.9 * scalar(pieces * steps)) pieces = piecesOf(1.05 * scalar(steps));
        steps = (left + pieces - 1) / pieces;
    }
    runTime.setDeltaT(scalar(steps) * dem.timestep(), false);
}

/// Version of the library that is loaded, as Debian writes it.
std::string openfoamVersion()
{
    return std::to_string(foamVersion::api) + "." + foamVersion::patch;
}

/// What runs here, each by its own word.
void printVersions(const Dem& dem)
{
    char mpi[MPI_MAX_LIBRARY_VERSION_STRING];
    int length;
    MPI_Get_library_version(mpi, &length);
    Info << "Hotbed " << HOTBED_VERSION << nl << "    OpenFOAM          " << openfoamVersion().c_str() << nl
         << "    LIGGGHTS          " << dem.version().c_str() << nl << "    MPI               " << mpi << nl << endl;
}

/// The solver is compiled against the headers of one version of OpenFOAM and must run with that very library.
void checkVersion()
{
    const std::string library = openfoamVersion();
    const std::string headers = HOTBED_OPENFOAM_HEADERS;
    if (headers.compare(0, library.size(), library) != 0)
        FatalErrorInFunction << "hotbedFoam is built with the headers of OpenFOAM " << headers.c_str()
                             << ", but the installed library is " << library.c_str()
                             << ": remove the folder build and build again (./hotbed test --quick)" << exit(FatalError);
}

/// Restarts have checksums of each rank's own files.
void checkFileHandler()
{
    if (Pstream::parRun() && fileHandler().type() == "collated")
        FatalErrorInFunction << "-fileHandler collated (or FOAM_FILEHANDLER, or fileHandler in a controlDict) puts the "
                                "files of all ranks together, restarts need those of each rank: decompose and run with "
                                "-fileHandler uncollated"
                             << exit(FatalError);
}

void printOptions(const Dem& dem, const Coupling& coupling, const CouplingSettings& settings)
{
    const label particles = returnReduce(label(dem.size()), sumOp<label>());
    Info << nl << "Case" << nl;
    Info << "    particles         " << particles << " coarse, ratio l = " << dem.ratio() << ", stand for "
         << particles * std::pow(dem.ratio(), 3) << nl << "    drag              "
         << (settings.drag ? settings.dragName : word("left out")) << nl << "    heat transfer     "
         << (coupling.heat() ? settings.heatName : word("left out: no energy equation", false)) << nl
         << "    particle motion   "
         << (dem.moving() ? "on" : "left out: nothing in the DEM script moves particles, weights are evaluated once")
         << nl;
    if (dem.moving())
        Info << "    contacts          "
             << (!dem.hasContacts()    ? "left out: no pair_style in the DEM script"
                 : dem.otherContacts() ? "not of model hotbed: their constants are taken as the coarse particle's"
                                       : "model hotbed, scaled from the original particle")
             << nl;
    Info << "    DEM step          " << dem.timestep() << " s" << nl << endl;
}

void warnOfGravity(const Gas& gas, const Dem& dem, const fileName& script)
{
    const std::array<double, 3> g = dem.gravity();
    const vector particles(g[0], g[1], g[2]);
    if (dem.moving() && mag(particles - gas.gravity()) > 1e-3 * max(mag(particles), mag(gas.gravity())))
        WarningInFunction << "gravity is " << gas.gravity() << " m/s2 in constant/g but " << particles << " for the "
                          << "particles: make constant/g and " << script << " the same" << endl;
}

void printStopped(const Time& runTime, int signal, bool restarts)
{
    Info << nl << "Stopped by signal " << signal << " at " << runTime.timeName() << " s, ";
    if (restarts)
        Info << "restart written: with startFrom latestTime the run goes on from there when it is started again "
             << "(./hotbed run CASE --restart)" << nl;
    else
        Info << "fields written, no restart (writeRestart no in constant/couplingProperties)" << nl;
}

/// The lines below the timing table. @param particleSteps DEM steps times the particles of this rank, summed over the
/// run.
/// @param total  time of the run [s]
void printSpeed(Timing& timing, const fvMesh& mesh, const Dem& dem, const Coupling& coupling, scalar particleSteps,
                double total, long steps)
{
    const auto sum = [](scalar value) { return returnReduce(value, sumOp<scalar>()); };
    const auto largest = [](scalar value) { return returnReduce(value, maxOp<scalar>()); };
    const auto row = [](const char* name, scalar value, const char* unit)
    {
        std::ostringstream line;
        line << "    " << std::left << std::setw(28) << name << std::right << std::setw(11) << std::setprecision(4)
             << value << ' ' << unit;
        Info << line.str().c_str() << nl;
    };
    const scalar gas = largest(timing.of("gas"));
    if (dem.moving() && sum(particleSteps) > 0)
        row("DEM, particle-steps a second", sum(particleSteps) / largest(timing.of("DEM")) / 1e6, "million");
    if (coupling.evaluations() < steps)
        row("closures evaluated", 100.0 * scalar(coupling.evaluations()) / scalar(steps), "% of the gas steps");
    if (gas > 0) row("gas, cells a second", sum(mesh.nCells()) * scalar(steps) / gas / 1e6, "million");
    if (Pstream::parRun() && steps > 0)
    {
        row("sent by a rank a step", largest(scalar(coupling.bytesSent())) / scalar(steps) / 1024, "KiB, exchange");
        const auto imbalance = [&](const char* name, scalar mine)
        {
            scalarList ofRanks(Pstream::nProcs());
            ofRanks[Pstream::myProcNo()] = mine;
            Pstream::gatherList(ofRanks);
            if (!Pstream::master()) return; // it has not got the others'
            const label most = findMax(ofRanks);
            const scalar mean = average(ofRanks);
            const std::string where = "largest over mean, rank " + std::to_string(most);
            if (mean > 0) row(name, ofRanks[most] / mean, where.c_str());
        };
        scalar exchange = 0;
        for (const char* phase : Coupling::phases) exchange += timing.busy(phase);
        imbalance("imbalance, particles", particleSteps);
        imbalance("imbalance, cells", mesh.nCells());
        if (dem.moving()) imbalance("imbalance, DEM at work", timing.busy("DEM"));
        imbalance("imbalance, exchange at work", exchange);
        imbalance("imbalance, gas at work", timing.busy("gas"));
        row("waiting, mean of the ranks", 100 * sum(secondsInMpi()) / Pstream::nProcs() / total,
            "% of the run, in MPI");
    }
    rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    row("peak memory of a rank", largest(scalar(usage.ru_maxrss) / 1024.0), "MiB");
}

} // namespace

int main(int argc, char* argv[])
{
    if (argc == 2 && std::strcmp(argv[1], "-version") == 0)
    {
        MPI_Init(&argc, &argv);
        printVersions(Dem(MPI_COMM_WORLD, "/dev/null"));
        return MPI_Finalize();
    }
    enterCase(argc, argv);
    argList::addBoolOption("version", "print the versions of Hotbed and of what it runs with");
    argList::addNote("Coarse-grained CFD-DEM with gas-particle heat transfer: LIGGGHTS particles in OpenFOAM gas.");
    argList::noCheckProcessorDirectories();
    Check::addOption();
    argList args(argc, argv);
    if (!args.checkRootCase()) FatalError.exit();
    bool ownMpi = false;
    if (int initialised = 0; MPI_Initialized(&initialised) == MPI_SUCCESS && !initialised)
    {
        MPI_Init(&argc, &argv); // OpenFOAM does so for -parallel only, LIGGGHTS needs it always
        ownMpi = true;
    }
    const double start = MPI_Wtime();
    long steps = 0;
    scalar particleSteps = 0;
    Check check(args);
    int stopped = 0;
    {
        std::unique_ptr<Dem> dem;
        try
        {
            dem = std::make_unique<Dem>(MPI_COMM_WORLD, "log.liggghts");
        }
        catch (const std::exception& problem)
        {
            FatalErrorInFunction << problem.what() << exit(FatalError);
        }
        printVersions(*dem);
        checkVersion();
        checkFileHandler();
        Watch::trapFloatingPoint();
        Restart::setAsideUnfinished(args.globalPath());
        Time runTime(Time::controlDictName, args);
        Restart restart(runTime);
        const CouplingSettings settings(runTime);
        const StepSettings stepSettings(runTime);
        Timing timing(secondsInMpi);
        try
        {
            const auto time = timing.measure("DEM set-up");
            auto variables = readSettings(runTime);
            variables.emplace_back("resume", restart.resumed() ? "1" : "0");
            variables.emplace_back("restart", restart.particles());
            if (Pstream::parRun()) dem->divide(piecesOfParticles(runTime));
            dem->read(settings.demScript, variables);
            check.particles(*dem);
            demSteps(runTime, *dem, settings.demScript);
            if (stepSettings.adjust && stepSettings.maxDeltaT < dem->timestep())
                FatalIOErrorInFunction(runTime.controlDict())
                    << "maxDeltaT is " << stepSettings.maxDeltaT << " s, shorter than a DEM step of " << dem->timestep()
                    << " s (timestep in " << settings.demScript << "): it must be at least that" << exit(FatalIOError);
            restart.compare(*dem, settings.demScript);
            dem->setup(restart.resumed());
        }
        catch (const std::exception& problem)
        {
            FatalErrorInFunction << problem.what() << exit(FatalError);
        }
        fvMesh mesh(IOobject(fvMesh::defaultRegion, runTime.timeName(), runTime, IOobject::MUST_READ));
        if (settings.drag && dem->moving() && !dem->drag())
            FatalErrorInFunction
                << settings.demScript << " moves particles and drag is on, but nothing lets the gas push "
                << "them: add 'fix ID all hotbed/drag', or set drag none in constant/couplingProperties"
                << exit(FatalError);
        Gas gas(mesh, settings.heatTransfer && dem->heat(), timing);
        Coupling coupling(settings, mesh, *dem, gas, timing);
        coupling.map();
        if (!restart.resumed()) coupling.refuseOutside(); // on their way they may leave the mesh
        gas.initialise(restart.resumed());
        check.gas(settings, mesh, *dem, gas);
        printOptions(*dem, coupling, settings);
        warnOfGravity(gas, *dem, settings.demScript);
        Bed bed(mesh, coupling, *dem, gas, settings.bedInterval);
        if (restart.resumed()) bed.resume(restart.state());

        if (settings.writeRestart) restart.begin();
        const Watch watch(mesh, gas, *dem);
        Info << "Starting time loop" << nl << endl;
        while (runTime.run())
        {
            const scalar courantRate = gas.courantRate();
            adjustTimeStep(runTime, *dem, courantRate * runTime.deltaTValue());
            ++runTime;
            const int substeps = demSteps(runTime, *dem, settings.demScript);
            Info << "Time = " << runTime.timeName() << "  Courant " << courantRate * runTime.deltaTValue()
                 << "  DEM steps " << substeps << endl;

            coupling.particlesToGas(courantRate);
            {
                const auto time = timing.measure("gas");
                gas.advance();
                watch.gas();
            }
            coupling.gasToParticles();
            bed.particlesWillMove();
            {
                const auto time = timing.measure("DEM");
                dem->advance(substeps);
                particleSteps += scalar(substeps) * dem->size();
            }
            bed.particlesHaveMoved();
            const auto time = timing.measure("output");
            stopped = watch.signal();
            bed.record(stopped || runTime.value() > runTime.endTime().value() - 0.5 * runTime.deltaTValue());
            const bool restarts = settings.writeRestart && (stopped || runTime.writeTime());
            if (restarts) restart.open();
            writeFields(runTime, stopped);
            if (restarts)
            {
                bed.particlesWillMove();
                restart.writeParticles(*dem);
                coupling.forgetAnswers();
                bed.particlesHaveMoved();
                restart.complete(bed.state(), *dem);
            }
            ++steps;
            if (check.enough(timing.of("DEM"), courantRate, substeps, runTime.value())) break;
            runTime.printExecutionTime(Info);
        }
        check.cost();
        if (stopped) printStopped(runTime, stopped, settings.writeRestart);
        bed.finish(static_cast<OSstream&>(Info));
        dem->finish();
        for (const auto& part : dem->times()) timing.add("DEM: " + part.first, part.second);
        std::ostringstream table;
        const double total = MPI_Wtime() - start;
        timing.print(table, MPI_COMM_WORLD, total, steps);
        Info << nl << table.str().c_str();
        printSpeed(timing, mesh, *dem, coupling, particleSteps, total, steps);
        Info << nl << "End" << nl << endl;
    }
    const bool interrupted = stopped && stopped != SIGUSR2;
    if (ownMpi || interrupted) MPI_Finalize();
    if (interrupted) std::_Exit(128 + stopped); // OpenFOAM ends every run with 0
    return 0;
}
