#pragma once

#include "fvCFD.H"

#include "closures.hpp"

#include <array>
#include <string>
#include <utility>
#include <vector>

namespace hotbed
{

/// The numbers of a case that are meant to be changed, file `settings` at its root: OpenFOAM dictionaries read them
/// with #include, the DEM script as LIGGGHTS variables.
/// @return every single-valued entry, in file order; empty without the file
std::vector<std::pair<std::string, std::string>> readSettings(const Foam::Time& runTime);

/// constant/couplingProperties, checked whole before anything is computed.
struct CouplingSettings
{
    explicit CouplingSettings(const Foam::Time& runTime);

    Foam::fileName demScript;        ///< path from the case
    Foam::word dragName, heatName;   ///< as the dictionary has them
    DragLaw drag = nullptr;          ///< null for none
    HeatLaw heatTransfer = nullptr;  ///< null for none
    Foam::scalar kernelWidth = 3;    ///< full window over the coarse diameter; 0 where windowLength is given
    Foam::scalar windowLength = 0;   ///< full window [m], the same for every particle; 0 where kernelWidth is given
    int kernelSamples = 2;           ///< lattice boxes a cell, per axis, on meshes that are not made of boxes
    int bedInterval = 10;            ///< gas steps between lines of bed.csv
    bool writeRestart = true;        ///< at every write time
    bool linearExchange = true;      ///< heat exact for a gas temperature linear in time; else h A (T_gas' - T)
    Foam::scalar closureCo = 0.2;    ///< Courant number up to which drag and heat transfer coefficients are kept
    bool temperatureGradient = true; ///< read the gas temperature at the particle, not at its cells' centres
};

/// How the particles' box is cut for the ranks where the DEM script does not say: as the gas is, where
/// system/decomposeParDict cuts it along x, y and z (methods simple and hierarchical), else never along gravity.
/// @return pieces along x, y, z; 0: as LIGGGHTS likes
std::array<int, 3> piecesOfParticles(const Foam::Time& runTime);

/// How system/controlDict lets the gas step follow the Courant number, checked.
struct StepSettings
{
    explicit StepSettings(const Foam::Time& runTime);

    bool adjust;            ///< adjustTimeStep; the others are not read without it
    Foam::scalar maxCo;     ///< largest Courant number
    Foam::scalar maxDeltaT; ///< longest gas step [s]
};

} // namespace hotbed
