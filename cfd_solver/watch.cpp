#include "watch.hpp"

#include <cfenv>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <sstream>

#include <fcntl.h>
#include <unistd.h>

using namespace Foam;

namespace hotbed
{
namespace
{

volatile std::sig_atomic_t received = 0;
bool mpirunReads = false; // what is printed
const Watch* watching = nullptr;

void handle(int signal, void (*handler)(int))
{
    struct sigaction action = {};
    action.sa_handler = handler;
    action.sa_flags = SA_RESETHAND | SA_RESTART; // the second one kills
    sigaction(signal, &action, nullptr);
}

void ask(int signal)
{
    received = signal;
    // whichever comes second
    std::signal(SIGINT, SIG_DFL);
    std::signal(SIGTERM, SIG_DFL);
    // who read what is printed may have ended on the same signal; mpirun stops reading: printing must not block then
    std::signal(SIGPIPE, SIG_IGN);
    if (mpirunReads && signal != SIGUSR2) fcntl(STDOUT_FILENO, F_SETFL, O_NONBLOCK);
}

void trapped(int)
{
    fedisableexcept(FE_ALL_EXCEPT); // what is looked at is not finite
    FatalErrorInFunction << "a division by zero, an overflow or a number that is not finite. ";
    if (watching)
        FatalError << watching->worst().c_str() << ". Likely the time step is too long (maxCo, maxDeltaT or deltaT in "
                   << "system/controlDict, timestep in the DEM script) or a boundary value impossible. "
                   << "The restarts written before are whole";
    else
        FatalError << "It came up while the case was set up: likely the DEM script puts two particles at one place, or "
                   << "a start or boundary value of T, p or U is impossible (zero kelvin, zero pressure)";
    FatalError << exit(FatalError);
}

std::string place(const vector& x)
{
    std::ostringstream text;
    text << '(' << x.x() << ' ' << x.y() << ' ' << x.z() << ") m";
    return text.str();
}

} // namespace

void Watch::trapFloatingPoint()
{
    handle(SIGFPE, trapped);
}

Watch::Watch(const fvMesh& mesh, const Gas& gas, const Dem& dem) : mesh_(mesh), gas_(gas), dem_(dem)
{
    watching = this;
    mpirunReads = std::getenv("OMPI_COMM_WORLD_SIZE") != nullptr;
    for (const int signal : {SIGINT, SIGTERM, SIGUSR2}) handle(signal, ask);
}

Watch::~Watch()
{
    for (const int signal : {SIGINT, SIGTERM, SIGUSR2}) std::signal(signal, SIG_DFL);
    watching = nullptr;
}

int Watch::signal() const
{
    return returnReduce(label(received), maxOp<label>());
}

std::string Watch::badCell() const
{
    const scalarField &T = gas_.T(), &p = gas_.thermo().p();
    const tmp<volScalarField> rho = gas_.thermo().rho();
    const vectorField& U = gas_.U();
    forAll(T, c)
    {
        const scalar density = rho()[c];
        if (T[c] > 0 && density > 0 && std::isfinite(T[c] + p[c] + density + magSqr(U[c]))) continue;
        std::ostringstream text;
        text << "cell " << c << " at " << place(mesh_.C()[c]) << " has T = " << T[c] << " K, p = " << p[c]
             << " Pa, density " << density << " kg/m3, U = (" << U[c].x() << ' ' << U[c].y() << ' ' << U[c].z()
             << ") m/s";
        return text.str();
    }
    return {};
}

void Watch::gas() const
{
    const std::string bad = badCell();
    if (!bad.empty())
        FatalErrorInFunction
            << "the gas blew up at " << mesh_.time().timeName() << " s: " << bad.c_str()
            << ". Likely the time step is too long (maxCo, maxDeltaT or deltaT in system/controlDict), "
            << "a boundary value is impossible, or particles heat or push the gas out of its range; the fastest one of "
            << "this rank is " << dem_.fastest().c_str() << ". The restarts written before are whole"
            << exit(FatalError);
}

std::string Watch::worst() const
{
    std::ostringstream text;
    const std::string bad = badCell();
    const vectorField& U = gas_.U();
    text << "Time " << mesh_.time().timeName() << " s; ";
    if (!bad.empty())
        text << "in the gas, " << bad;
    else if (U.size())
    {
        label fastest = 0;
        forAll(U, c) if (magSqr(U[c]) > magSqr(U[fastest])) fastest = c;
        text << "the fastest gas is at " << place(mesh_.C()[fastest]) << " with " << mag(U[fastest]) << " m/s";
    }
    const std::string particle = dem_.fastest();
    if (!particle.empty()) text << "; the fastest particle is " << particle;
    return text.str();
}

} // namespace hotbed
